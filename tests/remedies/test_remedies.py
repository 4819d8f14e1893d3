"""Cuts that are found for patches that can't be made, and what they cure."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from crossing import as_project, crossing_boundary, network_of, spiral
from failure_cases import alone, square, wrinkled
from scipy.spatial import cKDTree
from written import read_obj, read_report

from flatnet.cli import main
from flatnet.diagnosis import ProjectDiagnosis, diagnose_project
from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.fitting.run import run_patch
from flatnet.forms.surface import ReferenceSurface, tidy_mesh
from flatnet.geometry.triangles import dot, unit
from flatnet.network.assembly import make_network
from flatnet.parameters import FairParameters
from flatnet.project import load_project
from flatnet.remedies.auto_split import split
from flatnet.remedies.candidates import candidate_cuts
from flatnet.remedies.cut_curve import CutPlaces, draw_cut
from flatnet.remedies.diagnose import Diagnosis, Trial, diagnose, divide_by
from flatnet.remedies.paste import paste
from flatnet.report.diagnosis_text import diagnosis_lines


def fit_all(patches):
    return [run_patch(patch, FairParameters()) for patch in patches]


def deep_c():
    """A strip that goes round nearly once and overlaps itself when flat, because it is shorter inside than it seems."""
    t = np.linspace(0, 2 * np.pi * 0.93, 60)
    inner = np.c_[60 * np.cos(t), 60 * np.sin(t), 30 * np.sin(2 * t)]
    outer = np.c_[100 * np.cos(t), 100 * np.sin(t), 48 * np.sin(2 * t)]
    return inner, outer


@pytest.mark.parametrize("strip", [spiral(1.5), deep_c()], ids=["spiral", "deep C"])
def test_a_strip_that_covers_itself_is_cured_by_one_cut_that_is_found(strip):
    network = network_of(*strip)
    [patch] = network.patches
    [result] = fit_all([patch])
    assert result.failure.code == "self_intersection"
    cure = diagnose(network, patch, result, None, fit_all).cure
    assert [type(part) for part in cure.results] == [FittedPatch, FittedPatch]
    # Both sides of the new seam are the same vertices, and as long when flat.
    lengths = []
    for part, made in zip(cure.parts, cure.results, strict=True):
        run = part.boundary.stretches[-1]
        ids = (run.first + np.arange(run.count + 1)) % len(part.boundary.vertices)
        lengths.append(np.linalg.norm(np.diff(made.outline[ids], axis=0), axis=1).sum())
    assert lengths == pytest.approx([cure.cut.length] * 2, rel=1e-9)


def test_a_cut_lies_in_the_tangent_plane_at_both_ends_and_keeps_their_places():
    inner, outer = spiral(1.5)
    [patch] = network_of(inner, outer).patches
    places = CutPlaces(patch.boundary)
    n = len(inner)
    cut = draw_cut(places, n // 2, 2 * n - n // 2, 2.0, None)
    np.testing.assert_array_equal(cut.vertices[[0, -1]], patch.boundary.vertices[[cut.start, cut.end]])
    edges = unit(np.diff(cut.vertices, axis=0))
    np.testing.assert_allclose(dot(edges, cut.normals), 0.0, atol=1e-12)
    # The first edge is a chord of a curve tangent to the plane: its angle falls with the edge's length.
    for edge, normal in ((edges[0], places.normals[cut.start]), (edges[-1], places.normals[cut.end])):
        assert abs(edge @ normal) < np.sin(np.radians(3.0))


def test_a_cut_on_a_reference_surface_stays_on_it():
    grid = np.linspace(-60, 60, 41)
    x, y = np.meshgrid(grid, grid)
    z = 40 - (x**2 + y**2) / 200
    k = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = k[:-1, :-1].ravel(), k[:-1, 1:].ravel(), k[1:, 1:].ravel(), k[1:, :-1].ravel()
    mesh = tidy_mesh(np.c_[x.ravel(), y.ravel(), z.ravel()], np.r_[np.c_[a, b, c], np.c_[a, c, d]])
    surface = ReferenceSurface(mesh)
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring, normals = surface.nearest(np.c_[50 * np.cos(t), 50 * np.sin(t), 0 * t + 27.5])
    [patch] = network_of(ring[:20], ring[:19:-1]).patches
    patch = replace(patch, boundary=replace(patch.boundary, vertices=ring, normals=_orthogonal(ring, normals)))
    cut = draw_cut(CutPlaces(patch.boundary), 0, 17, 8.0, surface)
    np.testing.assert_allclose(surface.nearest(cut.vertices)[0], cut.vertices, atol=1e-9)
    assert cut.vertices[len(cut.vertices) // 2, 2] > 37.0  # over the top, not along the chord


def _orthogonal(ring, normals):
    edges = unit(np.roll(ring, -1, axis=0) - ring)
    return unit(normals - dot(normals, edges)[:, None] * edges)


def test_no_cut_is_drawn_across_a_bay():
    """Between the tips of a C there is no patch."""
    inner, outer = deep_c()
    [patch] = network_of(inner, outer).patches
    n = len(inner)
    assert draw_cut(CutPlaces(patch.boundary), 0, n - 1, 8.0, None) is None
    for candidate in candidate_cuts(patch, None, 6):
        middle = candidate.cut.vertices[len(candidate.cut.vertices) // 2]
        assert 55.0 < np.hypot(*middle[:2]) < 105.0


def test_a_long_spiral_is_divided_again_until_every_part_is_made():
    network = network_of(*spiral(2.7))
    [patch] = network.patches
    [failed] = fit_all([patch])
    divided, parts, cuts = split(network, patch, failed, None, fit_all, 3)
    assert len(parts) == 3 == len(cuts) + 1 and not any(isinstance(part, FailedPatch) for part in parts.values())
    assert [p.name for p in divided.patches] == list(parts)
    assert all(any(w.code == "divided" for w in part.warnings) for part in parts.values())


def test_a_cut_that_leaves_a_part_failing_is_a_step_and_no_cure(tmp_path):
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(as_project(*spiral(2.7))))
    project = load_project(file)
    network = make_network(project, None)
    [patch] = network.patches
    [failed] = fit_all([patch])
    found = diagnose(network, patch, failed, None, fit_all)
    assert found.cure is not None and found.cure.unmade == 1 and not found.cured
    assert not ProjectDiagnosis(project, (found,), (), (), 1).all_cured
    assert "the best, a step forward and no cure: cut again, to paste:" in "\n".join(diagnosis_lines(project, found))


def test_what_is_pasted_makes_the_patches_that_were_tried(tmp_path, capsys):
    """The lines that `diagnose` prints, put into the file, build."""
    content = as_project(*spiral(1.5))
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(content))
    assert main(["diagnose", str(file), "-o", str(tmp_path / "cuts.png")]) == 0
    said = capsys.readouterr().out
    assert "self_intersection" in said and (tmp_path / "cuts.png").stat().st_size > 10_000
    pasted = yaml.safe_load(said[said.index("nodes:\n") :].rsplit("\n", 2)[0])
    content["nodes"] = pasted["nodes"]
    content["curves"] |= pasted["curves"]
    content["patches"], content["rest"] = pasted["patches"], pasted["rest"]
    file.write_text(yaml.safe_dump(content))
    assert main(["build", str(file), "-o", str(tmp_path / "out")]) == 0


def test_what_is_said_of_a_patch_is_pasted_for_its_parts(tmp_path):
    """A square with all that a patch can say; it is cut along a diagonal, off which one hole lies on either side."""
    places = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 100, 0], "d": [0, 100, 0]}
    holes = {name: {"at": [*xy, 0], "kind": "eyelet", "diameter": 5} for name, xy in (("h_b", (90, 10)),
             ("h_d", (10, 90)), ("h_a", (10, 10)), ("h_c", (90, 90)))}  # fmt: skip
    sheet = {
        "around": ["ab", "bc", "cd", "da"],
        "material": "felt",
        "also": {"lining": {"allowance": 6}, "foam": {"cut": 2}},
        "min_angle": dict.fromkeys("abcd", 80),
        "marks": {**holes, "line": {"points": [[20, 20, 0], [80, 80, 0], [80, 20, 0]], "kind": "skive"}},
        "wrinkles": "expected",
        "planar_boundary": "simple",
    }
    content = {
        "flatnet": 1, "name": "said", "edge_length": 12, "nodes": places, "rest": "openings",
        "curves": {p + q: {"from": p, "to": q, "normals": [0, 0, 1]} for p, q in ("ab", "bc", "cd", "da")},
        "patches": {"sheet": sheet}, "materials": {name: {"width": 900} for name in ("felt", "lining", "foam")},
    }  # fmt: skip
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(content))
    project = load_project(file)
    network = make_network(project, None)
    [patch] = network.patches
    side = len(patch.boundary.vertices) // 4
    cut = draw_cut(CutPlaces(patch.boundary), 0, 2 * side, 12.0, None)  # from a to c
    divided, (one, other) = divide_by(network, patch, cut)
    [whole, *made] = fit_all([patch, one, other])
    trial = Trial(cut, divided, one.boundary.stretches[-1].seam, (one, other), tuple(made))
    said = paste(project, Diagnosis(network, patch, whole, (trial,)))
    pasted = yaml.safe_load(said)
    assert "e-1" not in said  # no round-off of zeros
    parts = pasted["patches"].values()
    assert "# min_angle is left out where the seam divides the corner: a, c" in said
    assert "# marks that are given to both parts, as they may lie on either: h_a, h_c, line" in said
    assert {tuple(part["min_angle"].items()) for part in parts} == {(("b", 80),), (("d", 80),)}
    for part in parts:
        [corner] = part["min_angle"]
        assert part["also"] == {"lining": {"allowance": 6}, "foam": {"cut": 2, "mirrored": 0}}
        assert (part["wrinkles"], part["planar_boundary"]) == ("expected", "simple")
        assert set(part["marks"]) == {f"h_{corner}", "h_a", "h_c", "line"}
        assert part["marks"][f"h_{corner}"] == holes[f"h_{corner}"]
        assert part["marks"]["line"] == sheet["marks"]["line"]
    content["curves"] |= pasted["curves"]
    content["patches"] = pasted["patches"]
    file.write_text(yaml.safe_dump(content))
    assert [p.name for p in make_network(load_project(file), None).patches] == ["sheet_1", "sheet_2"]


def test_auto_split_delivers_the_parts_with_their_seam(tmp_path):
    """The mirror image, which stands first in the file, is divided by the image of the cut."""
    content = as_project(*spiral(1.5))
    content["mirror"] = {"point": [-150, 0, 0], "normal": [1, 0, 0]}
    content["curves"]["rim_2"] = {"mirror_of": "rim"}
    content["patches"] = {"image": {"mirror_of": "strip"}} | content["patches"]
    content["rest"] = "openings"
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(content))
    assert main(["build", str(file), "-o", str(tmp_path / "out"), "--auto-split"]) == 0
    report = read_report(tmp_path / "out")
    assert [patch["name"] for patch in report["patches"]] == ["image_1", "image_2", "strip_1", "strip_2"]
    for cut, parts in (("strip_cut", ["strip_1", "strip_2"]), ("image_cut", ["image_1", "image_2"])):
        seam = next(seam for seam in report["seams"] if seam["curve"] == cut)
        assert sorted(seam["patches"]) == parts
        assert seam["difference_mm"] < 1e-6
    assert all("divided" in {w["code"] for w in patch["warnings"]} for patch in report["patches"])
    for part in ("1", "2"):
        space, flat, triangles = read_obj(tmp_path / "out/patches" / f"strip_{part}.obj")
        space_2, flat_2, triangles_2 = read_obj(tmp_path / "out/patches" / f"image_{part}.obj")
        apart, same = cKDTree(space_2).query(space * [-1, 1, 1] - [300, 0, 0])
        assert apart.max() < 1e-9 and sorted(same) == list(range(len(space)))
        np.testing.assert_allclose(flat_2[same], flat * [1, -1], atol=1e-9)
        assert {frozenset(same[corners]) for corners in triangles} == set(map(frozenset, triangles_2))


def test_a_cut_through_the_wrinkle_takes_it_away(tmp_path):
    """A step bends up and back; cut where it bends neither way, both halves bend one way only."""
    (tmp_path / "project.yaml").write_text(yaml.safe_dump(wrinkled()))
    network = make_network(load_project(tmp_path / "project.yaml"), None)
    [patch] = network.patches
    [whole] = fit_all([patch])
    assert whole.mesh.wrinkles.wrinkled
    diagnosis = diagnose(network, patch, whole, None, fit_all, trials=2)
    cure = diagnosis.cure
    assert cure.wrinkled == 0 and cure.turning < 0.25 * whole.mesh.wrinkles.turning
    assert np.ptp(cure.cut.vertices[:, 0]) < patch.edge_length  # along the step
    assert cure.cut.length == pytest.approx(30.0, rel=0.01)  # as wide as the strip
    assert "turns to and fro by" in "\n".join(diagnosis_lines(load_project(tmp_path / "project.yaml"), diagnosis))


def test_cuts_are_tried_on_a_patch_that_is_named_though_nothing_is_wrong_with_it(tmp_path, capsys):
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(alone(square())))
    assert main(["diagnose", str(file)]) == 0
    assert "none of them wrinkled" in capsys.readouterr().out
    assert main(["diagnose", str(file), "--patch", "sheet"]) == 0
    said = capsys.readouterr().out
    assert "sheet: made, bending 0.0" in said and "the best, to paste:" in said


@pytest.mark.parametrize("seed", range(3))
def test_random_strips_that_cross_themselves_are_cured(seed, tmp_path):
    """Three of the family that `make bench` counts."""
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(as_project(*crossing_boundary(seed))))
    found = diagnose_project(file)
    [diagnosis] = found.diagnoses
    assert diagnosis.result.failure.code == "self_intersection"
    assert diagnosis.cure is not None


def test_a_project_with_nothing_to_cure_says_so(tmp_path, capsys):
    inner, outer = spiral(0.5)
    file = tmp_path / "project.yaml"
    file.write_text(yaml.safe_dump(as_project(inner, outer)))
    assert main(["diagnose", str(file)]) == 0
    assert "1 patch made" in capsys.readouterr().out
    assert main(["diagnose", str(file), "--patch", "sole"]) == 2
    assert "no patch 'sole'; there are strip" in capsys.readouterr().err
