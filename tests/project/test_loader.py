"""The loader: what a good file becomes, and what is said about a bad one, where."""

from __future__ import annotations

import random
import re
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from flatnet.parameters import METHODS, FairParameters, Limits, MultiLoopParameters, NestingParameters
from flatnet.project import (
    AlsoSpec,
    DartSpec,
    Ends,
    FormSurface,
    Mark,
    Material,
    MeshSurface,
    NickSpec,
    NotchSpec,
    Problem,
    Project,
    ProjectError,
    SeamSpec,
    SewnTo,
    load_project,
)
from flatnet.project.curve_specs import AtLandmark, MeshEdges, NamedLine, OnCurve, OnLine, OnRay, PlaneSection

BOW_TIE, TRIANGLE = "[[0, 0], [9, 9], [9, 0], [0, 9]]", "[[0, 0], [9, 0], [0, 9]]"
GOOD = Path(__file__).with_name("good.yaml").read_text(encoding="utf-8")
DOCS = Path(__file__).parents[2] / "docs" / "project-file.md"


def load(folder: Path, text: str | bytes) -> Project:
    file = folder / "project.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    (folder / "tetrahedron.stl").touch()
    return load_project(file)


def problems_of(folder: Path, text: str | bytes) -> list[Problem]:
    with pytest.raises(ProjectError) as caught:
        load(folder, text)
    return caught.value.problems


# --- a good file


def test_every_key_is_read(tmp_path: Path) -> None:
    project = load(tmp_path, GOOD)
    assert (project.title, project.edge_length, project.chord_tolerance) == ("every key · 38", 8.0, 0.1)
    assert project.rest_is_open
    assert project.nesting == NestingParameters(seconds=3, seed=7)
    assert project.limits == Limits(seconds=60, memory=2000)
    surface = project.surface
    assert isinstance(surface, MeshSurface)
    assert surface.path == tmp_path / "tetrahedron.stl"
    assert (surface.mm_per_unit, surface.up, surface.outer) == (1000.0, "y", "inside")
    assert surface.clearance == project.clearance == 2.0
    assert project.materials["denim"] == Material("denim", 1500.0, 5000.0, (0.0, 90.0), 3.0, 10.0, thickness=1.2)
    assert project.materials["felt"] == Material("felt", 1000.0, rotations=None)


def test_names_are_what_stands_in_the_file(tmp_path: Path) -> None:
    nodes = load(tmp_path, GOOD).nodes
    assert list(nodes) == ["on", "no", "007", "d-e.f", "tip"]
    assert nodes["no"].on_surface and not nodes["on"].on_surface


def test_lengths_become_mm_and_1e_1_is_a_number(tmp_path: Path) -> None:
    project = load(tmp_path, GOOD)
    assert project.nodes["007"].position.tolist() == [100.0, 100.0, 1.0]
    np.testing.assert_array_equal(project.curves["hem"].points, [[30, -10, 0], [60, -10, 0]])
    assert (project.curves["side"].edge_length, project.patches["front"].edge_length) == (4.0, 6.0)


def test_curves(tmp_path: Path) -> None:
    curves = load(tmp_path, GOOD).curves
    assert (curves["side"].kind, curves["side"].on_surface, curves["side"].normals.source) == (
        "spline", True, "surface",
    )
    top = curves["top"]
    assert (top.start, top.points[1], top.end, top.closed) == ("007", "d-e.f", "on", False)
    assert curves["dart"].slit
    notches = NotchSpec(60.0, (1.0,), (0.25, 0.5), True, "castle", 2, 3.0)
    nicks = NickSpec(8.0, 40.0, 2.0, "under")
    assert curves["hem"].seam == SeamSpec(30.0, 30.0, Ends("mirrored"), notches, nicks=nicks)
    assert curves["dart"].seam == SeamSpec(notches=NotchSpec(every=50.0), dart=DartSpec("right", 8.0))
    assert curves["side"].seam == SeamSpec(
        None, 0.0, Ends("mitre", 25.0), sewn_to=SewnTo((("hem", False), ("top", True)), 0.03, 0.0, Mark(24, 137))
    )
    assert curves["top"].seam == SeamSpec(None, None, Ends("mitre", None), NotchSpec(nodes=("d-e.f",)))
    assert (curves["hole"].closed, curves["hole"].start) == (True, None)
    assert (curves["ring"].closed, curves["ring"].start, curves["ring"].end) == (True, "tip", "tip")
    assert curves["hem"].mark == Mark(15, 3)


def test_normals_are_unit_and_counted(tmp_path: Path) -> None:
    curves = load(tmp_path, GOOD).curves
    hem, top, dart, hole = (curves[name].normals for name in ("hem", "top", "dart", "hole"))
    assert hem.left is not None and top.left is not None and top.right is not None
    assert hem.left.per == "segment" and not hem.crease
    np.testing.assert_allclose(hem.left.values, [[0, 0, 1], [0, 0, 1], [0, 0.5**0.5, 0.5**0.5]], rtol=1e-15)
    assert (top.left.per, top.right.per, top.crease) == ("point", "curve", True)
    assert dart.left is not None and dart.left.per == "point"
    assert hole.left is not None and hole.left.per == "segment"


