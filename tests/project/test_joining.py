"""Drawn curves become a network: what meets, what is moved, what is named."""

import itertools

import numpy as np
import pytest

from flatnet.project.drawings import FileCurve
from flatnet.project.drawings.joining import join_curves


def drawn(name, *points, smooth=False):
    return FileCurve(name, np.array(points, dtype=float), smooth)


def nodes_of(curve):
    return [place for place in curve.places if isinstance(place, str)]


def codes(network):
    return [finding.code for finding in network.findings]


SQUARE = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]


def square_sides(gap=0.0):
    """Four curves; each begins `gap` mm beyond the end of the one before it, along its own direction."""
    sides = []
    for i, (a, b) in enumerate(zip(SQUARE, SQUARE[1:] + SQUARE[:1])):
        a, b = np.array(a, float), np.array(b, float)
        sides.append(drawn(f"side{i}", a + gap * (b - a) / 100, 0.5 * (a + b), b))
    return sides


def test_ends_at_one_place_are_one_node_without_further_word():
    network = join_curves(square_sides(), snap=0.0)
    assert len(network.nodes) == 4 and not network.findings
    ends = [nodes_of(curve) for curve in network.curves.values()]
    assert ends == [["n1", "n2"], ["n2", "n3"], ["n3", "n4"], ["n4", "n1"]]


@pytest.mark.parametrize("gap", [0.01, 0.3])
def test_ends_within_the_tolerance_are_moved_together_and_told(gap):
    network = join_curves(square_sides(gap), snap=0.4)
    assert len(network.nodes) == 4
    assert codes(network) == ["snapped_end"] * 8
    for finding in network.findings:
        assert finding.amount == pytest.approx(gap / 2)  # both move to the middle
    places = np.array(list(network.nodes.values()))
    away = np.linalg.norm(places[:, None] - np.array(SQUARE), axis=2)
    np.testing.assert_allclose(np.sort(away.min(axis=0)), gap / 2)


def test_ends_beyond_the_tolerance_stay_apart_and_are_named():
    network = join_curves(square_sides(0.5), snap=0.4)
    assert len(network.nodes) == 8
    assert codes(network) == ["near_miss"] * 8
    assert all(finding.amount == pytest.approx(0.5) for finding in network.findings)
    assert "curve 'side0' ends at node 'n1'" in network.findings[0].message
    assert "curve 'side3' is 0.5 mm away" in network.findings[0].message


def test_two_nodes_beside_each_other_are_named_too():
    """Two squares drawn side by side, half a millimetre apart: a slit that nobody meant."""
    left, right = square_sides(), [FileCurve(c.name + "b", c.points + [100.5, 0, 0]) for c in square_sides()]
    network = join_curves([*left, *right], snap=0.2)
    assert codes(network) == ["near_miss"] * 2
    assert all(finding.amount == pytest.approx(0.5) for finding in network.findings)
    assert not join_curves([*left, *right], snap=0.01).findings


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_an_end_near_a_curve_divides_it_there(order):
    """Whatever the order in which they are drawn."""
    curves = [
        drawn("bar", (0, 0, 0), (40, 0, 0), (100, 0, 0)),
        drawn("stem", (30, 0.2, 0), (30, 50, 0)),
        drawn("other", (39.9, -0.1, 0), (40, -50, 0)),
    ]
    network = join_curves([curves[i] for i in order], snap=0.3)
    bar = network.curves["bar"]
    assert len(nodes_of(bar)) == 4
    on_bar = [network.nodes[name] for name in nodes_of(bar)[1:3]]
    np.testing.assert_allclose(on_bar, [[30, 0, 0], [40, 0, 0]], atol=1e-12)  # at the vertex, where there is one
    amounts = {f.message.split("'")[1]: f.amount for f in network.findings if f.code == "snapped_end"}
    assert amounts == pytest.approx({"stem": 0.2, "other": np.hypot(0.1, 0.1)})


def test_a_curve_that_ends_on_itself():
    network = join_curves([drawn("six", (0, 100, 0), (0, 0, 0), (50, 0, 0), (50, 40, 0), (0.1, 40, 0))], snap=0.2)
    assert {name: nodes_of(curve) for name, curve in network.curves.items()} == {
        "six-1": ["n1", "n2"], "six-2": ["n2", "n2"],
    }
    np.testing.assert_allclose(network.nodes["n2"], [0, 40, 0], atol=1e-12)


