"""The network of projects/pants: one leg of the mannequin in 28 patches."""

from pathlib import Path

import numpy as np
import pytest

from flatnet.forms import make_surface
from flatnet.network.assembly import make_network
from flatnet.project import load_project

PROJECT = Path(__file__).parents[2] / "projects" / "pants" / "project.yaml"


@pytest.fixture(scope="module")
def drawn():
    project = load_project(PROJECT)
    surface = make_surface(project)
    return project, surface, make_network(project, surface)


def test_seven_bands_of_four(drawn):
    project, _, network = drawn
    assert len(network.patches) == 28 and not network.failed
    assert network.face_count == 30  # and two openings
    assert project.rest_is_open is False  # every face is said to be a patch or an opening


def test_patches_of_about_180_vertices(drawn):
    """Half the boundary, and the area by equilateral triangles inside: an estimate without meshing."""
    _, _, network = drawn
    counts = []
    for patch in network.patches:
        vertices = patch.boundary.vertices
        middle = vertices.mean(axis=0)
        fan = np.cross(vertices - middle, np.roll(vertices, -1, axis=0) - middle)
        area = np.linalg.norm(fan, axis=1).sum() / 2
        counts.append(len(vertices) / 2 + 1 + area / (np.sqrt(3) / 2 * patch.edge_length**2))
    assert sum(counts) == pytest.approx(5010, rel=0.05)  # Table 1
    assert min(counts) > 100 and max(counts) < 250


def test_the_rises_lie_in_the_sagittal_plane(drawn):
    """So the mirrored leg meets this one; 0.001 mm is a ten-thousandth of an edge."""
    _, _, network = drawn
    rises = [
        stretch for stretch in network.stretches.values() if stretch.curve in ("front_rise", "back_rise")
    ]
    assert len(rises) == 6
    for rise in rises:
        assert np.abs(rise.vertices[:, 0]).max() < 1e-3, rise.name


def test_curves_lie_on_the_mannequin_and_are_fair(drawn):
    _, surface, network = drawn
    for name, stretch in network.stretches.items():
        feet, _ = surface.nearest(stretch.vertices)
        assert np.linalg.norm(feet - stretch.vertices, axis=1).max() < 1e-6, name
        edges = np.diff(stretch.vertices, axis=0)
        lengths = np.linalg.norm(edges, axis=1)
        # Sampled evenly: what differs is chord against arc, and the projection.
        assert lengths.max() / lengths.min() < 1.02, name
        cosines = np.einsum("ij,ij->i", edges[:-1], edges[1:]) / (lengths[:-1] * lengths[1:])
        assert np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).max(initial=0.0) < 20.0, name


def test_corners_are_near_90_degrees(drawn):
    _, _, network = drawn
    for patch in network.patches:
        vertices = patch.boundary.vertices
        for stretch in patch.boundary.stretches:
            before = vertices[stretch.first - 1] - vertices[stretch.first]
            after = vertices[(stretch.first + 1) % len(vertices)] - vertices[stretch.first]
            cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
            assert 75.0 < np.degrees(np.arccos(cosine)) < 110.0, patch.name
