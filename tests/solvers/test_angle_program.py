"""Eq. 2: the optimum against SciPy's SLSQP, exact closing, bounds, statuses."""

import numpy as np
import pytest
from scipy.optimize import minimize

from flatnet.geometry.polygon import polygon_angles, predicted_angles
from flatnet.solvers.angle_program import AngleStatus, lay_out, nearest_in_box, solve_angle_program

TURN = 2.0 * np.pi


def edge_lengths(vertices):
    return np.linalg.norm(np.roll(vertices, -1, axis=0) - vertices, axis=1)


def wavy_loop(n, height=0.35):
    """A closed curve that swings up and down, with normals near +z."""
    t = TURN * np.arange(n) / n
    swing = np.sin(3 * t) + 0.5 * np.cos(2 * t + 1.0)
    vertices = np.c_[1.5 * np.cos(t) + 0.2 * np.sin(2 * t), np.sin(t), height * swing]
    edges = np.roll(vertices, -1, axis=0) - vertices
    normals = np.cross(np.cross(edges, [0.1, 0.2, 1.0]), edges)
    return vertices, normals / np.linalg.norm(normals, axis=1)[:, None]


def random_polygon(rng):
    n = int(rng.integers(3, 40))
    vertices = rng.normal(size=(n, 3))
    edges = np.roll(vertices, -1, axis=0) - vertices
    normals = np.cross(np.cross(edges, rng.normal(size=(n, 3))), edges)
    return vertices, normals / np.linalg.norm(normals, axis=1)[:, None]


def program(vertices, normals):
    alpha, _ = predicted_angles(vertices, normals)
    return alpha, edge_lengths(vertices), polygon_angles(vertices), np.full(len(vertices), TURN)


def slsqp(alpha, lengths, lower, upper):
    """The same program given to SciPy, started at alpha."""
    n, share = len(alpha), lengths / lengths.sum()

    def closing(theta):
        phi = np.cumsum(np.pi - theta)
        return np.array([theta.sum() - (n - 2) * np.pi, share @ np.cos(phi), share @ np.sin(phi)])

    def jacobian(theta):
        phi = np.cumsum(np.pi - theta)
        along_x = np.cumsum((share * np.sin(phi))[::-1])[::-1]
        along_y = -np.cumsum((share * np.cos(phi))[::-1])[::-1]
        return np.stack([np.ones(n), along_x, along_y])

    result = minimize(
        lambda theta: 0.5 * np.sum((theta - alpha) ** 2),
        np.clip(alpha, lower, upper),
        jac=lambda theta: theta - alpha,
        bounds=list(zip(lower, upper)),
        constraints={"type": "eq", "fun": closing, "jac": jacobian},
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert np.abs(closing(result.x)).max() < 1e-8
    return result.fun


@pytest.mark.parametrize("n", [5, 12, 40, 120])
@pytest.mark.parametrize("height", [0.1, 0.35])
def test_same_objective_as_slsqp(n, height):
    alpha, lengths, lower, upper = program(*wavy_loop(n, height))
    solution = solve_angle_program(alpha, lengths, lower, upper)
    assert solution.status is AngleStatus.CONVERGED
    objective = 0.5 * np.sum((solution.angles - alpha) ** 2)
    assert objective == pytest.approx(slsqp(alpha, lengths, lower, upper), abs=1e-9)


def test_same_objective_as_slsqp_with_most_bounds_active():
    """A circle of latitude: the normals ask for larger angles than the plane has room for."""
    n = 100
    t = TURN * np.arange(n) / n
    alpha = np.full(n, np.pi - 0.8 * TURN / n) + 0.02 * np.cos(2 * t)
    lower = np.full(n, np.pi - 1.01 * TURN / n)
    upper = np.full(n, TURN)
    solution = solve_angle_program(alpha, np.ones(n), lower, upper)
    assert (solution.angles == lower).sum() > n // 4
    objective = 0.5 * np.sum((solution.angles - alpha) ** 2)
    assert objective == pytest.approx(slsqp(alpha, np.ones(n), lower, upper), abs=1e-9)


@pytest.mark.parametrize("n", [3, 4, 10, 300, 10_000])
def test_the_polygon_closes_to_round_off_at_every_size(n):
    vertices, normals = wavy_loop(n, 0.2)
    alpha, lengths, lower, upper = program(vertices, normals)
    solution = solve_angle_program(alpha, lengths, lower, upper)
    assert solution.status is AngleStatus.CONVERGED
    assert solution.gap <= 1e-12
    assert (solution.angles >= lower).all() and (solution.angles <= upper).all()
    # Positions are rounded to eps of the perimeter, n eps of an edge.
    assert edge_lengths(solution.positions) == pytest.approx(lengths, rel=1e-12 + 4e-16 * n)
    assert solution.steps <= 30


def test_random_polygons_with_random_normals_are_solved_within_bounds():
    rng = np.random.default_rng(3)
    for _ in range(100):
        alpha, lengths, lower, upper = program(*random_polygon(rng))
        solution = solve_angle_program(alpha, lengths, lower, upper)
        assert solution.status is AngleStatus.CONVERGED
        assert solution.gap <= 1e-12
        assert (solution.angles >= lower).all() and (solution.angles <= upper).all()


def test_plane_triangles_with_divided_sides_are_solved():
    """All angles but one lie at their bounds or between them to round-off: nothing is left to move."""
    rng = np.random.default_rng(1)
    for _ in range(60):
        corners = rng.normal(size=(3, 2)) * 50.0
        (x, y), (u, v) = corners[1:] - corners[0]
        corners = corners if x * v > y * u else corners[::-1]
        counts = np.ceil(edge_lengths(corners) / 10.0).astype(int)
        ends = zip(corners, np.roll(corners, -1, axis=0), counts, strict=True)
        sides = [a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a) for a, b, count in ends]
        vertices = np.c_[np.concatenate(sides), np.zeros(counts.sum())]
        solution = solve_angle_program(*program(vertices, np.tile([0.0, 0.0, 1.0], (len(vertices), 1))))
        assert solution.status is AngleStatus.CONVERGED
        assert solution.angles == pytest.approx(polygon_angles(vertices), abs=1e-7)


