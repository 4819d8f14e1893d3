"""The reference surface that curves are drawn on: a user's mesh or a form of ours, in mm, z up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.geometry.triangles import unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Line:
    """A named line of a form, such as a girth ring or a feather edge.

    Attributes
    ----------
    points : (m, 3) float, mm: on the surface, in the line's direction, as dense as the surface's mesh; of a
        closed line the last is the first.
    """

    points: Floats

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    @property
    def closed(self) -> bool:
        return bool(np.array_equal(self.points[0], self.points[-1]))


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """A triangle mesh with smooth normals on its outer side, and what a form names on it.

    Attributes
    ----------
    mesh : in mm, z up, faces anticlockwise seen from outside.
    landmarks : name -> (3,) float, mm: points of the surface that nodes can be put at (`landmark: crotch`).
    lines : name -> lines of the surface that curves can follow (`line: waist`). Both move with the measurements;
        a user's mesh has neither.
    """

    mesh: trimesh.Trimesh
    landmarks: Mapping[str, Floats] = field(default_factory=dict)
    lines: Mapping[str, Line] = field(default_factory=dict)

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
