"""Draw layouts and single pieces as SVG in true scale: one unit of the drawing is 1 mm.

Inside a piece's group, coordinates are those of the piece's own frame, y up: a vertex of the path `sew` is
the `vt` of the patch's OBJ, rounded to 0.001 mm. The group's matrix, in full precision, does the rest: the
placement on the sheet, then the flip of y, because SVG is y-down. So a plain copy is seen from the side that
the normals point to, and a mirrored one mirrored. Text has a matrix of its own that keeps it upright and
never mirrored.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import svgwrite
from numpy.typing import NDArray
from svgwrite.container import Group
from svgwrite.extensions import Inkscape

from flatnet.export.lines import KINDS, piece_labels, sheet_rims
from flatnet.nesting.layout import Layout, Placement, turn
from flatnet.parameters import STROKES
from flatnet.pattern.labels import LINE_PITCH, Label, arrow_head, name_label, room_for_text, text_width
from flatnet.pattern.piece import Piece

Floats = NDArray[np.float64]

STROKE_WIDTH = 0.3  # mm
TEST_SQUARE = 50.0  # mm
MARGIN = 10.0  # mm around the test square and the title below the sheet
TITLE_HEIGHT = 6.0  # mm, on a small page
TITLE_PART = 0.01  # the title's height as a part of a long page's length, to be read when all of it is seen
TABLE_HEIGHT = 4.0  # mm, of the text in the table of seams
TITLE_LETTERS = 90  # in a line of the title
#: Colour that the defects of a hide are filled with.
DEFECT = "#d8d8d8"
#: The layers of a drawing by meaning, and the order in which they are drawn: what is cut through comes last.
LAYERS = ("text", *KINDS)


class _Page(svgwrite.Drawing):
    """A drawing in mm, `width` x `height`, whose lines are coloured by their meaning."""

    def __init__(self, path: Path, width: float, height: float, strokes: Mapping[str, str]) -> None:
        size, box = (f"{width}mm", f"{height}mm"), f"0 0 {width} {height}"
        super().__init__(str(path), size=size, viewBox=box, debug=False)
        self.strokes = strokes


def write_layout(
    path: Path,
    layout: Layout,
    project: str,
    missing: Sequence[str] = (),
    strokes: Mapping[str, str] = STROKES,
    by_meaning: bool = False,
) -> None:
    """Draw one sheet: its pieces, and below it a 50 mm test square, the title and what the seams' numbers mean.

    Parameters
    ----------
    missing : patches of this material that could not be made; the drawing says so.
    strokes : meaning of a line -> its colour.
    by_meaning : one layer for each meaning, with a group for every piece in it; else one group for every piece.
    """
    length, width = layout.size
    title = [f"{project} · {layout.name}", f"{layout.title_size}, {100.0 * layout.utilisation:.1f} % used"]
    if layout.draft:
        title.append("draft: not nested")
    if missing:
        title.append(f"INCOMPLETE: missing {', '.join(missing)}")
    size = np.array([length, width])
    _write_page(path, size, layout.placements, title, sheet_rims(layout), strokes, by_meaning, _zone_labels(layout))


def _zone_labels(layout: Layout) -> list[Label]:
    """The name of every quality zone of a hide, clear of pieces and defects where there is room."""
    if layout.hide is None or not layout.hide.zones:
        return []
    taken = [shapely.Polygon(placement.place(placement.piece.cut_line)) for placement in layout.placements]
    taken += [shapely.Polygon(ring) for ring in layout.hide.defects]
    covered = shapely.union_all(taken)
    labels = []
    for name, ring in layout.hide.zones:
        zone = shapely.Polygon(ring)
        left = max(shapely.get_parts(zone.difference(covered)), key=lambda part: float(part.area), default=zone)
        rooms = (room_for_text(part, ()) for part in (left, zone))
        labels.append(name_label(f"zone {name}", (), next((room for room in rooms if not room.is_empty), zone)))
    return labels


def write_piece(
    path: Path, piece: Piece, strokes: Mapping[str, str] = STROKES, by_meaning: bool = False
) -> None:
    """Draw one piece alone, in its own orientation, with a 50 mm test square and its seams."""
    corner, size = piece.cut_line.min(axis=0), np.ptp(piece.cut_line, axis=0)
    x, y = MARGIN - corner
    title = [" · ".join(piece.description)]
    placement = Placement(piece, 1, False, 0.0, x, y)
    _write_page(path, size + 2.0 * MARGIN, [placement], title, (), strokes, by_meaning)


def _write_page(
    path: Path,
    size: Floats,
    placements: Sequence[Placement],
    title: Sequence[str],
    sheet: Iterable[tuple[str, Floats]],
    strokes: Mapping[str, str],
    by_meaning: bool,
    labels: Sequence[Label] = (),
) -> None:
    """A page with the sheet and its labels at its top left corner, below it test square, title and table of seams."""
    lines = [part for line in title for part in textwrap.wrap(line, TITLE_LETTERS)]
    letter = min(max(TITLE_HEIGHT, TITLE_PART * size[0]), 4.0 * TITLE_HEIGHT)
    rows = seam_table(placements)
    column = TABLE_HEIGHT * max(map(text_width, rows), default=0.0) + MARGIN
    title_width = letter * max(map(text_width, lines))
    width = _rounded(max(size[0], TEST_SQUARE + title_width + 3.0 * MARGIN, column + MARGIN))
    columns = max(1, int((width - MARGIN) / column))  # the width is rounded
    top = size[1] + MARGIN
    table_top = top + max(TEST_SQUARE, LINE_PITCH * letter * len(lines)) + MARGIN
    deep = -(-len(rows) // columns)
    height = _rounded(table_top + LINE_PITCH * TABLE_HEIGHT * deep + MARGIN)
    drawing = _Page(path, width, height, strokes)
    inkscape = Inkscape(drawing)
    page = drawing.add(inkscape.layer(label="sheet", id="sheet"))

    for kind, outline in sheet:
        rim = _path(drawing, "sheet", outline * (1.0, -1.0) + (0.0, size[1]))
        rim.update({"class": kind, "fill": DEFECT if kind == "defect" else "none"})
        page.add(rim)
    if labels:
        on_sheet = page.add(drawing.g())
        on_sheet.matrix(1.0, 0.0, 0.0, -1.0, 0.0, float(size[1]))  # y up
        for label in labels:
            for words in _label(drawing, label, np.diag([1.0, -1.0])):
                on_sheet.add(words)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * TEST_SQUARE + (MARGIN, top)
    page.add(_path(drawing, "sheet", square)).update({"class": "test-square"})
    centre = square.mean(axis=0)
    page.add(_text(drawing, f"{TEST_SQUARE:g} mm", centre[0], centre[1], TITLE_HEIGHT, "middle"))
    for number, line in enumerate(lines):
        base = top + letter * (1.0 + LINE_PITCH * number)
        page.add(_text(drawing, line, TEST_SQUARE + 2.0 * MARGIN, base, letter, "start"))
    for number, row in enumerate(rows):
        base = table_top + TABLE_HEIGHT * (1.0 + LINE_PITCH * (number % deep))
        page.add(_text(drawing, row, MARGIN + column * (number // deep), base, TABLE_HEIGHT, "start"))
    for name, kinds in [(kind, [kind]) for kind in LAYERS] if by_meaning else [("pieces", list(LAYERS))]:
        layer = drawing.add(inkscape.layer(label=name, id=name))
        for placement in placements:
            layer.add(_piece(drawing, placement, size[1], kinds))
    drawing.save(pretty=True)


def seam_table(placements: Sequence[Placement]) -> list[str]:
    """A line for every seam of the pieces: what its number on them stands for, and what it joins."""
    seams = {run.seam.name: run.seam for placement in placements for run in placement.piece.seams}
    return [f"{seam.number} {seam.description}" for seam in sorted(seams.values(), key=lambda seam: seam.number)]


def _piece(drawing: _Page, placement: Placement, sheet_width: float, kinds: Sequence[str]) -> Group:
    """The group of a piece with its lines of some meanings."""
    piece = placement.piece
    flip = np.diag([1.0, -1.0])
    linear = flip @ turn(placement.rotation_deg, placement.mirrored)  # piece frame, y up -> drawing, y down
    group = drawing.g(
        class_="piece",
        data_patch=piece.name,
        data_copy=str(placement.copy),
        data_mirrored=str(placement.mirrored).lower(),
    )
    group.update({"inkscape:label": f"{piece.name} {placement.copy}"})
    group.matrix(*_plain(linear.T.ravel()), *_plain([placement.x_mm, sheet_width - placement.y_mm]))
    for kind in kinds:
        for element in _elements(drawing, piece, kind, linear):
            group.add(element)
    return group


def _elements(drawing: _Page, piece: Piece, kind: str, linear: Floats) -> Iterator[Any]:
    """What is drawn of a piece with one meaning."""
    if kind == "cut":
        yield _path(drawing, "cut", piece.cut_line, *piece.holes)
    elif kind == "sew":
        path = _path(drawing, "sew", piece.sew_line)
        seams = [
            {"number": run.seam.number, "name": run.seam.name, "from": first, "to": last}
            for run in piece.seams
            for first, last in [run.vertices[[0, -1]].tolist()]
        ]
        path.update({"data-seams": json.dumps(seams, ensure_ascii=False)})
        yield path
    elif kind == "notch" and piece.notches:
        yield _lines(drawing, "notch", [line for notch in piece.notches for line in notch.lines])
    elif kind == "nick" and piece.nicks:
        yield _lines(drawing, "nick", [nick.points for nick in piece.nicks])
    elif kind == "internal":
        for mark in piece.marks:
            path = _lines(drawing, "internal", mark.lines)
            path.update({"data-name": mark.name, "data-kind": mark.kind})
            yield path
    elif kind == "grain" and piece.grain is not None:
        heads = [arrow_head(line) for line in ([piece.grain] if piece.one_way else [piece.grain, piece.grain[::-1]])]
        yield _lines(drawing, "grain", [piece.grain, *heads])
    elif kind == "text":
        for label in piece_labels(piece):
            yield from _label(drawing, label, linear)


def _label(drawing: _Page, label: Label, linear: Floats) -> Iterator[Any]:
    """The lines of a label, upright on the drawing whatever the piece's matrix does."""
    along = linear @ label.direction
    if along[0] < -1e-6 or (abs(along[0]) <= 1e-6 and along[1] > 0.0):  # upside down, or reading downwards
        along = -along
    upright = linear.T @ np.array([[along[0], -along[1]], [along[1], along[0]]])  # linear is orthogonal
    for number, line in enumerate(label.lines):
        # Base lines about the centre; the middle of a capital is 0.35 heights above its base line.
        base = label.height * (LINE_PITCH * (number - 0.5 * (len(label.lines) - 1)) + 0.35)
        text = _text(drawing, line, 0.0, base, label.height, "middle")
        text.matrix(*_plain(upright.T.ravel()), *_plain(label.position))
        yield text