def test_patches(tmp_path: Path) -> None:
    project = load(tmp_path, GOOD)
    front, disk = project.patches["front"], project.patches["disk"]
    around = [[str(entry) for entry in loop] for loop in front.loops]
    assert around == [["hem", "side", "top:007..d-e.f", "top:d-e.f..on"], ["-hole"]]
    assert (front.material, front.cut, front.mirrored) == ("denim", 2, 1)
    assert front.grain is not None and disk.grain is None
    np.testing.assert_allclose(front.grain.direction, [0, 0.6, 0.8], rtol=1e-15)
    assert front.min_angles == {"no": np.radians(95.0)}
    assert (front.allowance, disk.allowance) == (8.0, None)
    assert (front.fold, disk.fold) == ("side", None)
    pocket, button = front.marks
    assert (pocket.name, pocket.kind, pocket.spline, pocket.closed) == ("pocket", "stitch", True, True)
    assert (button.kind, button.diameter, button.points[0].tolist()) == ("eyelet", 4.0, [10, 10, 0])
    assert front.also == (AlsoSpec("felt", 2, 0, 6.0),) and front.materials == ("denim", "felt")
    assert front.fitting == MultiLoopParameters()
    assert disk.fitting == FairParameters(normal_weight=2.0, ramp_steps=20)
    assert (front.wrinkles_expected, disk.wrinkles_expected) == (False, True)


def test_arrays_are_read_only(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="read-only"):
        load(tmp_path, GOOD).nodes["on"].position[0] = 1.0


SMALL = """\
flatnet: 1
name: small
edge_length: 1
nodes: {a: [0, 0, 0], b: [9, 0, 0], c: [9, 9, 0]}
curves:
  ab: {from: a, to: b, normals: [0, 0, 1]}
  bc: {from: b, to: c, normals: [0, 0, 1]}
  ca: {from: c, to: a, normals: [0, 0, 1]}
patches:
  p: {around: [ab, bc, ca]}
"""


def test_defaults(tmp_path: Path) -> None:
    project = load(tmp_path, SMALL)
    assert (project.edge_length, project.chord_tolerance, project.surface) == (1.0, 0.02, None)
    assert list(project.materials) == [project.patches["p"].material] == ["default"]
    grain = project.patches["p"].grain
    assert grain is not None and grain.direction is not None
    assert (grain.direction.tolist(), grain.said) == ([0, 0, 1], False)
    assert project.patches["p"].fitting == FairParameters()


UNITS = {"mm": 1, "cm": 10, "dm": 100, "m": 1000, "in": 25.4, "0.5": 0.5}


@pytest.mark.parametrize("unit", UNITS)
def test_units(tmp_path: Path, unit: str) -> None:
    project = load(tmp_path, f"units: {unit}\n{SMALL}")
    assert project.nodes["b"].position[0] == 9 * UNITS[unit]


def test_form_measurements_are_lengths_or_words(tmp_path: Path) -> None:
    text = f"units: cm\nsurface: {{form: mannequin, waist: 72, half: left}}\n{SMALL}"
    surface = load(tmp_path, text).surface
    assert isinstance(surface, FormSurface)
    assert (surface.form, surface.measurements) == ("mannequin", {"waist": 720.0, "half": "left"})
    assert surface.clearance == 5.0  # half an edge length


def test_a_curve_that_no_patch_uses_needs_no_normals(tmp_path: Path) -> None:
    text = SMALL.replace("patches:", "  da: {from: a, to: c, points: [[0, 9, 0]]}\npatches:")
    assert load(tmp_path, text).curves["da"].normals.source == "none"


def test_merged_keys_give_what_the_curve_does_not_say(tmp_path: Path) -> None:
    text = SMALL.replace("ab: {", "ab: &line {").replace("bc: {from: b, to: c, normals: [0, 0, 1]}",
                                                         "bc: {<<: *line, from: b, to: c}")
    curve = load(tmp_path, text).curves["bc"]
    assert (curve.start, curve.end, curve.normals.source) == ("b", "c", "given")


def test_closed_curve_through_nodes_has_stretches_around_it(tmp_path: Path) -> None:
    text = SMALL.replace(
        "patches:",
        "  ring: {points: [a, [0, -5, 0], b, [9, -5, 0]], normals: [0, 0, 1]}\npatches:\n"
        "  q: {around: [ring:b..a, ring:a..b]}\n  r: {around: [-ring:b..b]}",
    )
    assert load(tmp_path, text).patches["q"].loops[0][0].stretch == ("b", "a")


# --- bad files

