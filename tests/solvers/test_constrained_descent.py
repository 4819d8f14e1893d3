"""The solver on a mesh of one free vertex, where the answer is known, and where there is none."""

import numpy as np
import pytest

from flatnet.fitting.fair import FlattenableProblem
from flatnet.fitting.fair_energy import ghost_vertices
from flatnet.parameters import FairParameters
from flatnet.solvers.constrained_descent import CONVERGED, solve


def pyramid(rim_heights, apex):
    """Six triangles about a vertex; its planar mesh is the regular hexagon, its normals point up."""
    t = np.arange(6) * np.pi / 3
    planar = np.r_[np.c_[np.cos(t), np.sin(t)], [[0.0, 0.0]]]
    triangles = np.array([[k, (k + 1) % 6, 6] for k in range(6)])
    rim = np.c_[np.cos(t), np.sin(t), rim_heights]
    edges = np.roll(rim, -1, axis=0) - rim
    up = np.array([0.0, 0.0, 1.0]) - edges * (edges[:, 2] / np.sum(edges**2, axis=1))[:, None]
    ghosts = ghost_vertices(rim, up / np.linalg.norm(up, axis=1, keepdims=True))
    x = np.concatenate([rim, [apex], ghosts]).ravel()
    return FlattenableProblem(planar, triangles, 6, FairParameters()), x


def test_a_raised_apex_comes_down_into_the_plane():
    problem, x = pyramid(np.zeros(6), [0.1, 0.0, 0.6])
    result = solve(problem, x, ramp=np.geomspace(0.1, 100, 8), tolerance=1e-9, max_steps=200)
    assert result.status == CONVERGED
    # Over a plane the angle sum falls with the square of the height: 1e-9 rad are heights of some 1e-5.
    assert abs(result.x.reshape(-1, 3)[6, 2]) < 1e-4


def test_a_flat_mesh_is_made_fair_though_nothing_is_left_to_flatten():
    problem, x = pyramid(np.zeros(6), [0.3, 0.0, 0.0])
    assert np.abs(problem.constraint(x)).max() < 1e-15
    result = solve(problem, x, ramp=np.empty(0), tolerance=1e-9, max_steps=200)
    assert result.status == CONVERGED
    # By symmetry E is least in the middle; phase B ends where E has settled, to the second power of what is left.
    assert np.abs(result.x.reshape(-1, 3)[6]).max() < 1e-3


def test_a_bent_rim_is_met_exactly():
    problem, x = pyramid(0.2 * np.array([0, 1, 1, 0, -1, -1.0]), [0.0, 0.0, 0.1])
    result = solve(problem, x, ramp=np.geomspace(0.1, 100, 8), tolerance=1e-9, max_steps=200)
    assert result.status == CONVERGED
    assert result.residual == pytest.approx(np.abs(problem.constraint(result.x)).max())
    assert result.residual <= 1e-9
    fixed = np.ones(len(x), dtype=bool)
    fixed[18:21] = False
    assert np.array_equal(result.x[fixed], x[fixed])


def test_a_collapsed_triangle_is_a_status_and_no_exception():
    problem, x = pyramid(np.zeros(6), [np.nan, 0.0, 0.6])
    with np.errstate(invalid="ignore"):
        assert solve(problem, x, ramp=np.array([1.0]), tolerance=1e-9, max_steps=5).status == "singular"


def test_too_few_steps_are_said():
    problem, x = pyramid(0.2 * np.array([0, 1, 1, 0, -1, -1.0]), [0.0, 0.0, 0.5])
    assert solve(problem, x, ramp=np.array([1.0]), tolerance=1e-12, max_steps=1).status == "step_limit"
