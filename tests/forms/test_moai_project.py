"""The figure of projects/moai: a solid with one hole, as its script makes it, and a rim that its project finds."""

from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from flatnet.forms import make_surface
from flatnet.network.assembly import make_network
from flatnet.project import load_project

FOLDER = Path(__file__).parents[2] / "projects" / "moai"


@pytest.fixture(scope="module")
def drawn():
    project = load_project(FOLDER / "project.yaml")
    surface = make_surface(project)
    return surface.mesh, make_network(project, surface)


def test_the_script_writes_the_file_that_is_there():
    """To a digit: another processor may round the last one differently."""

    def numbers(text):
        rows = [line.split() for line in text.splitlines()[1:]]
        kinds = [row[0] for row in rows]
        return kinds, np.array([row[1:] for row in rows], float)

    kinds, made = numbers(run_path(str(FOLDER / "make_statue.py"))["written"]())
    kinds_there, there = numbers((FOLDER / "statue.obj").read_text(encoding="ascii"))
    assert kinds == kinds_there
    np.testing.assert_allclose(made, there, rtol=0, atol=0.1001)


def test_it_is_a_ball_with_one_hole(drawn):
    mesh, _ = drawn
    assert mesh.body_count == 1
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 1
    assert mesh.volume > 0  # faces look outwards


def test_the_patch_lies_in_the_hole_under_the_base_and_up_the_back(drawn):
    mesh, network = drawn
    (patch,) = network.patches
    rim = patch.boundary.vertices
    open_edges = mesh.edges_unique[np.bincount(mesh.edges_unique_inverse) == 1]
    edge_lengths = np.linalg.norm(np.diff(mesh.vertices[open_edges], axis=1)[:, 0], axis=1)
    around = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum()
    # Chords of 34 mm cut its corners, of which the sharpest are those where edges of the mesh cross it.
    assert around == pytest.approx(edge_lengths.sum(), rel=5e-3)
    low, high = rim[rim[:, 2] < 1.0], rim[rim[:, 2] > 1000.0]
    assert len(low) > 20 and len(high) > 20
    normals = patch.boundary.normals
    assert normals[rim[:, 2] < 1.0][:, 2].mean() < -0.9  # there it looks down
    assert normals[rim[:, 2] > 1000.0][:, 1].mean() < -0.9  # up there out of the back