#: (what stands in SMALL, what is put there, line, column, what must be said)
BAD = [
    ("flatnet: 1", "flatnet: 2", 1, 10, "reads version 1 of the format, got 2"),
    ("flatnet: 1\n", "", 1, 1, "'flatnet' is missing"),
    ("name: small", "name: ''", 2, 7, "name: expected a line of text"),
    ("name: small", "nmae: small", 2, 1, "unknown key 'nmae'; did you mean 'name'?"),
    ("edge_length: 1", "edge_length: -8", 3, 14, "must be greater than 0, got -8"),
    ("edge_length: 1", "edge_length: .nan", 3, 14, "expected a finite number, got '.nan'"),
    ("edge_length: 1", "edge_length: -.inf", 3, 14, "expected a finite number"),
    ("edge_length: 1", "edge_length: 1e999", 3, 14, "expected a finite number"),
    ("edge_length: 1", "edge_length: 1e10", 3, 14, "is 1e+10 mm; is the unit right?"),
    ("edge_length: 1", "edge_length: 12:30", 3, 14, "expected a number, got '12:30'"),
    ("edge_length: 1", "edge_length: '8'", 3, 14, "expected a number, got the text '8' in quotes"),
    ("edge_length: 1", "edge_length: yes", 3, 14, "expected a number, got 'yes'"),
    ("edge_length: 1", "edge_length:", 3, 13, "expected a number, got nothing"),
    ("edge_length: 1", "edge_length: [1]", 3, 14, "expected a number, got a list of 1"),
    ("edge_length: 1", "edge_length: 1\nunits: ft", 4, 8, "expected mm, cm, dm, m, in or a number"),
    ("edge_length: 1", "edge_length: 1\nrest: open", 4, 7, "expected 'openings', got 'open'"),
    ("edge_length: 1", "edge_length: 1\nedge_length: 2", 4, 1, "stands twice, first in line 3"),
    ("edge_length: 1", "edge_length: 1\n? [a]\n: 1", 4, 3, "a key must be a word, got a list of 1"),
    ("edge_length: 1", "edge_length: 1\n<<: 3", 4, 5, "'<<' takes an alias"),
    ("edge_length: 1", "edge_length: !!python/name:os.system 1", 3, 14, "means nothing here; leave it out"),
    ("edge_length: 1", "edge_length: 1\nsurface: {mesh: no.stl}", 4, 17, "there is no file"),
    ("edge_length: 1", "edge_length: 1\nsurface: {mesh: a.txt}", 4, 17, "expected a mesh file (.obj"),
    ("edge_length: 1", "edge_length: 1\nsurface: {up: z}", 4, 1, "needs 'form: <name>' or 'mesh: <file>'"),
    ("edge_length: 1", "edge_length: 1\nsurface: {form: f, clearance: -1}", 4, 31, "must not be less than 0"),
    ("edge_length: 1", "edge_length: 1\nsurface: {form: f, waist: 9mm}", 4, 27, "a length or a word"),
    ("a: [0, 0, 0]", "a: [0, 0]", 4, 12, "nodes: 'a': expected three numbers [x, y, z], got a list of 2"),
    ("a: [0, 0, 0]", "a: [0, 0, x]", 4, 19, "expected a number, got 'x'"),
    ("a: [0, 0, 0]", "a: {on: surface, at: [0, 0, 0]}", 4, 17, "the file has no surface"),
    ("a: [0, 0, 0]", "a: {an: [0, 0, 0]}", 4, 9, "node 'a': 'at' is missing"),
    ("a: [0, 0, 0]", "a: [0, 0, 0], a: [1, 1, 1]", 4, 23, "the key 'a' stands twice"),
    ("a: [0, 0, 0]", "a: [0, 0, 0], d: [0, 0, 0]", 4, 23, "'d' is at the same place as 'a'"),
    ("a: [0, 0, 0]", "a: [0, 0, 0], -d: [0, 0, 1]", 4, 23, "'-d' is no name"),
    ("a: [0, 0, 0]", "a: [0, 0, 0], d..e: [0, 0, 1]", 4, 23, "'d..e' is no name"),
    ("a: [0, 0, 0]", "a: [0, 0, 0], d:e: [0, 0, 1]", 4, 23, "'d:e' is no name"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, pionts: []", 6, 24, "did you mean 'points'?"),
    ("ab: {from: a, to: b", "ab: {from: a, to: d", 6, 21, "curve 'ab': to: there is no node 'd'"),
    ("ab: {from: a, to: b", "ab: {from: a", 6, 8, "'from' without 'to'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: a", 6, 3, "'ab': degenerate_curve: a closed curve needs at least 3"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: [[.nan, 0, 0]]", 6, 34, "degenerate_curve: expected a"),
    ("ab: {from: a, to: b", "ab: {closed: true, from: a, to: b", 6, 16, "closed: true, but"),
    ("ab: {from: a, to: b", "ab: {closed: maybe, from: a, to: b", 6, 16, "true or false, got 'maybe'"),
    ("ab: {from: a, to: b", "ab: {slit: yes, points: [[0,0,0],[1,0,0],[0,1,0]]", 6, 14, "has no tip"),
    ("ab: {from: a, to: b", "ab: {points: [[0,0,0],[1,0,0],[0,1,0],[0,0,0]]", 6, 41, "degenerate_curve: point 4"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: [[0,0,0]]", 6, 33, "same place as from"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: [[1,0,0],[1,0,0]]", 6, 41, "place as point 1"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: [c, [1,1,0], c]", 6, 45, "passes node 'c' twice"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: [1, 2, 3]", 6, 33, "a point is a list [x, y, z]"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, points: c", 6, 32, "a list of points and nodes, or the path of"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, edge_length: 1e-6", 6, 3, "are 'units' and 'edge_length'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, on: surface", 6, 28, "the file has no surface"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, kind: splin", 6, 30, "did you mean 'spline'?"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, allowance: -1", 6, 35, "must not be less than 0, got -1"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, allowance: {lft: 1}", 6, 36, "did you mean 'left'?"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, ends: miter", 6, 30, "did you mean 'mitre'?"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, ends: 0", 6, 30, "must be greater than 0, got 0"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: 0", 6, 33, "must be greater than 0, got 0"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {at: [101%]}", 6, 39, "at most 100%, got '101%'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {at: [-5]}", 6, 39, "must not be less than 0, got -5"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {at: 5}", 6, 38, "a list of lengths and percentages"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {marks: 4, every: 9}", 6, 41, "must be in [1, 3], got 4"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {kind: t, every: 9}", 6, 40, "expected 'slit' or 'T'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {kind: T}", 6, 33, "says no place; give 'every', 'at'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, notches: {at: [-3%]}", 6, 39, "a percentage from 0% to 100%, got"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, sewn_to: {curves: bc, ease: -3%}", 6, 52, "0% to 900%, got '-3%'"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, dart: left", 6, 30, "only a curve with slit: true can be a dart"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, dart: {drill: 3}", 6, 30, "'fold' is missing"),
    ("ab: {from: a, to: b", "ab: {from: a, to: b, dart: up", 6, 30, "expected 'left' or 'right', got 'up'"),
    ("a, to: b, normals: [0, 0, 1]", "a, to: b", 6, 3, "has no normals, but patch 'p' needs them"),
    ("b, normals: [0, 0, 1]", "b, normals: surface", 6, 33, "normals: surface, but the file has no surface"),
    ("b, normals: [0, 0, 1]", "b, normals: [0, 0, 0]", 6, 33, "a direction must not be [0, 0, 0]"),
    ("b, normals: [0, 0, 1]", "b, normals: up", 6, 33, "expected 'surface', 'curves', a direction"),
    ("b, normals: [0, 0, 1]", "b, normals: {left: [0, 0, 1]}", 6, 33, "'right' is missing"),
    ("b, normals: [0, 0, 1]", "b, normals: [[0,0,1],[0,0,1],[0,0,1]]", 6, 33, "3 given, but that fits"),
    ("b, normals: [0, 0, 1]", "b, normals: {per: point, values: [[0,0,1]]}", 6, 54, "expected 2 normals"),
    ("b, normals: [0, 0, 1]", "b, normals: {per: point}", 6, 33, "'values' is missing"),
    ("ab: {from: a, to: b, normals: [0, 0, 1]}", "ab: [a, b]", 6, 7, "keys with values, got a list of 2"),
    ("[ab, bc, ca]", "[ab, bc, xa]", 10, 24, "patch 'p': around, item 3: there is no curve 'xa'"),
    ("[ab, bc, ca]", "[ab, bc, ca, ab]", 10, 28, "'ab' stands there twice; its other side is '-ab'"),
    ("[ab, bc, ca]", "[ab, bc, ca]}\n  q: {around: [ab]", 11, 16, "already bounds patch 'p' on this side"),
    ("[ab, bc, ca]", "[ab, bc, ca:a..c]", 10, 24, "runs from 'c' to 'a'; write ca:c..a, backwards -ca:c..a"),
    ("[ab, bc, ca]", "[ab, bc, ca:a..b]", 10, 24, "its stretches: ca:c..a"),
    ("[ab, bc, ca]", "[ab, bc, +ca]", 10, 24, "expected a curve: hem, -hem, or a stretch"),
    ("[ab, bc, ca]", "[ab, [bc, ca]]", 10, 16, "got both"),
    ("[ab, bc, ca]", "[]", 10, 15, "names no curve"),
    ("{around: [ab, bc, ca]}", "{cut: 1}", 10, 3, "'around' is missing"),
    ("ca]}", "ca], material: felt}", 10, 39, "there is no material 'felt'"),
    ("ca]}", "ca], cut: 1.5}", 10, 34, "expected a whole number, got 1.5"),
    ("ca]}", "ca], cut: -1}", 10, 34, "must be in [0, 1000], got -1"),
    ("ca]}", "ca], cut: 0}", 10, 34, "nothing is cut"),
    ("ca]}", "ca], allowance: 1 cm}", 10, 40, "expected a number, got '1 cm'"),
    ("ca]}", "ca], grain: down}", 10, 36, "expected 'up', 'none', a direction"),
    ("ca]}", "ca], also: {felt: {}}}", 10, 36, "there is no material 'felt'"),
    ("ca]}", "ca], also: {default: {}}}", 10, 36, "'default' is its `material` already"),
    ("ca]}", "ca], also: {default: {cut: 0}}}", 10, 51, "nothing is cut"),
    ("ca]}", "ca], also: {default: {cuts: 1}}}", 10, 46, "did you mean 'cut'?"),
    ("ca]}", "ca], marks: {m: {}}}", 10, 37, "needs either 'at: [x, y, z]' for a point"),
    ("ca]}", "ca], marks: {m: {at: [0, 0, 0], closed: yes}}}", 10, 56, "'closed' is for lines only"),
    ("ca]}", "ca], marks: {m: {points: [[0, 0, 0]]}}}", 10, 49, "a line needs at least 2, 1 more"),
    ("ca]}", "ca], marks: {m: {points: [[0, 0, 0], [0, 0, 0]]}}}", 10, 49, "point 2 repeats the one before"),
    ("ca]}", "ca], marks: {m: {at: [0, 0, 0], kind: stitch}}}", 10, 62, "expected 'drill' or 'eyelet'"),
    ("ca]}", "ca], grain: {along: xy}}", 10, 44, "patch 'p': grain: along: there is no curve 'xy'"),
    ("ca]}", "ca], grain: {from: a}}", 10, 36, "'to' is missing; the grain runs along a curve or between two"),
    ("ca]}", "ca], grain: {from: a, to: d}}", 10, 50, "to: no curve passes a node 'd'"),
    ("ca]}", "ca], grain: {along: ab, to: b}}", 10, 48, "'along' and 'to' exclude each other"),
    ("ca]}", "ca], min_angle: {d: 90}}", 10, 41, "node 'd' is not on the boundary of the patch"),
    ("ca]}", "ca], min_angle: {a: 360}}", 10, 44, "must be between 0 and 360 degrees, got 360"),
    ("ca]}", "ca], wrinkles: yes}", 10, 39, "expected 'expected', got 'yes'"),
    ("ca]}", "ca], fitting: {method: fast}}", 10, 47, "expected 'fair' or 'multi_loop' or 'boundary_alone', got"),
    ("ca]}", "ca]}\nmaterials: {m: {gap: 1}}", 11, 13, "material 'm': 'width' is missing"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 9, gap: -1}}", 11, 32, "must not be less than 0, got -1"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 9, rotations: []}}", 11, 38, "names no angle"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 9, rotations: all}}", 11, 38, "'nap' or 'free', got 'all'"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 1}, n: {width: 1}}", 10, 3, "say which of m, n"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 9, sheets: 2}}", 11, 27, "a sheet has a 'length' too"),
    ("ca]}", "ca]}\nmaterials: {m: {width: 9, hides: {}}}", 11, 34, "'outline' is missing"),
    ("ca]}", "ca]}\nmaterials: {m: {hides: []}}", 11, 24, "there is none"),
    ("ca]}", "ca]}\nmaterials: {m: {hides: {outline: hide.svg}}}", 11, 34, "there is no file"),
    ("ca]}", "ca]}\nmaterials: {m: {hides: {outline: [[0, 0], [9, 0]]}}}", 11, 34, "three or more points"),
    ("ca]}", "ca]}\nmaterials: {m: {hides: {outline: [[0, 0], [9, 0], [3]]}}}", 11, 51, "a point [x, y]"),
    ("ca]}", f"ca]}}\nmaterials: {{m: {{hides: {{outline: {BOW_TIE}}}}}}}", 11, 34, "does not cross itself"),
    (
        "ca]}",
        f"ca]}}\nmaterials: {{m: {{hides: {{outline: {TRIANGLE}, defects: [[[50, 0], [60, 0], [60, 9]]]}}}}}}",
        11, 24, "a defect lies off the hide",
    ),
    (
        "ca]}",
        f"ca], zone: B}}\nmaterials: {{m: {{hides: {{outline: {TRIANGLE}, zones: {{A: {TRIANGLE}}}}}}}}}",
        10, 3, "no hide of material 'm' has a zone 'B'",
    ),
    ("ca]}", "ca], match: 3}", 10, 36, "true or false"),
    ("ca]}", "ca]}\nfitting: {ramp_steps: 0}", 11, 23, "ramp_steps must be in [1, 1000], got 0"),
    ("ca]}", "ca]}\nfitting: {ramp_start: 200}", 11, 1, "ramp_end must be in [200,"),
    ("ca]}", "ca]}\nfitting: {w1: 3}", 11, 11, "'w1' belongs to method 'multi_loop'"),
    ("ca]}", "ca]}\nnesting: {sed: 3}", 11, 11, "did you mean 'seed'?"),
    ("ca]}", "ca]}\nnesting: {seconds: 1.5}", 11, 20, "expected a whole number"),
    ("ca]}", "ca]}\nlimits: {second: 3}", 11, 10, "did you mean 'seconds'?"),
    ("ca]}", "ca]}\nlimits: {memory: 100}", 11, 18, "memory must be in [300, 1e+09], got 100"),
    ("curves:", "curves: {}\ncurvs:", 5, 1, "there are no curves"),
    ("patches:", "rest: openings\npatchs:", 9, 1, "nothing is left to make"),
    ("ca]}", "ca]", 11, 1, "not valid YAML: while parsing a flow mapping"),
    ("  ab:", "\tab:", 6, 1, "not valid YAML"),
    ("ca]}", "ca], stroke: #00ff00}", 11, 1, "; in line 10 #00ff00 begins a comment: write a colour in quotes"),
    ("small", "*small", 2, 7, "undefined alias"),
    ("small", "sm\x00all", 2, 9, "U+0000 is not allowed"),
]


