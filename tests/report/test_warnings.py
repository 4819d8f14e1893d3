"""Warnings about what was made: a patch inside the surface, a seam with a kink."""

import json

import numpy as np
import pytest
import yaml
from failure_cases import LATITUDE, RADIUS, cut_off_cap, roof
from written import read_obj, read_report

from flatnet.cli import main
from flatnet.report.build_files import read_build
from flatnet.report.panels import panels_of


def build(folder, project):
    (folder / "project.yaml").write_text(yaml.safe_dump(project | {"nesting": {"seconds": 1}}))
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out")]) == 0
    return read_report(folder / "out")


def test_a_sheet_that_cuts_a_cap_off_says_how_deep_and_where(tmp_path):
    (lid,) = build(tmp_path, cut_off_cap(tmp_path, clearance=5))["patches"]
    depth = RADIUS * (1 - np.cos(LATITUDE))
    (warning,) = [warning for warning in lid["warnings"] if warning["code"] == "inside_surface"]
    assert warning["amount"] == pytest.approx(depth, abs=0.3)  # facets of the ball, vertices beside the centre
    assert "near 'rim' at " in warning["where"] and "38." in warning["where"]  # 50 cos 40 degrees
    assert lid["metrics"]["surface_distance_mm"]["max_inside"] == warning["amount"]
    assert lid["metrics"]["surface_distance_mm"]["max_outside"] < 0.1

    heights = np.array(json.loads((tmp_path / "out" / "surface_distance.json").read_text())["lid"])
    vertices, _, _ = read_obj(tmp_path / "out" / "patches" / "lid.obj")
    np.testing.assert_allclose(heights, np.linalg.norm(vertices, axis=1) - RADIUS, atol=0.15)
    (caption,) = [p.caption for p in panels_of(read_build(tmp_path / "out")) if p.caption.startswith("off the surface")]
    assert f"{warning['amount']:.1f} mm inside (red)" in caption


def test_clearance_allows_it(tmp_path):
    (lid,) = build(tmp_path, cut_off_cap(tmp_path, clearance=12))["patches"]
    assert "inside_surface" not in [warning["code"] for warning in lid["warnings"]]


def seam_warnings(folder, project):
    seams = {seam["curve"]: seam for seam in build(folder, project)["seams"]}
    return seams["ridge"]["max_normal_gap_deg"], seams["ridge"]["warnings"]


def test_a_kink_along_a_seam_says_how_much_and_where(tmp_path, capsys):
    gap, (warning,) = seam_warnings(tmp_path, roof(40, crease=False))
    assert gap == pytest.approx(40, abs=1e-6)
    assert (warning["code"], warning["amount"]) == ("normal_gap", gap)
    assert warning["where"].startswith("'ridge' at ") and "at (0.0, " in warning["where"]
    assert "'left' and 'right'" in warning["message"]
    assert "ridge: warning normal_gap: " in capsys.readouterr().out


@pytest.mark.parametrize("angle, crease", [(25, False), (40, True)])
def test_a_small_angle_and_one_that_is_meant_are_no_kink(tmp_path, angle, crease):
    gap, warnings = seam_warnings(tmp_path, roof(angle, crease=crease))
    assert gap == pytest.approx(angle, abs=1e-6)
    assert warnings == []
