"""Folded darts: legs, cut edge when folded, marks."""

import numpy as np
import pytest
import shapely
from pieces import cloth, fitted, seams_of

from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.project.seam_specs import DartSpec, SeamSpec

#: A skirt panel whose hem (below) slopes; the dart opens at its upper edge, legs of 80 mm, 30 degrees apart.
TIP = np.array([100.0, 60.0])
LEGS = [TIP + 80.0 * np.array([np.sin(a), np.cos(a)]) for a in np.radians([15.0, -15.0])]


def panel(fold, allowance=10.0, slope=0.0, drill=10.0, steps=1, bulge=0.0):
    """Boundary: hem, right, upper right, leg to the tip, leg back, upper left, left; the curve runs to the tip."""
    right, left = [220, LEGS[0][1] + slope], [-20, LEGS[1][1] + slope]
    bend = [np.array([bulge * np.sin(np.pi * k / steps), 0.0]) for k in range(steps)]
    first = [LEGS[0] + k / steps * (TIP - LEGS[0]) + bend[k] for k in range(steps)]
    second = [TIP + k / steps * (LEGS[1] - TIP) - bend[k] for k in range(steps)]
    outline = np.array([[-20, 0], [220, 0], right, *first, *second, LEGS[1], left], float)
    names = ["hem", "right", "top_right", *["dart"] * 2, "top_left", "left"]
    counts = [1, 1, 1, steps, steps, 1, 1]
    firsts = np.cumsum([0, *counts])
    stretches = tuple(
        Stretch(name, int(first), count, bool(i == 4))
        for i, (name, first, count) in enumerate(zip(names, firsts, counts))
    )
    patch = fitted(outline, stretches=stretches, slit_tips=(3 + steps,))
    seams = seams_of(patch)
    spec = SeamSpec(dart=DartSpec(fold, drill) if fold else None)
    seams["dart"] = type(seams["dart"])("dart", 9, "dart", spec, ("piece",), 80.0)
    return make_piece(patch, cloth(allowance=allowance), seams)


def around(centre, degrees):
    t = np.radians(degrees)
    turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    return lambda points: centre + (points - centre) @ turn.T


def sector(start, end, radius=200.0):
    """Between two directions from the tip, degrees from +y to the right."""
    angles = np.radians(np.linspace(start, end, 20))
    return shapely.Polygon([TIP, *(TIP + radius * np.column_stack([np.sin(angles), np.cos(angles)]))])


@pytest.mark.parametrize("fold, sign", [("right", -1.0), ("left", 1.0)])
@pytest.mark.parametrize("slope", [-25.0, 0.0, 20.0])
@pytest.mark.parametrize("steps", [1, 9])
def test_the_cut_edge_is_true_when_the_dart_is_folded(fold, sign, slope, steps):
    """The curve runs down to its tip, so its left is the right of the drawing (+x)."""
    made = panel(fold, slope=slope, steps=steps)
    whole = made.region
    assert whole.is_valid and not made.holes
    assert len(made.cut_line) < 20  # no hairline is left along a leg
    assert whole.length < shapely.convex_hull(whole).length + 40.0
    assert whole.covers(shapely.Polygon([TIP, *LEGS]))
    # Under the piece beside the leg: the near half mirrored in that leg, the far half turned by the dart's angle.
    beside = whole.intersection(sector(sign * 15.0, sign * 30.0))
    far_half = whole.intersection(sector(0.0, -sign * 15.0))
    # A turn about the tip by the dart's angle takes the far leg to the near one.
    laid = shapely.transform(far_half, around(TIP, -sign * 30.0))
    assert laid.symmetric_difference(beside).area < 1e-6 * whole.area
    near_half = whole.intersection(sector(0.0, sign * 15.0))
    direction = np.array([sign * np.sin(np.radians(15.0)), np.cos(np.radians(15.0))])
    mirror = 2.0 * np.outer(direction, direction) - np.eye(2)
    laid = shapely.transform(near_half, lambda p: TIP + (p - TIP) @ mirror.T)
    assert laid.symmetric_difference(beside).area < 1e-6 * whole.area


def test_the_legs_stay_sew_lines_and_the_rest_of_the_cut_line_keeps_its_allowance():
    made, plain = panel("left"), panel(None, allowance=0.0)
    assert np.array_equal(made.sew_line, plain.sew_line)
    left, bottom, right, top = made.region.bounds
    assert (left, bottom, right) == pytest.approx((-30.0, -10.0, 230.0))
    assert top > LEGS[0][1] + 10.0  # the folded mouth stands over its chord
    assert not [w for w in made.warnings if w.code == "crowded_allowance"]
    open_dart = panel(None, allowance=15.0, steps=9)  # legs with allowances have no room for them
    assert [w.code for w in open_dart.warnings] == ["crowded_allowance"]


@pytest.mark.parametrize("fold, side", [("left", 1.0), ("right", -1.0)])
def test_marks_of_a_dart(fold, side):
    made = panel(fold, drill=12.0)
    line, arrow, drill = made.marks
    assert (line.kind, drill.kind) == ("fold", "drill")
    assert drill.points == pytest.approx((TIP + [0.0, 12.0])[None], abs=1e-9)
    assert line.points[:, 0] == pytest.approx([100.0, 100.0])
    tail, head = arrow.points[:2]
    assert np.sign(head[0] - tail[0]) == side
    mouth = [notch for notch in made.notches if notch.seam == "dart"]
    assert len(mouth) == 2
    for notch, leg in zip(mouth, sorted(LEGS, key=lambda leg: -side * leg[0])):
        assert notch.position == pytest.approx(leg, abs=1e-9)
        assert shapely.LinearRing(made.cut_line).distance(shapely.Point(notch.foot)) <= 1e-9


@pytest.mark.parametrize("bulge", [-3.0, 3.0])
def test_curved_legs_are_folded_along_their_chords(bulge):
    straight, curved = panel("left", steps=12), panel("left", steps=12, bulge=bulge)
    assert not np.array_equal(straight.sew_line, curved.sew_line)
    assert curved.region.symmetric_difference(straight.region).area < 1e-3
    assert curved.region.length == pytest.approx(straight.region.length, abs=1e-3)
    assert not curved.warnings


def test_a_dart_that_lies_closed_is_left_as_it_is():
    outline = np.array([[0, 0], [200, 0], [200, 100], [100, 100], [100, 40], [100, 100], [0, 100]], float)
    stretches = tuple(Stretch(name, i, 1, i == 4) for i, name in enumerate(["a", "b", "c", "dart", "dart", "d", "e"]))
    patch = fitted(outline, stretches=stretches, slit_tips=(4,))
    seams = seams_of(patch)
    seams["dart"] = type(seams["dart"])("dart", 9, "dart", SeamSpec(dart=DartSpec("left")), ("piece",), 60.0)
    made = make_piece(patch, cloth(allowance=5.0), seams)
    assert made.area == pytest.approx(210 * 110) and made.marks == ()