@pytest.mark.parametrize("old, new, line, column, phrase", BAD)
def test_bad_file(tmp_path: Path, old: str, new: str, line: int, column: int, phrase: str) -> None:
    assert SMALL.count(old) >= 1
    found = problems_of(tmp_path, SMALL.replace(old, new, 1))
    said = [(problem.mark, problem.message) for problem in found]
    assert any(mark == Mark(line, column) and phrase in message for mark, message in said), said


ON_FORM = """\
flatnet: 1
name: on a form
edge_length: 1
surface: {form: mannequin}
nodes:
  a: {landmark: crotch}
  b: {ray: {from: [0, 300, 500], direction: [0, -2, 0]}}
  c: {at: {line: waist, t: 1}}
  d: {at: {curve: ab, t: 0.4}}
curves:
  ab: {from: a, to: b, kind: geodesic}
  bd: {from: b, to: d, kind: fair, points: [[9, 9, 9], {line: hip, t: 0.25}]}
  ad: {from: a, to: d, section: {point: [1, 2, 3]}}
  ring: {line: waist}
  cut: {section: {point: [1, 2, 3], normal: [0, 0, 2]}}
  rim: {along: boundary}
  edge: {along: {feature: 40}, from: a, to: c}
join: crossings
patches:
  p: {around: [ab, bd, "edge:a..ab.edge"]}
"""


