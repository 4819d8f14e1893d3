"""Compare the lines of an export with those of the build."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.build import WrittenBuild, WrittenPiece
from flatnet.verify.drawing import DrawnLine
from flatnet.verify.mesh import aligned, farthest
from flatnet.verify.written import Record

Floats = NDArray[np.float64]

#: Ends of a line that are no farther apart are one, mm: formats round them.
ONE_PLACE = 1e-3


@dataclass(frozen=True, eq=False)
class WantedLine:
    """A line that an export has to show: `kind` is `sew`, `cut`, or a class of `WrittenPiece.lines`."""

    subject: str
    kind: str
    line: DrawnLine

    def moved(self, subject: str, linear: Floats, shift: Floats) -> WantedLine:
        """The same line where a copy lies."""
        return WantedLine(subject, self.kind, DrawnLine(self.line.points @ linear.T + shift, self.line.closed))


def drawn_line(points: Floats, closed: bool = False) -> DrawnLine:
    """A line of an export, (k, 2) mm; one that ends where it starts is closed, however the format says so."""
    if not closed and len(points) > 3 and farthest(points[:1], points[-1:]) <= ONE_PLACE:
        return DrawnLine(points[:-1], True)
    return DrawnLine(points, closed)


def of_piece(piece: WrittenPiece) -> list[WantedLine]:
    """In the piece's own frame, the sew line first."""
    closed = [("sew", piece.sew_line), *(("cut", line) for line in (piece.cut_line, *piece.holes))]
    others = [(kind, line) for kind, lines in piece.lines.items() for line in lines]
    return [WantedLine(piece.name, kind, DrawnLine(line, True)) for kind, line in closed] + [
        WantedLine(piece.name, kind, drawn_line(line)) for kind, line in others
    ]


def of_sheet(layout: Record, build: WrittenBuild) -> list[WantedLine]:
    """Of all copies where the report says that they lie, the sheet's lower left corner at 0."""
    pieces = {(piece.patch, piece.material): piece for piece in build.pieces}
    lines = []
    for record in layout.records("pieces"):
        piece = pieces.get((record.text("patch"), layout.text("material")))
        if piece is None:
            continue
        angle, side = np.radians(record.number("rotation_deg")), -1.0 if record.flag("mirrored") else 1.0
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag([1.0, side])
        shift = np.array([record.number("x_mm"), record.number("y_mm")])
        subject = f"{piece.patch} copy {record.count('copy')}"
        lines += [line.moved(subject, turn, shift) for line in of_piece(piece)]
    return lines


def nearest(wanted: DrawnLine, drawn: Sequence[DrawnLine]) -> float:
    """How far the drawn line that is most like a wanted one is from it, mm; inf where none has as many vertices."""
    return min((farthest(wanted.points, line.points) for line in _alike(wanted, drawn)), default=np.inf)


def found_elsewhere(wanted: DrawnLine, drawn: Sequence[DrawnLine]) -> tuple[float, Floats, Floats]:
    """The same for one that may lie elsewhere, turned by any angle but not mirrored; and its turn and shift."""
    best = np.inf, np.eye(2), np.zeros(2)
    for line in _alike(wanted, drawn):
        linear, shift = aligned(wanted.points, line.points)
        off = farthest(wanted.points @ linear.T + shift, line.points)
        if off < best[0]:
            best = off, linear, shift
    return best


def _alike(wanted: DrawnLine, drawn: Sequence[DrawnLine]) -> list[DrawnLine]:
    return [line for line in drawn if line.closed == wanted.closed and len(line.points) == len(wanted.points)]
