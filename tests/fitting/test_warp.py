"""The warp interpolates B, follows its normals better with cross-tangents, and refuses what is singular."""

import numpy as np
import pytest
from benchmark.boundaries import case

from flatnet.failure import PatchFailure
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import PlanarMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import constraint_points, warp
from flatnet.network.patch import BoundaryCurve, Stretch
from flatnet.report.metrics import angles_between, boundary_triangle_normals


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
