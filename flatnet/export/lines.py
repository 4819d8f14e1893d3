"""What is drawn of a piece, said once for every format: lines by their meaning, and words that stand upright."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.nesting.layout import Layout, Placement, turn
from flatnet.pattern.labels import LINE_PITCH, Label, arrow_head
from flatnet.pattern.piece import Piece

Floats = NDArray[np.float64]

#: The meanings of lines, in the order in which a machine draws them: what is cut through comes last.
KINDS = ("sew", "internal", "grain", "notch", "nick", "cut")


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline, (k, 2) mm; of a closed one the first point is not repeated. `kind`: one of `KINDS`, or `sheet`."""

    kind: str
    points: Floats
    closed: bool = False

    def moved(self, placement: Placement) -> Line:
        """The same line where the piece lies on its sheet."""
        return Line(self.kind, placement.place(self.points), self.closed)


@dataclass(frozen=True, eq=False)
class Words:
    """One line of text, centred on `position` (2,) of its base line; `angle` of its direction, rad; `height`, mm."""

    text: str
    position: Floats
    angle: float
    height: float


def sheet_rims(layout: Layout) -> Iterator[tuple[str, Floats]]:
    """The rims of a sheet, (k, 2) mm, y up: `sheet`, the hide's or round the rectangle that is used; of a hide every
    `defect` and `zone`."""
    if layout.hide is None:
        length, width = layout.size
        yield "sheet", np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]])
        return
    yield "sheet", np.array(layout.hide.outline)
    yield from (("defect", np.array(ring)) for ring in layout.hide.defects)
    yield from (("zone", np.array(ring)) for _, ring in layout.hide.zones)


def sheet_lines(layout: Layout) -> Iterator[Line]:
    """All rims of a sheet, for formats that have one meaning for them."""
    yield from (Line("sheet", rim, closed=True) for _, rim in sheet_rims(layout))


def piece_lines(piece: Piece) -> Iterator[Line]:
    """All lines of a piece in its own frame, in the order of `KINDS`."""
    yield Line("sew", piece.sew_line, closed=True)
    for mark in piece.marks:
        yield from (Line("internal", line) for line in mark.lines)
    if piece.grain is not None:
        yield Line("grain", piece.grain)
        for end in [piece.grain] if piece.one_way else [piece.grain, piece.grain[::-1]]:
            yield Line("grain", arrow_head(end))
    for notch in piece.notches:
        yield from (Line("notch", line) for line in notch.lines)
    yield from (Line("nick", nick.points) for nick in piece.nicks)
    for hole in piece.holes:
        yield Line("cut", hole, closed=True)
    yield Line("cut", piece.cut_line, closed=True)


def piece_labels(piece: Piece) -> list[Label]:
    """Its name and the numbers of its seams."""
    return [piece.label, *(run.label for run in piece.seams if run.label)]


def placed_words(placement: Placement) -> Iterator[Words]:
    """The texts of a piece on its sheet (y up), neither mirrored nor upside down."""
    linear = turn(placement.rotation_deg, placement.mirrored)
    for label in piece_labels(placement.piece):
        yield from upright(label, linear @ label.direction, placement.place(label.position[None])[0])


def upright(label: Label, along: Floats, position: Floats) -> Iterator[Words]:
    """The lines of a label that reads along a direction about a place, turned round rather than upside down."""
    if along[0] < -1e-6 or (abs(along[0]) <= 1e-6 and along[1] < 0.0):
        along = -along
    down = np.array([along[1], -along[0]])
    for number, line in enumerate(label.lines):
        # The middle of a capital is 0.35 heights above its base line.
        base = label.height * (LINE_PITCH * (number - 0.5 * (len(label.lines) - 1)) + 0.35)
        yield Words(line, position + base * down, math.atan2(along[1], along[0]), label.height)