def test_a_curve_that_almost_closes_is_closed():
    turns = np.linspace(0, 2 * np.pi - 0.01, 40)
    ring = FileCurve("ring", np.stack([10 * np.cos(turns), 10 * np.sin(turns), 0 * turns], axis=1))
    network = join_curves([ring], snap=0.2)
    assert network.curves["ring"].closed and nodes_of(network.curves["ring"]) == ["n1", "n1"]
    assert codes(network) == ["snapped_end"] * 2


def cross(gap):
    return [drawn("a", (-50, 0, 0), (50, 0, 0), (60, 1, 0)), drawn("b", (0, -50, gap), (0, 50, gap), (1, 60, gap))]


def test_crossing_curves_are_joined_when_asked():
    network = join_curves(cross(0.2), snap=0.3, join_crossings=True)
    assert [len(nodes_of(curve)) for curve in network.curves.values()] == [3, 3]
    middle = nodes_of(network.curves["a"])[1]
    assert nodes_of(network.curves["b"])[1] == middle
    np.testing.assert_allclose(network.nodes[middle], [0, 0, 0.1], atol=1e-12)
    assert [(f.code, f.amount) for f in network.findings] == [("crossing_curves", pytest.approx(0.2))]


def test_crossing_curves_are_named_and_left_alone_otherwise():
    network = join_curves(cross(0.2), snap=0.3)
    assert [len(nodes_of(curve)) for curve in network.curves.values()] == [2, 2]
    [finding] = network.findings
    assert "'a' and 'b' cross at (0, 0, 0.1)" in finding.message and "join: crossings" in finding.remedy
    assert not join_curves(cross(0.4), snap=0.3).findings


def test_curves_that_cross_at_points_that_both_have_share_a_node():
    grid = [drawn(f"h{y}", *((x, y, 0) for x in range(4))) for y in range(3)]
    grid += [drawn(f"v{x}", *((x, y, 0) for y in range(3))) for x in range(4)]
    network = join_curves(grid, snap=0.0)
    assert len(network.nodes) == 12 and not network.findings


def test_what_ends_inside_a_face_is_left_out_when_asked_and_told():
    tail = drawn("tail", (50, 0, 0), (50, 20, 0))
    beyond = drawn("beyond", (0, 30, 0), (100, 30, 0), (130, 30, 0))
    twig = drawn("twig", (120, 30, 0), (120, 60, 0))
    network = join_curves([*square_sides(), tail, beyond, twig], snap=0.01, join_crossings=True, trim=True)
    assert set(network.curves) == {"side0", "side1", "side2", "side3", "beyond"}
    assert len(nodes_of(network.curves["beyond"])) == 2
    assert len(nodes_of(network.curves["side0"])) == 2  # no node where the tail was
    trimmed = {f.message.split("'")[1]: f for f in network.findings if f.code == "trimmed_end"}
    assert set(trimmed) == {"tail", "beyond", "twig"}
    assert trimmed["tail"].amount == pytest.approx(20)
    assert "the nearest curve is 'beyond', gap 10 mm" in trimmed["tail"].message


def test_lines_that_follow_each_other_are_one_curve_up_to_their_corners():
    """The sides of a square and a ring, each in single lines, shuffled and turned at random."""
    t = np.linspace(0, 1, 6)
    corners = np.array(SQUARE, float)
    path = [a + s * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0)) for s in t[:-1]]
    turns = np.linspace(0, 2 * np.pi, 31)[:-1]
    ring = np.stack([10 * np.cos(turns) + 50, 10 * np.sin(turns) + 50, 0 * turns], axis=1)
    lines = [(a, b) for loop in (path, list(ring)) for a, b in zip(loop, loop[1:] + loop[:1])]
    random = np.random.default_rng(3)
    lines = [lines[i] if random.integers(2) else lines[i][::-1] for i in random.permutation(len(lines))]
    network = join_curves([drawn("", *line) for line in lines], snap=0.0)
    assert sorted(len(curve.places) for curve in network.curves.values()) == [6, 6, 6, 6, 30]
    [closed] = [curve for curve in network.curves.values() if curve.closed]
    assert len(closed.places) == 30 and len(network.nodes) == 4


def test_names_are_made_fit_and_unique():
    names = ["left side", "", "c1", "hem", "hem", "hem-1", "Ärmel/2", ""]
    lines = [drawn(name, (0, 9 * i, 0), (1, 9 * i, 0), (2, 9 * i, 1)) for i, name in enumerate(names)]
    assert list(join_curves(lines, snap=0.0, prefix="net_").curves) == [
        "net_left_side", "net_c2", "net_c1", "net_hem-1", "net_hem-2", "net_hem_1", "net_Ärmel_2", "net_c3",
    ]
