"""Write a sheet as PDF in true scale: on one page for a plotter, or in tiles to be glued together.

By reportlab. Everything is placed in points of 1/72 inch; a line is drawn from a whole point near it, so that the
seven digits which numbers have in the file are enough for 0.001 mm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.export.lines import Line, Words, piece_lines, placed_words, sheet_lines
from flatnet.export.missing_library import needs
from flatnet.export.pdf_fonts import Fonts
from flatnet.export.tiles import Paper, Tile, Tiling, tile_sheet
from flatnet.nesting.layout import Layout
from flatnet.pattern.labels import text_width
from flatnet.version import VERSION

Floats = NDArray[np.float64]

POINT = 72.0 / 25.4  # points in a mm
#: No page of a PDF may be longer, mm (14,400 points); a longer sheet is divided.
LONGEST = 14_400 / POINT
PAPERS = {
    "a4": Paper("A4", 210.0, 297.0),
    "letter": Paper("Letter", 215.9, 279.4),
    "a3": Paper("A3", 297.0, 420.0),
    "a0": Paper("A0", 841.0, 1189.0),
}
MARGIN = 10.0  # mm, around a sheet on one page
TEST_SQUARE = 50.0  # mm
RULER = 150.0  # mm
STROKE = 0.3  # mm
#: Where marks stand on the edge between two tiles, as parts of it; and half their size, mm.
MARK_PLACES, MARK_SIZE = (0.25, 0.75), 4.0
TITLE_HEIGHT, SMALL = 5.0, 3.0  # mm
ROW_HEIGHTS = (SMALL, 2.5, 2.0, 1.5)  # mm, of the table of seams


class Pages:
    """A PDF that is being written, in mm from a page's lower left corner, y up.

    Parameters
    ----------
    strokes : meaning -> colour, #rrggbb.
    """

    def __init__(self, path: Path, title: str, strokes: Mapping[str, str]) -> None:
        canvas = needs("reportlab.pdfgen.canvas", "PDF")
        self.colours = {kind: needs("reportlab.lib.colors", "PDF").HexColor(text) for kind, text in strokes.items()}
        # `invariant`: no date and no random identifier, so that the same build gives the same bytes.
        self.canvas = canvas.Canvas(str(path), invariant=1, pageCompression=1)
        self.canvas.setTitle(title)
        self.canvas.setCreator(f"flatnet {VERSION}")
        self.canvas.setViewerPreference("PrintScaling", "None")
        self.fonts = Fonts()

    def start(self, width: float, height: float) -> None:
        """A new page."""
        self.canvas.setPageSize((width * POINT, height * POINT))
        self.canvas.setLineWidth(STROKE * POINT)
        self.canvas.setLineJoin(1)

    def end(self) -> None:
        """The page is complete."""
        self.canvas.showPage()

    def save(self) -> list[str]:
        """Write the file; the texts that no font had letters for."""
        self.canvas.save()
        return self.fonts.notes

    def draw(self, line: Line, shift: Floats) -> None:
        """A line moved by `shift`."""
        points = (line.points + shift) * POINT
        origin = np.floor(points.min(axis=0))
        canvas = self.canvas
        canvas.saveState()
        canvas.setStrokeColor(self.colours[line.kind])
        canvas.translate(*origin.tolist())
        path = canvas.beginPath()
        first, *rest = (points - origin).tolist()
        path.moveTo(*first)
        for point in rest:
            path.lineTo(*point)
        if line.closed:
            path.close()
        canvas.drawPath(path)
        canvas.restoreState()

    def write(self, words: Words, shift: Floats, kind: str = "text") -> None:
        """A line of text moved by `shift`."""
        canvas = self.canvas
        canvas.saveState()
        canvas.translate(*((words.position + shift) * POINT).tolist())
        canvas.rotate(math.degrees(words.angle))
        canvas.setFillColor(self.colours[kind])
        text = self.fonts.use(canvas, words.text, words.height * POINT)
        canvas.drawCentredString(0.0, 0.0, text)
        canvas.restoreState()

    def say(self, text: str, x: float, y: float, height: float = SMALL) -> None:
        """A text that starts at a place."""
        canvas = self.canvas
        canvas.setFillColor(self.colours["text"])
        text = self.fonts.use(canvas, text, height * POINT)
        canvas.drawString(x * POINT, y * POINT, text)

    def box(self, corner: Floats, size: Floats, kind: str = "sheet") -> None:
        """A rectangle."""
        ends = corner + np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * size
        self.draw(Line(kind, ends, closed=True), np.zeros(2))

    def clip(self, corner: Floats, size: Floats) -> None:
        """Nothing outside a rectangle is seen, until the state is restored."""
        path = self.canvas.beginPath()
        path.rect(*(corner * POINT).tolist(), *(size * POINT).tolist())
        self.canvas.clipPath(path, stroke=0, fill=0)


def draw_full_size(pages: Pages, layout: Layout, title: str, rows: Sequence[str]) -> None:
    """One page with the whole sheet, below it the test square, a ruler, the title and the seams' numbers.

    A sheet that is longer than any page may be is divided into as long ones.
    """
    size = np.array(layout.size)
    if (size + [2.0 * MARGIN, 2.0 * MARGIN + TEST_SQUARE]).max() > LONGEST:
        longest = np.minimum(size + 2.0 * MARGIN, 0.98 * LONGEST)
        draw_tiles(pages, layout, title, rows, Paper("plotter", *longest.tolist()))
        return
    width = max(size[0], TEST_SQUARE + MARGIN + max(RULER, TITLE_HEIGHT * text_width(title)))
    table = _rows_height(rows, width)
    low = MARGIN + table + MARGIN + TEST_SQUARE
    pages.start(width + 2.0 * MARGIN, low + MARGIN + size[1] + MARGIN)
    corner = np.array([MARGIN, low + MARGIN])
    _draw_sheet(pages, layout, corner)
    _draw_pieces(pages, layout, corner)
    _draw_band(pages, title, np.array([MARGIN, low]), width)
    _draw_rows(pages, rows, np.array([MARGIN, MARGIN + table]), width, table)
    pages.end()


def draw_tiles(pages: Pages, layout: Layout, title: str, rows: Sequence[str], paper: Paper) -> None:
    """A first page with test square, ruler and a map of the others, then the tiles."""
    size = np.array(layout.size)
    regions = [shapely.transform(p.piece.region, p.place) for p in layout.placements]
    tiling = tile_sheet(size, regions, paper)
    _draw_cover(pages, layout, title, rows, tiling, size)
    for number, tile in enumerate(tiling.tiles, start=1):
        _draw_tile(pages, layout, title, tiling, tile, number)


def _draw_sheet(pages: Pages, layout: Layout, shift: Floats) -> None:
    for line in sheet_lines(layout):
        pages.draw(line, shift)


def _draw_pieces(pages: Pages, layout: Layout, shift: Floats, window: shapely.Geometry | None = None) -> None:
    for placement in layout.placements:
        if window is not None:
            corners = placement.place(placement.piece.cut_line)
            if not window.intersects(shapely.box(*corners.min(axis=0), *corners.max(axis=0))):
                continue
        for line in piece_lines(placement.piece):
            pages.draw(line.moved(placement), shift)
        for words in placed_words(placement):
            pages.write(words, shift)


def _draw_tile(pages: Pages, layout: Layout, title: str, tiling: Tiling, tile: Tile, number: int) -> None:
    paper = tiling.paper
    margin = np.full(2, paper.margin)
    pages.start(paper.width, paper.height)
    pages.canvas.saveState()
    pages.clip(margin, paper.window)
    window = shapely.box(*tile.corner, *(tile.corner + paper.window))
    if layout.hide is not None:
        _draw_sheet(pages, layout, margin - tile.corner)
    _draw_pieces(pages, layout, margin - tile.corner, window)
    pages.canvas.restoreState()
    pages.box(margin, paper.window)
    for line in glue_marks(tile, paper):
        pages.draw(line, np.zeros(2))
    text = f"{tile.name} · {number} of {len(tiling.tiles)} · {title} · overlap {paper.overlap:g} mm, glue mark on mark"
    pages.say(text, paper.margin + 1.0, 0.5 * paper.margin - 1.0)
    pages.end()


def glue_marks(tile: Tile, paper: Paper) -> list[Line]:
    """Crosses in the middle of the overlap with each neighbour, at 25 % and 75 % of the edge, on the page."""
    low, high = np.full(2, paper.margin), paper.margin + paper.window
    half = 0.5 * paper.overlap
    marks = []
    for is_printed, axis, place in zip(
        tile.neighbours, (0, 0, 1, 1), (low[0] + half, high[0] - half, low[1] + half, high[1] - half), strict=True
    ):
        for part in MARK_PLACES if is_printed else ():
            centre = low + part * paper.window
            centre[axis] = place
            marks += [
                Line("sheet", centre + MARK_SIZE * np.array([-way, way])) for way in np.eye(2)
            ]
    return marks


def _draw_cover(
    pages: Pages, layout: Layout, title: str, rows: Sequence[str], tiling: Tiling, size: Floats
) -> None:
    """Title, test square, ruler, the map of pages, and what the seams' numbers mean as far as there is room."""
    paper = tiling.paper
    pages.start(paper.width, paper.height)
    top = paper.height - paper.margin
    _draw_band(pages, title, np.array([paper.margin, top]), paper.window[0])
    top -= TEST_SQUARE + MARGIN
    pages.say(f"{len(tiling.tiles)} pages {paper.name} at 100 %, without fitting to the page", paper.margin, top)
    room = np.array([paper.window[0], 0.45 * (top - paper.margin)])
    scale = float((room / (np.array([tiling.columns, tiling.rows]) * paper.step + paper.overlap)).min())
    corner = np.array([paper.margin, top - MARGIN - scale * size[1]])
    for placement in layout.placements:
        outline = Line("cut", scale * placement.place(placement.piece.cut_line), closed=True)
        pages.draw(outline, corner)
    for tile in tiling.tiles:
        lower = corner + scale * (tile.corner + 0.5 * paper.overlap)
        pages.box(lower, scale * paper.step)
        middle = lower + 0.5 * scale * paper.step
        pages.write(Words(tile.name, middle, 0.0, min(4.0, 0.4 * scale * float(paper.step.min()))), np.zeros(2))
    base = corner[1] - MARGIN
    _draw_rows(pages, rows, np.array([paper.margin, base]), paper.window[0], base - paper.margin)
    pages.end()


