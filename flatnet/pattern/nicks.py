"""Nicks: cuts into an allowance, so that it lies flat when it is folded over a strongly curved sew line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.geometry.polygon import arclengths
from flatnet.geometry.triangles import dot, unit
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


def turns_under(vertices: Floats, normals: Floats) -> Floats:
    """How a sew line turns towards the inside of a fitted sheet at its vertices, (k,) rad; 0 at both ends.

    That is what it turns by in the surface onto which an allowance is folded under, at a right angle to the sheet.

    Parameters
    ----------
    vertices : (k, 3) mm, in space.
    normals : (k - 1, 3) unit; of the sheet along its edges.
    """
    along = unit(np.diff(vertices, axis=0))
    means = unit(normals[1:] + normals[:-1])
    return np.concatenate([[0.0], -dot(np.diff(along, axis=0), means), [0.0]])


def nicks_along(
    seam: str,
    spec: NickSpec,
    run: Floats,
    under: Floats,
    width: float,
    cut_line: shapely.Geometry,
    notches: Sequence[Floats],
) -> list[Nick]:
    """The nicks of one seam on one piece.

    Where the sew line turns by k per mm and the edge onto which an allowance of width w is folded by f, its cut line
    is longer by the part (k + f) w than what it comes to lie on. Folded back onto the piece, f is k. Where that is too
    much, a V of that width is cut out for every nick, and closes when it is folded; where it is too little, a slit
    opens.

    Parameters
    ----------
    run : (k, 2) mm; the sew line along the seam, the piece on its left.
    under : (k,) rad; what its vertices turn by where it is folded under (`turns_under`).
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
    folds = turns
    if spec.folded == "under":
        turned = np.cumsum(under) - 0.5 * under
        start, end = (np.interp(middles + shift, arclengths(run), turned) for shift in (-reach, reach))
        folds = (end - start) / (2.0 * half_way)
    nicks = []
    for place, chord, turn, fold in zip(here, after - before, turns, folds, strict=True):
        more = turn + fold
        outward = np.array([chord[1], -chord[0]]) / np.linalg.norm(chord)
        foot = way_out(place, outward, cut_line)
        if min(abs(fold), abs(more)) * spec.radius < 1.0 or np.linalg.norm(foot - place) <= spec.clear:
            continue
        if any(np.linalg.norm(foot - notch) < APART for notch in notches):
            continue
        tip = place + spec.clear * outward
        if more < 0.0:
            nicks.append(Nick(seam, np.array([foot, tip])))
            continue
        mouth = step * min(width * more, WIDEST * (1.0 + width * turn))
        side = 0.5 * mouth * np.array([-outward[1], outward[0]])
        ends = [_on(cut_line, foot + shift) for shift in (side, -side)]
        nicks.append(Nick(seam, np.array([ends[0], tip, ends[1]])))
    return nicks


def _on(cut_line: shapely.Geometry, point: Floats) -> Floats:
    """The point of the cut line that is nearest to another."""
    return shapely.get_coordinates(shapely.shortest_line(cut_line, shapely.Point(point)))[0]
