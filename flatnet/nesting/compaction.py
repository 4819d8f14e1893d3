"""Push the copies of a layout apart to their gap, and together along the roll, by linear programs.

The engine works in single precision, and finds copies that fill the width exactly only where its strip is a little
wider. So what it lays overlaps by a trifle, and hangs over the roll by one. Here every copy is shifted a little, none
turned, such that all keep the gap, lie on the roll and end as early as they can: after Z. Li and V. Milenkovic,
'Compaction and separation algorithms for non-convex polygons and their applications', European Journal of
Operational Research 84 (1995).

What keeps two copies apart is linear in their shifts: a vertex p of one that is near the outline of the other, whose
outward normal is n at the nearest place q, stays outside by the gap where

    n . (p + t_1 - q - t_2) >= gap.

Near q the other piece lies behind the line across n. So what satisfies it is a valid layout, not a first guess at one,
as long as all vertices within reach of the largest shift have their row. How far copies shift against each other is
bounded tightly where they are near, so that few vertices are within reach, and loosely alone, so that few rounds do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

#: The largest shift in a round of copies that are near each other against each other, as a part of the roll's width,
#: and of one alone, in these steps: what is far away may come much nearer in a round.
STEP, FAR = 2e-3, 4.0
#: Rounds at the most, and the part of the length that the last one has to gain.
ROUNDS, GAIN = 40, 1e-5
#: What a mm of overlap costs in mm of length: more than the copies that one may stand in the way of.
OVERLAP_COST = 1e4
#: mm within which a vertex touches an edge, from outside or inside: what the engine overlaps by is less.
TOUCH = 0.02
#: Sine of the angle by which an outline that leaves a touched edge may turn into it, by rounding.
INTO = 1e-3


@dataclass(frozen=True)
class Contacts:
    """Places where two outlines are near each other.

    Attributes
    ----------
    first, second : (n,) numbers of the outlines.
    normals : (n, 2), from the second to the first.
    rooms : (n,) mm that the first is away from the second along them; negative where they overlap.
    """

    first: Indices
    second: Indices
    normals: Floats
    rooms: Floats


def compact(outlines: Sequence[Floats], width: float, gap: float) -> Floats:
    """Shifts that make a layout valid and as short as small shifts can.

    It stays invalid where the width has no room for the copies as they lie side by side, or where they overlap by more
    than `TOUCH`.

    Parameters
    ----------
    outlines : of the copies where they lie, (n, 2) mm each, anticlockwise, simple, without edges of no length.
    width : of the roll, which lies at 0 <= y <= width, mm.
    gap : that copies keep, mm.

    Returns
    -------
    shifts : (copies, 2), mm; the layout then starts at x = 0.
    """
    edges = Edges.of(outlines)
    shifts = np.zeros((len(outlines), 2))
    shorter = np.inf
    for _ in range(ROUNDS):
        shifts[:, 0] -= (edges.low + shifts)[:, 0].min()
        change, length = _round(edges, shifts, width, gap, STEP * width)
        shifts += change
        if shorter - length <= GAIN * length:
            break
        shorter = length
    shifts[:, 0] -= (edges.low + shifts)[:, 0].min()
    return shifts


def _round(edges: Edges, shifts: Floats, width: float, gap: float, step: float) -> tuple[Floats, float]:
    """The best further shifts, and the length then; by up to `FAR` steps in x and in y, near copies by one apart."""
    # Not at the top: it takes its time to import.
    from scipy.optimize import linprog

    count = len(shifts)
    low, high = edges.low + shifts, edges.high + shifts
    near = contacts(edges, shifts, gap, gap + np.sqrt(2.0) * step)
    first, second = near.first, near.second
    # Unknown: x and y of every shift, the length, the overlap. All rows say: row . unknown <= limit.
    #   [ apart, below, above, before, behind   -1 ]
    #   [ together                               0 ]
    apart = _rows(
        [2 * first, 2 * first + 1, 2 * second, 2 * second + 1], np.hstack([-near.normals, near.normals]), count
    )
    copies, ones = np.arange(count), np.ones((count, 1))
    below = _rows([2 * copies + 1], -ones, count)
    above = _rows([2 * copies + 1], ones, count)
    before = _rows([2 * copies], -ones, count)
    behind = _rows([2 * copies, np.full(count, 2 * count)], np.hstack([ones, -ones]), count)
    relaxed = scipy.sparse.vstack([apart, below, above, before, behind])
    one, other = edges.neighbours(shifts, gap + 2.0 * np.sqrt(2.0) * FAR * step)
    either = np.tile([1.0, -1.0], (len(one), 1))
    together = [_rows([2 * one + axis, 2 * other + axis], either, count) for axis in (0, 1)]
    limits = [near.rooms - gap, low[:, 1], width - high[:, 1], low[:, 0], -high[:, 0], np.full(2 * len(one), step)]
    answer = linprog(
        np.concatenate([np.zeros(2 * count), [1.0, OVERLAP_COST]]),
        scipy.sparse.block_array([[relaxed, -np.ones((relaxed.shape[0], 1))], [scipy.sparse.vstack(together), None]]),
        np.concatenate(limits),
        bounds=[(-FAR * step, FAR * step)] * (2 * count) + [(0.0, None)] * 2,
        method="highs",
    )
    if answer.x is None:  # it gave up: nothing is moved
        return np.zeros((count, 2)), float(high[:, 0].max())
    return answer.x[: 2 * count].reshape(count, 2), float(answer.x[-2])


def _rows(columns: Sequence[Indices], values: Floats, count: int) -> scipy.sparse.csr_array:
    """Rows of the program without its last column, (n, 2 count + 1), with their values (n, columns)."""
    n = len(values)
    row = np.repeat(np.arange(n), len(columns))
    return scipy.sparse.csr_array((values.ravel(), (row, np.column_stack(columns).ravel())), shape=(n, 2 * count + 1))


@dataclass(frozen=True)
class Edges:
    """The edges of all outlines where these lay at first; each starts at the vertex that has its number.

    Attributes
    ----------
    owner : number of the outline.
    first : of each outline, its first edge.
    before, after : the edges that end where this one starts, and start where it ends.
    starts, along, normals : (n, 2), unit vectors but for the first; normals point outwards.
    lengths : mm.
    convex : whether the outline has a convex corner where the edge starts.
    low, high : (outlines, 2), corners of their boxes, mm.
    trees : of each outline, its edges to search in.
    """

    owner: Indices
    first: Indices
    before: Indices
    after: Indices
    starts: Floats
    along: Floats
    normals: Floats
    lengths: Floats
    convex: NDArray[np.bool_]
    low: Floats
    high: Floats
    trees: tuple[shapely.STRtree, ...]

    @classmethod
    def of(cls, outlines: Sequence[Floats]) -> Edges:
        sizes = np.array([len(outline) for outline in outlines])
        first = np.cumsum(sizes) - sizes
        base, size = np.repeat(first, sizes), np.repeat(sizes, sizes)
        within = np.arange(sizes.sum()) - base
        before, after = base + (within - 1) % size, base + (within + 1) % size
        starts = np.concatenate(outlines)
        along = starts[after] - starts
        lengths = np.hypot(*along.T)
        along = along / lengths[:, None]
        normals = np.column_stack([along[:, 1], -along[:, 0]])
        segments = shapely.linestrings(np.stack([starts, starts[after]], axis=1))
        return cls(
            np.repeat(np.arange(len(outlines)), sizes),
            first,
            before,
            after,
            starts,
            along,
            normals,
            lengths,
            _dot(normals[before], along) < 0.0,
            np.minimum.reduceat(starts, first),
            np.maximum.reduceat(starts, first),
            tuple(shapely.STRtree(part) for part in np.split(segments, first[1:])),
        )

    def neighbours(self, shifts: Floats, reach: float) -> tuple[Indices, Indices]:
        """All ordered pairs of outlines whose boxes, moved by shifts, are within a reach of each other, mm."""
        boxes = shapely.box(*(self.low + shifts - 0.5 * reach).T, *(self.high + shifts + 0.5 * reach).T)
        one, other = shapely.STRtree(boxes).query(boxes)
        return one[one != other], other[one != other]

    def within(self, shifts: Floats, reach: float) -> tuple[Indices, Indices]:
        """Corners and edges of different outlines, moved by shifts, that are within a reach of each other, mm."""
        corners = np.flatnonzero(_dot(self.along[self.before], self.normals) >= -2.0 * INTO)
        first = np.searchsorted(corners, self.first)
        corners_of = np.split(corners, first[1:])
        starts_of = np.split(self.starts[corners], first[1:])
        low, high = self.low - reach, self.high + reach
        vertices, edges = [np.zeros(0, np.intp)], [np.zeros(0, np.intp)]
        for one, other in zip(*self.neighbours(shifts, reach)):
            there = starts_of[one] + (shifts[one] - shifts[other])
            inside = np.flatnonzero(((there >= low[other]) & (there <= high[other])).all(axis=1))
            vertex, edge = self.trees[other].query(shapely.points(there[inside]), "dwithin", distance=reach)
            vertices.append(corners_of[one][inside[vertex]])
            edges.append(self.first[other] + edge)
        return np.concatenate(vertices), np.concatenate(edges)


def contacts(edges: Edges, shifts: Floats, gap: float, reach: float) -> Contacts:
    """What outlines moved by shifts have to be kept apart at, within a reach: vertices and edges, and convex corners.

    A vertex may meet the edges that it lies before, and the convex corners in whose cone of normals it lies, but only
    where both edges of its own leave them: where one turns towards them, it is that edge that meets the other's corner.
    Beyond an end that is no convex corner it need not be nearer to the outline than to the edge's line: it lies before
    the edge only if it keeps the gap to that.
    """
    vertex, edge = edges.within(shifts, reach)
    here = edges.starts[vertex] + (shifts[edges.owner[vertex]] - shifts[edges.owner[edge]])
    away = here - edges.starts[edge]
    along, height = _dot(away, edges.along[edge]), _dot(away, edges.normals[edge])
    end = np.where(along < 0.5 * edges.lengths[edge], edge, edges.after[edge])  # the nearer one
    beyond = (along < -TOUCH) | (along > edges.lengths[edge] + TOUCH)

    before = ~(beyond & edges.convex[end]) & (height >= np.where(beyond, gap, 0.0) - TOUCH)
    before &= _leaves(edges, vertex, edges.normals[edge])
    at_corner = np.minimum(np.abs(along), np.abs(along - edges.lengths[edge])) <= TOUCH
    at_corner &= before & (height <= TOUCH) & edges.convex[end]
    before[at_corner] = _one_at_each(vertex[at_corner], end[at_corner], edges.normals[edge[at_corner], 0])

    beyond &= edges.convex[end]
    away = here - edges.starts[end]
    distance = np.hypot(*away.T)
    outward = away / np.where(beyond, distance, 1.0)[:, None]
    cone = (_dot(away, edges.along[end]) <= 0.0) & (_dot(away, edges.along[edges.before[end]]) >= 0.0)
    corner = beyond & cone & _leaves(edges, vertex, outward)
    return Contacts(
        edges.owner[np.concatenate([vertex[before], vertex[corner]])],
        edges.owner[np.concatenate([edge[before], edge[corner]])],
        np.concatenate([edges.normals[edge[before]], outward[corner]]),
        np.concatenate([height[before], distance[corner]]),
    )


def _leaves(edges: Edges, vertex: Indices, normals: Floats) -> NDArray[np.bool_]:
    """Whether both edges that meet at vertices lead away from lines across normals."""
    return np.minimum(_dot(edges.along[vertex], normals), -_dot(edges.along[edges.before[vertex]], normals)) >= -INTO


def _one_at_each(vertex: Indices, corner: Indices, along_roll: Floats) -> NDArray[np.bool_]:
    """Of the two edges of a convex corner that a vertex touches, the one that lets it go along the roll.

    It has to stay before one of them only.

    Parameters
    ----------
    along_roll : component along the roll of the edges' normals.
    """
    order = np.argsort(np.abs(along_roll), kind="stable")
    _, first = np.unique(np.column_stack([vertex, corner])[order], axis=0, return_index=True)
    chosen = np.zeros(len(vertex), bool)
    chosen[order[first]] = True
    return chosen


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("ij,ij->i", a, b)
