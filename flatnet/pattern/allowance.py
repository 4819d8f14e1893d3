"""The cut line: the parallel curve of a sew line whose distance may change from edge to edge, corner by corner.

An edge of width a has a strip: the points outside it whose foot lies on the edge, no farther away than a. The
piece is the sew line's region, all strips, and what is laid between the strips at a corner. So every point of the
cut line that belongs to no corner is exactly the width of its edge away from it, and none is nearer to an edge
than that edge's width.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Geometry, Polygon

from flatnet.project.seam_specs import Ends

Floats = NDArray[np.float64]
#: Points at a corner in its own frame: x along the edge before it, y out of the piece, mm.
_Local = list[tuple[float, float]]

#: A corner of the cut line lies at most this many allowances from the sew line's (the trade's mitre limit).
MITRE_LIMIT = 3.5
#: Sides of a slit lie on each other up to round-off: an overlap narrower than this, mm, is none.
TOUCH = 1e-3
#: A repaired cut line lies on a grid this fine, mm: with free coordinates GEOS now and then loses a sliver.
GRID = 1e-7
#: A turn within this of 180 degrees is a slit's tip, rad.
TURNS_BACK = 1e-9
#: The end of an allowance is folded or squared over edges that turn by more than this, rad; at a flatter corner the
#: line to which it ends is hardly met.
LEAST_TURN = math.radians(15.0)


@dataclass(frozen=True)
class Corner:
    """How the allowances of two edges meet; `edge` is the one that is folded or squared to."""

    ends: Ends
    edge: Literal["before", "after"] = "before"


class _Joint(NamedTuple):
    """The cut line at one vertex.

    points : (k, 2) mm, from the parallel of the edge before it to that of the edge after it.
    turn : of the sew line, to the left, rad.
    cut_away : the corners of what no allowance may cover; none where no allowance is folded or squared.
    """

    points: Floats
    turn: float
    cut_away: Floats


@dataclass(frozen=True, eq=False)
class CutLine:
    """A cut line and what had to give way.

    Attributes
    ----------
    outline : (k, 2) float, mm, anticlockwise.
    holes : (k, 2) float each, clockwise: what a sew line that closes on itself goes round.
    crowded : (first edge, count) of every run of sew line edges that has no room for its allowance, because the
        piece or another allowance is in its way, where that is more than the inside of a corner.
    """

    outline: Floats
    holes: tuple[Floats, ...] = ()
    crowded: tuple[tuple[int, int], ...] = ()


def cut_line(
    outline: Floats, region: Polygon, widths: Floats, corners: Mapping[int, Corner] | None = None
) -> CutLine:
    """The outline with an allowance on every edge.

    Where the parallel curve crosses itself, in a notch narrower than its allowances or a closed slit, it is
    repaired: the union of the region, the strips and the corners takes its place.

    Parameters
    ----------
    outline : (n, 2) float, mm, anticlockwise; may touch itself.
    region : what is inside it.
    widths : (n,) float, mm, not negative; of the edge from vertex i to vertex i + 1.
    corners : vertex -> how allowances meet there; a mitre at all others.
    """
    closed = _is_closed(outline, region)
    widths = np.where(closed, 0.0, widths)
    if not widths.any():
        return CutLine(outline)
    joints = _joints(outline, widths, corners or {})
    parallel = np.concatenate([joint.points for joint in joints])
    simple = Polygon(parallel)
    if _runs_forward(outline, joints) and simple.is_valid and simple.exterior.is_ccw:
        return CutLine(parallel)
    return _repaired(outline, region, widths, joints, ~closed)


def _is_closed(outline: Floats, region: Polygon) -> NDArray[np.bool_]:
    """Which edges have the piece on both sides: those of a slit that lies closed in the plane."""
    middles = shapely.points(0.5 * (outline + np.roll(outline, -1, axis=0)))
    closed: NDArray[np.bool_] = shapely.distance(region.boundary, middles) > TOUCH
    return closed


def _joints(outline: Floats, widths: Floats, corners: Mapping[int, Corner]) -> list[_Joint]:
    """The cut line at every vertex."""
    along = _directions(outline)
    mitre = Corner(Ends())
    joints = []
    for vertex, after in enumerate(along):
        before = along[vertex - 1]
        turn = _turn(before, after)
        a, b, corner = float(widths[vertex - 1]), float(widths[vertex]), corners.get(vertex, mitre)
        width = a if corner.edge == "before" else b
        folded = corner.ends.is_folded and LEAST_TURN < turn < math.pi - LEAST_TURN and width > 0.0
        local, beyond = _folded(turn, a, b, corner) if folded else (_corner(turn, a, b, corner.ends), [])
        frame = np.array([before, _outward(before)])
        points, cut_away = (outline[vertex] + np.reshape(part, (-1, 2)) @ frame for part in (local, beyond))
        joints.append(_Joint(points, turn, cut_away))
    return joints


def _directions(outline: Floats) -> Floats:
    edges = np.roll(outline, -1, axis=0) - outline
    unit: Floats = edges / np.linalg.norm(edges, axis=1)[:, None]
    return unit


def _outward(along: Floats) -> Floats:
    """The normal out of the piece, on the right of a direction, (..., 2)."""
    return np.stack([along[..., 1], -along[..., 0]], axis=-1)


def _turn(before: Floats, after: Floats) -> float:
    """The angle to the left from one direction to the next, rad; -pi at a slit's tip, where it turns back."""
    turn = math.atan2(before[0] * after[1] - before[1] * after[0], before @ after)
    return -math.pi if abs(turn) > math.pi - TURNS_BACK else turn


