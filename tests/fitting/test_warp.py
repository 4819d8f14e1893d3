"""The warp interpolates B, follows its normals better with cross-tangents, and refuses what is singular."""

import numpy as np
import pytest
from benchmark.boundaries import case

from flatnet.failure import PatchFailure
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import PlanarMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import MOST_WITHOUT_SYMMETRY, constraint_points, merge_near, warp
from flatnet.geometry.triangles import angles_between, boundary_triangle_normals
from flatnet.network.patch import BoundaryCurve, Stretch
from flatnet.solvers.rbf import fit_triharmonic


def planar_mesh(boundary, edge_length):
    return tessellate(fit_planar_boundary(boundary), edge_length)


def normal_error(mesh, boundary):
    normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, mesh.boundary_count)
    return angles_between(normals, boundary.normals).mean()


def test_boundary_is_interpolated_bit_by_bit():
    boundary, edge_length = case("vamp", 80)
    mesh = warp(planar_mesh(boundary, edge_length), boundary)
    assert np.array_equal(mesh.vertices[: mesh.boundary_count], boundary.vertices)


def test_cross_tangents_bring_the_normals_nearer_to_the_given_ones():
    """Fig. 6: without T_out and T_in the boundary normals of M^0 do not follow the given ones as well."""
    boundary, edge_length = case("w12", 100)
    planar = planar_mesh(boundary, edge_length)
    with_tangents, without = warp(planar, boundary), warp(planar, boundary, cross_tangents=False)
    assert normal_error(with_tangents, boundary) < normal_error(without, boundary)


def test_a_planar_boundary_gives_the_planar_mesh_moved_into_place():
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    outline = 100 * np.c_[np.cos(t) * (1 + 0.3 * np.cos(2 * t)), np.sin(t)]
    frame = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    vertices = np.c_[outline, np.zeros(40)] @ frame.T + [10, 20, 30]
    normals = np.tile(frame[:, 2], (40, 1))
    boundary = BoundaryCurve(vertices, normals, (Stretch("rim", 0, 40, False),), np.zeros(40))
    planar = planar_mesh(boundary, 15.0)
    mesh = warp(planar, boundary)
    # A rigid motion is in the span of the linear polynomial: reproduced to round-off times the condition.
    inside = (mesh.vertices - vertices.mean(axis=0)) @ frame[:, 2]
    assert np.abs(inside).max() < 1e-7
    lengths = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices[None], axis=2)
    flat_lengths = np.linalg.norm(planar.positions[:, None] - planar.positions[None], axis=2)
    assert np.abs(lengths - flat_lengths).max() < 1e-6


def test_coinciding_constraint_points_at_a_right_angle_do_no_harm():
    """Where tau is the edge length, T_in of both edges at a corner of a square coincide (docs/method.md)."""
    up, zero = np.arange(0.0, 100.0, 10.0), np.zeros(10)
    sides = [np.c_[up, zero], np.c_[zero + 100, up], np.c_[100 - up, zero + 100], np.c_[zero, 100 - up]]
    outline = np.concatenate(sides)
    vertices = np.c_[outline, np.zeros(40)]
    boundary = BoundaryCurve(
        vertices, np.tile([0.0, 0.0, 1.0], (40, 1)), (Stretch("rim", 0, 40, False),), np.zeros(40)
    )
    sources, _ = constraint_points(outline, boundary, 10.0, cross_tangents=True)
    distances = np.linalg.norm(sources[:, None] - sources[None], axis=2) + np.eye(len(sources))
    assert distances.min() < 1e-9  # the trap is there ...
    mesh = warp(planar_mesh(boundary, 10.0), boundary)
    assert np.abs(mesh.vertices[:, 2]).max() < 1e-6  # ... and the square stays a square


def test_an_outline_that_touches_itself_is_refused():
    """Two boundary vertices at one place of the plane that belong to two places in space."""
    boundary, edge_length = case("cap", 40)
    planar = planar_mesh(boundary, edge_length)
    positions = planar.positions.copy()
    positions[20] = positions[0]
    with pytest.raises(PatchFailure) as failure:
        warp(PlanarMesh(positions, planar.triangles, 40), boundary)
    assert failure.value.finding.code == "warp_singular"


@pytest.fixture(scope="module")
def large():
    """A boundary with more constraint points than are solved without their symmetry, a coarse mesh, and M^0."""
    boundary, edge_length = case("w12", MOST_WITHOUT_SYMMETRY // 5 + 20)
    planar = planar_mesh(boundary, 4.0 * edge_length)
    return boundary, planar, warp(planar, boundary).vertices, np.ptp(boundary.vertices, axis=0).max()


def test_a_large_boundary_is_warped_as_by_the_system_of_all_points(large):
    boundary, planar, warped, size = large
    outline, tau = planar.positions[: planar.boundary_count], planar.mean_edge
    sources, targets = merge_near(*constraint_points(outline, boundary, tau, True), tau, fixed=len(outline))
    assert len(sources) > MOST_WITHOUT_SYMMETRY
    mapping = fit_triharmonic(sources, targets)
    expected = mapping(np.column_stack([planar.positions, np.zeros(len(planar.positions))]))
    # Both are Eq. 3 solved with a reciprocal condition of 1e-12; what is left of it is some 1e-7 of an edge.
    np.testing.assert_allclose(warped, expected, atol=1e-9 * size)


def curve(vertices, normals):
    n = len(vertices)
    return BoundaryCurve(vertices, normals, (Stretch("rim", 0, n, False),), np.zeros(n))


@pytest.mark.parametrize("scale", [1.0, 0.01, 39.37])
def test_a_large_warp_moves_and_grows_with_the_boundary(large, scale):
    boundary, planar, warped, size = large
    frame = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    shift = np.array([100.0, -2000.0, 30.0])
    moved = curve(scale * boundary.vertices @ frame.T + shift, boundary.normals @ frame.T)
    mesh = warp(PlanarMesh(scale * planar.positions, planar.triangles, planar.boundary_count), moved)
    expected = scale * warped @ frame.T + shift
    np.testing.assert_allclose(mesh.vertices, expected, atol=1e-9 * max(scale * size, 2000.0))


def test_a_large_warp_depends_neither_on_the_first_vertex_nor_on_the_side_it_is_seen_from(large):
    boundary, planar, warped, size = large
    n = planar.boundary_count
    order = np.arange(len(planar.positions))
    order[:n] = (17 - np.arange(n)) % n  # vertex i is the old one at order[i]
    triangles = np.argsort(order)[planar.triangles[:, ::-1]]
    backwards = curve(boundary.vertices[order[:n]], -boundary.normals[order[:n] - 1])
    mesh = warp(PlanarMesh(planar.positions[order] * [1.0, -1.0], triangles, n), backwards)
    np.testing.assert_allclose(mesh.vertices, warped[order], atol=1e-9 * size)
