"""What is fair: the energy that the default method lowers among the flattenable meshes, and its metric.

Sums of squares of residuals per element (docs/method.md gives the table). The gradient and the Gauss-Newton
metric have the same terms with different weights: the gradient says what is fair, the metric keeps steps
smooth and triangles healthy. Lengths are in units of the mean edge of M^p.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags_array

from flatnet.geometry.derivatives import area_gradients, edge_length_gradients, hinge_angle_gradients
from flatnet.geometry.laplacian import cotangent_laplacian
from flatnet.geometry.triangles import (
    area_vectors,
    boundary_triangles,
    edge_lengths,
    edges_of,
    hinge_angles,
    hinge_weights,
    hinges_of,
    signed_areas,
    vertex_sums,
)
from flatnet.parameters import FairParameters
from flatnet.solvers.symmetric import factored

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Hinges are clipped here so that 2 tan(theta / 2) stays finite, rad.
HINGE_CLIP = 3.0
#: Hinges beyond `WALL`, rad, are made stiffer. Measured on the steepest wrinkles of the benchmark: without it
#: hinges of 105 degrees remain, with it of 80.
WALL, STIFFNESS = 1.3, 40.0
#: Largest weight 3 l^2 / (A1 + A2) of a hinge: slivers of M^p must not rule.
HINGE_WEIGHT_CAP = 30.0
#: normal_weight 1 holds one normal as stiffly as a hinge where sqrt(area) is so many boundary edges long.
RIM_EDGES = 30.0
#: Least weights of edges and areas in the metric, and of a multiple of the identity that keeps it definite.
STRAIN_METRIC, AREA_METRIC, TIKHONOV = 3.0, 1.0, 1e-2


@dataclass(frozen=True, eq=False)
class Term:
    """Residuals r_e of elements e, with weights: energy 1/2 sum w r^2, metric sum v (dr/dx)^T (dr/dx).

    Attributes
    ----------
    elements : (e, k) vertex ids.
    residuals : vertices -> (e,).
    linearised : vertices -> residuals (e,) and their derivatives (e, 3 k).
    energy_weights, metric_weights : (e,).
    """

    elements: Ints
    residuals: Callable[[Floats], Floats]
    linearised: Callable[[Floats], tuple[Floats, Floats]]
    energy_weights: Floats
    metric_weights: Floats

    @cached_property
    def unknowns(self) -> Ints:
        """(e, 3 k); 3 * vertex + axis."""
        return (3 * self.elements[:, :, None] + np.arange(3)).reshape(len(self.elements), -1)


def bending_term(hinges: Ints, weights: Floats, metric_weights: Floats) -> Term:
    """r = 2 tan(theta / 2), and beyond `WALL` a wall on top: r grows by `STIFFNESS` (|theta| - WALL)^2.

    A fold of 90 degrees can't be sewn, and two of 45 bend as little; tan alone does not say so clearly enough.
    """

    def parts(vertices: Floats) -> tuple[Floats, Floats, Floats]:
        angle = np.clip(hinge_angles(vertices, hinges), -HINGE_CLIP, HINGE_CLIP)
        half_tangent = np.tan(0.5 * angle)
        beyond = np.maximum(np.abs(angle) - WALL, 0.0)
        return 2.0 * half_tangent + np.sign(angle) * STIFFNESS * beyond**2, half_tangent, beyond

    def linearised(vertices: Floats) -> tuple[Floats, Floats]:
        residuals, half_tangent, beyond = parts(vertices)
        slope = 1.0 + half_tangent**2 + 2.0 * STIFFNESS * beyond
        gradients = hinge_angle_gradients(vertices, hinges)
        gradients *= slope[:, None, None]
        return residuals, gradients.reshape(len(hinges), -1)

    return Term(hinges, lambda vertices: parts(vertices)[0], linearised, weights, metric_weights)


def _symmetric_ratio_term(
    elements: Ints,
    sizes: Callable[[Floats, Ints], Floats],
    gradients: Callable[[Floats, Ints], Floats],
    rest: Floats,
    weight: float,
    metric_weight: float,
) -> Term:
    """r = (q - 1 / q) / 2 with q = size / rest: 0 at rest, the same for twice and half, unbounded at 0."""

    def residuals(vertices: Floats) -> Floats:
        q = sizes(vertices, elements) / rest
        return 0.5 * (q - 1.0 / q)

    def linearised(vertices: Floats) -> tuple[Floats, Floats]:
        q = sizes(vertices, elements) / rest
        slope = 0.5 * (1.0 + 1.0 / q**2) / rest
        return 0.5 * (q - 1.0 / q), slope[:, None] * gradients(vertices, elements).reshape(len(elements), -1)

    ones = np.ones(len(elements))
    return Term(elements, residuals, linearised, weight * ones, max(weight, metric_weight) * ones)


def strain_term(edges: Ints, rest: Floats, weight: float) -> Term:
    """Edge lengths against their lengths on M^p, (e,)."""
    return _symmetric_ratio_term(edges, edge_lengths, edge_length_gradients, rest, weight, STRAIN_METRIC)


def area_term(triangles: Ints, rest: Floats, weight: float) -> Term:
    """Triangle areas against their areas on M^p, (t,)."""

    def areas(vertices: Floats, triangles: Ints) -> Floats:
        return np.linalg.norm(area_vectors(vertices, triangles), axis=1)

    return _symmetric_ratio_term(triangles, areas, area_gradients, rest, weight, AREA_METRIC)


def lumped_areas(planar: Floats, triangles: Ints, count: int) -> Floats:
    """A third of the area of the triangles at every vertex of M^p, (count,)."""
    thirds = np.abs(signed_areas(planar, triangles)) / 3.0
    return vertex_sums(triangles, np.repeat(thirds, 3), count)


def smoothness_matrix(planar: Floats, triangles: Ints, free: NDArray[np.bool_]) -> csr_matrix:
    """Q = L^T M^-1 L over the rows of the free vertices: cotangent L, lumped areas M, both of M^p."""
    areas = lumped_areas(planar, triangles, len(free))
    scale = np.where(free, 1.0 / np.sqrt(np.where(free, areas, 1.0)), 0.0)
    half_operator = diags_array(scale) @ cotangent_laplacian(planar, triangles, len(free))
    return (half_operator.T @ half_operator).tocsr()


def bump(planar: Floats, triangles: Ints, boundary_count: int) -> Floats:
    """A smooth hill over M^p, (m,): 0 on the boundary, 1 at its top, the solution of -Laplace u = const."""
    inner = slice(boundary_count, None)
    laplacian = cotangent_laplacian(planar, triangles, len(planar))[inner, inner]
    height = np.zeros(len(planar))
    height[inner] = factored(laplacian).solve(lumped_areas(planar, triangles, len(planar))[inner])
    return height / np.abs(height).max(initial=1e-300)


def capped_hinge_weights(planar: Floats, hinges: Ints) -> Floats:
    """Weight of every hinge on M^p, capped."""
    i, j, k, l = hinges.T
    length = edge_lengths(planar, hinges[:, :2])
    area = np.abs(signed_areas(planar, np.stack([i, j, k], 1))) + np.abs(
        signed_areas(planar, np.stack([j, i, l], 1))
    )
    return np.minimum(hinge_weights(length, area), HINGE_WEIGHT_CAP)


def boundary_hinges(triangles: Ints, boundary_count: int, first_ghost: int) -> Ints:
    """The hinges between boundary triangles and their ghosts, (n, 4): i, i + 1, inner vertex, ghost of edge i."""
    edge = np.arange(boundary_count)
    _, inner = boundary_triangles(triangles, boundary_count)
    return np.stack([edge, (edge + 1) % boundary_count, inner, first_ghost + edge], axis=1)


def ghost_vertices(boundary: Floats, normals: Floats) -> Floats:
    """A point outside every boundary edge in its given tangent plane, (n, 3), one edge length away."""
    edge = np.roll(boundary, -1, axis=0) - boundary
    middle = boundary + 0.5 * edge
    return middle + np.cross(edge, normals)


def fair_terms(
    planar: Floats, triangles: Ints, boundary_count: int, parameters: FairParameters
) -> list[Term]:
    """Bending, given normals, strain and area over a mesh whose ghosts follow its m vertices."""
    hinges = hinges_of(triangles)
    weights = capped_hinge_weights(planar, hinges)
    rim = boundary_hinges(triangles, boundary_count, len(planar))
    rim_length = edge_lengths(planar, rim[:, :2])
    rim_area = np.abs(signed_areas(planar, rim[:, :3]))
    # The ghost stands for a triangle as large as the one inside.
    rim_weights = np.minimum(hinge_weights(rim_length, 2.0 * rim_area), HINGE_WEIGHT_CAP)
    # Deviations from the normals do not shrink with the edges as hinges do, and there are more of them on a finer
    # boundary: weighted by length, normal_weight means the same at every mesh size.
    share = rim_length / np.sqrt(np.abs(signed_areas(planar, triangles)).sum())
    held = parameters.normal_weight * RIM_EDGES * share * rim_weights
    edges = edges_of(triangles)
    edges = edges[(edges >= boundary_count).any(axis=1)]
    return [
        bending_term(hinges, weights, weights),
        bending_term(rim, held, held),
        strain_term(edges, edge_lengths(planar, edges), parameters.strain_weight),
        area_term(triangles, np.abs(signed_areas(planar, triangles)), parameters.area_weight),
    ]