def _corner(turn: float, a: float, b: float, ends: Ends) -> _Local:
    """The cut line at one corner, between edges of widths a and b, of which the second turns left by `turn`."""
    if a == b == 0.0:
        return [(0.0, 0.0)]
    if turn <= 0.0:
        return _inner(turn, a, b)
    if ends.kind == "bevel":
        return [(0.0, a), _along_second(turn, 0.0, b)]
    return _outer(turn, a, b, MITRE_LIMIT * max(a, b) if ends.length is None else ends.length)


def _along_second(turn: float, x: float, y: float) -> tuple[float, float]:
    """A point x along the second edge and y out of it, in the frame of the first."""
    return x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)


def _crossing(turn: float, a: float, b: float) -> tuple[float, float]:
    """How far the parallels' crossing lies along the first edge beyond its end, and along the second one."""
    sine, cosine = math.sin(turn), math.cos(turn)
    return (b - a * cosine) / sine, (b * cosine - a) / sine


def _outer(turn: float, a: float, b: float, reach: float) -> _Local:
    """A mitre; what is farther than `reach` from the sew line's corner is cut off square to the bisector."""
    end, start = (0.0, a), _along_second(turn, 0.0, b)
    first, second = _crossing(turn, a, b)
    if first < 0.0 or second > 0.0:  # widths so different that the parallels cross over one of the edges
        return [end, start]
    # With d the unit bisector out of the corner, the first parallel at x is (x, a) d out, d = (sin, cos)(turn / 2).
    sine, cosine = math.sin(0.5 * turn), math.cos(0.5 * turn)
    if first * sine + a * cosine <= reach:
        return [(first, a)]
    x = min(max((reach - a * cosine) / sine, 0.0), first)
    y = min(max((reach - b * cosine) / sine, 0.0), -second)
    return [(x, a), _along_second(turn, -y, b)]


def _inner(turn: float, a: float, b: float) -> _Local:
    """Where the strips overlap: their parallels' crossing; where the wider one ends above the other, its end."""
    end, start = (0.0, a), _along_second(turn, 0.0, b)
    if turn == 0.0:
        return [end] if a == b else [end, start]
    if turn == -math.pi:
        return [end, start]
    first, second = _crossing(turn, a, b)
    if first > 0.0:
        return [end, (0.0, b / math.cos(turn))]
    if second < 0.0:
        return [_along_second(turn, 0.0, a / math.cos(turn)), start]
    return [(first, a)]


