"""Let a patch stretch by what its material gives: fairer and closer to its normals, its boundary as long as ever.

From the exactly flattenable mesh the angle sums are let go towards those of the fairest mesh without the constraint,
as far as the flat piece can follow with its interior edges strained by no more than the limit.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from flatnet.fitting.fair import FlattenableProblem
from flatnet.fitting.fair_energy import ghost_vertices
from flatnet.fitting.results import FlattenableMesh, SurfaceMesh
from flatnet.fitting.stuck import FOLD
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.derivatives import edge_length_gradients
from flatnet.geometry.triangles import (
    angle_sums,
    boundary_edges,
    edge_lengths,
    edge_strain,
    edges_of,
    hinge_angles,
    hinges_of,
    signed_areas,
)
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters
from flatnet.solvers.constrained_descent import CONVERGED, longest, solve
from flatnet.solvers.kkt import KktStatus, kkt_step

Floats = NDArray[np.float64]

#: Steps towards the fairest mesh at the most, the longest in mean edges; they end when E settles to this part.
FAIREST_STEPS, LONGEST, SETTLED = 60, 0.5, 1e-3
#: Halvings of the interval in which the share of the way lies.
HALVINGS = 6
#: Steps of the flat piece; its boundary edges are then this near to their lengths, relative.
FLAT_STEPS, BOUNDARY_EXACT = 40, 1e-12
#: How near the angle sums come to what they are let go to, rad, and flat corners to their least angles.
SHIFTED_TOLERANCE, CORNER_TOLERANCE = 1e-6, 1e-9
#: A flat piece whose strain is above this many limits is given up.
HOPELESS = 100.0
#: The strain of an edge costs its square and this power of it over the limit: the largest ones are spread.
POWER = 8


def strained(
    mesh: FlattenableMesh, flat: Floats, boundary: BoundaryCurve, parameters: FairParameters, limit: float
) -> tuple[FlattenableMesh, Floats]:
    """The mesh of least E whose flat piece keeps to the limit, and that piece; the exact ones where no other does.

    With c the angle sums less 2 pi, and c* those of the mesh that is fairest without the constraint, E is lowered
    subject to c = share c*. The largest share whose flat piece can be made is found by halving, once upwards from the
    exact mesh and once downwards from the fairest: they may lie on different branches. The one with the lower E is
    taken.

    Parameters
    ----------
    mesh, flat : M, exactly flattenable, and its flat piece, (m, 2) mm.
    limit : largest |flat length / length in space - 1| of an interior edge; boundary edges have 0.
    """
    relaxation = _Relaxation(mesh, flat, boundary, parameters, limit)
    found = [relaxation.halved(upwards) for upwards in (True, False)]
    _, vertices, piece, steps = min(found, key=lambda one: one[0])
    return replace(mesh, vertices=vertices, steps=mesh.steps + steps), piece


class _Relaxation:
    """The exact mesh of a patch, its energy on the flat piece, and what its angle sums are let go to."""

    def __init__(
        self,
        mesh: FlattenableMesh,
        flat: Floats,
        boundary: BoundaryCurve,
        parameters: FairParameters,
        limit: float,
    ) -> None:
        self.mesh, self.flat, self.boundary, self.limit = mesh, flat, boundary, limit
        self.max_steps = parameters.max_steps
        self.scale = float(edge_lengths(flat, edges_of(mesh.triangles)).mean())
        self.centre = boundary.vertices.mean(axis=0)
        self.problem = FlattenableProblem(
            flat / self.scale, mesh.triangles, mesh.boundary_count, parameters, boundary.min_angles
        )
        start = np.concatenate([mesh.vertices, ghost_vertices(boundary.vertices, boundary.normals)])
        self.exact = ((start - self.centre) / self.scale).ravel()
        self.fairest = _fairest(self.problem, self.exact)
        self.target = self.problem.constraint(self.fairest)

    def halved(self, upwards: bool) -> tuple[float, Floats, Floats, int]:
        """E, vertices (m, 3) mm, flat piece (m, 2) mm, and the steps it took."""
        best_x, best_piece, steps = self.exact, self.flat, 0
        x = self.exact if upwards else self.fairest
        low, high, share = 0.0, 1.0, 1.0
        for _ in range(1 + HALVINGS):
            shifted = _Shifted(self.problem, share * self.target)
            result = solve(shifted, x, ramp=np.empty(0), tolerance=SHIFTED_TOLERANCE, max_steps=self.max_steps)
            steps += result.steps
            piece = self._piece(result.x, best_piece) if result.status == CONVERGED else None
            if piece is not None:
                best_x, best_piece, low = result.x, piece, share
            else:
                high = share
            if low == 1.0:
                break
            if (piece is not None) if upwards else (piece is None and result.status == CONVERGED):
                x = result.x
            share = 0.5 * (low + high)
        return self.problem.energy(best_x), self._vertices(best_x), best_piece, steps

    def _vertices(self, x: Floats) -> Floats:
        vertices = x.reshape(-1, 3)[: len(self.flat)] * self.scale + self.centre
        vertices[: self.mesh.boundary_count] = self.boundary.vertices
        return vertices

    def _piece(self, x: Floats, start: Floats) -> Floats | None:
        """The flat piece within the limit; None where there is none, or none that can be cut."""
        triangles, count = self.mesh.triangles, self.mesh.boundary_count
        mesh = SurfaceMesh(self._vertices(x), triangles, count)
        if np.abs(hinge_angles(mesh.vertices, hinges_of(triangles))).max() > FOLD:
            return None
        flat = flattened(mesh, start, self.limit)
        if flat is None or not (signed_areas(flat, triangles) > 0.0).all():
            return None
        corners = angle_sums(flat, triangles)[:count]
        if (
            np.abs(edge_strain(mesh.vertices, flat, triangles)).max() > self.limit
            or (corners < self.boundary.min_angles - CORNER_TOLERANCE).any()
            or polygon_crossings(flat[:count], self.boundary.vertices)
        ):
            return None
        return flat


class _Shifted:
    """The problem of a patch with c(x) = target in place of c(x) = 0."""

    def __init__(self, problem: FlattenableProblem, target: Floats) -> None:
        self._constraint, self._target = problem.constraint, target
        self.jacobian, self.gram, self.kick = problem.jacobian, problem.gram, problem.kick
        self.energy, self.gradient_and_metric = problem.energy, problem.gradient_and_metric

    def constraint(self, x: Floats) -> Floats:
        return self._constraint(x) - self._target


def _fairest(problem: FlattenableProblem, x: Floats) -> Floats:
    """Lower E without the constraint."""
    energy = problem.energy(x)
    for _ in range(FAIREST_STEPS):
        gradient, metric = problem.gradient_and_metric(x)
        factor = metric.factor()
        if factor is None:
            break
        step = factor.solve(-gradient)
        step *= min(1.0, LONGEST / max(longest(step), 1e-300))
        for cut in range(6):
            trial = x + 0.5**cut * step
            lower = problem.energy(trial)
            if lower < energy:
                break
        else:
            break
        x, drop, energy = trial, energy - lower, lower
        if drop < SETTLED * energy:
            break
    return x


def flattened(mesh: SurfaceMesh, start: Floats, limit: float) -> Floats | None:
    """The flat mesh, (m, 2), whose interior edges are strained least and whose boundary edges not at all.

    Newton steps on the sum of e^2 / 2 + limit^2 (e / limit)^POWER / POWER over the interior edges, subject to the
    boundary's lengths; None where they do not settle.

    Parameters
    ----------
    start : (m, 2) float, mm; near the result.
    """
    edges = edges_of(mesh.triangles)
    lengths = edge_lengths(mesh.vertices, edges)
    rim = boundary_edges(edges, mesh.boundary_count)
    unknowns = (2 * edges[:, :, None] + np.arange(2)).reshape(len(edges), 4)

    def rows(data: Floats, which: NDArray[np.bool_]) -> csr_matrix:
        count = int(which.sum())
        at = np.repeat(np.arange(count), 4)
        return csr_matrix((data[which].ravel(), (at, unknowns[which].ravel())), shape=(count, 2 * len(start)))

    def strain(flat: Floats) -> Floats:
        return edge_lengths(flat, edges) / lengths - 1.0

    def cost(e: Floats) -> float:
        inner = e[~rim]
        return float(np.sum(0.5 * inner**2 + limit**2 * (inner / limit) ** POWER / POWER))

    hold = csr_matrix((np.full(2 * len(start), 1e-10 / lengths.mean() ** 2), (np.arange(2 * len(start)),) * 2))
    flat, e, weight = start, strain(start), 0.0
    for _ in range(FLAT_STEPS):
        if not np.abs(e).max() < HOPELESS * limit:
            return None
        data = edge_length_gradients(flat, edges).reshape(len(edges), 4) / lengths[:, None]
        inner, outer = rows(data, ~rim), rows(data, rim)
        ratio = (e[~rim] / limit) ** (POWER - 2)
        curved = inner.multiply(np.sqrt(1.0 + (POWER - 1) * ratio)[:, None]).tocsr()
        kkt = kkt_step((curved.T @ curved + hold).tocsr(), outer, inner.T @ (e[~rim] * (1.0 + ratio)), e[rim])
        if kkt.status is KktStatus.SINGULAR:
            return None
        weight = max(weight, 2.0 * float(np.abs(kkt.multipliers).max(initial=0.0)))
        merit = cost(e) + weight * float(np.abs(e[rim]).sum())
        for cut in range(8):
            trial = flat + 0.5**cut * kkt.step.reshape(-1, 2)
            e_trial = strain(trial)
            if cost(e_trial) + weight * float(np.abs(e_trial[rim]).sum()) <= merit * (1.0 + 1e-12):
                break
        settled = np.abs(e_trial - e).max() < 1e-3 * limit and cut == 0
        flat, e = trial, e_trial
        if settled and np.abs(e[rim]).max() < BOUNDARY_EXACT:
            return flat
    return flat if np.abs(e[rim]).max() < BOUNDARY_EXACT else None
