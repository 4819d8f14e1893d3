"""Where a closed polygon in the plane crosses or touches itself."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

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
        two edges coincide in space the edges are sides of a slit: those may touch, and overlap by
        `SLIT_TOLERANCE` mean edges.

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
    if space is not None and meet.any():
        meet &= ~_slit_sides(i, j, space, starts, ends)
    order = np.lexsort((j[meet], i[meet]))
    pairs = zip(i[meet][order], s[meet][order], j[meet][order], t[meet][order])
    return [(int(a), float(b), int(c), float(d)) for a, b, c, d in pairs]


def _cross(u: Floats, v: Floats) -> Floats:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _dot(u: Floats, v: Floats) -> Floats:
    return np.einsum("ij,ij->i", u, v)


def _meeting_points(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Fractions s of the segments ab and t of cd at their common point, and whether there is one."""
    u, v, w = b - a, d - c, c - a
    lengths = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
    # Differences of the corners carry the rounding of their own coordinates.
    reach = np.abs(np.concatenate([a, b, c, d], axis=1)).max(axis=1, initial=0.0)
    slack = ROUND_OFF * reach / np.minimum(np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1))
    area = _cross(u, v)
    parallel = np.abs(area) <= (ROUND_OFF + slack) * lengths

    safe = np.where(parallel, 1.0, area)
    s, t = _cross(w, v) / safe, _cross(w, u) / safe
    slack = slack * lengths / np.abs(safe)
    meet = (s >= -slack) & (s <= 1 + slack) & (t >= -slack) & (t <= 1 + slack) & ~parallel

    # Parallel segments meet where they are on one line and overlap along it.
    squared = _dot(u, u)
    from_c, from_d = _dot(w, u) / squared, _dot(w + v, u) / squared
    first = np.maximum(0.0, np.minimum(from_c, from_d))
    overlap = first <= np.minimum(1.0, np.maximum(from_c, from_d))
    on_line = np.abs(_cross(w, u)) <= (ROUND_OFF + slack) * np.linalg.norm(w, axis=1) * np.sqrt(squared)
    both = parallel & on_line & overlap
    along = np.where(from_d == from_c, 1.0, from_d - from_c)
    s, t = np.where(both, first, s), np.where(both, (first - from_c) / along, t)
    return np.clip(s, 0.0, 1.0), np.clip(t, 0.0, 1.0), meet | both


def _slit_sides(i: Ints, j: Ints, space: Floats, starts: Floats, ends: Floats) -> NDArray[np.bool_]:
    """Whether edges i and j have a point of space in common and overlap by no more than the tolerance."""
    n = len(space)
    mean_edge = np.linalg.norm(ends - starts, axis=1).mean()
    cells = np.round((space - space.min(axis=0)) / (SAME_POINT * mean_edge))
    point = np.unique(cells, axis=0, return_inverse=True)[1].reshape(-1)
    corners_i, corners_j = (np.stack([point[e], point[(e + 1) % n]], axis=1) for e in (i, j))
    share = (corners_i[:, :, None] == corners_j[:, None, :]).any(axis=(1, 2))

    depth = np.min(
        [
            _distance(starts[i], starts[j], ends[j]),
            _distance(ends[i], starts[j], ends[j]),
            _distance(starts[j], starts[i], ends[i]),
            _distance(ends[j], starts[i], ends[i]),
        ],
        axis=0,
    )
    return share & (depth <= SLIT_TOLERANCE * mean_edge)


def _distance(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Distance of each point to its segment."""
    along = ends - starts
    fraction = np.clip(_dot(points - starts, along) / _dot(along, along), 0.0, 1.0)
    return np.linalg.norm(points - starts - fraction[:, None] * along, axis=1)
