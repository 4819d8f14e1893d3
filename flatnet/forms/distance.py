"""How far points lie from a reference surface, and on which side of it."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.triangles import dot, unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A barycentric weight below this: the foot lies on the edge opposite that corner.
ON_EDGE = 1e-9


def signed_distance(surface: ReferenceSurface, points: Floats) -> Floats:
    """Distance of points from the surface, (n,), mm: positive on its outer side, negative inside.

    The side is that of the pseudonormal at the nearest point: the normal of the triangle, the mean of two on an
    edge, of all around weighted by their angles at a vertex (Baerentzen and Aanaes 2005), which decides it
    whatever the angle of the edge. Where the nearest point lies on the rim of an open surface, a point is partly
    beside the surface and on no side of it: there it is its height over the plane of the pseudonormal.

    Parameters
    ----------
    points : (n, 3) float, mm.
    """
    mesh = surface.mesh
    feet, distances, triangles = trimesh.proximity.closest_point(mesh, points)
    weights = trimesh.triangles.points_to_barycentric(mesh.triangles[triangles], feet)
    normals, on_rim = _pseudonormals(mesh, triangles, weights)
    heights = dot(points - feet, normals)
    return np.where(on_rim, heights, np.copysign(distances, heights))


def _pseudonormals(mesh: trimesh.Trimesh, triangles: Ints, weights: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """The pseudonormal at points of triangles, (n, 3), and whether they lie on the rim of the mesh, (n,)."""
    edges = mesh.faces_unique_edges
    count = np.bincount(edges.ravel(), minlength=len(mesh.edges_unique))
    sums = np.zeros((len(count), 3))
    np.add.at(sums, edges, mesh.face_normals[:, None])
    rim_vertices = np.zeros(len(mesh.vertices), bool)
    rim_vertices[mesh.edges_unique[count == 1]] = True

    zero = weights < ON_EDGE
    corners = zero.sum(axis=1)
    normals = np.array(mesh.face_normals[triangles])
    on_rim = np.zeros(len(triangles), bool)
    at = np.flatnonzero(corners == 1)
    # Columns of faces_unique_edges: from corner 0 to 1, 1 to 2, 2 to 0; opposite corner k is column k + 1.
    edge = edges[triangles[at], (np.argmax(zero[at], axis=1) + 1) % 3]
    normals[at], on_rim[at] = sums[edge], count[edge] == 1
    at = np.flatnonzero(corners == 2)
    vertex = mesh.faces[triangles[at], np.argmin(zero[at], axis=1)]
    normals[at], on_rim[at] = mesh.vertex_normals[vertex], rim_vertices[vertex]
    # Two faces folded onto each other cancel: there the triangle's own normal is as good as any.
    cancelled = np.linalg.norm(normals, axis=1) < 1e-6
    normals[cancelled] = mesh.face_normals[triangles[cancelled]]
    return unit(normals), on_rim
