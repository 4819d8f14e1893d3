"""The reference surface that curves are drawn on: a user's mesh or a form of ours, in mm, z up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.geometry.triangles import unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """A triangle mesh with smooth normals on its outer side.

    Attributes
    ----------
    mesh : in mm, z up, faces anticlockwise seen from outside.
    """

    mesh: trimesh.Trimesh

    def nearest(self, points: Floats) -> tuple[Floats, Floats]:
        """The nearest points of the surface and its unit normals there, both (n, 3).

        Normals are interpolated between the vertex normals of the triangle (means of the faces around,
        weighted by their angles there), so that they turn smoothly.
        """
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        if len(points) == 0:
            return points, points
        feet, _, triangles = trimesh.proximity.closest_point(self.mesh, points)
        weights = trimesh.triangles.points_to_barycentric(self.mesh.triangles[triangles], feet)
        corner_normals = self.mesh.vertex_normals[self.mesh.faces[triangles]]
        normals = np.einsum("nk,nkj->nj", weights, corner_normals)
        # At the edge of a fold the normals of a triangle's corners may cancel: there its own is taken.
        cancelled = np.linalg.norm(normals, axis=1) < 1e-3
        normals[cancelled] = self.mesh.face_normals[triangles[cancelled]]
        return np.asarray(feet), unit(normals)


def tidy_mesh(vertices: Floats, triangles: Ints) -> trimesh.Trimesh:
    """A mesh whose triangles share their vertices, without triangles of no area and vertices of no triangle.

    STL repeats a vertex for each triangle and OBJ along seams of its texture; normals are smooth where the
    triangles around a point share it.
    """
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    mesh.remove_unreferenced_vertices()
    return mesh
