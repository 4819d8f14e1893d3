"""Algorithm 1 as printed: gentle patches become flattenable, others less unflattenable; it says how it ended."""

import numpy as np
import pytest

from flatnet.fitting.multi_loop import _average_planes, _problem, multi_loop
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from flatnet.network.patch import BoundaryCurve, Stretch
from flatnet.parameters import MultiLoopParameters

TURN = 2.0 * np.pi


def graph_boundary(outline, height, scale=1.0):
    """The outline lifted onto z = height(x, y), with the surface's normals."""
    edges = np.roll(outline, -1, axis=0) - outline
    middle, step = outline + 0.5 * edges, 1e-4
    by_x = (height(*(middle + [step, 0]).T) - height(*(middle - [step, 0]).T)) / (2 * step)
    by_y = (height(*(middle + [0, step]).T) - height(*(middle - [0, step]).T)) / (2 * step)
    vertices = np.c_[outline, height(*outline.T)]
    edges = np.roll(vertices, -1, axis=0) - vertices
    normals = np.cross(np.cross(edges, np.c_[-by_x, -by_y, np.ones(len(outline))]), edges)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    n = len(outline)
    return BoundaryCurve(scale * vertices, normals, (Stretch("rim", 0, n, False),), np.zeros(n))


def oval(n=60):
    t = TURN * np.arange(n) / n
    return np.c_[60 * np.cos(t), 40 * np.sin(t)]


def gentle_cap(scale=1.0):
    return graph_boundary(oval(), lambda x, y: -0.002 * (x**2 + 0.5 * y**2), scale)


def gentle_roll():
    return graph_boundary(oval(), lambda x, y: 8 * np.cos(x / 40 + y / 90))


def wrinkled():
    return graph_boundary(oval(), lambda x, y: 3 * np.sin(x / 8) * (1 + y / 80))


def meshes(boundary, edge_length=8.0):
    planar = tessellate(fit_planar_boundary(boundary), edge_length)
    return warp(planar, boundary), planar


@pytest.mark.parametrize("make", [gentle_cap, gentle_roll])
def test_gentle_patches_become_flattenable(make):
    boundary = make()
    warped, planar = meshes(boundary)
    parameters = MultiLoopParameters(tolerance=1e-8)
    mesh = multi_loop(warped, boundary, planar, parameters)
    assert warped.max_flattenability > 1e-4
    assert mesh.status == "converged"
    assert mesh.max_flattenability <= 1e-8
    assert np.array_equal(mesh.vertices[: len(boundary.vertices)], boundary.vertices)
    assert 1 <= mesh.steps <= parameters.max_outer_loops * parameters.inner_steps


def test_a_wrinkled_patch_comes_nearer_and_the_rest_is_reported():
    boundary = wrinkled()
    warped, planar = meshes(boundary)
    mesh = multi_loop(warped, boundary, planar, MultiLoopParameters(max_outer_loops=10))
    assert mesh.max_flattenability < 0.7 * warped.max_flattenability
    assert mesh.status == "outer loop limit" and mesh.max_flattenability > 1e-10
    assert mesh.steps <= 50


def test_a_flat_patch_takes_no_step():
    boundary = graph_boundary(oval(), lambda x, y: 0 * x)
    warped, planar = meshes(boundary)
    mesh = multi_loop(warped, boundary, planar, MultiLoopParameters(tolerance=1e-9))
    assert (mesh.status, mesh.steps) == ("converged", 0)


def test_an_almost_flat_patch_ends_without_harm():
    """Rows of Lambda all but vanish: whatever the steps, the mesh stays finite and the status is true."""
    boundary = graph_boundary(oval(), lambda x, y: 1e-5 * np.sin(x / 9))
    warped, planar = meshes(boundary)
    mesh = multi_loop(warped, boundary, planar, MultiLoopParameters(tolerance=1e-13, max_outer_loops=5))
    assert np.isfinite(mesh.vertices).all()
    assert (mesh.status == "converged") == (mesh.max_flattenability <= 1e-13)


def test_the_unit_of_length_does_not_matter():
    small, large = gentle_cap(), gentle_cap(25.4)
    parameters = MultiLoopParameters(max_outer_loops=1)
    one = multi_loop(*_in_order(small, 8.0), parameters)
    other = multi_loop(*_in_order(large, 8.0 * 25.4), parameters)
    assert one.steps == other.steps
    assert other.vertices / 25.4 == pytest.approx(one.vertices, abs=1e-6)


def _in_order(boundary, edge_length):
    warped, planar = meshes(boundary, edge_length)
    return warped, boundary, planar


def test_the_printed_gradient_and_hessian_are_those_of_the_merit_function_over_the_valence():
    """Row p of Eq. 7 to 9 and of H, times |N(p)|: central differences of the quadratic E are exact but for rounding."""
    boundary = wrinkled()
    warped, _ = meshes(boundary, 16.0)
    problem = _problem(warped, boundary, 16.0, MultiLoopParameters())
    n = warped.boundary_count
    vertices = warped.vertices / 16.0
    tracking = problem.tracking(vertices)
    rng = np.random.default_rng(2)
    here = vertices.copy()
    here[n:] += 0.1 * rng.normal(size=here[n:].shape)
    gradient = problem.gradient(here, tracking)
    for _ in range(10):
        p, axis = int(rng.integers(len(here) - n)), int(rng.integers(3))
        ahead, behind = here.copy(), here.copy()
        ahead[n + p, axis] += 0.5
        behind[n + p, axis] -= 0.5
        slope = problem.merit(ahead, tracking, 0.0) - problem.merit(behind, tracking, 0.0)
        assert problem.valence[p] * gradient[p, axis] == pytest.approx(slope, rel=1e-9, abs=1e-9)
        column = problem.gradient(ahead, tracking) - problem.gradient(behind, tracking)
        assert problem.hessian[:, [3 * p + axis]].toarray().ravel() == pytest.approx(column.ravel(), abs=1e-9)


def test_v_tan_is_opposite_the_boundary_edges_and_tracks_its_average_plane():
    boundary = gentle_cap()
    warped, _ = meshes(boundary)
    tangent, points, normals = _average_planes(warped, boundary)
    n = warped.boundary_count
    for vertex, point, normal in zip(tangent, points, normals):
        planes = [
            edge
            for edge in range(n)
            for triangle in warped.triangles
            if {edge, (edge + 1) % n, int(vertex)} == set(triangle.tolist())
        ]
        assert planes
        middles = [0.5 * (boundary.vertices[e] + boundary.vertices[(e + 1) % n]) for e in planes]
        mean = np.sum(boundary.normals[planes], axis=0)
        assert point == pytest.approx(np.mean(middles, axis=0))
        assert normal == pytest.approx(mean / np.linalg.norm(mean))
