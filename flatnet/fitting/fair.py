"""The default method: from M^0 to a mesh that is exactly flattenable and fair (in place of Algorithm 1).

Same constraint as Eq. 5; fairness is measured by bending instead of the Laplacian, and the normals of the
boundary are held by hinges to ghost triangles in the given tangent planes. docs/method.md says why and how
well it does against the paper's algorithm.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, eye_array

from flatnet.fitting.fair_energy import (
    TIKHONOV,
    Term,
    bump,
    fair_terms,
    ghost_vertices,
    smoothness_matrix,
)
from flatnet.fitting.results import FlattenableMesh, PlanarMesh, WarpedMesh
from flatnet.geometry.angle_sums import AngleSums
from flatnet.geometry.triangles import edge_lengths, hinge_angles, hinges_of, vertex_normals
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters
from flatnet.solvers.constrained_descent import CONVERGED, solve
from flatnet.solvers.mesh_cholesky import BlockSum, MeshLayout, MeshMatrix

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


#: The penalty of the one soft step of a mesh that is carried over: `ramp_end` times the vertices over this. c of one
#: and the same curvature falls with the area of a vertex.
REFIT_VERTICES = 70.0
#: A fit is rough where max |c| is below this, rad: near enough to be unfolded and meshed anew.
ROUGH = 1e-3
#: Height of the bump that takes M^0 off a symmetric state, in mean edges.
BUMP = 0.1


class FlattenableProblem:
    """E(x) and c(x) of one patch as `solvers.constrained_descent` wants them; lengths in mean edges of M^p."""

    def __init__(
        self,
        planar: Floats,
        triangles: Ints,
        boundary_count: int,
        parameters: FairParameters,
        min_angles: Floats | None = None,
    ) -> None:
        self._planar, self._boundary_count = planar, boundary_count
        vertex_count = len(planar)
        total = vertex_count + boundary_count
        free = np.zeros(total, dtype=bool)
        free[boundary_count:vertex_count] = True
        self.terms: list[Term] = fair_terms(planar, triangles, boundary_count, parameters)
        least = {i: float(a) for i, a in enumerate(min_angles if min_angles is not None else ()) if a > 0.0}
        rows = np.concatenate([np.array(sorted(least), dtype=np.int64), np.arange(boundary_count, vertex_count)])
        self.sums = AngleSums(triangles, rows, total, least)
        self._stars = self.sums.stars()
        stars = [vertices for _, vertices in self._stars]
        elements = [term.elements for term in self.terms]
        points = np.concatenate([planar, np.zeros((boundary_count, 2))])
        self.layout = MeshLayout(points, free, elements + stars)
        self._metric_sum = BlockSum(self.layout, elements)
        self._gram_sum = BlockSum(self.layout, stars)
        self._free = np.repeat(free, 3)
        self.smoothness = smoothness_matrix(points, triangles, free)
        # Smoothness and Tikhonov: the part of the metric that does not change.
        self._constant = self.layout.on_every_axis(self.smoothness + TIKHONOV * eye_array(total))

    def constraint(self, x: Floats) -> Floats:
        return self.sums.values(x.reshape(-1, 3))

    def jacobian(self, x: Floats) -> csr_matrix:
        return self.sums.jacobian(x.reshape(-1, 3))

    def energy(self, x: Floats) -> float:
        vertices = x.reshape(-1, 3)
        total = 0.5 * float(np.sum(vertices * (self.smoothness @ vertices)))
        for term in self.terms:
            total += 0.5 * float(term.energy_weights @ term.residuals(vertices) ** 2)
        return total

    def gradient_and_metric(self, x: Floats) -> tuple[Floats, MeshMatrix]:
        vertices = x.reshape(-1, 3)
        gradient = (self.smoothness @ vertices).ravel()
        jacobians = []
        for term in self.terms:
            residuals, jacobian = term.linearised(vertices)
            jacobians.append(jacobian)
            pull = jacobian * (term.energy_weights * residuals)[:, None]
            gradient += np.bincount(term.unknowns.ravel(), weights=pull.ravel(), minlength=len(x))
        metric = self._metric_sum(jacobians, [term.metric_weights for term in self.terms])
        return gradient * self._free, metric.plus(self._constant)

    def kick(self, x: Floats, number: int) -> Floats:
        """A wave across M^p, along the normals, that dies out towards the boundary; every number has its own.

        Lengths fall from twice the extent of M^p, directions turn by the golden angle: no symmetry is kept.
        """
        extent = float(np.ptp(self._planar, axis=0).max())
        turn = number * np.pi * (3.0 - np.sqrt(5.0))
        phase = self._planar @ np.array([np.cos(turn), np.sin(turn)]) * (number * np.pi / extent) + number
        wave = bump(self._planar, self.sums.triangles, self._boundary_count) * np.cos(phase)
        vertices = x.reshape(-1, 3)
        normals = vertex_normals(vertices[: len(wave)], self.sums.triangles)
        step = np.zeros_like(vertices)
        step[: len(wave)] = (wave / np.abs(wave).max())[:, None] * normals
        return step.ravel()

    def gram(self, jacobian: csr_matrix) -> MeshMatrix:
        """J^T J."""
        rows = [self.sums.star_rows(jacobian, ids, stars.shape[1]) for ids, stars in self._stars]
        return self._gram_sum(rows, [np.ones(len(ids)) for ids, _ in self._stars])


@dataclass(frozen=True, eq=False)
class RoughFit:
    """A mesh on its way: c within `ROUGH` where it `arrived`; `finished` goes on from there.

    Attributes
    ----------
    mesh : M as far as it is made.
    planar : M^p, the mesh that it is fitted on.
    x : the unknowns of `problem`; `taken` : the steps of phases B and C on it.
    """

    mesh: FlattenableMesh
    planar: PlanarMesh
    boundary: BoundaryCurve
    parameters: FairParameters
    problem: FlattenableProblem
    x: Floats
    taken: int

    @property
    def arrived(self) -> bool:
        return self.mesh.status == CONVERGED

    def settled(self) -> RoughFit:
        """The fit with its mesh finished."""
        return replace(self, mesh=self.finished())

    def finished(self) -> FlattenableMesh:
        """M, flattenable to `parameters.tolerance` where it converges; as it is where it has not even arrived."""
        if not self.arrived:
            return self.mesh
        result = solve(
            self.problem,
            self.x,
            ramp=np.empty(0),
            tolerance=self.parameters.tolerance,
            max_steps=max(self.parameters.max_steps - self.taken, 1),
        )
        vertices = _in_space(result.x, self.planar, self.boundary)
        return replace(self.mesh, vertices=vertices, status=result.status, steps=self.mesh.steps + result.steps)


def fit_fair(
    warped: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: FairParameters
) -> FlattenableMesh:
    """M from M^0: interpolates B exactly, flattenable to `parameters.tolerance` where it converges."""
    return roughly_fit(warped, boundary, planar, parameters).finished()


def refit_fair(
    carried: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: FairParameters
) -> FlattenableMesh:
    """M from a mesh that is smooth and nearly M already."""
    return roughly_refit(carried, boundary, planar, parameters).finished()


def roughly_fit(
    warped: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: FairParameters
) -> RoughFit:
    """From M^0 by a soft ramp."""
    ramp = np.geomspace(parameters.ramp_start, parameters.ramp_end, parameters.ramp_steps)
    return _roughly(_off_symmetry(warped, planar, BUMP * planar.mean_edge), boundary, planar, parameters, ramp)


def roughly_refit(
    carried: WarpedMesh, boundary: BoundaryCurve, planar: PlanarMesh, parameters: FairParameters
) -> RoughFit:
    """From a mesh that is smooth and nearly M already: one stiff step, where a ramp would undo it."""
    ramp = np.array([parameters.ramp_end * len(carried.vertices) / REFIT_VERTICES])
    return _roughly(carried.vertices, boundary, planar, parameters, ramp)


def _roughly(
    start: Floats,
    boundary: BoundaryCurve,
    planar: PlanarMesh,
    parameters: FairParameters,
    ramp: Floats,
) -> RoughFit:
    """From the vertices `start`, (m, 3) mm, of M^p's triangles."""
    scale = planar.mean_edge
    problem = FlattenableProblem(
        planar.positions / scale, planar.triangles, planar.boundary_count, parameters, boundary.min_angles
    )
    ghosts = ghost_vertices(boundary.vertices, boundary.normals)
    x = (np.concatenate([start, ghosts]) - boundary.vertices.mean(axis=0)) / scale
    rough = max(ROUGH, parameters.tolerance)
    result = solve(problem, x.ravel(), ramp=ramp, tolerance=rough, max_steps=parameters.max_steps, rough=True)
    mesh = FlattenableMesh(
        _in_space(result.x, planar, boundary),
        planar.triangles,
        planar.boundary_count,
        method="fair",
        parameters=asdict(parameters),
        status=result.status,
        steps=result.steps,
    )
    return RoughFit(mesh, planar, boundary, parameters, problem, result.x, result.steps - len(ramp))


def _in_space(x: Floats, planar: PlanarMesh, boundary: BoundaryCurve) -> Floats:
    """The vertices, (m, 3) mm, of the unknowns x; those of the boundary are B's to the last bit."""
    vertices = x.reshape(-1, 3)[: len(planar.positions)] * planar.mean_edge + boundary.vertices.mean(axis=0)
    vertices[: planar.boundary_count] = boundary.vertices
    return vertices


def _off_symmetry(warped: WarpedMesh, planar: PlanarMesh, height: float) -> Floats:
    """The vertices of M^0 with a low bump towards its convex side, `height` mm at its top.

    A symmetric boundary has two flat solutions, one a mirror image of the other, and a symmetric M^0 lies
    on the ridge between them, where every step keeps the symmetry and none gets to c = 0 (a saddle between
    four arcs does this).
    """
    hinges = hinges_of(warped.triangles)
    lengths = edge_lengths(warped.vertices, hinges[:, :2])
    convex = np.copysign(1.0, np.sum(lengths * hinge_angles(warped.vertices, hinges)))
    normals = vertex_normals(warped.vertices, warped.triangles)
    hill = bump(planar.positions, planar.triangles, planar.boundary_count)
    return warped.vertices + (convex * height) * hill[:, None] * normals
