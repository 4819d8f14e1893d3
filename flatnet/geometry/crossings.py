"""Where a closed polygon in the plane crosses or touches itself."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.geometry.delaunay import planar_cross
from flatnet.geometry.polygon import side_lengths
from flatnet.geometry.triangles import dot

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: How deep the two sides of a slit may overlap, in mean edges.
SLIT_TOLERANCE = 1e-3
#: An area below this share of the product of the lengths that span it is round-off.
ROUND_OFF = 1e-14
#: Vertices in space nearer than this, in mean edges, are one point.
SAME_POINT = 1e-9


def polygon_crossings(positions: Floats, space: Floats | None = None) -> list[tuple[int, float, int, float]]:
    """Every pair of edges that are no neighbours and share a point.

    Parameters
    ----------
    positions : (n, 2) float; edge i runs from vertex i to vertex i + 1, the last one back to the first.
    space : (n, 3) float, optional; the polygon in space that this one is the flat image of. Where vertices of
        two edges coincide in space the edges belong to a slit: its sides may touch, and overlap by
        `SLIT_TOLERANCE` mean edges. For a polygon that runs anticlockwise.

    Returns
    -------
    list of (i, s, j, t), sorted, i < j : edge i at its fraction s meets edge j at its fraction t.
    """
    n = len(positions)
    starts, ends = positions, np.roll(positions, -1, axis=0)
    lines = shapely.linestrings(np.stack([starts, ends], axis=1))
    i, j = shapely.STRtree(lines).query(lines)
    apart = (i < j) & (j - i > 1) & (j - i < n - 1)
    i, j = i[apart], j[apart]

    s, t, meet = _meeting_points(starts[i], ends[i], starts[j], ends[j])
    i, s, j, t = i[meet], s[meet], j[meet], t[meet]
    if space is not None and len(i):
        crossing = ~_along_slit(i, s, j, positions, space)
        i, s, j, t = i[crossing], s[crossing], j[crossing], t[crossing]
    order = np.lexsort((j, i))
    pairs = zip(i[order], s[order], j[order], t[order])
    return [(int(a), float(b), int(c), float(d)) for a, b, c, d in pairs]


def _meeting_points(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Fractions s of the segments ab and t of cd at their common point, and whether there is one."""
    u, v, w = b - a, d - c, c - a
    lengths = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
    # Differences of the corners carry the rounding of their own coordinates.
    reach = np.abs(np.concatenate([a, b, c, d], axis=1)).max(axis=1, initial=0.0)
    slack = ROUND_OFF * reach / np.minimum(np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1))
    area = planar_cross(u, v)
    parallel = np.abs(area) <= (ROUND_OFF + slack) * lengths

    safe = np.where(parallel, 1.0, area)
    s, t = planar_cross(w, v) / safe, planar_cross(w, u) / safe
    slack = slack * lengths / np.abs(safe)
    meet = (s >= -slack) & (s <= 1 + slack) & (t >= -slack) & (t <= 1 + slack) & ~parallel

    # Parallel segments meet where they are on one line and overlap along it.
    squared = dot(u, u)
    from_c, from_d = dot(w, u) / squared, dot(w + v, u) / squared
    first = np.maximum(0.0, np.minimum(from_c, from_d))
    overlap = first <= np.minimum(1.0, np.maximum(from_c, from_d))
    on_line = np.abs(planar_cross(w, u)) <= (ROUND_OFF + slack) * np.linalg.norm(w, axis=1) * np.sqrt(squared)
    both = parallel & on_line & overlap
    along = np.where(from_d == from_c, 1.0, from_d - from_c)
    s, t = np.where(both, first, s), np.where(both, (first - from_c) / along, t)
    return np.clip(s, 0.0, 1.0), np.clip(t, 0.0, 1.0), meet | both


def _along_slit(i: Ints, s: Floats, j: Ints, positions: Floats, space: Floats) -> NDArray[np.bool_]:
    """Whether what edges i and j have in common is no more than two sides of a slit may have.

    The two sides of one edge of space lie each to the right of the other, up to the tolerance. Other edges of
    the slit meet only where their common point of space is.
    """
    n = len(space)
    following = (np.arange(n) + 1) % n
    tolerance = SLIT_TOLERANCE * float(side_lengths(positions).mean())
    cells = np.round((space - space.min(axis=0)) / (SAME_POINT / SLIT_TOLERANCE * tolerance))
    point = np.unique(cells, axis=0, return_inverse=True)[1].reshape(-1)

    def left_of(edge: Ints, vertex: Ints) -> Floats:
        along = positions[following[edge]] - positions[edge]
        return planar_cross(along, positions[vertex] - positions[edge]) / np.linalg.norm(along, axis=1)

    both_sides = (point[i] == point[following[j]]) & (point[following[i]] == point[j])
    depth = np.max([left_of(i, j), left_of(i, following[j]), left_of(j, i), left_of(j, following[i])], axis=0)

    place = positions[i] + s[:, None] * (positions[following[i]] - positions[i])
    at_common_point = np.zeros(len(i), dtype=bool)
    for a in (i, following[i]):
        for b in (j, following[j]):
            reach = np.maximum(*(np.linalg.norm(positions[corner] - place, axis=1) for corner in (a, b)))
            at_common_point |= (point[a] == point[b]) & (reach <= tolerance)
    return np.where(both_sides, depth <= tolerance, at_common_point)
