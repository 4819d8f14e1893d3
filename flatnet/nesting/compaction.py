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
as long as all vertices within reach of the largest shift have their row.
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

#: The largest shift in a round, as a part of the roll's width.
STEP = 2e-3
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
    shifts = np.zeros((len(outlines), 2))
    shorter = np.inf
    for _ in range(ROUNDS):
        shifts[:, 0] -= _start(outlines, shifts)
        moved = [outline + shift for outline, shift in zip(outlines, shifts)]
        change, length = _round(moved, width, gap, STEP * width)
        shifts += change
        if shorter - length <= GAIN * length:
            break
        shorter = length
    shifts[:, 0] -= _start(outlines, shifts)
    return shifts


def _start(outlines: Sequence[Floats], shifts: Floats) -> float:
    """Where a layout starts along the roll, mm."""
    return min(float(outline[:, 0].min()) + x for outline, x in zip(outlines, shifts[:, 0].tolist()))


def _round(outlines: Sequence[Floats], width: float, gap: float, step: float) -> tuple[Floats, float]:
    """The best shifts of at most a step in x and in y, and the length then."""
    # Not at the top: it takes its time to import.
    from scipy.optimize import linprog

    count = len(outlines)
    low, high = (np.array([end(outline, axis=0) for outline in outlines]) for end in (np.min, np.max))
    reach = gap + 2.0 * np.sqrt(2.0) * step
    near = contacts(outlines, reach)
    first, second = near.first, near.second
    # Unknown: x and y of every shift, the length, the overlap. All rows say: row . unknown <= limit.
    apart = _rows(
        [2 * first, 2 * first + 1, 2 * second, 2 * second + 1], np.hstack([-near.normals, near.normals]), count
    )
    copies, ones = np.arange(count), np.ones((count, 1))
    below = _rows([2 * copies + 1], -ones, count)
    above = _rows([2 * copies + 1], ones, count)
    before = _rows([2 * copies], -ones, count)
    behind = _rows([2 * copies, np.full(count, 2 * count)], np.hstack([ones, -ones]), count)
    limits = [near.rooms - gap, low[:, 1], width - high[:, 1], low[:, 0], -high[:, 0]]
    answer = linprog(
        np.concatenate([np.zeros(2 * count), [1.0, OVERLAP_COST]]),
        scipy.sparse.vstack([apart, below, above, before, behind]),
        np.concatenate(limits),
        bounds=[(-step, step)] * (2 * count) + [(0.0, None)] * 2,
        method="highs",
    )
    if answer.x is None:  # it gave up: nothing is moved
        return np.zeros((count, 2)), float(high[:, 0].max())
    return answer.x[: 2 * count].reshape(count, 2), float(answer.x[-2])


def _rows(columns: Sequence[Indices], values: Floats, count: int) -> scipy.sparse.csr_array:
    """Rows of the program, (n, 2 count + 2), with their values (n, columns); the overlap relaxes every one."""
    n = len(values)
    at = np.column_stack([*columns, np.full(n, 2 * count + 1)])
    content = np.column_stack([values, -np.ones(n)])
    row = np.repeat(np.arange(n), at.shape[1])
    return scipy.sparse.csr_array((content.ravel(), (row, at.ravel())), shape=(n, 2 * count + 2))


@dataclass(frozen=True)
class _Edges:
    """The edges of all outlines; each starts at the vertex that has its number.

    Attributes
    ----------
    owner : number of the outline.
    before, after : the edges that end where this one starts, and start where it ends.
    starts, along, normals : (n, 2), unit vectors but for the first; normals point outwards.
    lengths : mm.
    convex : whether the outline has a convex corner where the edge starts.
    """

    owner: Indices
    before: Indices
    after: Indices
    starts: Floats
    along: Floats
    normals: Floats
    lengths: Floats
    convex: NDArray[np.bool_]

    @classmethod
    def of(cls, outlines: Sequence[Floats]) -> _Edges:
        sizes = np.array([len(outline) for outline in outlines])
        base = np.repeat(np.cumsum(sizes) - sizes, sizes)
        within = np.arange(sizes.sum()) - base
        size = np.repeat(sizes, sizes)
        before, after = base + (within - 1) % size, base + (within + 1) % size
        starts = np.concatenate(outlines)
        along = starts[after] - starts
        lengths = np.hypot(*along.T)
        along = along / lengths[:, None]
        normals = np.column_stack([along[:, 1], -along[:, 0]])
        owner = np.repeat(np.arange(len(outlines)), sizes)
        return cls(owner, before, after, starts, along, normals, lengths, _dot(normals[before], along) < 0.0)


def contacts(outlines: Sequence[Floats], reach: float) -> Contacts:
    """What has to be kept apart within a reach, mm: vertices and edges, and convex corners.

    A vertex may meet the edges that it lies before, and the convex corners in whose cone of normals it lies, but only
    where both edges of its own leave them: where one turns towards them, it is that edge that meets the other's corner.
    """
    edges = _Edges.of(outlines)
    segments = shapely.linestrings(np.stack([edges.starts, edges.starts[edges.after]], axis=1))
    vertex, edge = shapely.STRtree(segments).query(shapely.points(edges.starts), "dwithin", distance=reach)
    between = edges.owner[vertex] != edges.owner[edge]
    vertex, edge = vertex[between], edge[between]
    away = edges.starts[vertex] - edges.starts[edge]
    along, height = _dot(away, edges.along[edge]), _dot(away, edges.normals[edge])
    end = np.where(along < 0.5 * edges.lengths[edge], edge, edges.after[edge])  # the nearer one
    beyond = ((along < -TOUCH) | (along > edges.lengths[edge] + TOUCH)) & edges.convex[end]

    before = ~beyond & (height >= -TOUCH) & _leaves(edges, vertex, edges.normals[edge])
    at_corner = np.minimum(np.abs(along), np.abs(along - edges.lengths[edge])) <= TOUCH
    at_corner &= before & (height <= TOUCH) & edges.convex[end]
    before[at_corner] = _one_at_each(vertex[at_corner], end[at_corner], edges.normals[edge[at_corner], 0])

    away = edges.starts[vertex] - edges.starts[end]
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


def _leaves(edges: _Edges, vertex: Indices, normals: Floats) -> NDArray[np.bool_]:
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
