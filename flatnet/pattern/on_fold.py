"""The half of a piece that is cut on folded cloth, its fold laid on the cloth's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.pattern.allowance import GRID, TOUCH, rings_of
from flatnet.pattern.edging import Fold
from flatnet.pattern.labels import grain_line, name_label, room_for_text, seam_label
from flatnet.pattern.marks import Mark
from flatnet.pattern.piece import Piece, SeamRun, region_of

Floats = NDArray[np.float64]

#: The bracket that says 'place on the fold' stands so far from the fold, mm, at most this part of the fold's length.
BRACKET, BRACKET_PART = 15.0, 0.15


def half_on_fold(piece: Piece, fold: Fold) -> Piece:
    """The half of a piece on the left of its fold, with no allowance along the fold and a bracket that points at it."""
    count = len(piece.sew_line) // 2 + 1  # from the fold's end anticlockwise to its start: `unfolded` lays them first
    sew_line = piece.sew_line[:count].copy()
    far = 2.0 * float(np.ptp(piece.cut_line, axis=0).sum())
    inward = np.array([-fold.along[1], fold.along[0]])
    ends = np.array([fold.start - far * fold.along, fold.end + far * fold.along])
    side = Polygon([*ends, *(ends[::-1] + far * inward)])
    outline, *holes = rings_of(shapely.intersection(piece.region, side, grid_size=GRID))
    notches = tuple(notch for notch in piece.notches if fold.heights(notch.position) > -TOUCH)
    nicks = tuple(nick for nick in piece.nicks if fold.heights(nick.points).mean() > 0.0)
    marks = [mark for mark in piece.marks if fold.heights(mark.points).mean() > -TOUCH]
    marks.append(Mark("place on the fold", "fold", _bracket(fold, inward)))
    half = replace(
        piece, sew_line=sew_line, cut_line=outline, holes=tuple(holes), notches=notches, nicks=nicks,
        allowances=np.append(piece.allowances[: count - 1], 0.0), marks=tuple(marks), on_fold=True,
    )  # fmt: skip
    lines = [line for notch in notches for line in notch.lines] + [line for mark in marks for line in mark.lines]
    free = room_for_text(region_of(sew_line), [sew_line, *lines])
    name, *rest = half.description
    label = name_label(name, rest, free)
    free = free.difference(label.box)
    runs = []
    for run in piece.seams:
        if run.vertices.max() < count:
            along = sew_line[np.sort(run.vertices)]
            words = seam_label(run.seam.number, run.seam.name, along, free)
            free = free.difference(words.box) if words else free
            runs.append(SeamRun(run.seam, run.vertices.copy(), words))
    grain = grain_line(free) if piece.grain is not None else None
    return replace(half, label=label, seams=tuple(runs), grain=grain)


def _bracket(fold: Fold, inward: Floats) -> Floats:
    """A line beside the fold with an arrow onto it at both ends."""
    length = float(np.linalg.norm(fold.end - fold.start))
    reach = min(BRACKET, BRACKET_PART * length)
    line = []
    for place, way in ((0.1 * length, 1.0), (0.9 * length, -1.0)):
        tip = fold.start + place * fold.along
        barbs = [tip + 0.3 * reach * (inward + shift * fold.along) for shift in (0.5, -0.5)]
        arm = [barbs[0], tip, barbs[1], tip, tip + reach * inward]
        line += arm if way > 0.0 else arm[::-1]
    return np.array(line)