def test_the_first_vertex_does_not_matter():
    alpha, lengths, lower, upper = program(*wavy_loop(50))
    solution = solve_angle_program(alpha, lengths, lower, upper)
    shifted = solve_angle_program(*(np.roll(array, 17) for array in (alpha, lengths, lower, upper)))
    assert np.roll(solution.angles, 17) == pytest.approx(shifted.angles, abs=1e-12)


def test_infeasible_where_one_edge_is_longer_than_all_others():
    lengths = np.array([1.0, 1.0, 1.0, 3.5])
    solution = solve_angle_program(np.full(4, np.pi / 2), lengths, np.zeros(4), np.full(4, TURN))
    assert solution.status in (AngleStatus.INFEASIBLE, AngleStatus.SINGULAR)
    assert solution.gap >= 0.5 / 6.5 - 1e-12


def test_not_converged_where_the_lower_bounds_leave_no_room():
    solution = solve_angle_program(np.full(4, 1.5), np.ones(4), np.full(4, 1.6), np.full(4, TURN))
    assert solution.status in (AngleStatus.INFEASIBLE, AngleStatus.SINGULAR)


def test_step_limit_is_reported():
    alpha, lengths, lower, upper = program(*wavy_loop(40))
    assert solve_angle_program(alpha, lengths, lower, upper, max_steps=1).status is AngleStatus.STEP_LIMIT


def test_nearest_in_box_satisfies_the_optimality_conditions():
    rng = np.random.default_rng(0)
    for _ in range(50):
        n = int(rng.integers(5, 60))
        rows = np.vstack([np.ones(n), rng.normal(size=(2, n))])
        inside, point = rng.uniform(0, 1, n), rng.normal(size=n)
        x, multipliers, residual = nearest_in_box(point, rows, rows @ inside, np.zeros(n), np.ones(n))
        assert np.abs(residual).max() < 1e-12 * n
        pull = x - point - multipliers @ rows
        at_lower, at_upper = x == 0.0, x == 1.0
        assert np.abs(pull[~at_lower & ~at_upper]).max(initial=0.0) < 1e-12
        assert (pull[at_lower] >= 0.0).all() and (pull[at_upper] <= 0.0).all()


def test_lay_out_spreads_the_gap_along_the_perimeter():
    angles = np.full(6, 2.0 * np.pi / 3.0) + 1e-3 * np.array([1, -1, 2, 0, 0, -2])
    lengths = np.array([1.0, 2.0, 1.0, 1.0, 2.0, 1.0])
    positions, gap = lay_out(angles, lengths)
    size = np.linalg.norm(gap) / lengths.sum()
    assert size > 1e-5
    assert np.abs(edge_lengths(positions) / lengths - 1.0).max() <= size * (1 + 1e-9)
