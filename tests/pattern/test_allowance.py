"""The cut line at its distance from the sew line, with allowances that differ from edge to edge, and at corners."""

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob

from flatnet.pattern.allowance import MITRE_LIMIT, Corner, cut_line
from flatnet.project.seam_specs import Ends

#: mm; what the cut line has to keep.
EXACT = 1e-6
#: A trapezium, 100 mm below and 60 mm above; its lower corners turn by 108 degrees, the upper ones by 72.
TRAPEZIUM = np.array([[0, 0], [100, 0], [80, 60], [20, 60]], float)


def cut(outline, widths, corners=None):
    outline = np.array(outline, float)
    return cut_line(outline, shapely.Polygon(outline), np.broadcast_to(widths, len(outline)).astype(float), corners)


def finely(outline, length=7.0):
    """The outline with its edges divided, and for each new edge the number of the old one."""
    parts, owner = [], []
    for edge, (p, q) in enumerate(zip(outline, np.roll(outline, -1, axis=0))):
        count = int(np.ceil(np.linalg.norm(q - p) / length))
        parts.append(p + np.arange(count)[:, None] / count * (q - p))
        owner += [edge] * count
    return np.concatenate(parts), np.array(owner)


def feet(points, outline):
    """Place of the foot of every point on every edge's line, 0 to 1 on the edge, and distance out of it, (p, n)."""
    edges = np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(edges, axis=1)
    offset = points[:, None] - outline
    along = np.einsum("pnd,nd->pn", offset, edges) / lengths**2
    out = (offset[..., 0] * edges[:, 1] - offset[..., 1] * edges[:, 0]) / lengths
    return along, out


def along_cut_line(line, spacing=0.9):
    ring = shapely.LinearRing(line)
    return shapely.get_coordinates(shapely.line_interpolate_point(ring, np.arange(0.0, ring.length, spacing)))


def at_corners(points, outline, widths):
    """Whether a point lies beyond both edges of a vertex within the mitre's reach, or on the end of a strip."""
    along, _ = feet(points, outline)
    wide = np.maximum(widths, np.roll(widths, 1))
    away = np.linalg.norm(points[:, None] - outline, axis=2)
    lengths = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    beyond = (np.roll(along, 1, axis=1) - 1.0) * np.roll(lengths, 1) >= -EXACT
    before = along * lengths <= EXACT
    step = np.abs(np.roll(along, 1, axis=1) - 1.0) * np.roll(lengths, 1) <= EXACT
    step |= np.abs(along) * lengths <= EXACT
    near = away <= 1.2 * MITRE_LIMIT * wide + EXACT  # the mitre is cut off square, its ends lie a little farther
    return (near & (beyond & before | step)).any(axis=1)


def check_distances(outline, widths, line):
    points = along_cut_line(line)
    along, out = feet(points, outline)
    on_edge = (along >= 0.0) & (along <= 1.0)
    exact = (on_edge & (np.abs(out - widths) <= EXACT)).any(axis=1)
    corner = at_corners(points, outline, widths)
    assert (exact | corner).all()
    assert exact.mean() > 0.7  # the corners are the exception
    ends = EXACT / np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    inside_a_strip = (along > ends) & (along < 1.0 - ends) & (out > EXACT) & (out < widths - EXACT)
    assert not inside_a_strip.any()
    assert shapely.Polygon(line).buffer(EXACT).covers(shapely.Polygon(outline))


def curves_of(seed, n):
    """Widths as a project has them: constant along a few runs of edges, some of them 0."""
    random = np.random.default_rng(seed)
    ends = np.sort(random.choice(n, 5, replace=False))
    choices = random.choice([0.0, 3.0, 6.0, 10.0, 18.0], 5)
    return choices[np.searchsorted(ends, np.arange(n), side="right") % 5]


@pytest.mark.parametrize("seed", range(8))
def test_every_point_off_the_corners_is_the_allowance_away(seed):
    outline = blob(seed, 400.0, 220.0, 90)
    widths = curves_of(seed, len(outline))
    if widths.any():
        made = cut(outline, widths)
        check_distances(outline, widths, made.outline)
        assert made.crowded == ()


