"""Compaction: what overlaps by a trifle is pushed apart, what is loose is pushed together, and nothing goes through."""

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob

from flatnet.nesting.compaction import TOUCH, Edges, compact, contacts
from flatnet.nesting.layout import turn

#: HiGHS keeps its rows to 1e-7, and a shift has two of them.
SOLVED = 1e-6


def compacted(outlines, width, gap=0.0):
    return [outline + shift for outline, shift in zip(outlines, compact(outlines, width, gap))]


def nearest(outlines):
    """Of all pairs the least distance; where they overlap, less the depth from which shrinking frees them."""
    shrunk = shapely.buffer(shapely.polygons([shapely.linearrings(o) for o in outlines]), -1.0, join_style="mitre")
    first, second = np.triu_indices(len(outlines), 1)
    return float(shapely.distance(shrunk[first], shrunk[second]).min()) - 2.0


def ends(outlines):
    low = np.min([outline.min(axis=0) for outline in outlines], axis=0)
    high = np.max([outline.max(axis=0) for outline in outlines], axis=0)
    return low, high


def grid(columns, rows, pitch):
    return [SQUARE + (i * pitch, j * pitch) for i in range(columns) for j in range(rows)]


@pytest.mark.parametrize("gap", [0.0, 3.0])
def test_loose_squares_end_as_short_as_they_can(gap):
    made = compacted(grid(4, 2, 103.5), 210.0, gap)
    low, high = ends(made)
    assert low[0] == pytest.approx(0.0, abs=SOLVED) and high[0] == pytest.approx(400.0 + 3.0 * gap, abs=SOLVED)
    assert low[1] >= -SOLVED and high[1] <= 210.0 + SOLVED
    assert nearest(made) >= gap - SOLVED


@pytest.mark.parametrize("seed", range(20))
def test_squares_that_fill_the_roll_and_overlap_by_rounding_are_laid_exactly(seed):
    # All corners meet: no direction between two of them says which piece lies on which side.
    random = np.random.default_rng(seed)
    rounding = (seed > 0) * 0.4 * TOUCH
    pushed = [square + random.uniform(-rounding, rounding, 2) for square in grid(4, 4, 100.0)]
    made = compacted([np.roll(square, random.integers(4), axis=0) for square in pushed], 400.0)
    np.testing.assert_allclose(ends(made), [[0.0, 0.0], [400.0, 400.0]], atol=SOLVED)
    assert nearest(made) == pytest.approx(0.0, abs=SOLVED)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("gap", [0.0, 2.0])
def test_whatever_lies_validly_stays_valid_and_gets_no_longer(seed, gap):
    random = np.random.default_rng(seed)
    outlines, taken, width = [], shapely.Polygon(), 700.0
    for _ in range(60):
        outline = [LETTER_F, 2.0 * LETTER_F, blob(seed, 300.0, 120.0), SQUARE][random.integers(4)]
        outline = outline @ turn(random.choice([0.0, 37.0, 180.0]), False).T
        low = outline.min(axis=0)
        placed = outline - low + random.uniform(0.0, [900.0, width - np.ptp(outline[:, 1])])
        if taken.is_empty or shapely.Polygon(placed).distance(taken) > gap:
            outlines.append(placed)
            taken = taken.union(shapely.Polygon(placed))
    made = compacted(outlines, width, gap)
    low, high = ends(made)
    assert nearest(made) >= gap - SOLVED
    assert low[1] >= -SOLVED and high[1] <= width + SOLVED
    before = np.subtract(*ends(outlines)[::-1])[0]
    # Few layouts at random are as short as they can be.
    assert high[0] - low[0] < before


def test_a_tongue_stays_in_its_pocket():
    # A U lies round a tongue, 1 mm away all round: nothing but the 1 mm at the tip can be gained.
    pocket = np.array([[0, 0], [200, 0], [200, 100], [180, 100], [180, 20], [20, 20], [20, 100], [0, 100]], float)
    tongue = np.array([[21, 21], [179, 21], [179, 150], [21, 150]], float)
    lying = [outline @ turn(-90.0, False).T + (0.0, 200.0) for outline in (pocket, tongue)]
    made = compacted(lying, 200.0)
    assert nearest(made) == pytest.approx(0.0, abs=SOLVED)
    assert np.ptp(np.concatenate(made)[:, 0]) == pytest.approx(149.0, abs=SOLVED)
    low, high = (outline[:, 1] for outline in made)
    assert low.min() + 20.0 - SOLVED <= high.min() and high.max() <= low.max() - 20.0 + SOLVED


