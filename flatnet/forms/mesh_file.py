"""Read a user's mesh file (OBJ, STL, PLY): a reference surface in mm, z up, its normals on the outer side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.failure import spoken
from flatnet.forms.surface import ReferenceSurface, tidy_mesh
from flatnet.project.model import MeshSurface
from flatnet.project.values import TO_Z_UP

Floats = NDArray[np.float64]

FORMATS = (".obj", ".ply", ".stl")


class MeshFileError(ValueError):
    """A mesh file that cannot be read, or is no surface."""


def read_mesh(source: MeshSurface) -> ReferenceSurface:
    """The surface of a mesh file.

    Polygons are cut into triangles. Faces that turn against most of those they hang together with are turned
    round.

    Raises
    ------
    MeshFileError
        Not there, not readable, another format, no faces, coordinates that are no numbers, no area, faces
        that have no common side.
    """
    vertices, triangles = _read(source.path)
    if len(triangles) == 0:
        raise MeshFileError(f"{source.path} has no faces; a surface of triangles or polygons is needed")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        raise MeshFileError(
            f"{source.path}: {len(bad)} of {len(vertices)} vertices have coordinates that are no finite "
            f"numbers, the first is vertex {bad[0] + 1}"
        )
    mesh = tidy_mesh(source.mm_per_unit * vertices @ TO_Z_UP[source.up].T, triangles)
    if len(mesh.faces) == 0:
        raise MeshFileError(f"{source.path}: all {len(triangles)} triangles have no area")
    if not mesh.is_winding_consistent:
        _turn_to_one_side(mesh)
        if not mesh.is_winding_consistent:
            raise MeshFileError(f"{source.path}: {_where_sides_change(mesh)}")
    if source.outer == "inside":
        mesh.invert()
    return ReferenceSurface(mesh)


def _read(path: Path) -> tuple[Floats, NDArray[np.int64]]:
    """Vertices and triangles as they stand in the file."""
    if path.suffix.lower() not in FORMATS:
        raise MeshFileError(f"{path}: a mesh file ends in {', '.join(FORMATS)}, not in {path.suffix!r}")
    if not path.is_file():
        raise MeshFileError(f"there is no mesh file {path}")
    try:
        mesh = trimesh.load_mesh(path, process=False)
    except Exception as error:  # the parsers raise whatever the damage leads to
        raise MeshFileError(f"{path} could not be read as {path.suffix[1:].upper()}: {error}") from error
    if not isinstance(mesh, trimesh.Trimesh):  # a cloud of points, or nothing
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    return np.array(mesh.vertices, dtype=float), np.array(mesh.faces, dtype=np.int64)


def _turn_to_one_side(mesh: trimesh.Trimesh) -> None:
    """Turn faces round so that neighbours agree, the larger area of each connected part staying as it was."""
    before = mesh.faces.copy()
    trimesh.repair.fix_winding(mesh)
    turned = (mesh.faces != before).any(axis=1)
    faces = mesh.faces.copy()
    parts = trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(faces))
    turned_area = np.bincount(parts, weights=mesh.area_faces * np.where(turned, 1.0, -1.0))
    wrong = turned_area[parts] > 0
    faces[wrong] = faces[wrong][:, ::-1]
    mesh.faces = faces


def _where_sides_change(mesh: trimesh.Trimesh) -> str:
    """Words for the first edge that two faces run along in the same direction."""
    edges, counts = np.unique(mesh.edges, axis=0, return_counts=True)
    twice = edges[counts > 1]
    middle = mesh.vertices[twice[0]].mean(axis=0)
    return (
        f"the faces have no common outer side: along {len(twice)} edges, the first at {spoken(middle)} mm, two "
        "faces run the same way; the surface is one-sided, or more than two faces meet there: repair the mesh"
    )
