"""Pieces that are strained on purpose: within the limit, their boundary not at all, and nearer to their normals."""

import numpy as np
import pytest
from benchmark.boundaries import case

from flatnet.fitting.fit import fit_patch
from flatnet.fitting.results import SurfaceMesh
from flatnet.fitting.strained import flattened
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.triangles import edge_strain, signed_areas
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters


def fitted(name, strain, n=48):
    boundary, edge_length = case(name, n)
    return fit_patch(Patch(name, boundary, edge_length, "m", strain=strain), FairParameters(), {})


def deviation(made):
    return np.degrees(made.mesh.normal_deviations(made.patch.boundary.normals)).mean()


@pytest.mark.parametrize("name", ["vamp", "cap", "pants", "saddle"])
def test_a_strained_piece_keeps_its_limit_and_its_boundary(name):
    made = fitted(name, 0.02)
    assert 0.0 <= made.mean_edge_strain <= made.max_edge_strain <= 0.02
    assert made.max_boundary_strain <= 1e-8
    n = made.mesh.boundary_count
    assert np.array_equal(made.mesh.vertices[:n], made.patch.boundary.vertices)
    assert (signed_areas(made.flat, made.mesh.triangles) > 0.0).all()
    assert not polygon_crossings(made.outline)


@pytest.mark.parametrize("name", ["vamp", "cap"])
def test_the_more_a_material_gives_the_nearer_the_mesh_comes_to_its_normals(name):
    """A dome needs stretch: both boundaries ask for about a radian of curvature that an exact piece can't have."""
    exact, little, more = (deviation(fitted(name, strain)) for strain in (0.0, 0.01, 0.03))
    assert little < 0.9 * exact
    assert more < 0.9 * little


def test_no_strain_is_exact_and_the_default():
    made = fitted("vamp", 0.0)
    assert made.patch.strain == 0.0
    assert made.max_edge_strain <= 1e-8
    assert made.mesh.max_flattenability <= 1e-9
    assert "strained" not in made.seconds


def test_a_flat_mesh_is_found_without_strain_where_there_is_one():
    """From a flat piece pushed about inside: least strain is none, and the boundary never left its lengths."""
    made = fitted("cylinder", 0.0)
    mesh = SurfaceMesh(made.mesh.vertices, made.mesh.triangles, made.mesh.boundary_count)
    pushed = made.flat.copy()
    inner = slice(mesh.boundary_count, None)
    pushed[inner] += np.random.default_rng(0).normal(scale=0.05, size=pushed[inner].shape)
    flat = flattened(mesh, pushed, 0.05)
    assert flat is not None
    assert np.abs(edge_strain(mesh.vertices, flat, mesh.triangles)).max() < 1e-6
