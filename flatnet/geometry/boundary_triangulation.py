"""Triangulate a closed polygon in space without any vertex inside: always exactly flattenable, seldom fair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import hinge_weights

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A triangle of less than this share of its longest side squared has no normal.
FLAT = 1e-6


def triangulate_boundary(vertices: Floats, normals: Floats) -> Ints:
    """The triangles between a boundary's vertices that bend little and are nearly tangent to the edge normals.

    Dynamic programming over the chords (i, j), as for the triangulation of least weight (Klincsek 1980): the cost of a
    triangle on a chord is its bending against the best triangles beyond its two other sides, theta^2 3 l^2 / (A1 + A2),
    and at a side on the boundary against the given normal. Because the best triangle beyond a side is chosen before
    this one (Liepa 2003), the sum is small but not always the least. O(n^3) time, O(n^2) memory.

    Parameters
    ----------
    vertices : (n, 3) float, mm; anticlockwise seen against the normals.
    normals : (n, 3) float, unit; of the edge from vertex i to vertex i + 1.

    Returns
    -------
    (n - 2, 3) int, anticlockwise. Empty where the polygon lies on a line.
    """
    n = len(vertices)
    cost = np.full((n, n), np.inf)
    apex = np.zeros((n, n), dtype=np.int64)
    beyond = np.zeros((n, n, 3))  # unit normal of the triangle beyond a chord, seen from the larger polygon
    area = np.full((n, n), np.nan)  # and its area; nan at the boundary, where the triangle itself is taken
    i = np.arange(n - 1)
    cost[i, i + 1], beyond[i, i + 1] = 0.0, normals[:-1]
    for gap in range(2, n):
        i = np.arange(n - gap)[:, None]
        j = i + gap
        k = i + np.arange(1, gap)
        across = np.cross(vertices[k] - vertices[i], vertices[j] - vertices[i])
        twice = np.linalg.norm(across, axis=2)
        sides = [np.linalg.norm(vertices[a] - vertices[b], axis=2) for a, b in ((i, k), (k, j), (i, j))]
        thin = twice < FLAT * np.max(np.broadcast_arrays(*sides), axis=0) ** 2
        unit_normals = across / np.where(thin, 1.0, twice)[:, :, None]
        total = cost[i, k] + cost[k, j]
        for a, b, length in ((i, k, sides[0]), (k, j, sides[1])):
            total = total + _bend(unit_normals, 0.5 * twice, beyond[a, b], area[a, b], length)
        if gap == n - 1:
            closing = np.broadcast_to(normals[-1], unit_normals.shape)
            total = total + _bend(unit_normals, 0.5 * twice, closing, np.full(k.shape, np.nan), sides[2])
        total = np.where(thin, np.inf, total)
        best = np.argmin(total, axis=1)
        row = np.arange(len(best))
        at = i[:, 0], j[:, 0]
        cost[at], apex[at] = total[row, best], k[row, best]
        beyond[at], area[at] = unit_normals[row, best], 0.5 * twice[row, best]
    return _collected(apex) if np.isfinite(cost[0, n - 1]) else np.empty((0, 3), dtype=np.int64)


def _bend(normals: Floats, areas: Floats, others: Floats, other_areas: Floats, lengths: Floats) -> Floats:
    """theta^2 3 l^2 / (A1 + A2) between triangles that share a side."""
    sine = np.linalg.norm(np.cross(normals, others), axis=2)
    theta = np.arctan2(sine, np.einsum("ikd,ikd->ik", normals, others))
    both = areas + np.where(np.isnan(other_areas), areas, other_areas)
    return theta**2 * hinge_weights(lengths, np.where(both > 0.0, both, np.inf))


def _collected(apex: Ints) -> Ints:
    """The triangles below the chord from the first to the last vertex."""
    triangles = []
    chords = [(0, len(apex) - 1)]
    while chords:
        i, j = chords.pop()
        if j - i > 1:
            k = int(apex[i, j])
            triangles.append((i, k, j))
            chords += [(k, j), (i, k)]
    return np.array(triangles, dtype=np.int64)