def _text(drawing: _Page, text: str, x: float, y: float, height: float, anchor: str) -> Any:
    return drawing.text(
        text,
        insert=(_rounded(x), _rounded(y)),
        class_="text",
        font_size=_rounded(height),
        font_family="sans-serif",
        text_anchor=anchor,
        fill=drawing.strokes["text"],
    )


def _path(drawing: _Page, kind: str, *outlines: Floats) -> Any:
    """One path of closed outlines."""
    return _stroked(drawing, kind, " ".join(f"M {_points(outline)} Z" for outline in outlines))


def _lines(drawing: _Page, kind: str, lines: Sequence[Floats]) -> Any:
    """One path of open lines."""
    return _stroked(drawing, kind, " ".join(f"M {_points(line)}" for line in lines))


def _stroked(drawing: _Page, kind: str, commands: str) -> Any:
    return drawing.path(
        d=commands, class_=kind, fill="none", stroke=drawing.strokes[kind], stroke_width=STROKE_WIDTH
    )


def _points(points: Floats) -> str:
    return " ".join(f"{_rounded(x)},{_rounded(y)}" for x, y in points)


def _rounded(value: float) -> float:
    """To 0.001 mm, and no -0."""
    return round(float(value), 3) + 0.0


def _plain(numbers: Sequence[float] | Floats) -> list[float]:
    """Python floats, which print in full, without -0."""
    return [float(number) + 0.0 for number in numbers]
