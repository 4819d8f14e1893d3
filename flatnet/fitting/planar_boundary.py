"""Fit the length-preserved planar boundary B^p to the boundary curve B (paper 3.1, Eq. 1-2, Lemmas 1 and 2)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding, PatchFailure
from flatnet.fitting.results import PlanarBoundary
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.polygon import polygon_angles, predicted_angles, side_lengths
from flatnet.network.patch import BoundaryCurve
from flatnet.solvers.angle_program import AngleSolution, AngleStatus, solve_angle_program

Floats = NDArray[np.float64]

STAGE = "planar_boundary"
#: Lemma 2 fires above this excess per vertex, rad. The angles of a closed polygon in space never exceed
#: (n - 2) pi (Fenchel); a triangle and a planar convex one reach it, and rounding adds about 1e-15 a vertex.
LEMMA_2_TOLERANCE = 1e-13
#: The bound that opens a crossing is looked for to this accuracy, rad.
BOUND_ACCURACY = np.radians(0.1)
#: Second moments that differ by less than this share have no principal axis; third ones below it, no sense.
ISOTROPIC, SYMMETRIC = 1e-5, 1e-7
#: Vertices whose distances from the centroid differ by less than this share are equally far.
EQUALLY_FAR = 1e-7


def fit_planar_boundary(boundary: BoundaryCurve, simple: bool = False) -> PlanarBoundary:
    """B^p: the planar polygon with the edge lengths of B whose angles are nearest to those that the normals predict.

    Solves Eq. 2 with the lower bounds of Lemma 1, raised by `boundary.min_angles`, and theta <= 2 pi; places the
    result in `canonical_frame`.

    Parameters
    ----------
    simple : where B^p crosses itself, Eq. 2 is solved again with the largest bound theta <= bound that removes the
        crossing, and a warning says how far the angles were changed. The bound pi gives a convex outline, and always
        has a solution.

    Raises
    ------
    PatchFailure
        `lemma_2` where the lower bounds add up to more than (n - 2) pi; that takes a `min_angle`, since the
        angles in space alone never do. `self_intersection` where B^p crosses itself; the two sides of a slit may
        touch. `not_converged` where Eq. 2 was not solved.
        `degenerate_curve` for fewer than three vertices, or an edge whose length is no positive number.
    """
    vertices = boundary.vertices
    lengths = side_lengths(vertices)
    _check_edges(lengths, boundary)
    predicted, opposed = predicted_angles(vertices, boundary.normals)
    predicted[list(boundary.slit_tips)] = 2.0 * np.pi
    lower = np.maximum(polygon_angles(vertices), boundary.min_angles)
    _check_lemma_2(lower, boundary)

    def solve(largest: float) -> AngleSolution:
        upper = np.maximum(lower, largest)
        upper[list(boundary.slit_tips)] = 2.0 * np.pi
        return solve_angle_program(predicted, lengths, lower, upper)

    solution = solve(2.0 * np.pi)
    if solution.status is not AngleStatus.CONVERGED:
        raise PatchFailure.of(
            "not_converged",
            STAGE,
            f"no flat outline with these edge lengths and smallest angles was found ({solution.status.value} "
            f"after {solution.steps} steps, open by {solution.gap * lengths.sum():.3g} mm).",
            "Lower min_angle, or check the normals of the patch.",
            amount=solution.gap * float(lengths.sum()),
            unit="mm",
        )
    warnings = [opposed_normals(boundary, int(vertex)) for vertex in np.flatnonzero(opposed)]
    if simple and polygon_crossings(solution.positions, vertices):
        bound, opened = _mildest_simple(solve, vertices)
        warnings.append(_opened(bound, solution, opened, predicted))
        solution = opened
    _check_crossings(solution.positions, boundary)
    return PlanarBoundary(
        positions=canonical_frame(solution.positions),
        inner_angles=solution.angles,
        predicted_angles=predicted,
        lower_bounds=lower,
        warnings=tuple(warnings),
    )


def _mildest_simple(solve: Callable[[float], AngleSolution], vertices: Floats) -> tuple[float, AngleSolution]:
    """The largest bound of the angles whose outline does not cross itself, to `BOUND_ACCURACY`, and that outline."""
    low, high = np.pi, 2.0 * np.pi
    best = solve(low)
    while high - low > BOUND_ACCURACY:
        middle = 0.5 * (low + high)
        trial = solve(middle)
        if trial.status is AngleStatus.CONVERGED and not polygon_crossings(trial.positions, vertices):
            low, best = middle, trial
        else:
            high = middle
    return low, best


def _opened(bound: float, before: AngleSolution, after: AngleSolution, predicted: Floats) -> Finding:
    errors = [float(np.mean((solution.angles - predicted) ** 2)) for solution in (before, after)]
    return Finding(
        code="outline_opened",
        stage=STAGE,
        message=(
            "its flat outline crossed itself and was opened: no inner angle is larger than "
            f"{np.degrees(bound):.1f} degrees now, and the mean square error of the angles is {errors[1]:.3g} "
            f"rad^2 where it was {errors[0]:.3g}."
        ),
        remedy="The patch departs from its normals for it; a cut (`flatnet diagnose`) keeps them.",
        amount=errors[1],
        unit="rad^2",
    )


def canonical_frame(positions: Floats) -> Floats:
    """The polygon in a frame that depends on nothing but its shape.

    The origin is the centroid of the area, x runs along the major principal axis of its second moments, in the
    sense in which the third moment of x is positive; where that vanishes (symmetry), in the sense in which that of y
    is. So neither a rigid motion nor another first vertex changes the result, and a mirror image comes out mirrored
    (y -> -y; -x for a shape with a mirror line across its major axis).

    Ties: a shape unchanged by half a turn may come out turned by half a turn. One without a principal axis (a square,
    a regular polygon) has x towards the vertex farthest from the centroid, the first in the order of B of those
    equally far.
    """
    following = np.roll(positions, -1, axis=0)

    def moment(x: Floats, power: int) -> float:
        """Integral of x^power over the area; x is linear in the plane, given at the vertices."""
        y = np.roll(x, -1)
        terms = sum(x**k * y ** (power - k) for k in range(power + 1))
        return float(twice_area @ terms) / ((power + 1) * (power + 2))

    origin = positions.mean(axis=0)
    for _ in range(2):  # the second time with small numbers: to round-off
        p, q = positions - origin, following - origin
        twice_area = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        origin = origin + np.array([moment(p[:, 0], 1), moment(p[:, 1], 1)]) / moment(p[:, 0], 0)
    x, y = (positions - origin).T
    twice_area = x * np.roll(y, -1) - y * np.roll(x, -1)

    xx, yy = moment(x, 2), moment(y, 2)
    xy = 0.5 * (moment(x + y, 2) - xx - yy)
    if np.hypot(xx - yy, 2.0 * xy) > ISOTROPIC * (xx + yy):
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        turned = _turned(x, y, angle)
        scale = SYMMETRIC * (xx + yy) * np.hypot(x, y).max()
        sense = next((m for m in (moment(turned[:, 0], 3), moment(turned[:, 1], 3)) if abs(m) > scale), 1.0)
        return turned if sense > 0.0 else -turned
    distance = np.hypot(x, y)
    farthest = int(np.argmax(distance > (1.0 - EQUALLY_FAR) * distance.max()))
    return _turned(x, y, np.arctan2(y[farthest], x[farthest]))


def _turned(x: Floats, y: Floats, angle: float) -> Floats:
    """Coordinates in axes that are turned by `angle`, (n, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y, c * y - s * x], axis=1)


