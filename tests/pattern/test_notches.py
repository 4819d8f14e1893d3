"""Notches: the same on both sides of a seam, cut into its allowance, and different where seams look alike."""

import numpy as np
import pytest
import shapely
import yaml
from pieces import SQUARE, blob, cloth, fitted
from svgelements import SVG, Path
from written import read_obj, read_report

from flatnet.cli import main
from flatnet.network.network import SampledStretch
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.notches import Notch, NotchedSeam, SeamNotch, place_notches, tell_apart
from flatnet.pattern.seams import Seam
from flatnet.project.patch_specs import AlsoSpec
from flatnet.project.seam_specs import NotchSpec, SeamSpec


def straight(length, edges=7):
    vertices = np.column_stack([np.linspace(0, length, edges + 1), np.zeros((edges + 1, 2))])
    normals = np.tile([0.0, 0.0, 1.0], (edges, 1))
    return SampledStretch("s", "s", "a", "b", vertices, normals, normals)


def places(spec, stretch, start=0.0, total=None):
    found = place_notches(spec, stretch, start, stretch.length if total is None else total)
    along = np.linspace(0, stretch.length, len(stretch.vertices))
    for notch in found:  # where it is said to be
        assert along[notch.edge] + notch.fraction * np.diff(along)[notch.edge] == pytest.approx(notch.arclength)
    return [notch.arclength for notch in found]


def test_a_row_starts_at_the_seams_start_and_keeps_off_its_end():
    assert places(NotchSpec(every=100), straight(520)) == pytest.approx([100, 200, 300, 400])
    assert places(NotchSpec(every=100), straight(530)) == pytest.approx([100, 200, 300, 400, 500])
    assert places(NotchSpec(every=100), straight(90)) == []


def test_places_are_counted_along_the_whole_curve():
    spec = NotchSpec(at=(30.0, 150.0), at_parts=(0.5,))
    assert places(spec, straight(100), 0.0, 300.0) == pytest.approx([30])
    assert places(spec, straight(200), 100.0, 300.0) == pytest.approx([50])  # 150 mm is the half: one notch


def test_a_place_at_the_end_of_a_curve_is_on_it():
    spec = NotchSpec(at=(0.0,), at_parts=(1.0,))
    assert places(spec, straight(100)) == pytest.approx([0, 100])
    assert places(spec, straight(100), 0.0, 300.0) == [0]
    assert places(spec, straight(200), 100.0, 300.0) == pytest.approx([200])


def notched(length, *arclengths, fixed=False):
    return NotchedSeam(length, tuple(SeamNotch(0, 0.0, place) for place in arclengths), fixed)


def marks(seams):
    return [tuple(notch.marks for notch in seam.notches) for seam in tell_apart(seams)]


def test_seams_that_look_alike_get_different_marks():
    alike = [notched(300, 100, 200.0 + shift) for shift in (0, 1, 2)]
    assert len(set(marks(alike))) == 3
    others = [notched(300, 80, 190), notched(340, 80, 190), notched(300, 80)]
    assert marks(others) == [(1, 1), (1, 1), (1,)]  # length, number or place tell them apart already


def test_a_symmetric_seam_can_not_be_turned_round():
    ((first, second),) = marks([notched(300, 100, 200)])
    assert first != second
    assert marks([notched(300, 90, 200)]) == [(1, 1)]


def test_no_two_of_many_match_from_either_end():
    seams = tell_apart([notched(300, 100, 200)] * 2 + [notched(302, 101, 201)])
    for i, seam in enumerate(seams):
        assert not seam.backwards.looks_like(seam)
        assert not any(seam.looks_like(other) or seam.backwards.looks_like(other) for other in seams[:i])


def test_marks_that_are_asked_for_stay():
    asked = NotchedSeam(300, (SeamNotch(0, 0, 100, 2), SeamNotch(0, 0, 200, 2)), True)
    assert marks([asked, asked]) == [(2, 2)] * 2