def test_nodes_and_curves_of_a_surface(tmp_path: Path) -> None:
    project = load(tmp_path, ON_FORM)
    assert project.joins_crossings
    nodes, curves = project.nodes, project.curves
    assert nodes["a"].place == AtLandmark("crotch") and nodes["a"].on_surface
    assert nodes["c"].place == OnLine("waist", 1.0)
    assert nodes["d"].place == OnCurve("ab", None, 0.4) and not nodes["d"].on_surface
    ray = nodes["b"].place
    assert isinstance(ray, OnRay)
    assert (ray.origin.tolist(), ray.direction.tolist()) == ([0, 300, 500], [0, -1, 0])
    assert all(curve.on_surface and curve.normals.source == "surface" for curve in curves.values())
    assert (curves["ab"].kind, curves["bd"].kind) == ("geodesic", "fair")
    assert curves["ab"].nodes == ["a", "d", "b"]
    assert curves["bd"].points[1] == OnLine("hip", 0.25) and curves["bd"].nodes == ["b", "d"]
    assert curves["ring"].path == NamedLine("waist") and curves["ring"].closed
    assert curves["rim"].path == MeshEdges("boundary", np.radians(30.0))
    assert curves["edge"].path == MeshEdges("feature", np.radians(40.0))
    cut = curves["cut"].path
    assert isinstance(cut, PlaneSection) and cut.point is not None and cut.normal is not None
    assert (cut.point.tolist(), cut.normal.tolist()) == ([1, 2, 3], [0, 0, 1])


