"""Where a triangle mesh in space passes through itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    """Which segments pass through the inside of their triangle, by the signs of five volumes."""

    def volume(p: Floats, q: Floats, r: Floats, s: Floats) -> Floats:
        return np.einsum("ij,ij->i", np.cross(q - p, r - p), s - p)

    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    across = volume(a, b, c, start) * volume(a, b, c, end) < 0.0
    around = np.stack([volume(start, end, a, b), volume(start, end, b, c), volume(start, end, c, a)])
    return across & ((around > 0.0).all(axis=0) | (around < 0.0).all(axis=0))
