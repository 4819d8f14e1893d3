"""Pieces: cut lines at their distance, labels and grain inside, outlines that can't be cut."""

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob, cloth, fitted, piece

from flatnet.failure import PatchFailure
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.allowance import MITRE_LIMIT
from flatnet.pattern.seams import Seam
from flatnet.project.seam_specs import Ends, SeamSpec

#: Round-off of GEOS over outlines of 100 to 1000 mm.
ROUND_OFF = 1e-9


def middles(outline):
    return shapely.points(0.5 * (outline + np.roll(outline, -1, axis=0)))


def test_the_sew_line_is_the_flat_outline_untouched():
    assert np.array_equal(piece(LETTER_F, cloth(allowance=10.0)).sew_line, fitted(LETTER_F).outline)


@pytest.mark.parametrize("allowance", [1.0, 7.5, 9.9])
def test_straight_parts_of_the_cut_line_are_the_allowance_away(allowance):
    made = piece(LETTER_F, cloth(allowance=allowance))
    distance = shapely.distance(middles(made.cut_line), shapely.LinearRing(made.sew_line))
    assert len(made.cut_line) == len(LETTER_F)
    np.testing.assert_allclose(distance, allowance, atol=ROUND_OFF)


def test_convex_corners_are_mitred():
    made = piece(SQUARE, cloth(allowance=10.0))
    assert made.area == pytest.approx(120.0**2, rel=1e-12)


def test_a_sharp_corner_is_capped_at_the_mitre_limit():
    # The tip's half angle is atan(2.5 / 100): uncapped, the mitre would reach 40 allowances out.
    made = piece([[0, 0], [100, 2.5], [0, 5]], cloth(allowance=4.0))
    reach = made.cut_line[:, 0].max() - 100.0
    assert 4.0 <= reach <= MITRE_LIMIT * 4.0 + ROUND_OFF


@pytest.mark.parametrize("seed", range(5))
def test_on_curves_the_cut_line_keeps_its_distance(seed):
    made = piece(blob(seed), cloth(width=2000.0, allowance=10.0))
    assert made.region.is_valid and made.region.contains(shapely.Polygon(made.sew_line))
    distance = shapely.distance(middles(made.cut_line), shapely.LinearRing(made.sew_line))
    np.testing.assert_allclose(distance, 10.0, atol=ROUND_OFF)
    assert shapely.is_ccw(shapely.LinearRing(made.cut_line))


def seam(number, **spec):
    return Seam(f"seam_{number}", number + 1, f"curve_{number}", SeamSpec(**spec), ("piece",), 100.0)


def test_the_more_special_allowance_wins():
    # Of a square from (0, 0) to (100, 100): a side of a seam, the patch, and the seam of the other side.
    seams = {f"seam_{i}": seam(i) for i in range(4)}
    seams["seam_0"] = seam(0, left=30.0, right=1.0)
    seams["seam_2"] = seam(2, right=20.0)

    def bounds(**rest):
        return make_piece(fitted(SQUARE, **rest), cloth(allowance=5.0), seams).region.bounds

    assert bounds() == pytest.approx((-5, -30, 105, 105))
    assert bounds(allowance=7.0) == pytest.approx((-7, -30, 107, 107))
    stretches = tuple(Stretch(f"seam_{i}", i, 1, i == 2) for i in range(4))
    assert bounds(stretches=stretches) == pytest.approx((-5, -30, 105, 120))


def test_the_wider_allowance_decides_how_both_end():
    seams = {f"seam_{i}": seam(i) for i in range(4)}
    seams["seam_0"] = seam(0, left=30.0, ends=Ends("bevel"))
    seams["seam_1"] = seam(1, left=10.0, ends=Ends("mitre", 12.0))
    found = make_piece(fitted(SQUARE), cloth(), seams).cut_line.round(9).tolist()
    assert [100.0, -30.0] in found and [110.0, 0.0] in found  # a bevel, as the wider one wants


def test_an_allowance_without_room_is_a_warning_that_says_where():
    slot = [[0, 0], [50, 0], [50, 60], [52, 60], [52, 0], [100, 0], [100, 100], [0, 100]]
    (warning,) = piece(slot, cloth(allowance=5.0)).warnings
    assert (warning.code, warning.amount) == ("crowded_allowance", pytest.approx(122.0))
    assert "'seam_1' at 0.0 mm" in warning.where


def test_without_allowance_the_cut_line_is_the_sew_line():
    made = piece(LETTER_F)
    assert np.array_equal(made.cut_line, made.sew_line)


def test_a_closed_slit_is_cut_once_and_takes_nothing_from_the_piece():
    slit = [[0, 0], [100, 0], [100, 50], [40, 50], [100, 50], [100, 100], [0, 100]]
    made = piece(slit)
    assert made.area == pytest.approx(1e4, rel=1e-12)
    assert piece(slit, cloth(allowance=5.0)).area == pytest.approx(110.0**2, rel=1e-12)