#: As BAD, for ON_FORM.
BAD_ON_FORM = [
    ("surface: {form: mannequin}\n", "", 5, 3, "node 'a': lies on a surface, but the file has none"),
    ("surface: {form: mannequin}\n", "", 10, 30, "kind: geodesic is drawn on a surface, but the file has none"),
    ("surface: {form: mannequin}\n", "", 13, 10, "line: lies on a surface, but the file has none"),
    ("a: {landmark: crotch}", "a: {landmark: crotch, at: [0, 0, 0]}", 6, 3, "'at' and 'landmark' exclude each other"),
    ("a: {landmark: crotch}", "a: {landmark: crotch, on: surface}", 6, 25, "'on' goes with a point [x, y, z]"),
    ("direction: [0, -2, 0]", "direction: [0, 0, 0]", 7, 45, "a direction must not be [0, 0, 0]"),
    (", direction: [0, -2, 0]", "", 7, 7, "ray: 'direction' is missing"),
    ("line: waist, t: 1}", "line: waist, t: 1.2}", 8, 28, "t: must be in [0, 1], got 1.2"),
    ("line: waist, t: 1}", "line: waist}", 8, 7, "'t' is missing; the fraction of its length, 0 to 1"),
    ("{line: hip, t: 0.25}", "{line: hip, t: -1}", 12, 71, "curve 'bd': point 2: t: must be in [0, 1], got -1"),
    ("{line: hip, t: 0.25}", "{line: hip}", 12, 56, "'t' is missing; the fraction of its length, 0 to 1"),
    ("{line: hip, t: 0.25}", "{curve: ab, t: 0.25}", 12, 57, "unknown key 'curve'"),
    ("surface: {form: mannequin}\n", "", 11, 56, "lies on a line of a form, but the file has no surface"),
    ("curve: ab, t: 0.4", "curve: ab, t: 0", 9, 26, "must be greater than 0 and less than 1, got 0; at its ends"),
    ("curve: ab, t: 0.4", "curve: rink, t: 0.4", 9, 3, "there is no curve 'rink'; did you mean 'ring'?"),
    ("curve: ab, t: 0.4", "curve: ab:b..a, t: 0.4", 9, 3, "'ab' has no stretch b..a; it has ab:a..b"),
    ("curve: ab, t: 0.4", "t: 0.4", 9, 7, "give 'curve' and 't', or 'line' and 't'"),
    ("curve: ab, t: 0.4", "curve: -ab, t: 0.4", 9, 19, "expected a curve: side, or a stretch of one, side:a..b"),
    ("curve: ab, t: 0.4", "curve: ad, t: 0.4", 13, 3, "curve 'ad': is drawn through node 'd', which lies on it"),
    ("ab: {from: a, to: b", "ab: {from: a, points: [c], to: b", 9, 3, "say between which: ab:a..c, ab:c..b"),
    ("ab: {from: a, to: b", "ab: {from: a, points: [d], to: b", 11, 3, "is drawn through node 'd'"),
    ("a: {landmark: crotch}", "a: {at: {curve: bd, t: 0.5}}", 6, 3, "none of these can be drawn first, each"),
    ("d: {at:", "e: {at: {curve: ab, t: 0.4}}\n  d: {at:", 10, 3, "'d' is at the same place as 'e'; keep one"),
    ("ring: {line: waist}", "ring: {line: waist, along: boundary}", 14, 23, "'line' and 'along' exclude each other"),
    ("ring: {line: waist}", "ring: {line: waist, kind: fair}", 14, 23, "'line' and 'kind' exclude each other"),
    ("ring: {line: waist}", "ring: {line: waist, normals: [[0, 0, 1]]}", 14, 32, "the curve has no points"),
    ("point: [1, 2, 3], normal: [0, 0, 2]", "normal: [0, 0, 2]", 15, 9, "needs 'point' and 'normal'"),
    ("section: {point: [1, 2, 3]}", "section: {}", 13, 24, "a section needs 'point' or 'normal', or both"),
    ("along: boundary", "along: border", 16, 16, "or {feature: <degrees>}, got 'border'"),
    ("{feature: 40}", "{feature: 190}", 17, 27, "must be in [1, 179], got 190"),
    ("join: crossings", "join: all", 18, 7, "join: expected 'crossings', got 'all'"),
    ("join: crossings\n", "", 19, 24, "no stretch of 'edge' runs from 'a' to 'ab.edge'"),
]