@pytest.mark.parametrize("seed", range(8))
def test_on_star_shapes_with_sharp_corners_too(seed):
    random = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    star = random.uniform(70, 150, 14)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    outline, owner = finely(star)
    widths = random.choice([0.0, 4.0, 8.0], len(star))[owner]
    check_distances(outline, widths, cut(outline, widths).outline)


def test_a_constant_allowance_round_a_convex_outline_has_the_area_of_steiner():
    # Area of a mitred offset: A + P a + a^2 times the sum of tan(turn / 2).
    made = cut(TRAPEZIUM, 5.0)
    edges = np.roll(TRAPEZIUM, -1, axis=0) - TRAPEZIUM
    turns = np.arctan2(*edges.T[::-1])
    turns = (np.roll(turns, -1) - turns) % (2 * np.pi)
    perimeter = np.linalg.norm(edges, axis=1).sum()
    expected = 4800.0 + 5.0 * perimeter + 25.0 * np.tan(turns / 2).sum()
    assert shapely.Polygon(made.outline).area == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("scale", [1.0, 0.02])
def test_a_plain_outline_gains_no_vertices(scale):
    outline = scale * blob(3)
    assert len(cut(outline, 10.0 * scale).outline) == len(outline)


def test_where_it_crosses_itself_it_is_the_union_of_what_it_is_made_of():
    # Both ways to the cut line agree where both can be taken: a deep bay whose parallels do not meet.
    bay = np.array([[0, 0], [100, 0], [100, 40], [30, 40], [30, 60], [100, 60], [100, 100], [0, 100]], float)
    plain = cut(bay, 4.0)
    repaired = cut(finely(bay, 2.0)[0], 4.0)  # edges in the inner corners vanish
    assert len(plain.outline) == len(bay) and plain.crowded == repaired.crowded == ()
    assert shapely.Polygon(plain.outline).symmetric_difference(shapely.Polygon(repaired.outline)).area < 1e-9


def test_a_notch_narrower_than_its_allowances_is_closed_and_said():
    notch, owner = finely([[0, 0], [100, 0], [100, 47], [40, 50], [100, 53], [100, 100], [0, 100]])
    made = cut(notch, 5.0)
    assert shapely.Polygon(made.outline).is_valid
    ((first, count),) = made.crowded
    crowded = np.unique(owner[np.arange(first, first + count) % len(notch)])
    assert crowded.tolist() == [2, 3]
    assert cut(notch, 0.05).crowded == ()  # with room at its mouth only the tip is lost


def test_an_allowance_that_would_reach_into_the_piece_across_a_slit_leaves_the_piece_whole():
    slot = np.array([[0, 0], [50, 0], [50, 60], [52, 60], [52, 0], [100, 0], [100, 100], [0, 100]], float)
    made = cut(slot, [5, 5, 5, 5, 5, 5, 5, 5])
    assert shapely.Polygon(made.outline).area == pytest.approx(110.0**2, rel=1e-9)
    assert made.crowded == ((1, 3),)


def test_a_mitre_is_cut_off_at_the_length_that_is_asked_for():
    tip = np.array([[0, 0], [100, 10], [0, 20]], float)
    outline = finely(tip)[0]
    for length, reach in ((None, MITRE_LIMIT * 4.0), (9.0, 9.0)):
        made = cut(tip, 4.0, {1: Corner(Ends("mitre", length))})
        assert made.outline[:, 0].max() - 100.0 == pytest.approx(reach, abs=1e-9)
        check_distances(outline, np.full(len(outline), 4.0), made.outline)


def test_a_bevel_runs_from_the_end_of_one_allowance_to_that_of_the_other():
    made = cut(SQUARE, [10, 6, 10, 10], {1: Corner(Ends("bevel"))})
    found = {tuple(point) for point in made.outline.round(9)}
    assert {(100.0, -10.0), (106.0, 0.0)} <= found


