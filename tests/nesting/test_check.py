"""The checker finds every way in which a layout can be wrong, and nothing in a right one."""

from dataclasses import replace

import pytest
from pieces import LETTER_F, SQUARE, cloth, piece

from flatnet.nesting import Layout, Placement, check_layouts
from flatnet.nesting.check import TOLERANCE

MATERIAL = cloth(width=400.0, length=500.0, gap=5.0)
F = piece(LETTER_F, MATERIAL, name="F", cut=1, mirrored=1)
PATCH = piece(SQUARE, MATERIAL, name="square", cut=1)

PLAIN = Placement(F, 1, False, 0.0, 0.0, 0.0)
MIRRORED = Placement(F, 2, True, 180.0, 380.0, 0.0)  # x 300..380, y 0..100
BOX = Placement(PATCH, 1, False, 0.0, 100.0, 0.0)


def problems(*placements, material=MATERIAL):
    return check_layouts([Layout(material, placements)], [F, PATCH])


def test_a_right_layout_has_no_problem():
    assert problems(PLAIN, MIRRORED, BOX) == []


def test_what_lies_within_the_tolerance_is_right():
    slack = 0.9 * TOLERANCE
    assert problems(replace(PLAIN, x_mm=-slack), MIRRORED, BOX) == []
    assert problems(PLAIN, MIRRORED, replace(BOX, x_mm=85.0 - slack)) == []  # F ends at 80, gap 5
    assert problems(PLAIN, MIRRORED, replace(BOX, y_mm=300.0 + slack)) == []
    no_gap = cloth(width=400.0)
    assert problems(PLAIN, MIRRORED, replace(BOX, x_mm=80.0 - slack), material=no_gap) == []


@pytest.mark.parametrize(
    ("placements", "found"),
    [
        ([PLAIN, BOX], "F copy 2 (mirrored): placed 0 times"),
        ([PLAIN, MIRRORED, BOX, replace(BOX, y_mm=200.0)], "square copy 1: placed 2 times"),
        ([PLAIN, MIRRORED, BOX, replace(BOX, copy=2, y_mm=200.0)], "square copy 2: placed 1 times"),
        ([PLAIN, replace(MIRRORED, mirrored=False, y_mm=100.0), BOX], "F copy 2: placed 1 times"),
        ([PLAIN, MIRRORED, replace(BOX, mirrored=True, y_mm=200.0)], "square copy 1 (mirrored)"),
        ([PLAIN, MIRRORED, replace(BOX, rotation_deg=90.0, x_mm=250.0)], "rotated by 90"),
        ([PLAIN, MIRRORED, replace(BOX, rotation_deg=1e-6)], "rotated by 1e-06"),
        ([PLAIN, MIRRORED, replace(BOX, y_mm=-0.01)], "0.010 mm outside"),
        ([replace(PLAIN, x_mm=-0.01), MIRRORED, BOX], "0.010 mm outside"),
        ([PLAIN, MIRRORED, replace(BOX, y_mm=300.01)], "0.010 mm outside"),
        ([PLAIN, replace(MIRRORED, x_mm=500.01), BOX], "0.010 mm outside"),
        ([PLAIN, MIRRORED, replace(BOX, x_mm=50.0)], "F copy 1 and square copy 1: overlap"),
        ([PLAIN, MIRRORED, replace(BOX, x_mm=80.0 - 0.01)], "overlap"),
        ([PLAIN, MIRRORED, replace(BOX, x_mm=84.99)], "4.990 mm apart instead of 5"),
        ([PLAIN, MIRRORED, replace(BOX, x_mm=80.0)], "0.000 mm apart instead of 5"),
        ([PLAIN, MIRRORED, replace(BOX, x_mm=float("nan"))], "square copy 1: its place is not a number"),
    ],
)
def test_each_violation_is_found(placements, found):
    assert any(found in problem for problem in problems(*placements))


def test_a_piece_inside_another_overlaps_it():
    small = piece(SQUARE / 10.0, MATERIAL, name="small")
    layout = Layout(MATERIAL, (BOX, Placement(small, 1, False, 0.0, 140.0, 40.0)))
    assert any("overlap" in problem for problem in check_layouts([layout], [PATCH, small]))


def test_without_a_gap_a_deep_overlap_and_a_shallow_one_are_found():
    material = cloth(width=400.0)
    for x in (79.99, 10.0):
        assert any("overlap" in p for p in problems(PLAIN, MIRRORED, replace(BOX, x_mm=x), material=material))


def test_the_copies_are_counted_over_all_sheets():
    sheets = [Layout(MATERIAL, (PLAIN, MIRRORED)), Layout(MATERIAL, (BOX,), 2)]
    assert check_layouts(sheets, [F, PATCH]) == []
    assert check_layouts([*sheets, sheets[1]], [F, PATCH]) != []


def test_free_rotation_allows_any():
    material = cloth(width=400.0, rotations=None)
    assert problems(PLAIN, MIRRORED, replace(BOX, rotation_deg=33.3, x_mm=200.0), material=material) == []