@pytest.mark.parametrize("old, new, line, column, phrase", BAD_ON_FORM)
def test_bad_file_on_a_form(tmp_path: Path, old: str, new: str, line: int, column: int, phrase: str) -> None:
    assert old in ON_FORM
    problems = problems_of(tmp_path, ON_FORM.replace(old, new, 1))
    assert (line, column) in [
        (problem.mark.line, problem.mark.column) for problem in problems if problem.mark and phrase in problem.message
    ], [str(problem) for problem in problems]


@pytest.mark.parametrize(
    "text, phrase",
    [
        ("", "the file is empty"),
        ("# nothing\n", "the file is empty"),
        ("[" * 5000, "nested too deep"),
        ('a: "\\UFFFFFFFF"', "not valid YAML"),
        (f"%YAML {'9' * 5000}.1\n---\na: 1", "not valid YAML"),
    ],
)
def test_unreadable_text(tmp_path: Path, text: str, phrase: str) -> None:
    (problem,) = problems_of(tmp_path, text)
    assert phrase in problem.message and problem.mark is None


def test_bytes_that_are_no_utf8(tmp_path: Path) -> None:
    (problem,) = problems_of(tmp_path, "flatnet: 1\nname: Hösen".encode("latin-1"))
    assert problem.mark == Mark(2, 8) and "0xf6 is no UTF-8" in problem.message


def test_a_byte_order_mark_is_no_problem(tmp_path: Path) -> None:
    assert load(tmp_path, "\ufeff" + SMALL).name == "small"
    (problem,) = problems_of(tmp_path, "\ufeff" + SMALL.replace("flatnet: 1", "flatnet: 2"))
    assert problem.mark == Mark(1, 10)