def _draw_band(pages: Pages, title: str, corner: Floats, width: float) -> None:
    """The test square with its upper left corner at a place, beside it title and ruler."""
    pages.box(corner - [0.0, TEST_SQUARE], np.full(2, TEST_SQUARE), "text")
    middle = corner + [0.5 * TEST_SQUARE, -0.5 * TEST_SQUARE]
    pages.write(Words(f"{TEST_SQUARE:g} mm", middle, 0.0, TITLE_HEIGHT), np.zeros(2))
    left = corner[0] + TEST_SQUARE + MARGIN
    room = width - TEST_SQUARE - MARGIN
    pages.say(title, left, corner[1] - TITLE_HEIGHT, min(TITLE_HEIGHT, room / text_width(title)))
    _draw_ruler(pages, np.array([left, corner[1] - TEST_SQUARE]), min(RULER, 10.0 * (room // 10.0)))


def _draw_ruler(pages: Pages, corner: Floats, length: float) -> None:
    """From `corner` to the right, with ticks each mm and numbers in cm."""
    pages.draw(Line("text", corner + [[0.0, 0.0], [length, 0.0]]), np.zeros(2))
    for mm in range(int(length) + 1):
        tall = 8.0 if mm % 10 == 0 else 5.0 if mm % 5 == 0 else 3.0
        pages.draw(Line("text", corner + [[mm, 0.0], [mm, tall]]), np.zeros(2))
        if mm % 10 == 0:
            pages.write(Words(f"{mm // 10}", corner + [mm, 9.0], 0.0, SMALL), np.zeros(2))


def _columns(rows: Sequence[str], letter: float, width: float) -> int:
    return max(1, int(width // (letter * max(map(text_width, rows)) + 2.0)))


def _rows_height(rows: Sequence[str], width: float) -> float:
    """What they need in letters of the usual size."""
    return 1.4 * SMALL * -(-len(rows) // _columns(rows, SMALL, width)) if rows else 0.0


def _draw_rows(pages: Pages, rows: Sequence[str], corner: Floats, width: float, height: float) -> None:
    """Rows of text below a place, as small as they need to be; what has no room at the smallest size is left out."""
    if not rows or height < SMALL:
        return
    for letter in ROW_HEIGHTS:
        columns = _columns(rows, letter, width)
        deep = int(height / (1.4 * letter) + 1e-9)
        if columns * deep >= len(rows):
            break
    for number, row in enumerate(rows[: columns * deep]):
        x, y = corner + [width / columns * (number // deep), -letter - 1.4 * letter * (number % deep)]
        pages.say(row, x, y, letter)


def draw_certificate(pages: Pages, certificate: Mapping[str, Any], paper: Paper) -> None:
    """What certificate.json says, on pages of their own: the result, every check, the hashes of the files."""
    lines = [
        f"Certificate · {certificate['project']} · {'all checks passed' if certificate['passed'] else 'FAILED'}",
        "",
    ]
    for check in certificate["checks"]:
        worst = "-" if check["worst"] is None else f"{check['worst']:.3g}"
        result = f"{check['failed']} FAILED" if check["failed"] else "ok"
        figures = f"{check['things']} checked, {result}; worst {worst} of {check['allowed']:g} {check['unit']}"
        lines.append(f"{check['check']}: {figures}")
    lines += ["", *certificate["problems"], "", "SHA-256 of the files that were read:"]
    lines += [f"{digest}  {file}" for file, digest in certificate["sha256"].items()]
    letter = 2.4
    deep = int(paper.window[1] // (1.5 * letter))
    for first in range(0, len(lines), deep):
        pages.start(paper.width, paper.height)
        for number, line in enumerate(lines[first : first + deep]):
            pages.say(line, paper.margin, paper.height - paper.margin - 1.5 * letter * (number + 1), letter)
        pages.end()