def _folded(turn: float, a: float, b: float, corner: Corner) -> tuple[_Local, _Local]:
    """An allowance ends as its fold wants it: on its own sew line where the other one's cut line comes in.

    From there it runs on as the mirror image of that cut line, so that both lie on each other when the allowance is
    folded over; or at a right angle. At a corner whose second edge is folded all is seen from behind: that is the
    mirror image in the bisector.

    Returns
    -------
    points : of the cut line.
    beyond : the corners of what has to be free of allowances, whichever edges they belong to.
    """
    if corner.edge == "after":
        seen = _folded(turn, b, a, Corner(corner.ends))
        points, beyond = ([_along_second(turn, -x, y) for x, y in reversed(part)] for part in seen)
        return points, beyond
    on_fold = b / math.sin(turn)
    slant = 1.0 / math.tan(turn) if corner.ends.kind == "mirrored" else 0.0
    deep, far = max(a, b), on_fold + 4.0 * (a + b)
    beyond = [(on_fold, 0.0), (on_fold + slant * deep, deep), (far + slant * deep, deep), (far, 0.0)]
    return [(on_fold + slant * a, a), (on_fold, 0.0)], beyond


def _runs_forward(outline: Floats, joints: Sequence[_Joint]) -> bool:
    """Whether the parallel of every edge runs in the edge's direction: none has vanished between its corners."""
    starts = np.array([joint.points[-1] for joint in joints])
    ends = np.array([joint.points[0] for joint in joints])
    run = np.roll(ends, -1, axis=0) - starts
    return bool((np.sum(run * _directions(outline), axis=1) >= 0.0).all())


def _repaired(
    outline: Floats, region: Polygon, widths: Floats, joints: Sequence[_Joint], outside: NDArray[np.bool_]
) -> CutLine:
    """The outline of the union of the region, the strips and the corners; `outside`: edges that have one."""
    following = np.roll(outline, -1, axis=0)
    out = widths[:, None] * _outward(_directions(outline))
    strips = shapely.polygons(np.stack([following, outline, outline + out, following + out], axis=1))
    filled = []
    for vertex, joint in enumerate(joints):
        if joint.turn > 0.0:  # between strips that part; at inner corners they overlap
            fan = [outline[vertex], outline[vertex] + out[vertex - 1], *joint.points, outline[vertex] + out[vertex]]
            filled.append(Polygon(fan).buffer(0.0))
    parts = np.array([part for part in (*strips, *filled) if part.area > 0.0])
    allowances = shapely.union_all(parts, grid_size=GRID)
    cut_away = shapely.union_all([Polygon(joint.cut_away) for joint in joints], grid_size=GRID)
    whole = shapely.union(region, shapely.difference(allowances, cut_away, grid_size=GRID), grid_size=GRID)
    outer, *holes = rings_of(whole)
    middles = shapely.points(0.5 * (outline + following) + out)
    lost = outside & shapely.contains(whole, middles) & (shapely.distance(whole.boundary, middles) > TOUCH)
    return CutLine(outer, tuple(holes), _crowded(outline, lost, widths))


def rings_of(region: Geometry) -> list[Floats]:
    """The outline of a region, anticlockwise, and its holes, clockwise, (k, 2) each, without crumbs of round-off."""
    whole = shapely.orient_polygons(max(shapely.get_parts(region), key=lambda part: part.area))
    slack = TOUCH * whole.length
    return [
        shapely.get_coordinates(ring)[:-1]
        for ring in (whole.exterior, *(hole for hole in whole.interiors if Polygon(hole).area > slack))
    ]


def _crowded(outline: Floats, lost: NDArray[np.bool_], widths: Floats) -> tuple[tuple[int, int], ...]:
    """Runs of edges that have lost their parallel, longer than the inside of a corner explains.

    Inside a corner as sharp as the mitre limit allows outside, each edge loses that many allowances.
    """
    lengths = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    runs = []
    for first, count in cyclic_runs(lost):
        edges = np.arange(first, first + count) % len(outline)
        if lengths[edges].sum() > 2.0 * MITRE_LIMIT * widths[edges].max():
            runs.append((first, count))
    return tuple(runs)


def cyclic_runs(marked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, count) of every run of marked elements of a ring."""
    if marked.all():
        return [(0, len(marked))]
    shift = int(np.flatnonzero(~marked)[0])  # a run that begins there begins nowhere before
    steps = np.diff(np.roll(marked, -shift).astype(int), append=0)
    starts, ends = np.flatnonzero(steps > 0) + 1, np.flatnonzero(steps < 0) + 1
    return [((int(a) + shift) % len(marked), int(b - a)) for a, b in zip(starts, ends, strict=True)]
