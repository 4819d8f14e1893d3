"""The angles of a closed planar polygon with given edge lengths that are nearest to given angles (paper Eq. 2).

    min  1/2 |theta - alpha|^2
    s.t. sum_i theta_i = (n - 2) pi,   sum_i l_i (cos phi_i, sin phi_i) = 0,   lower <= theta <= upper

where phi_i = phi_0 + sum_{b <= i} (pi - theta_b) is the direction of edge i.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Floats = NDArray[np.float64]

#: Armijo's share of the descent that a step promises.
SUFFICIENT_DESCENT = 1e-4
#: Weight that holds the multipliers of a quadratic program near their centre, per unknown.
DUAL_DAMPING = 1e-6
#: Error of a row of a quadratic program that counts as none, per unknown.
ROUND_OFF = 1e-16
#: Largest step of an angle, rad, at which the unit Hessian hands over to the exact one, and that counts as none.
NEAR_STEP, LAST_STEP = 1e-3, 1e-10
#: Least eigenvalue, per vertex, of the Gram matrix of the free closing conditions: below it they are dependent.
DEPENDENT = 1e-12
#: Most gap over the perimeter of a polygon that counts as closed, and most error of its angle sum per vertex, rad.
CLOSED_GAP, CLOSED_TURN = 1e-12, 1e-13


class AngleStatus(Enum):
    """How the iteration ended."""

    CONVERGED = "converged"
    INFEASIBLE = "infeasible"
    SINGULAR = "singular"
    STEP_LIMIT = "step limit"


@dataclass(frozen=True, eq=False)
class AngleSolution:
    """Where the iteration ended.

    Attributes
    ----------
    angles : (n,) float, rad; theta, within its bounds.
    positions : (n, 2) float; the polygon, closed by force (`lay_out`), in the unit of the edge lengths.
    gap : by how much the angles alone leave the polygon open, over its perimeter.
    status : only a converged polygon is a solution.
    steps : quadratic programs solved.
    """

    angles: Floats
    positions: Floats
    gap: float
    status: AngleStatus
    steps: int


@dataclass(frozen=True, eq=False)
class _Program:
    """Eq. 2 with the perimeter as the unit of length."""

    predicted: Floats
    share: Floats
    lower: Floats
    upper: Floats

    def closing(self, angles: Floats) -> tuple[Floats, Floats]:
        """Positions of the polygon and its closing error: the excess of the angle sum and the gap, (3,)."""
        positions, gap = lay_out(angles, self.share)
        return positions, np.array([(angles - np.pi).sum() + 2.0 * np.pi, *gap])

    def nearest(self, angles: Floats, rows: Floats, error: Floats) -> tuple[Floats, Floats, Floats]:
        """The step to the nearest angles within bounds that takes the error of linear constraints away."""
        return nearest_in_box(self.predicted - angles, rows, -error, self.lower - angles, self.upper - angles)


def solve_angle_program(
    predicted: Floats, lengths: Floats, lower: Floats, upper: Floats, *, max_steps: int = 200
) -> AngleSolution:
    """Eq. 2 by sequential quadratic programming.

    The steps take the unit Hessian, so that each is a projection onto a box and three linear equations
    (`nearest_in_box`, O(n)). A line search on the merit function 1/2 |theta - alpha|^2 + nu |closing error|, with nu
    twice the length of the multipliers, makes them converge from afar; Newton steps with the exact Hessian
    finish them. Where no step from alpha closes the polygon, the convex polygon (theta <= pi) nearest to alpha
    is the second start: one exists for every closed polygon in space.

    Parameters
    ----------
    predicted : (n,) float, rad; alpha.
    lengths : (n,) float > 0; lengths[i] from vertex i to i + 1.
    lower, upper : (n,) float, rad; bounds of theta.
    """
    n = len(predicted)
    program = _Program(predicted, lengths / lengths.sum(), lower, upper)
    solution = _descend(program, predicted, max_steps)
    room = lower.sum() - CLOSED_TURN * n <= (n - 2) * np.pi <= upper.sum() + CLOSED_TURN * n
    if solution.status is not AngleStatus.CONVERGED and room:
        convex = replace(program, upper=np.minimum(upper, np.maximum(lower, np.pi)))
        start = _descend(convex, lower, max_steps)
        second = _descend(program, start.angles, max_steps)
        solution = replace(second, steps=solution.steps + start.steps + second.steps)
    return replace(solution, positions=solution.positions * lengths.sum())


def lay_out(angles: Floats, lengths: Floats) -> tuple[Floats, Floats]:
    """The polygon of given inner angles and edge lengths, closed by force.

    What is left open between last and first vertex is spread along the perimeter, so that the relative error
    of every edge length is at most the gap over the perimeter. The mean direction of the edges is held, so that
    nothing but a constant turn depends on which vertex is the first.

    Returns
    -------
    positions : (n, 2) float.
    gap : (2,) float; from first to last point before closing.
    """
    share = lengths / lengths.sum()
    directions = np.cumsum(np.pi - angles)
    directions -= share @ directions
    ends = np.cumsum(lengths[:, None] * np.stack([np.cos(directions), np.sin(directions)], axis=1), axis=0)
    gap = ends[-1]
    closed = ends - np.cumsum(share)[:, None] * gap
    return np.concatenate([np.zeros((1, 2)), closed[:-1]]), gap


def _closing_rows(positions: Floats) -> Floats:
    """Derivative of the closing error by the angles, (3, n): ones, and the positions turned by 90 degrees.

    Exact with the gauge and the closing of `lay_out`; centred, which the row of ones makes up for.
    """
    centred = positions - positions.mean(axis=0)
    return np.stack([np.ones(len(positions)), -centred[:, 1], centred[:, 0]])


def _descend(program: _Program, start: Floats, max_steps: int) -> AngleSolution:
    """Steps with the unit Hessian and a line search; near the end, steps with the exact one."""
    # The sum of the angles is linear: put right first, it stays right.
    n = len(start)
    total = np.array([(n - 2) * np.pi])
    angles = nearest_in_box(start, np.ones((1, n)), total, program.lower, program.upper)[0]
    step = _step(program, angles)
    near, steps, penalty = NEAR_STEP, 1, 0.0
    while steps < max_steps:
        if step.size < near:
            angles, step, taken = _finish(program, angles, step)
            near, steps = 0.1 * step.size, steps + taken
            if step.size <= LAST_STEP:
                break
        penalty = max(penalty, 2.0 * float(np.linalg.norm(step.multipliers)))
        fraction = _line_search(program, angles, step, penalty)
        if fraction == 0.0:
            break
        angles = angles + fraction * step.step
        step, steps = _step(program, angles), steps + 1

    closed = step.gap <= CLOSED_GAP and abs(step.error[0]) <= CLOSED_TURN * n
    if closed and step.size <= LAST_STEP:
        status = AngleStatus.CONVERGED
    elif closed or steps >= max_steps:
        status = AngleStatus.STEP_LIMIT
    else:
        free_rows = step.rows[:, step.free]
        dependent = np.linalg.eigvalsh(free_rows @ free_rows.T)[0] <= DEPENDENT * n
        status = AngleStatus.SINGULAR if dependent else AngleStatus.INFEASIBLE
    return AngleSolution(angles, step.positions, step.gap, status, steps)


@dataclass(frozen=True, eq=False)
class _Step:
    """The solution of the quadratic program at some angles, and what it was made from."""

    positions: Floats
    rows: Floats
    error: Floats
    step: Floats
    free: NDArray[np.bool_]
    multipliers: Floats
    residual: Floats

    @property
    def size(self) -> float:
        """Largest change of an angle, rad; it vanishes only at a solution."""
        return float(np.abs(self.step).max())

    @property
    def gap(self) -> float:
        return float(np.linalg.norm(self.error[1:]))


def _step(program: _Program, angles: Floats) -> _Step:
    positions, error = program.closing(angles)
    rows = _closing_rows(positions)
    step, multipliers, residual = program.nearest(angles, rows, error)
    goal = angles + step
    free = (goal > program.lower) & (goal < program.upper)
    return _Step(positions, rows, error, step, free, multipliers, residual)


def _line_search(program: _Program, angles: Floats, step: _Step, penalty: float) -> float:
    """The largest of 1, 1/2, 1/4 ... that lets the merit function fall enough; 0 where none does."""

    def merit(angles: Floats, error: Floats) -> float:
        return float(0.5 * np.sum((angles - program.predicted) ** 2) + penalty * np.linalg.norm(error))

    slope = (angles - program.predicted) @ step.step
    slope -= penalty * (np.linalg.norm(step.error) - np.linalg.norm(step.residual))
    before = merit(angles, step.error)
    noise = 1e-13 * (1.0 + before)
    fraction = 1.0
    while fraction > 1e-9:
        trial = angles + fraction * step.step
        if merit(trial, program.closing(trial)[1]) <= before + SUFFICIENT_DESCENT * fraction * slope + noise:
            return fraction
        fraction *= 0.5
    return 0.0


def _finish(program: _Program, angles: Floats, step: _Step) -> tuple[Floats, _Step, int]:
    """Newton steps, or plain ones, for as long as they halve what is left to do: down to round-off."""
    taken, improved = 0, True
    while improved:
        improved = False
        for move in (_newton_step(program, angles, step), step.step):
            trial = np.clip(angles + move, program.lower, program.upper)
            trial_step, taken = _step(program, trial), taken + 1
            if max(trial_step.size, trial_step.gap) < 0.5 * max(step.size, step.gap):
                angles, step, improved = trial, trial_step, True
                break
    return angles, step, taken


def _newton_step(program: _Program, angles: Floats, step: _Step) -> Floats:
    """The step to a stationary point of the Lagrangian; angles that the quadratic program leaves at a bound stay.

    The second derivative of the closing error by theta_a and theta_b is the position of vertex max(a, b), so the
    Hessian W of the Lagrangian is the unit matrix plus s_max(a, b). Differences of neighbouring rows of
    W d = r, in the unknowns E_j = d_1 + ... + d_j, are tridiagonal:

        -E_{j-1} + (2 + s_j - s_{j+1}) E_j - E_{j+1} = r_j - r_{j+1},    last row: -E_{k-1} + (1 + s_k) E_k = r_k
    """
    free = step.free
    rows = step.rows[:, free]
    k = rows.shape[1]
    if k < 3:
        return step.step
    s = -(step.multipliers[1] * step.rows[2, free] - step.multipliers[2] * step.rows[1, free])
    goal_at_bounds = np.where(free, 0.0, step.step)

    band = np.full((3, k), -1.0)
    band[1, :-1] = 2.0 + s[:-1] - s[1:]
    band[1, -1] = 1.0 + s[-1]
    right = np.column_stack([(program.predicted - angles)[free], rows.T])
    right[:-1] -= right[1:]
    sums = solve_banded((1, 1), band, right)
    solved = np.diff(sums, axis=0, prepend=np.zeros((1, 4)))
    error = step.error + step.rows @ goal_at_bounds
    try:
        multipliers = np.linalg.solve(rows @ solved[:, 1:], -error - rows @ solved[:, 0])
    except np.linalg.LinAlgError:  # what is free can't move: a triangle, all its straight angles at their bounds
        return step.step
    newton = goal_at_bounds
    newton[free] = solved @ np.r_[1.0, multipliers]
    return newton


def nearest_in_box(
    point: Floats, rows: Floats, target: Floats, lower: Floats, upper: Floats
) -> tuple[Floats, Floats, Floats]:
    """The x nearest to `point` with rows x = target and lower <= x <= upper.

    x = clip(point + rows^T m): a semi-smooth Newton iteration on the few multipliers m finds which bounds hold,
    O(n) a step, and lets a bound go as soon as its multiplier changes sign. A quadratic term holds m near a centre,
    which moves to m until the rows are exact or come no nearer: so dependent rows do no harm, and where no x
    satisfies rows and box the x returned comes close.

    Parameters
    ----------
    rows : (k, n) float, k small.
    target : (k,) float.

    Returns
    -------
    x : (n,) float, within its bounds.
    multipliers : (k,) float.
    residual : (k,) float; rows x - target.
    """
    damping = DUAL_DAMPING * len(point)
    multipliers = np.zeros(len(rows))
    left = np.inf
    for _ in range(20):
        multipliers = _damped_multipliers(point, rows, target, lower, upper, multipliers, damping)
        x = np.clip(point + multipliers @ rows, lower, upper)
        residual = rows @ x - target
        before, left = left, np.abs(residual).max()
        if left <= ROUND_OFF * len(point) or left > 0.5 * before:
            break
    return x, multipliers, residual


def _damped_multipliers(
    point: Floats, rows: Floats, target: Floats, lower: Floats, upper: Floats, centre: Floats, damping: float
) -> Floats:
    """The m at which rows clip(point + rows^T m) - target + damping (m - centre) vanishes."""

    def evaluate(m: Floats) -> tuple[NDArray[np.bool_], Floats]:
        unbounded = point + m @ rows
        x = np.clip(unbounded, lower, upper)
        return x == unbounded, rows @ x - target + damping * (m - centre)

    m = centre
    free, residual = evaluate(m)
    for _ in range(100):
        free_rows, before = rows[:, free], free
        step = -np.linalg.solve(free_rows @ free_rows.T + damping * np.eye(len(rows)), residual)
        slope, fraction = residual @ step, 1.0
        # The dual is convex: a positive slope at the end of the step says that it went too far.
        while True:
            free, residual = evaluate(m + fraction * step)
            if residual @ step <= -0.1 * slope or fraction < 1e-12:
                break
            fraction *= 0.5
        m = m + fraction * step
        if fraction == 1.0 and np.array_equal(free, before):
            break
    return m
