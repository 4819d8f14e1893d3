"""Curves sewn to other curves: their ease, their notches at the same parts of both, and the walk along them."""

import numpy as np
import pytest
import yaml
from written import read_report

from flatnet.build import check
from flatnet.cli import main
from flatnet.pattern.seams import plan_seams
from flatnet.project import ProjectError

UP = [0, 0, 1]
ARM = {"p": [0, 0, 0], "q": [60, 0, 0], "r": [100, 0, 0], "s": [100, -40, 0], "t": [0, -40, 0]}
CAP = {"u": [100, 300, 0], "v": [0, 300, 0], "w": [0, 360, 0], "x": [100, 360, 0]}


def straight(start, end, **rest):
    return {"from": start, "to": end, "normals": UP, **rest}


def sleeve(front=None, back=None, cap=None):
    """Two patches in a plane: one with the armhole p to q to r, 100 mm, one with a wavy cap from u to v."""
    x = np.linspace(100.0, 0.0, 21)
    wave = np.column_stack([x, 300.0 - 12.0 * np.sin(np.pi * x / 100.0), np.zeros(21)])
    return {
        "flatnet": 1,
        "name": "sleeve",
        "edge_length": 10,
        "nodes": ARM | CAP,
        "curves": {
            "front": straight("p", "q", **(front or {})),
            "back": straight("r", "q", **(back or {})),
            **{a + b: straight(a, b) for a, b in ("sr", "ts", "pt", "vw", "wx", "xu")},
            "cap": straight("u", "v", points=wave[1:-1].tolist(), **(cap or {})),
        },
        "patches": {
            "body": {"around": ["ts", "sr", "back", "-front", "pt"]},
            "arm": {"around": ["-cap", "-xu", "-wx", "-vw"]},
        },
        "rest": "openings",
        "materials": {"cloth": {"width": 500, "allowance": 8}},
        "nesting": {"seconds": 1},
    }


def seams_of(tmp_path, project):
    (tmp_path / "sleeve.yaml").write_text(yaml.safe_dump(project))
    read, network = check(tmp_path / "sleeve.yaml")
    return plan_seams(read, network), network


#: From u to v the cap meets the armhole from r to p.
ONTO = ["back", "-front"]


@pytest.mark.parametrize("on_cap", [True, False])
def test_notches_are_carried_to_the_same_part_of_the_other_side(tmp_path, on_cap):
    if on_cap:
        project = sleeve(cap={"notches": {"at": ["20%", "75%"], "marks": 2}, "sewn_to": ONTO})
        parts = [0.2, 0.75]
    else:  # the armhole's seam between front and back, at 40 of 100 mm, is met by a notch of its own
        project = sleeve(front={"notches": {"at": [15], "kind": "T"}}, cap={"sewn_to": {"curves": ONTO}})
        parts = [0.4, 0.85]
    seams, network = seams_of(tmp_path, project)
    cap = network.stretches["cap"].length
    assert [notch.arclength for notch in seams["cap"].notches] == pytest.approx([part * cap for part in parts])
    (joined,) = seams["cap"].joins
    assert seams["front"].joins == seams["back"].joins == seams["cap"].joins
    along = {"back": lambda mm: mm, "front": lambda mm: 40.0 + 60.0 - mm}
    assert [along[plain.seam](plain.notch.arclength) for _, plain in joined.matches] == pytest.approx(
        [100 * part for part in parts]
    )
    if on_cap:
        assert [n.arclength for n in seams["back"].notches] == pytest.approx([20])
        assert [n.arclength for n in seams["front"].notches] == pytest.approx([25])  # from p
        assert [n.marks for n in (*seams["back"].notches, *seams["front"].notches)] == [2, 2]
    else:
        assert seams["cap"].spec.notches.kind == "T"
        assert seams["back"].notches == ()


@pytest.mark.parametrize("ease, off", [({}, True), ({"ease": "3.5%"}, False), ({"ease": 3.5}, False)])
def test_the_walk_compares_the_ease_with_what_is_declared(tmp_path, capsys, ease, off):
    project = sleeve(front={"notches": {"at": [15]}}, cap={"sewn_to": {"curves": ONTO, **ease}})
    (tmp_path / "sleeve.yaml").write_text(yaml.safe_dump(project))
    assert main(["check", str(tmp_path / "sleeve.yaml")]) == 0
    assert "mm on back + front 100.0 mm, ease 3.5 mm (3.5 %), declared" in capsys.readouterr().out
    assert main(["build", str(tmp_path / "sleeve.yaml"), "-o", str(tmp_path / "out")]) == 0
    (walk,) = [walk for walk in read_report(tmp_path / "out")["seam_walk"] if walk["a"] == "cap"]
    x = np.linspace(0.0, 100.0, 21)
    cap = np.hypot(np.diff(x), np.diff(12.0 * np.sin(np.pi * x / 100.0))).sum()
    assert (walk["b"], walk["length_b_mm"]) == ("back + front", pytest.approx(100.0))
    assert walk["ease_mm"] == pytest.approx(cap - 100.0, abs=1e-6)
    assert [leg["b_mm"] for leg in walk["legs"]] == pytest.approx([40, 45, 15], abs=1e-6)
    assert [leg["a_mm"] / leg["b_mm"] for leg in walk["legs"]] == pytest.approx([cap / 100] * 3, rel=1e-6)
    said = capsys.readouterr().out
    assert (len(walk["warnings"]) == 1) == off == ("warning ease_off" in said)
    assert f"seam walk: cap {cap:.1f} mm on back + front 100.0 mm" in said
    drawn = (tmp_path / "out" / "pieces" / "body.svg").read_text()
    assert drawn.count("sewn to cap") == 2