@pytest.mark.parametrize("seed", range(4))
def test_a_notch_stands_on_the_cut_line_over_its_place_on_the_sew_line(seed):
    outline = blob(seed, 400, 250, 60)
    random = np.random.default_rng(seed)
    stretches = tuple(Stretch(f"s{i}", 15 * i, 15, bool(i % 2)) for i in range(4))
    seams, said = {}, {}
    for number, stretch in enumerate(stretches, 1):
        said[stretch.seam] = [SeamNotch(int(e), f, 0.0, 2) for e, f in zip([2, 7, 12], random.uniform(0.1, 0.9, 3))]
        spec = SeamSpec(5.0 * number, 5.0 * number, notches=NotchSpec(depth=4.0))
        seams[stretch.seam] = Seam(stretch.seam, number, stretch.seam, spec, ("piece",), 1.0, tuple(said[stretch.seam]))
    made = make_piece(fitted(outline, stretches=stretches), cloth(), seams)
    cut = shapely.LinearRing(made.cut_line)
    assert len(made.notches) == 12
    for run in made.seams:
        along = outline[run.vertices]
        wanted = [along[n.edge] + n.fraction * (along[n.edge + 1] - along[n.edge]) for n in said[run.seam.name]]
        found = [notch for notch in made.notches if notch.seam == run.seam.name]
        order = [int(np.argmin([np.linalg.norm(n.position - place) for n in found])) for place in wanted]
        assert sorted(order) == [0, 1, 2]
        for place, k in zip(wanted, order):
            notch, width = found[k], run.seam.spec.left
            assert np.linalg.norm(notch.position - place) <= 1e-9
            assert cut.distance(shapely.Point(notch.foot)) <= 1e-9
            assert notch.foot - notch.position == pytest.approx(-width * notch.inward, abs=1e-9)
            for line in notch.lines:
                assert np.diff(line, axis=0) @ notch.inward == pytest.approx([4.0])
    assert [w for w in made.warnings if w.code == "deep_notch"] == []


def square(depth=4.0, kind="slit", stretches=None, nodes=False, also=None):
    spec = SeamSpec(3.0, 3.0, notches=NotchSpec(kind=kind, depth=depth, nodes=nodes))
    notches = (SeamNotch(0, 0.25, 25.0),)
    seams = {
        f"seam_{i}": Seam(f"seam_{i}", i + 1, "rim", spec, ("piece",), 100.0, notches,
                          start=f"n{i}", end=f"n{(i + 1) % 4}")
        for i in range(4)
    }  # fmt: skip
    return make_piece(fitted(SQUARE, stretches=stretches), cloth(), seams, also=also)


def test_a_notch_across_the_sew_line_is_a_warning():
    found = [(w.code, w.amount) for w in square(depth=4.0).warnings]
    assert found == [("deep_notch", pytest.approx(1.0))] * 4


@pytest.mark.parametrize("allowance, whose", [(0.0, "'lining' under `also`"), (None, "its curve")])
def test_a_warning_of_a_further_material_says_which_and_what_counts_there(allowance, whose):
    (warning, *_) = square(depth=5.0, also=AlsoSpec("lining", 1, 0, allowance)).warnings
    assert "across the sew line into the piece of 'lining'." in warning.message
    assert f"Give {whose} a larger `allowance`" in warning.remedy


@pytest.mark.parametrize("kind, lines, width", [("slit", 1, 0), ("T", 2, 4), ("V", 1, 4), ("castle", 1, 4)])
def test_kinds_differ_in_their_strokes(kind, lines, width):
    notch = square(depth=2.0, kind=kind).notches[0]
    assert len(notch.lines) == lines
    points = np.concatenate(notch.lines)
    assert np.ptp(points, axis=0) == pytest.approx([width, 2.0])
    assert points[:, 1].min() == pytest.approx(-3.0)  # it begins on the cut line


@pytest.mark.parametrize("kind", ["slit", "T", "V", "castle"])
def test_marks_side_by_side_do_not_touch(kind):
    """Two castles that share a side are cut as one wide castle."""
    notch = Notch("s", np.zeros(2), np.zeros(2), np.array([0.0, 1.0]), kind, 4.0, 3)
    marks = np.array_split(np.array(notch.lines, dtype=object), 3)
    first, second, third = (shapely.MultiLineString([np.array(line, float) for line in mark]) for mark in marks)
    assert first.distance(second) >= 2.0 and second.distance(third) == pytest.approx(first.distance(second))
    assert notch.feet.mean(axis=0) == pytest.approx(notch.foot)


def test_nodes_have_notches_where_the_outline_runs_straight_on_along_the_curve():
    positions = [tuple(notch.position.round(9)) for notch in square(depth=2.0, nodes=True).notches]
    assert set(positions) == {(25, 0), (100, 25), (75, 100), (0, 75), (0, 0), (100, 0), (100, 100), (0, 100)}


def test_of_named_nodes_only_these_have_notches():
    stretches = tuple(Stretch(f"seam_{i}", i, 1, False) for i in range(4))
    found = {tuple(notch.position.round(9)) for notch in square(2.0, "slit", stretches, ("n0", "n2")).notches}
    assert found - {(25, 0), (100, 25), (75, 100), (0, 75)} == {(0, 0), (100, 100)}


# --- as built

RADIUS = 120.0


def rolled(u, v):
    """A place of the plane rolled onto a cylinder, and the normal there."""
    t = np.asarray(u) / RADIUS
    normals = np.stack([np.sin(t), 0 * t, np.cos(t)], axis=-1)
    return np.stack([RADIUS * np.sin(t), np.asarray(v, float), RADIUS * np.cos(t)], axis=-1), normals


