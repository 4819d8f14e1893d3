"""Carry a fitted mesh over to a fresh tessellation of its flat outline, smoothly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import eye_array

from flatnet.fitting.fair_energy import smoothness_matrix
from flatnet.fitting.results import FlattenableMesh, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.geometry.triangles import edge_lengths, edges_of
from flatnet.solvers.symmetric import factored

Floats = NDArray[np.float64]

#: How stiffly a smoothed mesh is held to where it was, against smoothness, in mean edges of the mesh that
#: it comes from: waves shorter than about 2 pi / HOLD^(1/4) = 5.5 of them go. At 0.1 sharp wrinkles lose their normals,
#: at 10 smooth sheets crumple a little.
HOLD = 1.7


def rest_strain(planar: PlanarMesh, mesh: FlattenableMesh) -> float:
    """Root mean square of (length on M / length on M^p - 1) over all edges: how far M has left M^p."""
    edges = edges_of(planar.triangles)
    strain = edge_lengths(mesh.vertices, edges) / edge_lengths(planar.positions, edges) - 1.0
    return float(np.sqrt(np.mean(strain**2)))


def flat_boundary(flat: Floats, planar_boundary: PlanarBoundary) -> PlanarBoundary:
    """The planar boundary whose positions are the flat outline of the fitted mesh."""
    return replace(planar_boundary, positions=flat[: len(planar_boundary.positions)].copy())


def carried_over(mesh: FlattenableMesh, flat: Floats, planar: PlanarMesh, normal_weight: float) -> WarpedMesh:
    """The mesh of `planar` on the smooth surface next to `mesh`, each vertex about where it lies in the flat shape.

    Placed on the facets of `mesh` the finer mesh would bend at their edges, and the way back to c = 0 would turn
    these bends into crumples. So it is smoothed: min X^T Q X + w |X - placed|^2, Q the smoothness of the energy.
    The smoothing knows nothing of the given normals; the more they count, the less it may move.
    """
    placed = placed_on(mesh, flat, planar)
    n, count = planar.boundary_count, len(planar.positions)
    edge = edge_lengths(flat, edges_of(mesh.triangles)).mean()  # its facets are what must go
    smoothness = smoothness_matrix(planar.positions / planar.mean_edge, planar.triangles, np.arange(count) >= n)
    hold = HOLD * max(normal_weight, 1.0) * (planar.mean_edge / edge) ** 4
    factor = factored(smoothness[n:, n:] + hold * eye_array(count - n))
    vertices = placed.copy()
    vertices[n:] = factor.solve(hold * placed[n:] - smoothness[n:, :n] @ placed[:n])
    return WarpedMesh(vertices, planar.triangles, n)


def placed_on(mesh: FlattenableMesh, flat: Floats, planar: PlanarMesh) -> Floats:
    """The vertices of `planar`, placed on the facets of `mesh` where they lie in its flat shape; (m, 3), mm."""
    corners = flat[mesh.triangles]
    tree = shapely.STRtree(shapely.polygons(corners))
    inner = planar.positions[planar.boundary_count :]
    found = tree.query_nearest(shapely.points(inner), all_matches=False)[1]
    a, b, c = (corners[found, k] for k in range(3))
    sides = np.stack([b - a, c - a], axis=2)
    weights = np.linalg.solve(sides, (inner - a)[:, :, None])[:, :, 0]
    weights = np.column_stack([1.0 - weights.sum(axis=1), weights])
    placed = np.einsum("ik,ikj->ij", weights, mesh.vertices[mesh.triangles[found]])
    return np.concatenate([mesh.vertices[: planar.boundary_count], placed])
