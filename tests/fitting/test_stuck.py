"""Meshes that are stuck without refinement and free with it; and one that stays stuck."""

import numpy as np
import pytest
from benchmark.boundaries import boundary_curve, case
from benchmark.random_boundaries import random_case

from flatnet.failure import PatchFailure
from flatnet.fitting.contradiction import Asked
from flatnet.fitting.fit import check_converged
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import FailedPatch, FittedPatch, FlattenableMesh
from flatnet.fitting.run import run_patch
from flatnet.fitting.stuck import refined, stuck_vertices
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from flatnet.geometry.triangles import hinge_angles, hinges_of, signed_areas
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters


def fitted(boundary, edge_length, **parameters):
    return run_patch(Patch("p", boundary, edge_length, "m"), FairParameters(**parameters))


def dome_rim(n=24, height=0.05):
    """A nearly level ring with the normals of a dome of 45 degrees."""
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    normals = np.c_[np.cos(t), np.sin(t), np.ones(n)]
    return boundary_curve(np.c_[np.cos(t), np.sin(t), height * np.cos(2 * t)], normals)


def nine_edges():
    """A crumpled rim of nine edges, mm: its patch gets 33 vertices, too few not to fold."""
    vertices = [
        [40, 40, 17], [22, 101, 86], [-89, 89, -17], [-113, 69, -31], [-44, -57, 21],
        [-35, -92, 70], [-8, -86, 0], [2, -77, 46], [58, -116, 79],
    ]  # fmt: skip
    normals = [
        [0.21, -0.71, 0.68], [-0.67, -0.08, 0.73], [-0.31, -0.25, 0.92], [-0.16, 0.3, 0.94], [-0.2, 0.78, 0.6],
        [0.91, 0.19, 0.37], [-0.68, -0.67, 0.29], [-0.35, 0.25, 0.9], [-0.04, 0.36, 0.93],
    ]  # fmt: skip
    return boundary_curve(np.array(vertices) / 100.0, np.array(normals)), 100.0


#: boundary -> (boundary and edge length, parameters, what becomes of it without refinement)
STUCK = {
    "few vertices for a crumpled rim": (nine_edges(), {}, "folded"),
    "a cap with its normals held": (random_case("caps", 5, 200), {"normal_weight": 3000.0}, "not_converged"),
    "a tube with its normals held": (random_case("tubes", 8, 200), {"normal_weight": 1000.0}, "not_converged"),
    "a flat ring with a dome's normals": (case("cap", 12), {"normal_weight": 1000.0}, "not_converged"),
}


@pytest.mark.parametrize("name", STUCK)
def test_what_is_stuck_without_refinement_is_made_with_it(name):
    (boundary, edge_length), parameters, code = STUCK[name]
    without = fitted(boundary, edge_length, **parameters, stuck_rounds=0)
    assert isinstance(without, FailedPatch) and without.failure.code == code
    made = fitted(boundary, edge_length, **parameters)
    assert isinstance(made, FittedPatch)
    assert made.mesh.max_flattenability <= 1e-9
    assert made.max_edge_strain <= 1e-8
    hinges = hinges_of(made.mesh.triangles)
    assert np.degrees(np.abs(hinge_angles(made.mesh.vertices, hinges)).max()) <= 120.0
    assert (signed_areas(made.flat, made.mesh.triangles) > 0.0).all()
    # M, M^0 and M^p belong together, and all of them to B.
    n = len(boundary.vertices)
    assert len(made.flat) == len(made.mesh.vertices)
    assert np.array_equal(made.planar.triangles, made.warped.triangles)
    assert len(made.planar.positions) == len(made.warped.vertices)
    for mesh in (made.mesh, made.warped):
        assert mesh.boundary_count == n
        assert np.array_equal(mesh.vertices[:n], boundary.vertices)