def test_no_such_file_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(ProjectError, match=r"none\.yaml: there is no such file"):
        load_project(tmp_path / "none.yaml")
    with pytest.raises(ProjectError, match="is a folder; name the project file in it"):
        load_project(tmp_path)


def test_all_problems_come_together_in_file_order(tmp_path: Path) -> None:
    text = SMALL.replace("name: small", "name: ''").replace("to: c", "to: z").replace("bc,", "bd,")
    with pytest.raises(ProjectError) as caught:
        load(tmp_path, text)
    places = re.findall(r"^.*project\.yaml:(\d+:\d+): ", str(caught.value), flags=re.MULTILINE)
    assert places == ["2:7", "7:21", "10:20"]


def test_a_problem_is_said_once(tmp_path: Path) -> None:
    """A node that can't be read is no reason to complain about the curves that use it."""
    (problem,) = problems_of(tmp_path, SMALL.replace("a: [0, 0, 0]", "a: [0, 0, x]"))
    assert problem.mark == Mark(4, 19)


def test_every_parameter_out_of_range_is_said(tmp_path: Path) -> None:
    found = problems_of(tmp_path, f"{SMALL}fitting: {{normal_weight: -1, max_steps: 0}}\n")
    assert [problem.mark for problem in found] == [Mark(11, 26), Mark(11, 41)]


def test_recursive_aliases_end(tmp_path: Path) -> None:
    text = SMALL.replace("[ab, bc, ca]", "&loop [*loop, *loop]")
    assert problems_of(tmp_path, text)
    text = SMALL.replace("ab: {from: a, to: b,", "ab: &ab {<<: *ab, from: a, to: b,")
    assert load(tmp_path, text).curves["ab"].end == "b"


# --- mutations and docs


VALUES = ["~", "no", "[]", "{}", "0", "-1", ".nan", "1e999", "'x'", "12:30", "[0, 0, 0]", "[[0, 0, 1]]"]
SIGNS = [*"-:*&|%@#?!\"'\t\n\\\u2028é", "*top", "&top", "<<: *top", "!!map", "[[", "--- "]


def _damaged(text: str, seed: int, count: int) -> list[str]:
    """Seeded damage: words swapped or replaced by other values; in every other copy any characters too."""
    chance = random.Random(seed)
    copies = []
    for number in range(count):
        tokens = re.findall(r"[\w.]+|[^\w.]+" if number % 2 else r"\w+|\s+|[^\w\s]", text)
        words = [i for i, token in enumerate(tokens) if number % 2 == 0 or re.match(r"[\w.]", token)]
        for _ in range(chance.randint(1, 4)):
            i, j = chance.choice(words), chance.choice(words)
            if chance.random() < 0.5:
                tokens[i], tokens[j] = tokens[j], tokens[i]
            else:
                tokens[i] = chance.choice(VALUES if number % 2 else SIGNS)
        copies.append("".join(tokens))
    return copies


def test_damaged_files_raise_nothing_but_project_errors(tmp_path: Path) -> None:
    said = []
    for text in _damaged(GOOD, seed=1, count=200):
        try:
            load(tmp_path, text)
        except ProjectError as error:
            assert error.problems
            said.append(str(error))
    assert sum("not valid YAML" not in message for message in said) > 70  # most damaged values are found


def test_the_docs_name_every_key_and_parameter() -> None:
    from flatnet.project import curves, faces, hides, imports, loader, marks, mirror, nodes, paths, sewing

    text = DOCS.read_text(encoding="utf-8")
    keys = {
        *loader._TOP_KEYS, *loader._MESH_KEYS, *loader._MATERIAL_KEYS,
        *nodes._NODE_KEYS, *nodes._RAY_KEYS, *nodes._AT_KEYS, *paths._SECTION_KEYS, *curves._CURVE_KEYS,
        *faces._PATCH_KEYS, *faces._ALSO_KEYS, *faces._GRAIN_KEYS, *marks.MARK_KEYS, *sewing._NOTCH_KEYS,
        *sewing._DART_KEYS, *sewing._SEWN_KEYS, *sewing._NICK_KEYS, *hides._HIDE_KEYS, *imports._IMPORT_KEYS,
        *imports._PLACE_KEYS,
        *mirror._MIRROR_KEYS, mirror.IMAGE_KEY,
    }
    assert not [key for key in sorted(keys) if not re.search(rf"\b{key}\b:", text)]
    for parameters in (*METHODS.values(), NestingParameters, Limits):
        for name, value in vars(parameters()).items():
            assert re.search(rf"\b{name}\b", text) and str(value) in text, name


def test_the_file_in_the_docs_has_only_known_keys(tmp_path: Path) -> None:
    """Its dots and names lead nowhere, but every key of it is one."""
    text = DOCS.read_text(encoding="utf-8").split("```yaml\n")[1].split("```")[0].replace("...", "1")
    messages = [problem.message for problem in problems_of(tmp_path, dedent(text))]
    assert not [message for message in messages if "key" in message or "YAML" in message]
