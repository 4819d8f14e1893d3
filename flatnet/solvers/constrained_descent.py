"""Minimise a sum of squares E(x) subject to c(x) = 0: soft ramp, tangential and normal steps, Newton tail.

Projecting onto c = 0 first and fairing afterwards does not work where c = 0 is rugged: the shape is decided on
the way there. So the long waves go first, under a soft, growing penalty (phase A); then every step has a part
along c = 0 that lowers E and a part across it that lowers c (phase B); then c alone is driven to round-off
(phase C). Where no step lowers c any more the mesh lies on a ridge between solutions, flat to first order: a
smooth kick takes it off, and B and C begin again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from flatnet.solvers.mesh_cholesky import MeshFactor, MeshMatrix

Floats = NDArray[np.float64]

#: Status of a result that reached its tolerance.
CONVERGED = "converged"
#: Longest steps, in units of the mean edge: ramp; normal; tangential at first and at most.
RAMP_STEP, NORMAL_STEP, TANGENT_STEP, TANGENT_STEP_MOST = 0.3, 0.4, 0.2, 0.5
#: Penalty of the constraint in the factorised matrix: start, floor and ceiling of phase B; start and ceiling of C,
#: which is high because the gradients of c are small where a fine mesh is nearly flat.
BETA, BETA_FLOOR, BETA_CEILING = 1e5, 1e2, 1e5
TAIL_BETA, TAIL_BETA_CEILING = 1e6, 1e12
#: The tail aims at this part of the tolerance; where the surface is flat, c is quadratic and its last digits are hard.
TAIL_GOAL = 0.1
#: Phase B ends after so many full normal steps, or when E changes by less than this part.
FULL_STEPS, SETTLED = 8, 2e-3
#: A step must bring |c|^2 down to (1 - SUFFICIENT a) of itself, a the part of the normal step that is taken.
SUFFICIENT = 0.2
#: The metric of the tail is kept while its steps are shorter than this, in mean edges; the factor of a step is used
#: again as long as that brings c down to this part of itself.
SHORT_STEP, CHORD = 0.05, 0.2
#: How often a step is cut before it is given up.
CUTS = 4
#: Heights of the kicks, in mean edges, each tried where the one before led to no solution.
KICKS = (0.5, 1.0, 2.0, 3.0)


class Problem(Protocol):
    """What the solver needs to know; x is flat, fixed unknowns have no gradient and no step."""

    def constraint(self, x: Floats) -> Floats: ...
    def jacobian(self, x: Floats) -> csr_matrix: ...
    def energy(self, x: Floats) -> float: ...
    def gradient_and_metric(self, x: Floats) -> tuple[Floats, MeshMatrix]: ...
    def gram(self, jacobian: csr_matrix) -> MeshMatrix: ...
    def kick(self, x: Floats, number: int) -> Floats:
        """A smooth step whose longest vertex move is 1; another one for every number."""


class SingularMetricError(ArithmeticError):
    """The metric is not positive definite, or not finite."""


@dataclass(frozen=True, eq=False)
class Result:
    """Where the solver came to.

    Attributes
    ----------
    x : the unknowns.
    residual : max |c|.
    steps : factorisations.
    status : `converged`, `step_limit`, `stalled` (no step lowers |c|) or `singular` (a triangle has collapsed).
    """

    x: Floats
    residual: float
    steps: int
    status: str


@dataclass
class _State:
    x: Floats
    steps: int = 0


def longest(step: Floats) -> float:
    """Length of the longest vertex move of a flat step."""
    return float(np.sqrt((step.reshape(-1, 3) ** 2).sum(axis=1).max(initial=0.0)))


def solve(
    problem: Problem, x: Floats, *, ramp: Floats, tolerance: float, max_steps: int, rough: bool = False
) -> Result:
    """Run phases A, B and C from x.

    Parameters
    ----------
    ramp : the penalties rho of phase A, one step each; none goes on from where x is.
    tolerance : max |c| to reach.
    max_steps : most steps of B and C together.
    rough : end as soon as c is within the tolerance, whether E has settled or not.
    """
    state = _State(x.copy())
    if not len(problem.constraint(x)):
        return Result(x, 0.0, 0, CONVERGED)
    try:
        _soft_ramp(problem, state, ramp)
        limit = state.steps + max_steps
        for number, height in enumerate((0.0, *KICKS)):
            if number:
                state.x = state.x + height * problem.kick(state.x, number)
            _tangential_and_normal_steps(problem, state, limit, tolerance if rough else 0.0)
            status = _newton_tail(problem, state, tolerance, limit, tolerance if rough else TAIL_GOAL * tolerance)
            if status != "stalled":
                break
    except SingularMetricError:
        status = "singular"
    residual = float(np.abs(problem.constraint(state.x)).max())
    return Result(state.x, residual, state.steps, status)


def _soft_ramp(problem: Problem, state: _State, ramp: Floats) -> None:
    """A: (H + rho J^T J) d = -(g + rho J^T c), cut to RAMP_STEP, no line search."""
    for rho in ramp:
        c, jacobian = problem.constraint(state.x), problem.jacobian(state.x)
        gradient, metric = problem.gradient_and_metric(state.x)
        factor = _factor(metric, problem.gram(jacobian), rho)
        step = factor.solve(-(gradient + rho * (jacobian.T @ c)))
        state.x = state.x + step * min(1.0, RAMP_STEP / max(longest(step), 1e-300))
        state.steps += 1


def _factor(metric: MeshMatrix, gram: MeshMatrix, beta: float) -> MeshFactor:
    """Factor of H + beta J^T J; a tenth of beta as often as round-off asks for it."""
    for _ in range(12):
        factor = metric.plus(gram, beta).factor()
        if factor is not None:
            return factor
        beta /= 10.0
    raise SingularMetricError


def _normal_step(factor: MeshFactor, c: Floats, jacobian: csr_matrix, beta: float, rounds: int) -> Floats:
    """min 1/2 d^T H d subject to J d = -c, by `rounds` of the augmented Lagrangian; A = H + beta J^T J."""
    multiplier = np.zeros_like(c)
    step = np.zeros(jacobian.shape[1])
    for _ in range(rounds):
        step = factor.solve(-(jacobian.T @ (beta * c + multiplier)))
        multiplier += beta * (c + jacobian @ step)
    return step


def _tangential_step(factor: MeshFactor, gradient: Floats, jacobian: csr_matrix, beta: float) -> Floats:
    """min g^T d + 1/2 d^T H d subject to J d = 0, in the same way, two rounds."""
    step = factor.solve(-gradient)
    return factor.solve(-(gradient + beta * (jacobian.T @ (jacobian @ step))))


def _tangential_and_normal_steps(problem: Problem, state: _State, limit: int, enough: float) -> None:
    """B: one factorisation a step; leaves when c falls in full steps, E has settled or max |c| is below `enough`."""
    beta, reach, full_steps = BETA, TANGENT_STEP, 0
    energy = problem.energy(state.x)
    while full_steps < FULL_STEPS and state.steps < limit:
        c = problem.constraint(state.x)
        if np.abs(c).max() < enough:
            return
        jacobian = problem.jacobian(state.x)
        gradient, metric = problem.gradient_and_metric(state.x)
        factor = _factor(metric, problem.gram(jacobian), beta)
        state.steps += 1
        normal = _normal_step(factor, c, jacobian, beta, rounds=2)
        tangential = _tangential_step(factor, gradient, jacobian, beta)
        share = min(1.0, NORMAL_STEP / max(longest(normal), 1e-300))
        tangential *= min(1.0, reach / max(longest(tangential), 1e-300))
        accepted = False
        for cut in range(CUTS):
            scale = 0.5**cut
            part = share * scale
            x = state.x + part * normal + scale * tangential
            x, c_new = _corrected(problem, factor, jacobian, beta, x, (1.0 - part) * c)
            energy_new = problem.energy(x)
            if _acceptable(c, c_new, part, energy, energy_new):
                accepted = True
                break
        if not accepted:
            if beta <= BETA_FLOOR:
                return
            beta, reach = max(beta / 10.0, BETA_FLOOR), 0.5 * reach
            continue
        settled = part == 1.0 and abs(energy - energy_new) < SETTLED * energy
        state.x, energy = x, energy_new
        full_steps += share == 1.0  # also where the step was cut: what creeps here, the tail does better
        reach = min(reach * (1.5 if cut == 0 else 0.5), TANGENT_STEP_MOST)
        beta = min(3.0 * beta, BETA_CEILING)
        if settled:
            return


def _corrected(
    problem: Problem, factor: MeshFactor, jacobian: csr_matrix, beta: float, x: Floats, target: Floats
) -> tuple[Floats, Floats]:
    """Up to two second-order corrections towards c = target with the factor of the step; keeps what helps."""
    c = problem.constraint(x)
    for _ in range(2):
        miss = c - target
        trial = x + factor.solve(-beta * (jacobian.T @ miss))
        c_trial = problem.constraint(trial)
        if not np.linalg.norm(c_trial - target) < 0.9 * np.linalg.norm(miss):
            break
        x, c = trial, c_trial
    return x, c


def _acceptable(c: Floats, c_new: Floats, part: float, energy: float, energy_new: float) -> bool:
    before, after = float(c @ c), float(c_new @ c_new)
    if not np.isfinite(energy_new) or not np.isfinite(after):
        return False
    if part < 1.0:
        return after <= (1.0 - SUFFICIENT * part) * before
    small = after <= 1e-6 * len(c)
    return after <= 0.5 * before or (small and energy_new < energy)


def _newton_tail(problem: Problem, state: _State, tolerance: float, limit: int, goal: float) -> str:
    """C: Newton steps on c alone in the metric H, with doubled steps where c is flat (double roots).

    Ends at max |c| <= `goal`, or within the tolerance where a step no longer halves c. H stays as long as the steps are
    short: it says which of many steps is taken, not where c is 0.
    """
    beta = TAIL_BETA
    metric: MeshMatrix | None = None
    c = problem.constraint(state.x)
    while not np.abs(c).max() <= goal:  # nan goes on to the factor, which says so
        if state.steps >= limit:
            return "step_limit" if np.abs(c).max() > tolerance else CONVERGED
        jacobian = problem.jacobian(state.x)
        if metric is None:
            _, metric = problem.gradient_and_metric(state.x)
        factor = _factor(metric, problem.gram(jacobian), beta)
        state.steps += 1
        step = _normal_step(factor, c, jacobian, beta, rounds=4)
        if longest(step) > SHORT_STEP:
            metric = None
        x, c_new = _line_search(problem, state.x, step, c)
        halved = x is not None and np.linalg.norm(c_new) <= 0.5 * np.linalg.norm(c)
        if x is not None:
            state.x, c = _chord_steps(problem, factor, jacobian, beta, x, c_new, goal) if halved else (x, c_new)
            beta = min(10.0 * beta, TAIL_BETA_CEILING)
        elif beta > 1.0:
            beta /= 100.0
        elif np.abs(c).max() > tolerance:
            return "stalled"
        if not halved and np.abs(c).max() <= tolerance:
            break
    return CONVERGED


def _chord_steps(
    problem: Problem, factor: MeshFactor, jacobian: csr_matrix, beta: float, x: Floats, c: Floats, goal: float
) -> tuple[Floats, Floats]:
    """Newton steps with the factor of the step before, as long as each takes c to `CHORD` of itself."""
    while np.abs(c).max() > goal:
        trial = x + _normal_step(factor, c, jacobian, beta, rounds=2)
        c_trial = problem.constraint(trial)
        if not np.linalg.norm(c_trial) <= CHORD * np.linalg.norm(c):
            break
        x, c = trial, c_trial
    return x, c


def _line_search(problem: Problem, x: Floats, step: Floats, c: Floats) -> tuple[Floats | None, Floats]:
    """Halve the step until |c| falls; try it twice as long where it is short."""
    step = step * min(1.0, NORMAL_STEP / max(longest(step), 1e-300))
    for cut in range(2 * CUTS):
        trial = x + 0.5**cut * step
        c_trial = problem.constraint(trial)
        if np.linalg.norm(c_trial) < (1.0 - 0.1 * 0.5**cut) * np.linalg.norm(c):
            if cut == 0 and longest(step) < 0.1:
                twice = x + 2.0 * step
                c_twice = problem.constraint(twice)
                if np.linalg.norm(c_twice) < np.linalg.norm(c_trial):
                    return twice, c_twice
            return trial, c_trial
    return None, c
