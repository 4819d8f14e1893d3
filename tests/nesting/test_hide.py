"""Hides and sheets: pieces inside, off the defects, in their zones, in one direction where they are to match."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob, cloth, piece

from flatnet.nesting import Layout, Placement, check_layouts, nest, read_stored, write_stored
from flatnet.nesting.check import TOLERANCE
from flatnet.nesting.fill import fill
from flatnet.nesting.frame import SIMPLIFIED, _frame
from flatnet.nesting.hide import lay_on_hide, nest_on_hide
from flatnet.nesting.layout import copies_of
from flatnet.parameters import NestingParameters
from flatnet.project.hides import Hide

QUICK = NestingParameters(seconds=1)


def ring(points):
    return tuple((float(x), float(y)) for x, y in points)


def rectangle(left, bottom, right, top):
    return ring([(left, bottom), (right, bottom), (right, top), (left, top)])


def skin(seed=3, size=700.0):
    """A smooth outline with its box at the origin."""
    outline = blob(seed, length=size, width=0.8 * size)
    return ring(outline - outline.min(axis=0))


DEFECT = rectangle(300.0, 240.0, 340.0, 300.0)
HIDE = Hide(skin(), (DEFECT,), (("A", rectangle(120.0, 150.0, 300.0, 450.0)),))


def leather(*hides, **changes):
    hides = hides or (HIDE,)
    sizes = np.array([hide.size for hide in hides]).max(axis=0)
    usual = {"length": sizes[0], "width": sizes[1], "rotations": None, "gap": 2.0, "hides": hides}
    return cloth(**{**usual, **changes})


def at(made, x, y, rotation=0.0, number=1, mirrored=False):
    return Placement(made, number, mirrored, rotation, x, y)


class TestChecker:
    material = leather(Hide(rectangle(0, 0, 500, 400), (DEFECT,), (("A", rectangle(0, 0, 200, 400)),)))
    square = piece(SQUARE, material)

    def problems(self, made, *placements, **changes):
        material = replace(self.material, **changes)
        return check_layouts([Layout(material, placements)], [made])

    def test_what_lies_right_has_no_problem(self):
        assert self.problems(self.square, at(self.square, 0.0, 0.0)) == []
        # Touching the defect, and the rim within the tolerance.
        assert self.problems(self.square, at(self.square, 200.0, 240.0)) == []
        assert self.problems(self.square, at(self.square, -0.9 * TOLERANCE, 0.0)) == []

    def test_off_the_hide(self):
        (problem,) = self.problems(self.square, at(self.square, -3.0, 0.0))
        assert "piece copy 1: 2.999 mm outside the hide" in problem

    def test_on_a_defect(self):
        (problem,) = self.problems(self.square, at(self.square, 201.0, 200.0))
        assert "covers 59.9 mm^2 of defect 1" in problem  # 1 mm of its 60, less the tolerance

    def test_around_a_defect(self):
        (problem,) = self.problems(self.square, at(self.square, 270.0, 220.0))
        assert "of defect 1" in problem

    def test_outside_its_zone_or_on_no_hide(self):
        made = replace(self.square, zone="A")
        assert self.problems(made, at(made, 100.0, 0.0)) == []
        (problem,) = self.problems(made, at(made, 101.0, 0.0))
        assert "not inside zone 'A'" in problem
        other = replace(self.square, zone="B")
        assert any("not inside zone 'B'" in each for each in self.problems(other, at(other, 0.0, 0.0)))
        assert any("lies on no hide" in each for each in self.problems(made, at(made, 0.0, 0.0), hides=()))

    def test_copies_that_do_not_match(self):
        made = replace(piece(SQUARE, self.material, cut=2), match=True)
        first = at(made, 0.0, 0.0, 0.0)
        assert self.problems(made, first, at(made, 0.0, 200.0, 360.0, 2)) == []
        assert any("turned by 180" in each for each in self.problems(made, first, at(made, 100.0, 300.0, 180.0, 2)))

    def test_more_sheets_than_there_are(self):
        layout = Layout(self.material, (at(self.square, 0.0, 0.0),), 2)
        assert any("sheet 2: material 'cloth' has 1" in each for each in check_layouts([layout], [self.square]))


def test_a_frame_is_what_the_region_is_not():
    region = HIDE.region
    separation = 2.0
    frame = _frame(region, separation)
    assert frame.is_valid and frame.geom_type == "Polygon" and not frame.interiors
    # It keeps its separation to all that pieces may cover, but for the walls and what is simplified.
    assert frame.intersection(shapely.Polygon(HIDE.outline).buffer(separation - 2 * SIMPLIFIED)).area < 60 * 40 + 400.0
    assert frame.covers(shapely.Polygon(DEFECT))
    # As wide as its box, which a mouth at one corner does not change.
    left, bottom, right, top = frame.bounds
    assert bottom < -separation and top > HIDE.size[1] + separation
    free = shapely.box(left, bottom, right, top).difference(frame)
    assert free.covers(region.buffer(-1.0).difference(_wall(region)))


def _wall(region):
    return shapely.LineString(shapely.shortest_line(shapely.Polygon(DEFECT), region.exterior)).buffer(2.0)


def test_pieces_lie_on_the_hide_and_together():
    material = leather()
    pieces = [piece(LETTER_F, material, name="F", cut=4, mirrored=4), piece(0.6 * SQUARE, material, name="box", cut=3)]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and not layout.draft
    assert check_layouts([layout], pieces) == []
    # Half of the pieces' area of room is enough: the engine need not be good for that.
    assert layout.used_length < 0.8 * HIDE.size[0]
    assert layout.utilisation == pytest.approx(sum(p.piece.area for p in layout.placements) / HIDE.area)


def test_what_asks_for_a_zone_lies_there_and_what_is_to_match_in_one_direction():
    material = leather()
    pieces = [
        replace(piece(LETTER_F, material, name="F", cut=2, mirrored=1), zone="A"),
        replace(piece(0.5 * LETTER_F, material, name="f", cut=3, mirrored=3), match=True),
    ]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == ()
    assert check_layouts([layout], pieces) == []
    assert len({p.rotation_deg for p in layout.placements if p.piece.name == "f"}) == 1
    zone = shapely.Polygon(HIDE.zones[0][1]).buffer(TOLERANCE)
    for placement in layout.placements:
        if placement.piece.zone:
            assert zone.covers(shapely.Polygon(placement.place(placement.piece.cut_line)))


def test_hide_after_hide_and_what_is_left_over_is_told():
    small = Hide(rectangle(0, 0, 220, 110))
    useless = Hide(rectangle(0, 0, 90, 90))
    material = leather(small, useless, small, gap=1.0)
    pieces = [piece(SQUARE, material, name="square", cut=6)]
    layouts, (finding,) = nest(pieces, material, QUICK)
    assert [(layout.sheet, len(layout.placements)) for layout in layouts] == [(1, 2), (3, 2)]
    assert (finding.code, finding.patch, finding.amount) == ("out_of_material", "square", 2.0)
    assert "2 of 6 copies have no room on material 'cloth', which has 3 hides" in finding.message
    left = [copy for copy in copies_of(pieces) if copy.number > 4]
    assert Counter(p.copy for layout in layouts for p in layout.placements) == Counter([1, 2, 3, 4])
    assert check_layouts(layouts, pieces, left) == []
    assert check_layouts(layouts, pieces) != []


def test_no_more_sheets_than_there_are():
    material = cloth(width=210.0, length=215.0, gap=2.0, sheets=1)
    layouts, (finding,) = nest([piece(SQUARE, material, cut=6)], material, QUICK)
    assert len(layouts) == 1 and len(layouts[0].placements) == 4
    assert finding.code == "out_of_material" and finding.amount == 2.0


def test_stored_layouts_of_hides_are_used_again(tmp_path):
    material = leather(Hide(rectangle(0, 0, 220, 110)), gap=1.0)
    pieces = [piece(SQUARE, material, cut=3)]
    layouts, findings = nest(pieces, material, QUICK)
    write_stored(tmp_path / "layout.json", layouts)
    stored = read_stored(tmp_path / "layout.json")
    said = []
    again, found = nest(pieces, material, QUICK, stored, said.append)
    assert said == ["cloth: the layout is unchanged"] and found == findings
    assert [p.as_dict() for p in again[0].placements] == [p.as_dict() for p in layouts[0].placements]
    other = leather(Hide(rectangle(0, 0, 220, 110), (rectangle(10, 10, 20, 20),)), gap=1.0)
    said.clear()
    nest(pieces, other, QUICK, stored, said.append)
    assert not any("unchanged" in text for text in said)


def test_the_last_resort_is_valid_and_always_the_same():
    material = leather()
    pieces = [
        replace(piece(LETTER_F, material, name="F", cut=2), zone="A"),
        piece(LETTER_F, material, name="G", cut=2, mirrored=1),
    ]
    first, second = (lay_on_hide(copies_of(pieces), HIDE, material) for _ in range(2))
    assert check_layouts([Layout(material, tuple(first))], pieces) == []
    assert [p.as_dict() for p in first] == [p.as_dict() for p in second]


@pytest.mark.parametrize(
    "hide",
    [
        pytest.param(Hide(rectangle(0, 0, 500, 400)), id="without the zone"),
        pytest.param(Hide(rectangle(0, 0, 500, 400), (rectangle(-1, -1, 501, 401),)), id="one defect"),
        pytest.param(Hide(rectangle(0, 0, 500, 400), (), (("A", rectangle(-9, -9, 0, 0)),)), id="zone at a corner"),
    ],
)
def test_where_a_hide_has_no_place_nothing_is_laid(hide):
    material = leather(hide)
    copies = copies_of([replace(piece(SQUARE, material, cut=2), zone="A")])
    assert lay_on_hide(copies, hide, material) == nest_on_hide(copies, hide, material, QUICK) == []


def test_what_has_room_finds_it():
    # A place of 102 x 102 between two squares: a third one fits, a fourth one nowhere.
    material = cloth(width=104.0, length=306.0, rotations=(0.0,), gap=1.0)
    made = piece(SQUARE, material, cut=4)
    placed = [at(made, 0.0, 1.0), at(made, 204.0, 1.0, number=2)]
    region = shapely.box(0.0, 0.0, 306.0, 104.0)
    (found,) = fill(copies_of([made])[2:], region, placed, material)
    assert 101.0 - TOLERANCE <= found.x_mm <= 103.0 + TOLERANCE
    layout = Layout(material, (*placed, found))
    assert check_layouts([layout], [made], copies_of([made])[3:]) == []


def test_a_rotation_off_the_grain_that_would_fit_is_named():
    material = cloth(width=150.0, length=1000.0)
    strip = np.array([[0, 0], [100, 0], [100, 300], [0, 300]], float)
    layouts, (finding,) = nest([piece(strip, material)], material, QUICK)
    assert layouts == ()
    assert "300.0 mm wide" in finding.message and "150.0 mm" in finding.message
    assert "Turned by 90 degrees against its grain it would fit." in finding.remedy
    hopeless = cloth(width=90.0, length=200.0)
    _, (finding,) = nest([piece(strip, hopeless)], hopeless, QUICK)
    assert "would fit" not in finding.remedy