def _check_edges(lengths: Floats, boundary: BoundaryCurve) -> None:
    broken = np.flatnonzero(~(np.isfinite(lengths) & (lengths > 0.0)))
    if len(lengths) >= 3 and not len(broken):
        return
    where = boundary.place(int(broken[0])) if len(broken) else ""
    of_edge = f"the edge from {where} on is {lengths[broken[0]]:g} mm long" if len(broken) else f"it has {len(lengths)}"
    raise PatchFailure.of(
        "degenerate_curve",
        STAGE,
        f"a boundary needs at least 3 edges, each longer than 0; {of_edge}.",
        "Take the point out that stands there twice, or is no place.",
        where=where,
    )


def _check_lemma_2(lower: Floats, boundary: BoundaryCurve) -> None:
    n = len(lower)
    excess = float(lower.sum() - (n - 2) * np.pi)
    if excess <= LEMMA_2_TOLERANCE * n:
        return
    raised = np.flatnonzero(boundary.min_angles > polygon_angles(boundary.vertices))
    where = ", ".join(boundary.place(int(vertex)) for vertex in raised)
    raise PatchFailure.of(
        "lemma_2",
        STAGE,
        f"the smallest angles of the flat outline add up to {np.degrees(excess):.4g} degrees more than a closed "
        f"outline of {n} vertices has; they are raised by min_angle at {where}.",
        "Lower min_angle there by that much in all.",
        where=where,
        amount=excess,
        unit="rad",
    )


def _check_crossings(positions: Floats, boundary: BoundaryCurve) -> None:
    crossings = polygon_crossings(positions, boundary.vertices)
    if not crossings:
        return
    i, s, j, t = crossings[0]
    first, second = boundary.place(i + s), boundary.place(j + t)
    raise PatchFailure.of(
        "self_intersection",
        STAGE,
        f"the flat outline crosses itself {len(crossings)} times, first where {first} meets {second}.",
        "A curve that cuts the patch in two between these places solves it.",
        where=f"{first} and {second}",
        amount=float(len(crossings)),
        unit="crossings",
    )


def opposed_normals(boundary: BoundaryCurve, vertex: int) -> Finding:
    """The warning that the normals before and behind a vertex are opposed."""
    where = boundary.place(vertex)
    return Finding(
        code="opposed_normals",
        stage=STAGE,
        message=f"the normals of the two edges that meet at {where} are opposed; the angle in space is used there.",
        remedy="Give normals that turn by less than 180 degrees from edge to edge.",
        where=where,
        amount=180.0,
        unit="deg",
    )
