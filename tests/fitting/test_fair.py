"""The default method on the eight boundaries: exact, fair, unfolded without strain."""

import numpy as np
import pytest
from benchmark.boundaries import CASES, case

from flatnet.fitting.fair import FlattenableProblem, fit_fair
from flatnet.fitting.fair_energy import ghost_vertices
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.unfold import unfold
from flatnet.fitting.warp import warp
from flatnet.geometry.intersections import self_intersections
from flatnet.geometry.triangles import bending, edge_strain, hinge_angles, hinges_of, signed_areas
from flatnet.parameters import FairParameters

#: Bending E at normal weight 1 and about 550 vertices; a crumpled solution lies at two to forty times as much.
FAIR = {"w05": 300, "w12": 600, "w20": 1000, "saddle": 110, "vamp": 7, "cap": 0.01, "pants": 60, "cylinder": 25}


def fitted(name, n=110, **parameters):
    boundary, edge_length = case(name, n)
    planar = tessellate(fit_planar_boundary(boundary), edge_length)
    warped = warp(planar, boundary)
    return boundary, warped, fit_fair(warped, boundary, planar, FairParameters(**parameters))


@pytest.mark.parametrize("name", CASES)
def test_exact_and_fair(name):
    boundary, warped, mesh = fitted(name)
    assert mesh.status == "converged"
    assert mesh.max_flattenability <= 1e-9
    assert np.array_equal(mesh.vertices[: mesh.boundary_count], boundary.vertices)
    flat = unfold(mesh)
    assert np.abs(edge_strain(mesh.vertices, flat, mesh.triangles)).max() <= 1e-8
    assert (signed_areas(flat, mesh.triangles) > 0).all()
    assert len(self_intersections(mesh.vertices, mesh.triangles)) == 0
    hinges = hinges_of(mesh.triangles)
    worst = np.degrees(np.abs(hinge_angles(mesh.vertices, hinges)).max())
    given = np.degrees(np.abs(hinge_angles(warped.vertices, hinges)).max())
    assert worst <= max(90.0, given + 5.0)
    assert bending(mesh.vertices, mesh.triangles) <= FAIR[name]


def test_the_energy_gradient_is_its_derivative():
    """Central differences of E in random directions; the step errs by its square."""
    boundary, edge_length = case("w12", 40)
    planar = tessellate(fit_planar_boundary(boundary), edge_length)
    warped = warp(planar, boundary)
    problem = FlattenableProblem(
        planar.positions / edge_length, planar.triangles, planar.boundary_count, FairParameters()
    )
    ghosts = ghost_vertices(boundary.vertices, boundary.normals)
    x = np.concatenate([warped.vertices, ghosts]).ravel() / edge_length
    gradient, _ = problem.gradient_and_metric(x)
    free = np.zeros((len(x) // 3, 3))
    free[planar.boundary_count : len(planar.positions)] = 1.0
    rng = np.random.default_rng(0)
    for _ in range(5):
        direction = rng.normal(size=len(x)) * free.ravel()
        direction /= np.linalg.norm(direction)
        step = 1e-5
        slope = (problem.energy(x + step * direction) - problem.energy(x - step * direction)) / (2 * step)
        assert slope == pytest.approx(gradient @ direction, rel=1e-6, abs=1e-6)


def test_a_larger_normal_weight_holds_the_normals_better_at_the_price_of_bending():
    from flatnet.geometry.triangles import angles_between, boundary_triangle_normals

    errors, energies = [], []
    for weight in (1.0, 10.0):
        boundary, _, mesh = fitted("w12", normal_weight=weight)
        normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, mesh.boundary_count)
        errors.append(angles_between(normals, boundary.normals).mean())
        energies.append(bending(mesh.vertices, mesh.triangles))
    assert errors[1] < 0.8 * errors[0]
    assert energies[1] > energies[0]
