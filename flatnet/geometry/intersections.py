"""Where a triangle mesh in space passes through itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.geometry.triangles import cross, dot

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A volume below this share of the product of the lengths that span it is round-off: the points lie in a plane.
ROUND_OFF = 1e-14


def self_intersections(vertices: Floats, triangles: Ints) -> Ints:
    """Pairs of triangles that pass through each other, (k, 2), first index lower, sorted.

    Two triangles cross where an edge of one passes through the inside of the other. Pairs with a common edge
    are left to the hinge angle; of pairs with a common vertex only the edges away from it count.
    """
    corners = vertices[triangles]
    centres = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1)
    pairs = cKDTree(centres).query_pairs(2.0 * radius.max(), output_type="ndarray")
    near = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1) < radius[pairs].sum(axis=1)
    pairs = pairs[near]
    low, high = corners.min(axis=1), corners.max(axis=1)
    a, b = pairs.T
    pairs = pairs[((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)]
    a, b = pairs.T
    shared = (triangles[a][:, :, None] == triangles[b][:, None, :]).sum(axis=(1, 2))
    pairs = pairs[shared < 2]
    crossing = np.zeros(len(pairs), dtype=bool)
    for first, second in (pairs.T, pairs[:, ::-1].T):
        for edge in range(3):
            ends = triangles[first][:, [edge, (edge + 1) % 3]]
            apart = ~(ends[:, :, None] == triangles[second][:, None, :]).any(axis=(1, 2))
            crossing[apart] |= _pierces(
                vertices[ends[apart, 0]], vertices[ends[apart, 1]], corners[second[apart]]
            )
    found = pairs[crossing]
    return found[np.lexsort(found.T[::-1])]


def _pierces(start: Floats, end: Floats, corners: Floats) -> NDArray[np.bool_]:
    """Which segments pass through the inside of their triangle, by the signs of five volumes; not in its plane."""

    def side(p: Floats, q: Floats, r: Floats, s: Floats) -> Floats:
        """On which side of the plane through p, q, r point s lies, and 0 on it, (k,)."""
        u, v, w = q - p, r - p, s - p
        volume = dot(cross(u, v), w)
        reach = np.sqrt(dot(u, u) * dot(v, v) * dot(w, w))
        return np.where(np.abs(volume) > ROUND_OFF * reach, np.sign(volume), 0.0)

    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    across = side(a, b, c, start) * side(a, b, c, end) < 0.0
    around = side(start, end, a, b) + side(start, end, b, c) + side(start, end, c, a)
    return across & (np.abs(around) == 3.0)