def curve(start, end, points, **rest):
    u, v = np.array(points, float).T
    places, normals = rolled(u, v)
    return {
        "from": start, "to": end, "points": places[1:-1].tolist(), "normals": normals.tolist(), "kind": "spline", **rest
    }  # fmt: skip


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """Two patches on a cylinder that share a wavy curve, one of them on its right."""
    corners = {"a": (0, 0), "b": (90, 0), "c": (180, 0), "d": (180, 110), "e": (100, 110), "f": (0, 110)}
    wave = [(90 + 10 * t + 9 * np.sin(5 * t), 110 * t) for t in np.linspace(0, 1, 9)]
    line = lambda p, q: [np.array(corners[p]) + k / 4 * (np.subtract(corners[q], corners[p])) for k in range(5)]  # noqa: E731
    curves = {f"{p}{q}": curve(p, q, line(p, q)) for p, q in ["ab", "ef", "fa", "bc", "cd", "de"]}
    wave[-1] = corners["e"]
    curves["wave"] = curve("b", "e", wave, notches={"every": 25, "at": ["37%"]}, allowance=12)
    project = {
        "flatnet": 1,
        "name": "roll",
        "edge_length": 12,
        "nodes": {name: rolled(*place)[0].tolist() for name, place in corners.items()},
        "curves": curves,
        "patches": {"left": {"around": ["ab", "wave", "ef", "fa"]}, "right": {"around": ["bc", "cd", "de", "-wave"]}},
        "rest": "openings",
        "materials": {"cloth": {"width": 500, "allowance": 8}},
        "nesting": {"seconds": 1},
    }
    folder = tmp_path_factory.mktemp("roll")
    (folder / "roll.yaml").write_text(yaml.safe_dump(project))
    assert main(["build", str(folder / "roll.yaml"), "-o", str(folder / "out")]) == 0
    return folder / "out"


def drawn_notches(file):
    """First points of the notches' strokes, in the piece's frame."""
    (path,) = [e for e in SVG.parse(str(file), ppi=25.4).elements() if isinstance(e, Path)
               and e.values.get("class") == "notch"]
    return np.array([stroke.split()[0].split(",") for stroke in path.values["d"].split("M")[1:]], float)


def test_both_notches_of_a_pair_lie_at_the_same_arclength(out):
    (wave,) = [seam for seam in read_report(out)["seams"] if seam["curve"] == "wave"]
    assert [round(notch["at_3d_mm"] % 25, 3) for notch in wave["notches"]].count(0.0) == 4
    assert len(wave["notches"]) == 5
    for side, key in zip(wave["sides"], ("at_a_mm", "at_b_mm")):
        _, flat, _ = read_obj(out / "patches" / f"{side['patch']}.obj")
        sew = shapely.LineString(flat[side["vertices"]])
        feet = shapely.points(drawn_notches(out / "pieces" / f"{side['patch']}.svg"))
        measured = np.unique(shapely.line_locate_point(sew, feet).round(2))
        assert shapely.distance(sew, feet) == pytest.approx(12.0, abs=0.3)  # marks side by side stand off the normal
        assert len(measured) == sum(notch["marks"] for notch in wave["notches"])
        for notch in wave["notches"]:
            assert notch[key] == pytest.approx(notch["at_3d_mm"], abs=1e-6)
            assert notch["marks"] == 1 and np.abs(measured - notch[key]).min() <= 0.02


def test_a_notch_beyond_its_curve_is_a_problem_of_the_project(out, tmp_path, capsys):
    project = yaml.safe_load((out.parent / "roll.yaml").read_text())
    project["curves"]["cd"]["notches"] = {"at": [500]}
    (tmp_path / "roll.yaml").write_text(yaml.safe_dump(project))
    assert main(["check", str(tmp_path / "roll.yaml")]) == 2
    assert "curve 'cd': notches: 500 mm is beyond its end, it is 110.0 mm long" in capsys.readouterr().err


def test_a_check_says_that_faces_listed_nowhere_are_open(out, capsys):
    assert main(["check", str(out.parent / "roll.yaml")]) == 0
    assert "3 faces (2 patches, 0 openings and the rest), V - E + F = 2" in capsys.readouterr().out


@pytest.mark.parametrize("key", ["notches", "nicks"])
def test_a_row_of_far_too_many_is_a_problem_of_the_project(out, tmp_path, capsys, key):
    project = yaml.safe_load((out.parent / "roll.yaml").read_text())
    project["curves"]["cd"][key] = 1e-9
    (tmp_path / "roll.yaml").write_text(yaml.safe_dump(project))
    assert main(["check", str(tmp_path / "roll.yaml")]) == 2
    assert f"curve 'cd': {key}: one every 1e-09 mm would be 1.1e+11 along its 110.0 mm" in capsys.readouterr().err
