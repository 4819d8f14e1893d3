"""One minimal project per failure code; the other patch of the project comes out each time."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from written import read_report

from flatnet.cli import main
from flatnet.failure import CODES
from flatnet.fitting.results import FailedPatch
from flatnet.fitting.run import run_patch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch
from flatnet.parameters import FairParameters

UP = [0.0, 0.0, 1.0]


def closed(points, normals):
    return {"closed": True, "points": np.asarray(points).tolist(), "normals": np.asarray(normals).tolist()}


def square(side=100.0, x=0.0):
    return closed([[x, 0, 0], [x + side, 0, 0], [x + side, side, 0], [x, side, 0]], UP)


def project(curves, patches, **rest):
    """A good square and whatever is added to it."""
    return {
        "flatnet": 1,
        "name": "case",
        "edge_length": 12,
        "curves": {"good": square(x=-500.0), **curves},
        "patches": {"good": {"around": ["good"]}, **patches},
        "rest": "openings",
        "materials": {"cloth": {"width": 1500}},
        "nesting": {"seconds": 1},
        **rest,
    }


def lemma_2():
    """Corners that add up to more than a square has: 4 x 95 degrees."""
    nodes = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 100, 0], "d": [0, 100, 0]}
    names = list(nodes)
    curves = {
        f"{p}{q}": {"from": p, "to": q, "normals": UP} for p, q in zip(names, names[1:] + names[:1], strict=True)
    }
    bad = {"around": list(curves), "min_angle": dict.fromkeys(names, 95)}
    return project(curves, {"bad": bad}, nodes=nodes)


def self_intersection():
    """A ring cut open that climbs as it goes round once and a half: flat, it covers itself."""
    t = np.linspace(0, 3 * np.pi, 60)
    inner = np.c_[60 * np.cos(t), 60 * np.sin(t), 12 * t]
    outer = np.c_[100 * np.cos(t), 100 * np.sin(t), 12 * t]
    return project({"spiral": closed(np.r_[outer, inner[::-1]], UP)}, {"bad": {"around": ["spiral"]}})


def not_converged():
    """A saddle, and one step to get there."""
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.c_[100 * np.cos(t), 100 * np.sin(t), 30 * np.cos(2 * t)]
    middle = np.c_[-0.6 * np.cos(t), 0.6 * np.sin(t), np.ones(40)]
    bad = {"around": ["ring"], "fitting": {"ramp_steps": 1, "max_steps": 1}}
    return project({"ring": closed(ring, middle)}, {"bad": bad})


def folded():
    """An accordion whose folds turn by 170 degrees, its normals held hard: exactly flat, and never made."""
    rise, run = 25 * np.cos(np.radians(5)), 25 * np.sin(np.radians(5))
    zigzag = np.array([[run * k, 0.0, rise * (k % 2)] for k in range(7)])
    side = np.array([[0.0, y, 0.0] for y in (25.0, 50.0, 75.0)])
    points = np.r_[zigzag, zigzag[-1] + side, zigzag[::-1] + [0, 100, 0], zigzag[0] + side[::-1]]
    flaps = np.array([[-rise, 0.0, run], [rise, 0.0, run]])[np.arange(6) % 2] / 25
    normals = np.r_[flaps, [flaps[-1]] * 4, flaps[::-1], [flaps[0]] * 4]
    curve = closed(points, normals) | {"edge_length": 26}
    bad = {"around": ["fold"], "edge_length": 25, "fitting": {"normal_weight": 3000, "stuck_rounds": 0}}
    return project({"fold": curve}, {"bad": bad})


def not_disk():
    """A square ring: two loops."""
    outer, inner = square(200.0), closed([[50, 50, 0], [150, 50, 0], [150, 150, 0], [50, 150, 0]], UP)
    return project({"outer": outer, "inner": inner}, {"bad": {"around": [["outer"], ["-inner"]]}})


def warp_singular():
    """Two corners a ten-thousandth of a millimetre apart: nothing tells their constraint points from each other."""
    points = [[0, 0, 0], [1e-4, 0, 0], [100, 0, 20], [100, 100, 0], [0, 100, 20]]
    return project({"spike": closed(points, UP)}, {"bad": {"around": ["spike"]}})


def sheet_too_small():
    """A piece of 200 x 200 mm on a ribbon."""
    materials = {"cloth": {"width": 1500}, "ribbon": {"width": 50}}
    bad = {"around": ["large"], "material": "ribbon"}
    case = project({"large": square(200.0)}, {"bad": bad}, materials=materials)
    case["patches"]["good"]["material"] = "cloth"
    return case


CASES = {
    case.__name__: case
    for case in (lemma_2, self_intersection, warp_singular, not_converged, folded, not_disk, sheet_too_small)
}


@pytest.mark.parametrize("code", CASES)
def test_the_failure_is_named_and_the_other_patch_comes_out(code, tmp_path, capsys):
    (tmp_path / "project.yaml").write_text(yaml.safe_dump(CASES[code]()))
    out = tmp_path / "out"
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(out)]) == 1
    report = read_report(out)
    assert report["status"] == "partial"
    by_name = {patch["name"]: patch for patch in report["patches"]}
    assert by_name["good"]["status"] == "ok"
    failure = by_name["bad"]["failure"]
    assert failure["code"] == code
    assert failure["patch"] == "bad"
    assert failure["message"] and failure["remedy"]
    assert f"FAILED {code}" in capsys.readouterr().out
    assert (out / "pieces" / "good.svg").exists()
    assert [piece["patch"] for piece in report["layouts"][0]["pieces"]] == ["good"]
    if report["layouts"][0]["material"] == "cloth" and code != "sheet_too_small":
        assert "INCOMPLETE" in (out / report["layouts"][0]["file"]).read_text()


def test_a_bug_becomes_an_internal_error_with_its_traceback():
    """A patch that no project can give: fewer angles than corners."""
    boundary = BoundaryCurve(
        np.array([[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0.0]]),
        np.tile([0.0, 0.0, 1.0], (4, 1)),
        (Stretch("rim", 0, 4, False),),
        np.zeros(3),
    )
    result = run_patch(Patch("bad", boundary, 12.0, "cloth"), FairParameters())
    assert isinstance(result, FailedPatch)
    assert result.failure.code == "internal_error"
    assert "Traceback" in result.failure.details


def test_every_code_is_documented():
    text = (Path(__file__).parents[1] / "docs" / "failures.md").read_text()
    assert [code for code in CODES if f"`{code}`" not in text] == []


def test_a_level_patch_whose_grain_is_said_to_be_up_says_so_and_has_no_arrow(tmp_path):
    level = project({}, {})
    level["patches"]["good"]["grain"] = "up"
    (tmp_path / "project.yaml").write_text(yaml.safe_dump(level))
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    (patch,) = read_report(tmp_path / "out")["patches"]
    assert [warning["code"] for warning in patch["warnings"]] == ["no_grain"]
    assert 'class="grain"' not in (tmp_path / "out" / "pieces" / "good.svg").read_text()