def test_a_mesh_without_enough_vertices_gets_more_where_it_folds():
    (boundary, edge_length), parameters, _ = STUCK["few vertices for a crumpled rim"]
    made = fitted(boundary, edge_length, **parameters)
    start = tessellate(fit_planar_boundary(boundary), edge_length)
    assert len(made.mesh.vertices) > len(start.positions)
    assert np.array_equal(made.mesh.triangles, made.planar.triangles)
    assert made.mesh.parameters["normal_weight"] == FairParameters().normal_weight


def test_normals_that_are_held_too_hard_give_way_and_the_patch_says_so():
    """A nearly level ring has one flat piece, nearly level, 45 degrees from a dome's normals."""
    boundary = dome_rim(8, 0.005)
    assert isinstance(fitted(boundary, 30.0, normal_weight=1000.0, stuck_rounds=0), FailedPatch)
    made = fitted(boundary, 30.0, normal_weight=1000.0, stuck_rounds=1)
    assert isinstance(made, FittedPatch)
    (warning,) = [w for w in made.warnings if w.code == "normals_gave_way"]
    assert warning.amount == made.mesh.parameters["normal_weight"] < 1000.0
    assert made.mesh.max_flattenability <= 1e-9


@pytest.mark.parametrize(("name", "reason"), [("cap", "a dome"), ("saddle", "a saddle"), ("w12", "hardly contradict")])
def test_a_failure_says_where_and_whether_the_normals_are_the_reason(name, reason):
    boundary, edge_length = case(name, 60)
    planar_boundary = fit_planar_boundary(boundary)
    planar = tessellate(planar_boundary, edge_length)
    m0 = warp(planar, boundary)
    mesh = FlattenableMesh(m0.vertices, m0.triangles, m0.boundary_count, "fair", {}, "stalled", 9)
    asked = Asked.by(planar_boundary, boundary)
    with pytest.raises(PatchFailure) as raised:
        check_converged(mesh, boundary, FairParameters(), asked)
    finding = raised.value.finding
    assert finding.code == "stuck_vertex"
    assert finding.amount == m0.max_flattenability
    assert "mm from 'boundary' at" in finding.where
    assert reason in finding.message
    assert ("seam" in finding.remedy) == asked.contradicts
    with pytest.raises(PatchFailure, match="not_converged"):
        check_converged(mesh, boundary, FairParameters(stuck_rounds=0), asked)


def planar_mesh(name="w12", n=40):
    boundary, edge_length = case(name, n)
    return tessellate(fit_planar_boundary(boundary), edge_length)


@pytest.mark.parametrize("picked", [slice(0, 1), slice(3, 9), slice(None)])
def test_refinement_puts_one_vertex_into_every_triangle_round_the_stuck_ones(picked):
    planar = planar_mesh()
    n = planar.boundary_count
    stuck = np.arange(n, len(planar.positions))[picked]
    finer = refined(planar, stuck)
    around = np.isin(planar.triangles, stuck).any(axis=1).sum()
    assert len(finer.positions) == len(planar.positions) + around
    assert len(finer.triangles) == len(planar.triangles) + 2 * around
    assert np.array_equal(finer.positions[:n], planar.positions[:n])
    areas = signed_areas(finer.positions, finer.triangles)
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(signed_areas(planar.positions, planar.triangles).sum(), rel=1e-12)
    # No triangle has all its corners on the boundary and no edge inside joins two of them: these can't move.
    inner_edges = hinges_of(finer.triangles)[:, :2]
    assert ((finer.triangles >= n).any(axis=1)).all()
    assert ((inner_edges >= n).any(axis=1)).all()


def test_a_mesh_that_is_made_has_no_stuck_vertex():
    boundary, edge_length = case("vamp", 60)
    made = fitted(boundary, edge_length)
    assert len(stuck_vertices(made.mesh, boundary, 1e-9)) == 0
    assert len(stuck_vertices(made.warped, boundary, 1e-9)) > 0
