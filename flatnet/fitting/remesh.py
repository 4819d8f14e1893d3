"""Carry a fitted mesh over to a fresh tessellation of its flat outline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.fitting.results import FlattenableMesh, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.geometry.triangles import edge_lengths, edges_of

Floats = NDArray[np.float64]


def rest_strain(planar: PlanarMesh, mesh: FlattenableMesh) -> float:
    """Root mean square of (length on M / length on M^p - 1) over all edges: how far M has left M^p."""
    edges = edges_of(planar.triangles)
    strain = edge_lengths(mesh.vertices, edges) / edge_lengths(planar.positions, edges) - 1.0
    return float(np.sqrt(np.mean(strain**2)))


def flat_boundary(flat: Floats, planar_boundary: PlanarBoundary) -> PlanarBoundary:
    """The planar boundary whose positions are the flat outline of the fitted mesh."""
    return replace(planar_boundary, positions=flat[: len(planar_boundary.positions)].copy())


def carried_over(mesh: FlattenableMesh, flat: Floats, planar: PlanarMesh) -> WarpedMesh:
    """The vertices of `planar`, placed on `mesh` where they lie in its flat shape (barycentric); (m, 3), mm."""
    corners = flat[mesh.triangles]
    tree = shapely.STRtree(shapely.polygons(corners))
    inner = planar.positions[planar.boundary_count :]
    found = tree.query_nearest(shapely.points(inner), all_matches=False)[1]
    a, b, c = (corners[found, k] for k in range(3))
    sides = np.stack([b - a, c - a], axis=2)
    weights = np.linalg.solve(sides, (inner - a)[:, :, None])[:, :, 0]
    weights = np.column_stack([1.0 - weights.sum(axis=1), weights])
    placed = np.einsum("ik,ikj->ij", weights, mesh.vertices[mesh.triangles[found]])
    vertices = np.concatenate([mesh.vertices[: planar.boundary_count], placed])
    return WarpedMesh(vertices, planar.triangles, planar.boundary_count)