def test_what_can_not_be_sewn_is_a_problem_of_the_project(tmp_path):
    cases = [
        ({"cap": {"sewn_to": "bakc"}}, "there is no curve 'bakc'; did you mean 'back'?"),
        ({"cap": {"sewn_to": "cap"}}, "name another curve"),
        ({"cap": {"sewn_to": ["back", "-back"]}}, "'back' is met twice"),
        ({"cap": {"sewn_to": "back"}, "back": {"sewn_to": "cap"}}, "say it of one of both"),
        ({"cap": {"sewn_to": "back", "notches": 9}, "back": {"notches": 9}}, "'back' has notches too"),
        ({"cap": {"sewn_to": "back", "notches": 9}, "front": {"sewn_to": "back", "notches": 9}}, "notches of 'cap'"),
        ({"cap": {"sewn_to": {"curves": "back", "ease": "950%"}}}, "at most 900%"),
        ({"cap": {"sewn_to": {"ease": "9%"}}}, "'curves' is missing"),
        ({"cap": {"sewn_to": ["back", "--front"]}}, "expected a curve"),
        ({"cap": {"notches": {"nodes": ["u", "q"]}}}, "curve 'cap': notches: nodes: it passes no node 'q'"),
    ]
    for said, message in cases:
        with pytest.raises(ProjectError) as caught:
            seams_of(tmp_path, sleeve(**said))
        assert message in str(caught.value)


def skirt_on_the_fold(hem=None, ruffle=None, side=None, backwards=False):
    """One half of a skirt, 120 mm at the hem and 80 mm high, and a ruffle of 240 mm; a gusset of 80 mm."""
    nodes = {"a": [0, 0, 0], "b": [120, 0, 0], "c": [120, 80, 0], "d": [0, 80, 0]}
    nodes |= {"k": [0, -90, 0], "l": [240, -90, 0], "m": [240, -50, 0], "n": [0, -50, 0]}
    nodes |= {"x": [300, 0, 0], "y": [340, 0, 0], "z": [300, 80, 0]}
    return {
        "flatnet": 1,
        "name": "skirt",
        "edge_length": 10,
        "nodes": nodes,
        "curves": {
            "hem": straight(*("ba" if backwards else "ab"), **(hem or {})),
            "bc": straight("b", "c", **(side or {})),
            **{p + q: straight(p, q) for p, q in ("cd", "da", "kl", "lm", "nk", "xy", "yz", "zx")},
            "ruffle": straight("m", "n", **(ruffle or {})),
        },
        "patches": {
            "skirt": {"around": ["-hem" if backwards else "hem", "bc", "cd", "da"], "fold": "da"},
            "ruffle": {"around": ["kl", "lm", "ruffle", "nk"]},
            "gusset": {"around": ["xy", "yz", "zx"]},
        },
        "rest": "openings",
        "materials": {"cloth": {"width": 500, "allowance": 8}},
        "nesting": {"seconds": 1},
    }


@pytest.mark.parametrize("backwards", [False, True])
def test_what_is_cut_on_the_fold_is_sewn_with_both_halves(tmp_path, capsys, backwards):
    project = skirt_on_the_fold({"notches": {"at": [30]}}, {"sewn_to": "hem"}, {"sewn_to": "zx"}, backwards)
    seams, _ = seams_of(tmp_path, project)
    (joined,) = seams["ruffle"].joins
    assert (joined.eased.length, joined.plain.length) == pytest.approx((240.0, 240.0))
    from_fold = 90.0 if backwards else 30.0
    assert [notch.arclength for notch in seams["ruffle"].notches] == pytest.approx([120 - from_fold, 120 + from_fold])
    (side,) = seams["bc"].joins  # off the fold: once on either half
    assert (side.eased.length, side.plain.length) == pytest.approx((80.0, 80.0))

    (tmp_path / "skirt.yaml").write_text(yaml.safe_dump(project))
    assert main(["build", str(tmp_path / "skirt.yaml"), "-o", str(tmp_path / "out")]) == 0
    walks = {walk["a"]: walk for walk in read_report(tmp_path / "out")["seam_walk"]}
    for name in ("ruffle", "bc"):
        assert walks[name]["ease_mm"] == pytest.approx(0.0, abs=1e-6) and not walks[name]["warnings"]
    legs = [120 - from_fold, 2 * from_fold, 120 - from_fold]
    for side in ("a_mm", "b_mm"):
        assert [leg[side] for leg in walks["ruffle"]["legs"]] == pytest.approx(legs, abs=1e-6)
    assert "ruffle 240.0 mm on hem 240.0 mm" in capsys.readouterr().out


def test_both_notches_of_a_whole_curve_meet_the_one_of_the_half(tmp_path):
    project = skirt_on_the_fold(ruffle={"notches": {"at": ["25%", "75%"]}, "sewn_to": {"curves": "hem", "ease": 3}})
    seams, _ = seams_of(tmp_path, project)
    assert [notch.arclength for notch in seams["hem"].notches] == pytest.approx([60.0])
    (joined,) = seams["hem"].joins
    assert [plain.image for _, plain in joined.matches] == [True, False]
    assert joined.ease == pytest.approx(3.0)
