"""A patch of its boundary alone: exactly flat whatever the boundary, never without a word, through the whole flow."""

import json

import numpy as np
import pytest
import yaml
from crossing import network_of, spiral
from failure_cases import folded, roll
from written import read_report

from flatnet.cli import main
from flatnet.fitting.results import FailedPatch
from flatnet.fitting.run import run_patch
from flatnet.geometry.triangles import unit
from flatnet.network.patch import BoundaryCurve, Patch, Stretch
from flatnet.parameters import BoundaryAloneParameters


def random_boundary(seed):
    """A closed curve that no smooth sheet spans, its normals anything that is orthogonal to the edges."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    height = sum(rng.normal(0, 25 / k) * np.cos(k * t + rng.uniform(0, 6)) for k in range(1, 6))
    vertices = np.c_[100 * np.cos(t), 60 * np.sin(t), height]
    edges = unit(np.roll(vertices, -1, axis=0) - vertices)
    up = rng.normal([0, 0, 1], 0.3, (50, 3))
    normals = unit(up - np.einsum("ij,ij->i", up, edges)[:, None] * edges)
    return Patch("p", BoundaryCurve(vertices, normals, (Stretch("rim", 0, 50, False),), np.zeros(50)), 8.0, "cloth")


@pytest.mark.parametrize("seed", range(5))
def test_it_is_flat_to_round_off_and_has_the_boundary_and_nothing_else(seed):
    patch = random_boundary(seed)
    fitted = run_patch(patch, BoundaryAloneParameters())
    np.testing.assert_array_equal(fitted.mesh.vertices, patch.boundary.vertices)
    assert len(fitted.mesh.triangles) == 48
    assert fitted.max_edge_strain < 1e-12
    [said] = [warning for warning in fitted.warnings if warning.code == "boundary_alone"]
    deviations = np.degrees(fitted.mesh.normal_deviations(patch.boundary.normals))
    assert said.amount == pytest.approx(deviations.max())
    assert said.where == patch.boundary.place(int(np.argmax(deviations)) + 0.5)


def test_a_tube_is_ruled_and_not_faired():
    """On half a cylinder the creases are its rulings: it bends as the boundary does, step by step."""
    t = np.linspace(0, np.pi, 25)
    low, high = (np.c_[50 * np.cos(t), 50 * np.sin(t), np.full(25, z)] for z in (0.0, 90.0))
    vertices = np.concatenate([low, high[::-1]])
    middle = (vertices + np.roll(vertices, -1, axis=0)) * [1, 1, 0]
    boundary = BoundaryCurve(vertices, unit(middle), (Stretch("rim", 0, 50, False),), np.zeros(50))
    fitted = run_patch(Patch("p", boundary, 8.0, "cloth"), BoundaryAloneParameters())
    assert np.degrees(fitted.mesh.normal_deviations(boundary.normals)).max() < 0.51 * 180 / 24
    around = 24 * 100 * np.sin(np.pi / 48)
    corners = fitted.outline[[0, 24, 25, 49]]
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    assert sides == pytest.approx([around, 90.0, around, 90.0])
    assert np.linalg.norm(corners[2] - corners[0]) == pytest.approx(np.hypot(around, 90.0))  # a rectangle


def test_it_is_chosen_for_one_patch_and_goes_through_the_whole_flow(tmp_path):
    """The accordion that folds: made, with its folds as a warning."""
    content = folded()
    content["patches"]["bad"]["fitting"] = {"method": "boundary_alone"}
    file, out = tmp_path / "project.yaml", tmp_path / "out"
    file.write_text(yaml.safe_dump(content))
    assert main(["build", str(file), "-o", str(out)]) == 0
    record = next(patch for patch in read_report(out)["patches"] if patch["name"] == "bad")
    assert record["method"]["name"] == "boundary_alone"
    assert {"boundary_alone", "folded"} <= {warning["code"] for warning in record["warnings"]}
    metrics = record["metrics"]
    assert metrics["vertices"] == metrics["triangles"] + 2
    assert (metrics["max_flattenability_rad"], metrics["mean_flattenability_rad"]) == (0.0, 0.0)
    assert metrics["bending"] == pytest.approx(metrics["boundary_alone"]["bending"])
    assert "NaN" not in json.dumps(metrics)
    assert main(["draw", str(out), "-o", str(tmp_path / "out.png")]) == 0


def test_what_covers_itself_when_flat_is_not_made_even_so():
    [patch] = network_of(*spiral(1.5)).patches
    failed = run_patch(patch, BoundaryAloneParameters())
    assert isinstance(failed, FailedPatch)
    assert (failed.failure.code, failed.failure.stage) == ("self_intersection", "unfold")


def test_a_boundary_on_a_line_spans_nothing():
    vertices = np.c_[[0.0, 10.0, 25.0, 12.0], np.zeros((4, 2))]
    boundary = BoundaryCurve(vertices, np.tile([0, 0, 1.0], (4, 1)), (Stretch("a", 0, 4, False),), np.zeros(4))
    failed = run_patch(Patch("p", boundary, 8.0, "cloth"), BoundaryAloneParameters())
    assert failed.failure.code == "degenerate_curve"


def test_a_mesh_that_passes_through_itself_is_warned_of(tmp_path):
    (tmp_path / "project.yaml").write_text(yaml.safe_dump(roll()))
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    [record] = read_report(tmp_path / "out")["patches"]
    [said] = [w for w in record["warnings"] if w["code"] == "mesh_self_intersection"]
    assert said["amount"] == record["metrics"]["self_intersections_3d"] > 0
    assert "near 'sheet' at" in said["message"]
