"""Put the panels of a build on one sheet: rows that fill its width, captions, a title and the colour bar."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from io import BytesIO

import numpy as np
from matplotlib import style
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from flatnet.report.build_files import BuildFiles
from flatnet.report.panels import COLOURS, POINT, RED, Panel, panels_of

RESOLUTION = 150  # dots per inch
WIDTH = 14.0  # inches, as are all lengths here
#: Height over width of the rows together; they are broken to come near it.
PROPORTION = 0.58
TALLEST_ROW = 7.5
GAP, MARGIN, HEAD, CAPTION = 0.25, 0.25, 0.6, 0.5
#: Points of a caption, and at the least; a letter is about so much as wide.
CAPTION_SIZE, LEAST_CAPTION_SIZE, LETTER = 9.0, 5.0, 0.58
LEAST_LETTERS = 16
#: Part of the gap between panels that a caption may take.
CAPTION_GAP = 0.7


def contact_sheet(build: BuildFiles) -> bytes:
    """The sheet of a build as a PNG."""
    return sheet_of(lambda: panels_of(build), lambda figure: _add_head(figure, build))


def sheet_of(panels: Callable[[], Sequence[Panel]], add_head: Callable[[Figure], None]) -> bytes:
    """Panels and a head as a PNG; the same ones give the same one whatever matplotlib's settings are."""
    content = BytesIO()
    with style.context("default"):
        _figure(panels(), add_head).savefig(content, dpi=RESOLUTION, format="png")
    return content.getvalue()


def _figure(panels: Sequence[Panel], add_head: Callable[[Figure], None]) -> Figure:
    rows = break_rows([panel.aspect for panel in panels])
    height = 2.0 * MARGIN + HEAD + sum(CAPTION + row_height for _, row_height in rows)
    height += GAP * (len(rows) - 1)
    figure = Figure(figsize=(WIDTH, height), facecolor="white")
    add_head(figure)
    top, remaining = height - MARGIN - HEAD, iter(panels)
    for count, row_height in rows:
        left = MARGIN
        for _ in range(count):
            panel = next(remaining)
            _add_panel(figure, panel, left, top - CAPTION, row_height)
            left += panel.aspect * row_height + GAP
        top -= CAPTION + row_height + GAP
    return figure


def break_rows(aspects: Sequence[float]) -> list[tuple[int, float]]:
    """Break panels into rows that fill the sheet's width: how many stand in each, and its height in inches.

    Parameters
    ----------
    aspects : width over height of every panel.
    """

    def badness(rows: list[tuple[int, float]]) -> float:
        """Away from the wanted proportion, or of unequal heights."""
        heights = np.array([height for _, height in rows])
        proportion = (heights.sum() + CAPTION * len(rows)) / WIDTH
        return float(abs(np.log(proportion / PROPORTION)) + np.abs(np.log(heights / heights.mean())).mean())

    return min((_filled(aspects, wanted) for wanted in np.linspace(1.0, TALLEST_ROW, 66)), key=badness)


def _filled(aspects: Sequence[float], least: float) -> list[tuple[int, float]]:
    """Rows filled in turn; a new one begins where the next panel would make a row lower than `least`."""

    def row_height(row: Sequence[float]) -> float:
        return (WIDTH - 2.0 * MARGIN - GAP * (len(row) - 1)) / sum(row)

    rows: list[list[float]] = [[]]
    for aspect in aspects:
        if rows[-1] and row_height([*rows[-1], aspect]) < least:
            rows.append([])
        rows[-1].append(aspect)
    return [(len(row), min(row_height(row), TALLEST_ROW)) for row in rows]


def _add_panel(figure: Figure, panel: Panel, left: float, top: float, height: float) -> None:
    """Its upper left corner at `left` and `top` inches from the left and the bottom, its caption above."""
    page = figure.get_size_inches()
    width = panel.aspect * height
    axes = figure.add_axes((left / page[0], (top - height) / page[1], width / page[0], height / page[1]))
    axes.set_axis_off()
    axes.set_xlim(panel.low[0], panel.high[0])
    axes.set_ylim(*((panel.high[1], panel.low[1]) if panel.y_down else (panel.low[1], panel.high[1])))
    panel.paint(axes, width / float(panel.high[0] - panel.low[0]) / POINT)
    caption, points, fits = fitted_caption(panel.caption, width)
    # A caption wider than its panel goes to the left, where there is always paper.
    x, side = (left, "left") if fits else (left + width, "right")
    figure.text(x / page[0], (top + 0.08) / page[1], caption, fontsize=points, va="bottom", ha=side)


def fitted_caption(caption: str, width: float) -> tuple[str, float, bool]:
    """Its lines, their points, and whether they fit a panel of that width, in inches.

    Over narrow panels it has the gap beside it too, and becomes smaller where it would reach the caption next to it.
    """
    letters = int(width / (LETTER * CAPTION_SIZE * POINT))
    text = textwrap.fill(caption, max(letters, LEAST_LETTERS))
    longest = max(map(len, text.splitlines()))
    largest = (width + CAPTION_GAP * GAP) / (LETTER * POINT * longest)
    return text, float(np.clip(largest, LEAST_CAPTION_SIZE, CAPTION_SIZE)), letters >= LEAST_LETTERS


def _add_head(figure: Figure, build: BuildFiles) -> None:
    """Title and figures, and of patches what failed, and the colour bar."""
    page = figure.get_size_inches()
    left, right, top = MARGIN / page[0], 1.0 - MARGIN / page[0], 1.0 - MARGIN / page[1]
    records = build.report["patches"]
    failed = [record["name"] for record in records if record["status"] != "ok"]
    vertices = sum(len(patch.mesh.vertices) for patch in build.patches)
    figures = f"{len(records)} patch{'es' * (len(records) != 1)} · {vertices:,} vertices"
    if not records:
        copies = sum(len(layout["pieces"]) for layout in build.report["layouts"])
        figures = f"{copies} piece{'s' * (copies != 1)}"
    if build.patches:
        worst = max(patch.mesh.max_flattenability for patch in build.patches)
        figures += f" · worst flattenability {worst:.0e} rad"
    title = textwrap.shorten(build.report["project"], 50, placeholder=" ...")
    figure.text(left, top, title, fontsize=17, weight="bold", va="top", parse_math=False)
    figure.text(left, top - 0.34 / page[1], figures, fontsize=11, va="top", color="#444444")
    if failed:
        text = textwrap.shorten(f"{len(failed)} FAILED: {', '.join(failed)}", 170, placeholder=" ...")
        figure.text(left, top - 0.58 / page[1], text, fontsize=9, va="top", color="#b00020", weight="bold")
    if not records:
        return
    bar = figure.add_axes((right - 3.1 / page[0], top - 0.2 / page[1], 3.0 / page[0], 0.14 / page[1]))
    colours = ScalarMappable(Normalize(0.0, RED), COLOURS)
    ticks = np.linspace(0.0, RED, 5)
    figure.colorbar(colours, cax=bar, orientation="horizontal", extend="max", extendfrac=0.03, ticks=ticks)
    bar.tick_params(labelsize=8, length=2)
    words = "flattenability |θ − 2π|, rad"
    figure.text(right - 3.2 / page[0], top - 0.13 / page[1], words, fontsize=9, ha="right", va="center")
