"""report.json of a small build: its keys, seams with a patch that failed, nothing of what was not made."""

import numpy as np
import pytest
import yaml
from written import boundary_vertices, read_obj, read_report

from flatnet.cli import main
from flatnet.failure import Finding

UP = [0, 0, 1]
PLACES = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [200, 0, 0], "d": [200, 80, 0], "e": [100, 80, 0], "f": [0, 80, 0]}
EDGES = ["ab", "be", "ef", "fa", "bc", "cd", "de"]
#: Two rectangles that share `be`; the corners asked for make the first one impossible.
PROJECT = {
    "flatnet": 1,
    "name": "pair",
    "edge_length": 14,
    "nodes": PLACES,
    "curves": {edge: {"from": edge[0], "to": edge[1], "normals": UP} for edge in EDGES},
    "patches": {
        "left": {"around": ["ab", "be", "ef", "fa"], "min_angle": dict.fromkeys("abef", 95)},
        "right": {"around": ["-be", "bc", "cd", "de"], "grain": [1, 0, 0]},
    },
    "rest": "openings",
}
METRICS = {
    "vertices", "triangles", "max_flattenability_rad", "mean_flattenability_rad", "initial_max_flattenability_rad",
    "strain_limit", "mean_edge_strain", "max_boundary_strain", "asked_curvature_rad", "least_normal_deviation_deg",
    "max_edge_strain", "boundary_error_mm", "angle_error", "max_normal_deviation_deg", "mean_normal_deviation_deg",
    "wrinkles", "surface_distance_mm", "lemma_2_margin_rad", "max_dihedral_deg", "bending", "min_triangle_angle_deg",
    "boundary_alone", "flipped_triangles", "self_intersections_3d", "area_mm2",
}  # fmt: skip


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    (folder / "project.yaml").write_text(yaml.safe_dump(PROJECT))
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out")]) == 1
    return folder / "out"


def test_the_keys_are_those_of_the_format(out):
    report = read_report(out)
    assert {"format", "flatnet", "project", "status", "patches", "seams", "layouts"} <= set(report)
    left, right = report["patches"]
    keys = {"name", "status", "failure", "warnings", "metrics", "method", "seconds"}
    assert set(left) == set(right) == keys
    assert set(left["failure"]) == set(Finding.__dataclass_fields__)
    assert (left["failure"]["code"], left["metrics"], left["method"]) == ("lemma_2", None, None)
    assert set(right["metrics"]) == METRICS
    assert set(right["method"]) == {"name", "parameters", "status", "steps"}
    assert set(right["seconds"]) == {"planar_boundary", "tessellation", "warp", "flattenable_mesh", "unfold"}
    assert set(report["seams"][0]) == {
        "curve", "patches", "length_3d_mm", "length_a_mm", "length_b_mm", "difference_mm", "max_normal_gap_deg",
        "warnings", "from", "to", "sides", "number", "notches",
    }  # fmt: skip
    (layout,) = report["layouts"]
    assert {"file", "material", "sheet_width_mm", "used_length_mm", "utilisation", "pieces"} <= set(layout)
    assert set(layout["pieces"][0]) == {"patch", "copy", "mirrored", "rotation_deg", "x_mm", "y_mm"}


def test_figures_of_a_rectangle(out):
    _, right = read_report(out)["patches"]
    assert right["metrics"]["area_mm2"] == pytest.approx(8000, rel=1e-12)
    assert right["metrics"]["self_intersections_3d"] == 0
    assert right["metrics"]["lemma_2_margin_rad"] == pytest.approx(0.0, abs=1e-12)


def test_the_length_of_a_failed_patch_is_null_and_not_that_of_its_neighbour(out):
    seams = {seam["curve"]: seam for seam in read_report(out)["seams"]}
    shared = seams["be"]
    assert shared["patches"] == ["left", "right"]
    assert (shared["length_a_mm"], shared["difference_mm"], shared["max_normal_gap_deg"]) == (None, None, None)
    assert shared["length_b_mm"] == pytest.approx(80, abs=1e-9)
    assert (seams["ab"]["length_a_mm"], seams["ab"]["length_b_mm"]) == (None, None)


def test_vertices_of_a_seam_run_from_its_start_to_its_end(out):
    vertices, _, triangles = read_obj(out / "patches" / "right.obj")
    for seam in read_report(out)["seams"]:
        ids = seam["sides"][-1]["vertices"]
        if seam["patches"][-1] == "right":
            assert set(ids) <= set(boundary_vertices(triangles))
            ends = [PLACES[seam["from"]], PLACES[seam["to"]]]
            np.testing.assert_array_equal(vertices[[ids[0], ids[-1]]], ends)


def test_what_was_not_made_has_no_files(out):
    report = read_report(out)
    assert report["status"] == "partial"
    assert not [file for file in report["files"] if "left" in file]
    assert [piece["patch"] for piece in report["layouts"][0]["pieces"]] == ["right"]


def test_what_was_made_of_a_project_with_a_failed_patch_verifies(out):
    assert main(["verify", str(out)]) == 0
