"""Write a sheet as plain DXF: closed polylines on layers named for what they mean, for lasers and routers.

DXF R2010 in mm, by ezdxf; x along the roll, y across it. Coordinates have all their digits, texts their own letters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.export.lines import KINDS, Line, Words, piece_lines, placed_words, sheet_lines
from flatnet.export.missing_library import needs
from flatnet.nesting.layout import Layout

TITLE_HEIGHT = 10.0  # mm


def write_dxf(path: Path, layout: Layout, title: str, strokes: Mapping[str, str]) -> None:
    """Draw one sheet with its pieces; every piece's lines are one DXF group, named patch and copy.

    Parameters
    ----------
    title : stands below the sheet.
    strokes : meaning -> colour, #rrggbb; of the layers.
    """
    with _fixed_meta_data(needs("ezdxf", "DXF")) as ezdxf:
        document = ezdxf.new("R2010", units=ezdxf.units.MM)
        _draw_sheet(document, layout, title, strokes)
        document.saveas(path)


@contextmanager
def _fixed_meta_data(ezdxf: Any) -> Iterator[Any]:
    """No dates and no random numbers, so that the same layout gives the same bytes."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield ezdxf
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _draw_sheet(document: Any, layout: Layout, title: str, strokes: Mapping[str, str]) -> None:
    for name in (*KINDS, "text", "sheet"):
        document.layers.add(name, true_color=int(strokes[name][1:], 16))
    page = document.modelspace()
    for line in sheet_lines(layout):
        _draw(page, line)
    _write(page, Words(title, np.array([0.5 * layout.size[0], -2.0 * TITLE_HEIGHT]), 0.0, TITLE_HEIGHT))
    for placement in layout.placements:
        entities = [_draw(page, line.moved(placement)) for line in piece_lines(placement.piece)]
        entities += [_write(page, words) for words in placed_words(placement)]
        document.groups.new(f"{placement.piece.name}-{placement.copy}").extend(entities)


def _draw(page: Any, line: Line) -> Any:
    return page.add_lwpolyline(line.points.tolist(), close=line.closed, dxfattribs={"layer": line.kind})


def _write(page: Any, words: Words) -> Any:
    from ezdxf.enums import TextEntityAlignment

    text = page.add_text(
        words.text, height=words.height, rotation=math.degrees(words.angle), dxfattribs={"layer": "text"}
    )
    return text.set_placement(words.position.tolist(), align=TextEntityAlignment.CENTER)
