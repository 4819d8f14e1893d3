"""Algorithm 1 as printed: M^0 to a flattenable Laplacian mesh by sequential quadratic programming (paper 4, Eq. 5-10).

The printed H is not symmetric and Eq. 7 is not the gradient of Eq. 6. Taken as printed they belong together:
row p of both, times |N(p)|, is the Hessian and the gradient of

    E = w1/2 sum_edges |v_i - v_j|^2 + 1/2 sum_p |N(p)| (w2 |v_p - v_p^0|^2 + w3 |v_p - v_p^p|^2),

so the line search measures E, with the constraints as an exact penalty: E + nu sum_p |theta_p - 2 pi|.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags, identity, kron

from flatnet.fitting.results import FlattenableMesh, PlanarMesh, WarpedMesh
from flatnet.geometry.angle_sums import AngleSums
from flatnet.geometry.triangles import boundary_triangles, dot, edges_of
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import MultiLoopParameters
from flatnet.solvers.kkt import KktStatus, KktStep, kkt_step

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Armijo's share of the descent that a step promises, and the shortest fraction of a step that is tried.
SUFFICIENT_DESCENT, SHORTEST = 1e-4, 1e-6
#: A sum of unit normals shorter than this has no direction: the vertex gets no tracking plane.
OPPOSED = 1e-6


def multi_loop(
    warped: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: MultiLoopParameters
) -> FlattenableMesh:
    """M: interior vertices of M^0 moved until theta = 2 pi, near M^0, smooth and tangent to the given planes.

    As printed, the method often stops far from flattenable: where the surface is flat the gradient of an angle sum
    vanishes and the steps explode. `status` says how it ended: `converged`, `outer loop limit`,
    `stalled` (no part of a step lets the merit function fall) or `singular` (Eq. 10 has no solution).
    """
    unit_length = planar.mean_edge
    vertices = warped.vertices / unit_length
    problem = _problem(warped, boundary, unit_length, parameters)

    steps, penalty, status = 0, 0.0, "outer loop limit"
    for _ in range(parameters.max_outer_loops):
        if problem.worst(vertices) <= parameters.tolerance:
            break
        tracking, moved = problem.tracking(vertices), False
        for _ in range(parameters.inner_steps):
            solved = problem.solve(vertices, tracking)
            steps += 1
            penalty = problem.penalty(vertices, tracking, solved, penalty)
            trial = problem.line_search(vertices, tracking, solved, penalty)
            if trial is not None:
                vertices, moved = trial, True
            if trial is None or np.linalg.norm(solved.step) < parameters.step_tolerance:
                break
        if not moved:  # the next loop would start from the very same problem
            status = "singular" if solved.status is KktStatus.SINGULAR else "stalled"
            break
    if problem.worst(vertices) <= parameters.tolerance:
        status = "converged"

    result = vertices * unit_length
    result[: warped.boundary_count] = warped.vertices[: warped.boundary_count]
    return FlattenableMesh(
        result, warped.triangles, warped.boundary_count, "multi_loop", asdict(parameters), status, steps
    )


@dataclass(frozen=True, eq=False)
class _Tracking:
    """v^0 of the interior vertices (Eq. 8) and v^p of those in V_tan (Eq. 9)."""

    position: Floats
    tangent: Floats


@dataclass(frozen=True, eq=False)
class _Problem:
    """Eq. 5 in units of the mean edge; the interior vertices stand behind the boundary.

    Attributes
    ----------
    laplacian : (interior, m) sparse; L of Eq. 4.
    hessian : (3 interior, 3 interior) sparse; H of Eq. 10.
    valence : (interior,) float; |N(p)|.
    tangent : (k,) int; V_tan, counted from the first interior vertex.
    plane_points, plane_normals : (k, 3); the average plane of each vertex of V_tan.
    """

    boundary_count: int
    edges: Ints
    sums: AngleSums
    laplacian: csr_matrix
    hessian: csr_matrix
    valence: Floats
    tangent: Ints
    plane_points: Floats
    plane_normals: Floats
    parameters: MultiLoopParameters

    def worst(self, vertices: Floats) -> float:
        return float(np.abs(self.sums.values(vertices)).max(initial=0.0))

    def tracking(self, vertices: Floats) -> _Tracking:
        """Tracking positions released to where the vertices are now."""
        interior = vertices[self.boundary_count :]
        p = interior[self.tangent]
        height = dot(p - self.plane_points, self.plane_normals)
        return _Tracking(interior, p - height[:, None] * self.plane_normals)

    def gradient(self, vertices: Floats, tracking: _Tracking) -> Floats:
        """-B_p of Eq. 10, (interior, 3): Eq. 7 and the derivatives of Eq. 8 and 9, weighted."""
        interior = vertices[self.boundary_count :]
        result = self.parameters.w1 * (self.laplacian @ vertices)
        result += self.parameters.w2 * (interior - tracking.position)
        result[self.tangent] += self.parameters.w3 * (interior[self.tangent] - tracking.tangent)
        return result

    def solve(self, vertices: Floats, tracking: _Tracking) -> KktStep:
        """Eq. 10."""
        jacobian = self.sums.jacobian(vertices)[:, 3 * self.boundary_count :]
        gradient = self.gradient(vertices, tracking).ravel()
        return kkt_step(self.hessian, jacobian, gradient, self.sums.values(vertices))

    def merit(self, vertices: Floats, tracking: _Tracking, penalty: float) -> float:
        """E of the head of this module plus the penalty of the constraints."""
        along = vertices[self.edges[:, 1]] - vertices[self.edges[:, 0]]
        interior = vertices[self.boundary_count :]
        position = np.sum((interior - tracking.position) ** 2, axis=1) @ self.valence
        off_plane = np.sum((interior[self.tangent] - tracking.tangent) ** 2, axis=1)
        energy = self.parameters.w1 * np.sum(along**2) + self.parameters.w2 * position
        energy += self.parameters.w3 * (off_plane @ self.valence[self.tangent])
        return float(0.5 * energy + penalty * np.abs(self.sums.values(vertices)).sum())

    def energy_slope(self, vertices: Floats, tracking: _Tracking, solved: KktStep) -> float:
        """Derivative of E along the whole step."""
        gradient = self.valence[:, None] * self.gradient(vertices, tracking)
        return float(np.sum(gradient * solved.step.reshape(-1, 3)))

    def penalty(self, vertices: Floats, tracking: _Tracking, solved: KktStep, least: float) -> float:
        """nu: twice the multipliers of E, and so much that the merit function falls along the step."""
        violation = np.abs(self.sums.values(vertices)).sum()
        multipliers = np.abs(self.valence * solved.multipliers).max(initial=0.0)
        balance = self.energy_slope(vertices, tracking, solved) / violation if violation else 0.0
        return float(max(least, 2.0 * multipliers, 2.0 * balance))

    def line_search(self, vertices: Floats, tracking: _Tracking, solved: KktStep, penalty: float) -> Floats | None:
        """The vertices after the largest of 1, 1/2, 1/4 ... of the step that lets the merit function fall enough."""
        slope = self.energy_slope(vertices, tracking, solved)
        slope -= penalty * np.abs(self.sums.values(vertices)).sum()
        before = self.merit(vertices, tracking, penalty)
        fraction = 1.0
        while solved.status is not KktStatus.SINGULAR and fraction >= SHORTEST:
            trial = vertices.copy()
            trial[self.boundary_count :] += fraction * solved.step.reshape(-1, 3)
            if self.merit(trial, tracking, penalty) <= before + SUFFICIENT_DESCENT * fraction * slope:
                return trial
            fraction *= 0.5
        return None


def _problem(
    warped: WarpedMesh, boundary: BoundaryCurve, unit_length: float, parameters: MultiLoopParameters
) -> _Problem:
    n, m = warped.boundary_count, len(warped.vertices)
    edges = edges_of(warped.triangles)
    ends = np.concatenate([edges, edges[:, ::-1]])
    adjacency = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(m, m)).tocsr()
    valence = np.bincount(ends[:, 0], minlength=m).astype(float)
    laplacian = (identity(m) - diags(1.0 / valence) @ adjacency).tocsr()[n:]
    tangent, points, normals = _average_planes(warped, boundary)

    diagonal = np.full(m - n, parameters.w2)
    diagonal[tangent - n] += parameters.w3
    hessian = kron(parameters.w1 * laplacian[:, n:] + diags(diagonal), identity(3)).tocsr()
    return _Problem(
        boundary_count=n,
        edges=edges,
        sums=AngleSums(warped.triangles, np.arange(n, m), m),
        laplacian=laplacian,
        hessian=hessian,
        valence=valence[n:],
        tangent=tangent - n,
        plane_points=points / unit_length,
        plane_normals=normals,
        parameters=parameters,
    )


def _average_planes(warped: WarpedMesh, boundary: BoundaryCurve) -> tuple[Ints, Floats, Floats]:
    """V_tan, sorted, and for each of its vertices a point and the unit normal of its cross-tangent plane.

    The plane of a boundary edge passes through its middle with the given normal; a vertex opposite several edges
    gets their mean point and mean normal.
    """
    n, m = warped.boundary_count, len(warped.vertices)
    _, apex = boundary_triangles(warped.triangles, n)
    edge = np.flatnonzero(apex >= n)
    apex = apex[edge]
    count = np.bincount(apex, minlength=m)
    points, normals = np.zeros((m, 3)), np.zeros((m, 3))
    np.add.at(points, apex, 0.5 * (boundary.vertices[edge] + boundary.vertices[(edge + 1) % n]))
    np.add.at(normals, apex, boundary.normals[edge])
    length = np.linalg.norm(normals, axis=1)
    tangent = np.flatnonzero(length > OPPOSED)
    return tangent, points[tangent] / count[tangent, None], normals[tangent] / length[tangent, None]
