"""Change the connectivity of a planar triangulation: Delaunay flips, locating points, inserting vertices.

The first `boundary_count` vertices are the outline. An edge inside that joins two of them, a chord, is never
made here. Half-edge h = 3 t + k runs from corner k of triangle t to corner k + 1; corner k + 2 lies opposite.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Differences of this size, relative, decide between choices that are equal but for round-off.
TIE_WEIGHT = 1e-6

#: An in-circle determinant below this, relative, is round-off.
ROUND_OFF = 1e-12


def half_edge_vertices(triangles: Ints) -> tuple[Ints, Ints, Ints]:
    """Tail, head and opposite vertex of every half-edge, each (3 t,)."""
    return triangles.ravel(), triangles[:, [1, 2, 0]].ravel(), triangles[:, [2, 0, 1]].ravel()


def twins_of(triangles: Ints) -> Ints:
    """The half-edge that runs the other way, for every half-edge; -1 on the rim; (3 t,)."""
    tails, heads, _ = half_edge_vertices(triangles)
    size = int(triangles.max(initial=0)) + 1
    key, wanted = tails * size + heads, heads * size + tails
    order = np.argsort(key)
    place = np.minimum(np.searchsorted(key, wanted, sorter=order), len(key) - 1)
    twin = order[place]
    return np.where(key[twin] == wanted, twin, -1)


def planar_cross(u: Floats, v: Floats) -> Floats:
    """z component of the cross product of vectors in the plane."""
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def tie_break(positions: Floats) -> Floats:
    """A smooth function of the place, (m,), of order 1, that differs between places alike by symmetry.

    It decides wherever geometry leaves a choice, so that the choice does not hang on the order of vertices.
    The first term turns with the positions, mirrored or not; the second decides what a symmetry leaves open.
    """
    mean_square = np.sum(positions**2) / max(len(positions), 1) + np.finfo(float).tiny
    x, y = (positions / np.sqrt(mean_square)).T
    square = x * x + y * y
    skew = (np.sum(x * square) * x + np.sum(y * square) * y) / max(len(positions), 1)
    return square * (square + skew) + 0.03 * x * y * (1.0 + x + y)


def delaunay_flips(positions: Floats, triangles: Ints, boundary_count: int) -> Ints:
    """Flip edges until all are locally Delaunay, save those whose flip would make a chord (Lawson).

    Many edges are flipped at once, no two of one triangle. Edges on the rim stay.
    """
    triangles = triangles.copy()
    scale = np.mean(np.sum(positions**2, axis=1))
    weights = TIE_WEIGHT * scale * tie_break(positions)
    while True:
        tails, heads, opposite = half_edge_vertices(triangles)
        twin = twins_of(triangles)
        edge = np.flatnonzero(twin > np.arange(len(twin)))
        left, right = opposite[edge], opposite[twin[edge]]
        gain = _in_circle(positions, weights, tails[edge], heads[edge], left, right)
        wanted = (gain > ROUND_OFF) & ((left >= boundary_count) | (right >= boundary_count))
        edge, gain = edge[wanted], gain[wanted]
        if len(edge) == 0:
            return triangles
        edge = edge[one_per_triangle(edge // 3, twin[edge] // 3, gain)]
        flip(triangles, edge, twin[edge])


def flip(triangles: Ints, edge: Ints, twin: Ints) -> None:
    """Put the other diagonal across each half-edge `edge` with its `twin`, in place; no triangle in two."""
    tails, heads, opposite = half_edge_vertices(triangles)
    left, right = opposite[edge], opposite[twin]
    triangles[edge // 3] = np.stack([tails[edge], right, left], axis=1)
    triangles[twin // 3] = np.stack([right, heads[edge], left], axis=1)


def _in_circle(positions: Floats, weights: Floats, i: Ints, j: Ints, k: Ints, other: Ints) -> Floats:
    """Positive where vertex `other` lies inside the circle through the triangle (i, j, k); dimensionless."""
    a, b, c = (positions[v] - positions[other] for v in (i, j, k))
    lift_a, lift_b, lift_c = (
        np.sum(d * d, axis=1) + weights[v] - weights[other] for d, v in ((a, i), (b, j), (c, k))
    )
    determinant = lift_a * planar_cross(b, c) - lift_b * planar_cross(a, c) + lift_c * planar_cross(a, b)
    return determinant / (np.sum(a * a, axis=1) + np.sum(b * b, axis=1) + np.sum(c * c, axis=1)) ** 2


def one_per_triangle(left: Ints, right: Ints, score: Floats) -> Ints:
    """Of edges between triangles `left` and `right`, those with the best score in both; indices."""
    if len(score) == 0:
        return np.empty(0, dtype=np.int64)
    rank = np.empty(len(score), dtype=np.int64)
    rank[np.argsort(score, kind="stable")] = np.arange(len(score))
    best = np.full(max(left.max(), right.max()) + 1, -1)
    np.maximum.at(best, left, rank)
    np.maximum.at(best, right, rank)
    return np.flatnonzero((rank == best[left]) & (rank == best[right]))


def locate(positions: Floats, triangles: Ints, twin: Ints, points: Floats, start: Ints) -> Ints:
    """The triangle that holds each point, walking from `start`; -1 where the walk leaves the mesh."""
    place = start.copy()
    walking = np.arange(len(points))
    for _ in range(len(triangles)):
        corners = positions[triangles[place[walking]]]
        side = planar_cross(np.roll(corners, -1, axis=1) - corners, points[walking, None] - corners)
        across = np.argmin(side, axis=1)
        outside = side[np.arange(len(walking)), across] < 0.0
        walking, across = walking[outside], across[outside]
        if len(walking) == 0:
            break
        beyond = twin[3 * place[walking] + across]
        place[walking] = np.where(beyond < 0, -1, beyond // 3)
        walking = walking[beyond >= 0]
    place[walking] = -1
    return place


def insert(positions: Floats, triangles: Ints, points: Floats, place: Ints) -> tuple[Floats, Ints]:
    """Join each point to the corners of the triangle `place` that holds it; no two points in one triangle."""
    new = len(positions) + np.arange(len(points))
    a, b, c = triangles[place].T
    triangles = triangles.copy()
    triangles[place] = np.stack([a, b, new], axis=1)
    more = [np.stack([b, c, new], axis=1), np.stack([c, a, new], axis=1)]
    return np.concatenate([positions, points]), np.concatenate([triangles, *more])


def drop_degree_three(positions: Floats, triangles: Ints, free: Bools) -> Ints:
    """Take `free` vertices of degree three out of the mesh, one triangle for three; `positions` keeps them.

    Such a vertex is flattenable only in the plane of its neighbours, and without it the angles are larger.
    """
    triangles = triangles.copy()
    preference = tie_break(positions)
    degree = np.bincount(triangles.ravel(), minlength=len(positions))
    candidates = np.flatnonzero((degree == 3) & free)
    for vertex in candidates[np.argsort(preference[candidates])]:
        around = np.flatnonzero((triangles == vertex).any(axis=1))
        # A neighbour that was taken out may have left it with another degree; a lone vertex stays.
        if len(around) == 3 and len(triangles) > 3:
            first, second = triangles[around[:2]]
            triangles[around[0], first == vertex] = np.setdiff1d(second, first)
            triangles = np.delete(triangles, around[1:], axis=0)
    return triangles