def test_a_tip_slides_into_a_valley_and_not_through_its_other_side():
    valley = np.array([[0, 0], [100, 0], [80, 50], [100, 100], [0, 100]], float)
    tip = np.array([[80.3, 49.6], [180.0, 30.0], [180.0, 70.0]])
    made = compacted([valley, tip], 500.0)
    first, second = map(shapely.Polygon, made)
    assert first.distance(second) <= SOLVED and first.intersection(second).area <= SOLVED
    assert ends(made)[1][0] == pytest.approx(179.7, abs=SOLVED)


def test_a_spike_beside_a_burr_keeps_the_gap_to_the_burr_and_not_to_the_line_below_it():
    # Along y: an edge at 0, a burr of 0.3 at its end, then a step down to -6, above it a spike with its tip at 0.5;
    # it stands 5 away from the burr, and can go down to -1, 5 above the floor. Both pieces are as wide as the roll.
    below = [[0, -50], [120, -50], [120, -6], [20.1, -6], [20.05, 0.3], [20, 0], [0, 0]]
    spike = [[25.12, 0.5], [27, 60], [120, 60], [120, 80], [0, 80], [0, 60], [25.12, 60]]
    lying = [np.array(outline, float) @ turn(-90.0, False).T + (50.0, 120.0) for outline in (below, spike)]
    made = compacted(lying, 120.0, 5.0)
    assert shapely.distance(*map(shapely.Polygon, made)) == pytest.approx(5.0, abs=SOLVED)
    assert np.ptp(np.concatenate(made)[:, 0]) == pytest.approx(128.5, abs=SOLVED)


def test_a_long_row_that_is_loose_everywhere_closes():
    made = compacted([SQUARE + (105.0 * i, 0.0) for i in range(20)], 500.0)
    assert ends(made)[1][0] == pytest.approx(2000.0, abs=SOLVED)


def test_pieces_whose_corners_meet_slide_along_each_other():
    lower = [SQUARE + (100.0 * i, 0.0) for i in range(3)]
    upper = [SQUARE + (100.0 * i, 100.0) for i in (1, 2, 3)]
    made = compacted([*lower, *upper], 200.0)
    assert ends(made)[1][0] < 390.0
    assert nearest(made) == pytest.approx(0.0, abs=SOLVED)


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 71.0])
@pytest.mark.parametrize("apart", [0.5, 4.0])
def test_the_nearest_contact_of_convex_pieces_is_their_distance(angle, apart):
    other = (SQUARE - 50.0) @ turn(angle, False).T + 50.0
    for direction in np.radians(np.arange(0.0, 360.0, 30.0)):
        moved = other + 300.0 * np.array([np.cos(direction), np.sin(direction)])
        first, second = shapely.Polygon(SQUARE), shapely.Polygon(moved)
        line = np.diff(shapely.get_coordinates(shapely.shortest_line(first, second)), axis=0)[0]
        moved = moved - line * (1.0 - apart / np.hypot(*line))
        found = contacts(Edges.of([SQUARE, moved]), np.zeros((2, 2)), 0.0, 5.0)
        distance = first.distance(shapely.Polygon(moved))
        assert found.rooms.min() == pytest.approx(distance, abs=1e-9)
        # Each is a wall between the two: all of the first lies before it, all of the second behind it.
        for i, j, normal, room in zip(found.first, found.second, found.normals, found.rooms):
            outlines = [SQUARE, moved]
            assert (outlines[i] @ normal).min() - (outlines[j] @ normal).max() == pytest.approx(room, abs=1e-9)


def test_what_can_not_be_laid_side_by_side_is_left_to_the_checker():
    made = compacted([SQUARE, SQUARE + (0.0, 100.0)], 199.9)
    low, high = ends(made)
    assert max(-low[1], high[1] - 199.9, -nearest(made)) > 0.03
