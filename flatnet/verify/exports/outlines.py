"""Compare the outlines of an export with those of the build."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.build import WrittenBuild, WrittenPiece
from flatnet.verify.mesh import aligned, farthest
from flatnet.verify.written import Record

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outline:
    """A closed line that an export has to show: `kind` is `cut` or `sew`, `points` (k, 2) mm."""

    subject: str
    kind: str
    points: Floats


def of_piece(piece: WrittenPiece) -> list[Outline]:
    """In the piece's own frame."""
    cut = [Outline(piece.name, "cut", line) for line in (piece.cut_line, *piece.holes)]
    return [Outline(piece.name, "sew", piece.sew_line), *cut]


def of_sheet(layout: Record, build: WrittenBuild) -> list[Outline]:
    """Of all copies where the report says that they lie, the sheet's lower left corner at 0."""
    pieces = {(piece.patch, piece.material): piece for piece in build.pieces}
    outlines = []
    for record in layout.records("pieces"):
        piece = pieces.get((record.text("patch"), layout.text("material")))
        if piece is None:
            continue
        angle, side = np.radians(record.number("rotation_deg")), -1.0 if record.flag("mirrored") else 1.0
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ np.diag([1.0, side])
        shift = [record.number("x_mm"), record.number("y_mm")]
        subject = f"{piece.patch} copy {record.count('copy')}"
        outlines += [Outline(subject, line.kind, line.points @ turn.T + shift) for line in of_piece(piece)]
    return outlines


def nearest(outline: Outline, drawn: Sequence[Floats], moved: bool) -> float:
    """How far the drawn line that is most like an outline is from it, mm; inf where none has as many vertices.

    Parameters
    ----------
    moved : it may lie elsewhere, turned by any angle, but not mirrored.
    """
    best = np.inf
    for line in drawn:
        if len(line) != len(outline.points):
            continue
        points = outline.points
        if moved:
            linear, shift = aligned(points, line)
            points = points @ linear.T + shift
        best = min(best, farthest(points, line))
    return float(best)
