"""Nicks: cuts into an allowance, so that it lies flat when it is folded over a strongly curved sew line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.pattern.notches import way_out
from flatnet.project.seam_specs import NickSpec

Floats = NDArray[np.float64]

#: A nick's mouth takes at most this part of the cut line between two nicks: what is left has to hold.
WIDEST = 0.6
#: The turning of the sew line is measured over this many of its edges at the least, which turn at their ends alone.
SMOOTH = 3.0
#: No nick is nearer to a notch than this, mm: both could not be told apart.
APART = 4.0


@dataclass(frozen=True, eq=False)
class Nick:
    """A V that is cut out of an allowance, or a slit.

    Attributes
    ----------
    seam : whose allowance it is cut into.
    points : (3, 2) of a V, from the cut line to its tip and back; (2, 2) of a slit, from the cut line to its tip, mm.
    """

    seam: str
    points: Floats

    def __post_init__(self) -> None:
        self.points.setflags(write=False)


def nicks_along(
    seam: str, spec: NickSpec, run: Floats, width: float, cut_line: shapely.Geometry, notches: Sequence[Floats]
) -> list[Nick]:
    """The nicks of one seam on one piece.

    Folded over, the edge of an allowance of width w is shorter by the part 2 w k than it lies flat, where the sew line
    turns by k per mm. Where it bulges outwards there is too much of it: a V of that width is cut out for every nick,
    and closes when it is folded. Where it is hollow there is too little: a slit opens.

    Parameters
    ----------
    run : (k, 2) mm; the sew line along the seam, the piece on its left.
    width : its allowance, mm.
    cut_line : all rings of it.
    notches : (2,) mm, where notches are on the cut line.
    """
    line = shapely.LineString(run)
    count = int(line.length / spec.every)
    if count == 0 or width <= spec.clear:
        return []
    step = line.length / count
    middles = (np.arange(count) + 0.5) * step
    reach = 0.5 * max(step, SMOOTH * line.length / (len(run) - 1))
    before, here, after = (
        shapely.get_coordinates(shapely.line_interpolate_point(line, np.clip(middles + shift, 0.0, line.length)))
        for shift in (-reach, 0.0, reach)
    )
    a, b = here - before, after - here
    half_way = 0.5 * (np.linalg.norm(a, axis=1) + np.linalg.norm(b, axis=1))
    turns = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.sum(a * b, axis=1)) / half_way
    nicks = []
    for place, chord, turn in zip(here, after - before, turns, strict=True):
        outward = np.array([chord[1], -chord[0]]) / np.linalg.norm(chord)
        foot = way_out(place, outward, cut_line)
        if abs(turn) * spec.radius < 1.0 or np.linalg.norm(foot - place) <= spec.clear:
            continue
        if any(np.linalg.norm(foot - notch) < APART for notch in notches):
            continue
        tip = place + spec.clear * outward
        if turn < 0.0:
            nicks.append(Nick(seam, np.array([foot, tip])))
            continue
        mouth = step * min(2.0 * width * turn, WIDEST * (1.0 + width * turn))
        side = 0.5 * mouth * np.array([-outward[1], outward[0]])
        ends = [_on(cut_line, foot + shift) for shift in (side, -side)]
        nicks.append(Nick(seam, np.array([ends[0], tip, ends[1]])))
    return nicks


def _on(cut_line: shapely.Geometry, point: Floats) -> Floats:
    """The point of the cut line that is nearest to another."""
    return shapely.get_coordinates(shapely.shortest_line(cut_line, shapely.Point(point)))[0]
