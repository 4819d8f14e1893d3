"""Formulas of triangle meshes: areas, angles, angle sums, edge strain. Plain arrays in, plain arrays out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def unit(vectors: Floats) -> Floats:
    """Vectors over their last axis divided by their lengths."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def cross(u: Floats, v: Floats) -> Floats:
    """Row by row u x v, (n, 3). A third of the time of np.cross, which dominates on small meshes."""
    result = np.empty_like(u)
    result[:, 0] = u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1]
    result[:, 1] = u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2]
    result[:, 2] = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return result


def dot(u: Floats, v: Floats) -> Floats:
    """Row by row u . v, (n,)."""
    return np.einsum("ij,ij->i", u, v)


def area_vectors(vertices: Floats, triangles: Ints) -> Floats:
    """Normal of every triangle times its area, (t, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * cross(b - a, c - a)


def vertex_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Unit normal at every vertex, (m, 3): the mean of its triangles' normals by area."""
    by_corner = np.repeat(area_vectors(vertices, triangles), 3, axis=0)
    sums = [vertex_sums(triangles, by_corner[:, k], len(vertices)) for k in range(3)]
    return unit(np.stack(sums, axis=1))


def signed_areas(positions: Floats, triangles: Ints) -> Floats:
    """Signed area of every triangle in the plane, (t,); positive when anticlockwise."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def corner_angles(vertices: Floats, triangles: Ints) -> Floats:
    """Angle at each corner of every triangle, (t, 3), rad; in the plane or in space.

    atan2 of cross and dot product: exact to round-off for thin triangles, where arccos loses half the digits.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    sides = c - b, a - c, b - a
    if vertices.shape[1] == 2:
        twice_area = np.abs(sides[1][:, 0] * sides[2][:, 1] - sides[1][:, 1] * sides[2][:, 0])
    else:
        normal = cross(sides[1], sides[2])
        twice_area = np.sqrt(dot(normal, normal))
    cosines = [-dot(sides[(k + 1) % 3], sides[(k + 2) % 3]) for k in range(3)]
    return np.arctan2(twice_area[:, None], np.stack(cosines, axis=1))


def vertex_sums(triangles: Ints, by_corner: Floats, count: int) -> Floats:
    """Values of the triangles' corners, (3 t,), summed at their vertices, (count,)."""
    return np.bincount(triangles.ravel(), weights=by_corner, minlength=count).astype(np.float64)


def angle_sums(vertices: Floats, triangles: Ints) -> Floats:
    """Sum of the triangle angles at every vertex, (m,), rad; theta of Property 1."""
    angles = corner_angles(vertices, triangles)
    return vertex_sums(triangles, angles.ravel(), len(vertices))


def angle_defects(vertices: Floats, triangles: Ints) -> Floats:
    """theta - 2 pi at every vertex, (m,), rad; meaningless on the boundary."""
    return angle_sums(vertices, triangles) - 2.0 * np.pi


def edges_of(triangles: Ints) -> Ints:
    """Every edge once, (e, 2), lower index first, sorted."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0)


def boundary_edges(edges: Ints, boundary_count: int) -> NDArray[np.bool_]:
    """Which edges, (e, 2) with the lower index first, join one of the first `boundary_count` vertices to the next."""
    apart = edges[:, 1] - edges[:, 0]
    return (edges[:, 1] < boundary_count) & ((apart == 1) | (apart == boundary_count - 1))


def edge_lengths(vertices: Floats, edges: Ints) -> Floats:
    """Length of every edge, (e,); in the plane or in space."""
    return np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)


def edge_strain(vertices: Floats, flat: Floats, triangles: Ints) -> Floats:
    """Flat length over length in space, less 1, for every edge of `edges_of(triangles)`, (e,)."""
    edges = edges_of(triangles)
    return edge_lengths(flat, edges) / edge_lengths(vertices, edges) - 1.0


def hinges_of(triangles: Ints) -> Ints:
    """Every interior edge with the two vertices across it, (h, 4): edge from i to j, k on its left, l on its right.

    Triangle (i, j, k) is one of the mesh and so is (j, i, l). Sorted by (i, j) with i < j.
    """
    tails = triangles.ravel()
    heads = triangles[:, [1, 2, 0]].ravel()
    opposite = triangles[:, [2, 0, 1]].ravel()
    size = int(triangles.max()) + 1
    key = tails * size + heads
    order = np.argsort(key, kind="stable")
    key, tails, heads, opposite = key[order], tails[order], heads[order], opposite[order]
    twin = np.searchsorted(key, heads * size + tails)
    twin_in = np.minimum(twin, len(key) - 1)
    paired = (key[twin_in] == heads * size + tails) & (tails < heads)
    return np.stack([tails[paired], heads[paired], opposite[paired], opposite[twin_in[paired]]], axis=1)


def boundary_triangles(triangles: Ints, boundary_count: int) -> tuple[Ints, Ints]:
    """The triangle at every boundary edge (i, i + 1), and its third vertex; (n,) each.

    The first `boundary_count` vertices are the boundary in its order.
    """
    tails = triangles.ravel()
    heads = triangles[:, [1, 2, 0]].ravel()
    apexes = triangles[:, [2, 0, 1]].ravel()
    at = np.flatnonzero((tails < boundary_count) & (heads == (tails + 1) % boundary_count))
    at = at[np.argsort(tails[at])]
    return at // 3, apexes[at]


def boundary_triangle_normals(vertices: Floats, triangles: Ints, boundary_count: int) -> Floats:
    """Unit normal of the triangle at every boundary edge, (n, 3), in the order of B."""
    at, _ = boundary_triangles(triangles, boundary_count)
    return unit(area_vectors(vertices, triangles[at]))


def angles_between(a: Floats, b: Floats) -> Floats:
    """Angle between two arrays of unit vectors, row by row, rad."""
    return 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))


def hinge_angles(vertices: Floats, hinges: Ints) -> Floats:
    """Signed dihedral angle of every hinge, (h,), rad in (-pi, pi]; 0 where flat, positive where convex.

    Convex as seen from the side that the normals point to.
    """
    i, j, k, l = (vertices[hinges[:, c]] for c in range(4))
    edge = j - i
    left, right = cross(edge, k - i), cross(l - i, edge)
    sine = dot(cross(left, right), edge) / np.sqrt(dot(edge, edge))
    return np.arctan2(sine, dot(left, right))


def hinge_weights(lengths: Floats, areas: Floats) -> Floats:
    """3 l^2 / (A1 + A2), the weight of theta^2 in bending; `areas` are those of both triangles of a hinge together."""
    return 3.0 * lengths**2 / areas


def bending(vertices: Floats, triangles: Ints) -> float:
    """Sum over the hinges of theta^2 3 l^2 / (A1 + A2): 0 where flat, the same at every scale and mesh size."""
    hinges = hinges_of(triangles)
    i, j, k, l = hinges.T
    area = np.linalg.norm(area_vectors(vertices, np.stack([i, j, k], axis=1)), axis=1)
    area += np.linalg.norm(area_vectors(vertices, np.stack([j, i, l], axis=1)), axis=1)
    length = edge_lengths(vertices, hinges[:, :2])
    return float(np.sum(hinge_angles(vertices, hinges) ** 2 * hinge_weights(length, area)))