@pytest.mark.parametrize("edge, corner", [(0, 0), (0, 1), (2, 2), (2, 3)])
@pytest.mark.parametrize("step", [200.0, 3.0])
def test_a_mirrored_end_lies_on_the_neighbours_cut_line_when_it_is_folded_over(edge, corner, step):
    outline, owner = finely(TRAPEZIUM, step)
    widths = np.where(owner == edge, 20.0, 8.0)
    vertex = int(np.argmin(np.linalg.norm(outline - TRAPEZIUM[corner], axis=1)))
    side = "before" if corner == (edge + 1) % 4 else "after"
    made = cut(outline, widths, {vertex: Corner(Ends("mirrored"), side)})
    height = TRAPEZIUM[edge, 1]
    whole = shapely.Polygon(made.outline)
    up, down = shapely.box(-99, height, 199, height + 20), shapely.box(-99, height - 20, 199, height)
    fold, rest = (down, up) if edge == 0 else (up, down)
    folded = shapely.transform(whole.intersection(fold), lambda p: p * [1, -1] + [0, 2 * height])
    near = shapely.Point(TRAPEZIUM[corner]).buffer(30.0)
    kept = whole.intersection(rest)
    assert folded.intersection(near).symmetric_difference(kept.intersection(near)).area < 1e-6


@pytest.mark.parametrize("step", [200.0, 3.0])
def test_a_square_end_stands_at_a_right_angle_where_the_neighbours_cut_line_comes_in(step):
    outline, owner = finely(TRAPEZIUM, step)
    vertex = int(np.argmin(np.linalg.norm(outline - TRAPEZIUM[1], axis=1)))
    made = cut(outline, np.where(owner == 0, 20.0, 8.0), {vertex: Corner(Ends("square"), "before")})
    x = 100.0 + 8.0 / np.sin(np.arctan2(60.0, 20.0))
    found = {tuple(point) for point in made.outline.round(6)}
    assert {(round(x, 6), 0.0), (round(x, 6), -20.0)} <= found


def test_an_end_is_not_folded_where_there_is_no_allowance_to_fold_nor_at_a_flat_or_inner_corner():
    for outline, vertex in ((SQUARE, 1), (LETTER_F, 2)):
        plain = cut(outline, np.where(np.arange(len(outline)) == vertex - 1, 0.0, 5.0))
        asked = cut(
            outline,
            np.where(np.arange(len(outline)) == vertex - 1, 0.0, 5.0),
            {vertex: Corner(Ends("mirrored"), "before")},
        )
        assert np.array_equal(plain.outline, asked.outline)


@pytest.mark.parametrize("widths", [[10, 5, 0, 0, 0], [5, 10, 0, 0, 0], [10, 0, 5, 5, 5]])
def test_at_a_flat_inner_corner_the_wider_allowance_ends_above_the_other(widths):
    inner = np.array([[0, 0], [100, 0], [170, -70], [170, 100], [0, 100]], float)
    made = cut(inner, widths)
    check_distances(inner, np.array(widths, float), made.outline)


@pytest.mark.parametrize("first", [0, 25, 540])
def test_wild_outlines_are_covered_whole_and_reached_no_farther_than_the_mitre(first):
    for seed in range(first, first + 25):
        random = np.random.default_rng(seed)
        count = int(random.integers(3, 40))
        angle, radius = np.sort(random.uniform(0, 2 * np.pi, count)), random.uniform(20, 150, count)
        outline = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        region = shapely.Polygon(outline)
        if not region.is_valid or not region.exterior.is_ccw:
            continue
        widths = random.choice([0.0, 3.0, 10.0, 25.0], count)
        kinds, sides = ["mitre", "bevel", "mirrored", "square"], ["before", "after"]
        chosen = random.choice(count, count // 2, replace=False) if seed % 2 else []
        corners = {int(v): Corner(Ends(random.choice(kinds)), random.choice(sides)) for v in chosen}
        made = cut(outline, widths, corners)
        whole = shapely.Polygon(made.outline, made.holes)
        assert whole.is_valid, seed
        assert region.difference(whole).area < 1e-4, seed
        assert shapely.distance(shapely.points(made.outline), region).max() <= 1.2 * MITRE_LIMIT * 25.0, seed