def test_a_ring_that_lies_closed_keeps_its_hole():
    outer, inner = SQUARE, 0.4 * SQUARE + 30.0
    ring = np.concatenate([outer, outer[:1], inner[[0, 3, 2, 1, 0]]])
    assert piece(ring).area == pytest.approx(100.0**2 - 40.0**2, rel=1e-12)
    made = piece(ring, cloth(allowance=5.0))
    assert made.area == pytest.approx(110.0**2 - 30.0**2, rel=1e-12)
    (hole,) = made.holes
    assert not shapely.is_ccw(shapely.LinearRing(hole))
    filled = piece(ring, cloth(allowance=25.0))  # the allowance fills the hole
    assert filled.holes == () and filled.area == pytest.approx(150.0**2, rel=1e-12)


def test_a_slit_whose_sides_cross_by_round_off_is_still_closed():
    hair = 1e-10
    slit = [[0, 0], [100, 0], [100, 50 + hair], [70, 50 - hair], [40, 50], [70, 50 + hair], [100, 50 - hair]]
    assert piece([*slit, [100, 100], [0, 100]]).area == pytest.approx(1e4, rel=1e-9)


@pytest.mark.parametrize(
    "outline",
    [
        [[0, 0], [100, 0], [100, 60], [40, 50], [100, 40], [100, 100], [0, 100]],  # a slit's sides overlap
        [[0, 0], [100, 100], [100, 0], [0, 100]],  # a bow tie
    ],
)
def test_a_piece_that_overlaps_itself_is_a_failure(outline):
    with pytest.raises(PatchFailure) as caught:
        piece(outline, name="dart")
    assert caught.value.finding.code == "self_intersection"
    assert caught.value.finding.patch == "dart"


def test_seams_are_runs_of_sew_line_vertices_in_the_seams_direction():
    stretches = (Stretch("front", 3, 2, False), Stretch("side", 1, 2, True))
    front, side = piece(SQUARE, stretches=stretches).seams
    assert front.vertices.tolist() == [3, 0, 1]
    assert side.vertices.tolist() == [3, 2, 1]


@pytest.mark.parametrize("outline", [LETTER_F, LETTER_F / 3.0, blob(1), blob(2, 90.0, 40.0)])
def test_labels_and_grain_lie_inside_and_clear_of_each_other(outline):
    stretches = tuple(Stretch(f"side:knee..hem_{i}", i, 5, False) for i in range(0, len(outline), 5))
    made = piece(outline, stretches=stretches, cut=2, mirrored=2)
    boxes = [made.label.box, *(seam.label.box for seam in made.seams if seam.label)]
    inside = shapely.Polygon(outline).buffer(ROUND_OFF)
    assert all(inside.covers(box) for box in boxes)
    shapes = [*boxes, shapely.LineString(made.grain)]
    for i, shape in enumerate(shapes):
        assert all(shape.intersection(other).area + shape.intersection(other).length < 1e-6
                   for other in shapes[:i])


def test_no_label_covers_a_slit_that_lies_closed():
    """It is no part of the rim of what is inside, yet it is drawn."""
    slit = np.array([[0, 0], [100, 0], [100, 50], [20, 50], [100, 50], [100, 100], [0, 100]], float)
    made = piece(slit)
    boxes = [made.label.box, *(seam.label.box for seam in made.seams if seam.label)]
    lines = shapely.LineString(slit[2:5])
    assert not any(lines.intersects(shape) for shape in [*boxes, shapely.LineString(made.grain)])


@pytest.mark.parametrize("name", ["p", "p0", "a_long_name"])
@pytest.mark.parametrize("size", [0.5, 5.0, 6.0])
def test_a_piece_with_hardly_any_room_for_its_label_is_made(size, name):
    assert piece(0.01 * size * SQUARE, name=name).cut == 1


def test_seam_labels_read_along_their_seam_next_to_it():
    for run in piece(SQUARE, name="s").seams:
        start, end = SQUARE[run.vertices[0]], SQUARE[run.vertices[-1]]
        np.testing.assert_allclose(run.label.direction, (end - start) / 100.0, atol=1e-12)
        distance = shapely.LineString([start, end]).distance(shapely.Point(run.label.position))
        assert distance == pytest.approx(run.label.height, abs=1e-9)


def test_a_name_that_fits_nowhere_along_a_short_seam_is_left_out():
    labels = [run.label for run in piece(SQUARE / 100.0).seams]
    assert labels == [None] * 4


def test_the_grain_arrow_runs_along_plus_x_inside_the_piece_and_only_where_there_is_grain():
    made = piece(LETTER_F)
    tail, head = made.grain
    assert tail[1] == head[1] and head[0] > tail[0]
    assert shapely.Polygon(LETTER_F).contains(shapely.LineString(made.grain))
    assert piece(LETTER_F, grain=None).grain is None


def test_the_label_says_what_to_cut_from_what():
    label = piece(SQUARE, name="yoke", cut=2, mirrored=1).label
    assert label.lines == ("yoke", "cut 2 + 1 mirrored", "cloth")


@pytest.mark.parametrize("size, count", [((9, 9), 3), ((8, 7), 2), ((8, 4), 1)])  # a line takes 2.6 mm
def test_on_a_small_piece_it_says_less_rather_than_what_none_can_read(size, count):
    label = piece(SQUARE * size / 100, name="yoke").label
    lines = ("yoke", "cut 1", "cloth")[:count]
    assert label.lines == lines and label.height >= 2.0
    assert piece(SQUARE / 100.0, name="yoke").label.height < 1.0  # the name alone is always there
