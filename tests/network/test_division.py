"""A divided network is the same network with one more seam: no vertex moves, and every patch still closes."""

import numpy as np
import pytest
from drawn import UP, excess, flat, line, network_of, square

from flatnet.network.division import Cut, divide, halves, with_node


def two_squares(folder):
    """Two squares with the curve `wall` between them, and a slit in the left one; seen from above."""
    nodes, curves = square()
    nodes |= {"se2": [80, 0, 0], "ne2": [80, 40, 0], "tip": [20, 20, 0]}
    curves |= {"south2": line("se", "se2"), "east2": line("se2", "ne2"), "north2": line("ne2", "ne"),
               "dart": line("sw", "tip", slit=True)}  # fmt: skip
    curves["wall"] = curves.pop("east")
    return network_of(
        folder,
        nodes=nodes,
        curves=flat(curves),
        patches={
            "left": {"around": ["dart", "-dart", "south", "wall", "north", "west"]},
            "right": {"around": ["south2", "east2", "north2", "-wall"]},
        },
        openings={"outside": {"around": ["-west", "-north", "-north2", "-east2", "-south2", "-south"]}},
    )


def straight_cut(boundary, start, end, count=3):
    vertices = np.linspace(boundary.vertices[start], boundary.vertices[end], count + 1)
    return Cut(start, end, vertices, np.tile([0.0, 0.0, 1.0], (count, 1)))


def vertex_at(patch, place):
    return int(np.argmin(np.linalg.norm(patch.boundary.vertices - place, axis=1)))


def along(network, patch):
    """The vertices of a patch's boundary read from its seams, one after the other."""
    runs = []
    for run in patch.boundary.stretches:
        vertices = network.stretches[run.seam].vertices
        assert len(vertices) == run.count + 1
        runs.append((vertices[::-1] if run.reversed else vertices)[:-1])
    return np.concatenate(runs)


@pytest.fixture
def divided(tmp_path):
    """The left square cut from the middle of its wall to its upper left corner."""
    network = two_squares(tmp_path)
    left = network.patches[0]
    cut = straight_cut(left.boundary, vertex_at(left, [40, 20, 0]), vertex_at(left, [0, 40, 0]))
    return network, left, cut, divide(network, "left", cut, "cut", ("below", "above"), ("a", "b"))


def test_every_boundary_follows_its_seams_to_the_last_bit(divided):
    _, _, _, result = divided
    assert [patch.name for patch in result.patches] == ["below", "above", "right"]
    for patch in result.patches:
        first = patch.boundary.stretches[0].first
        np.testing.assert_array_equal(np.roll(patch.boundary.vertices, -first, axis=0), along(result, patch))
        assert sum(run.count for run in patch.boundary.stretches) == len(patch.boundary.vertices)


def test_a_new_node_parts_the_seam_for_both_its_patches_and_an_old_one_is_used(divided):
    before, _, _, result = divided
    assert set(result.nodes) - set(before.nodes) == {"a"}
    seam = result.stretches["cut"]
    assert (seam.start, seam.end) == ("a", "nw")
    right = result.patches[-1]
    assert [(s.seam, s.reversed) for s in right.boundary.stretches][-2:] == [("wall:a..ne", True), ("wall:se..a", True)]
    np.testing.assert_array_equal(right.boundary.vertices, before.patches[-1].boundary.vertices)
    assert not any("wall" in name for loop in result.openings["outside"] for name in loop)


def test_the_parts_share_the_cut_and_have_the_rest_between_them(divided):
    _, left, cut, result = divided
    below, above, _ = result.patches
    edges = len(cut.normals)
    assert len(below.boundary.vertices) + len(above.boundary.vertices) == len(left.boundary.vertices) + 2 * edges
    assert below.boundary.stretches[-1].reversed != above.boundary.stretches[-1].reversed
    # Flat patches: no curvature, whole or divided.
    assert [excess(patch) for patch in result.patches[:2]] == pytest.approx([0.0, 0.0], abs=1e-12)
    # The slit's tip stays the tip, on the side where the slit is.
    assert len(below.boundary.slit_tips) == 1
    tip = below.boundary.slit_tips[0]
    np.testing.assert_array_equal(below.boundary.vertices[tip], [20, 20, 0])
    assert above.boundary.slit_tips == ()


def test_min_angles_stay_at_their_corners_but_for_the_one_that_is_divided(tmp_path):
    nodes, curves = square()
    around = ["south", "east", "north", "west"]
    patch = {"around": around, "min_angle": {"sw": 80, "ne": 85}}
    network = network_of(tmp_path, nodes=nodes, curves=flat(curves), patches={"all": patch}, rest="openings")
    [whole] = network.patches
    cut = straight_cut(whole.boundary, vertex_at(whole, [0, 0, 0]), vertex_at(whole, [40, 20, 0]))
    for half in halves(whole.boundary, cut, "cut"):
        corners = {tuple(half.vertices[i]): half.min_angles[i] for i in np.flatnonzero(half.min_angles)}
        has_ne = any((half.vertices == [40, 40, 0]).all(axis=1))
        assert corners == ({(40.0, 40.0, 0.0): np.radians(85)} if has_ne else {})


def test_a_closed_curve_without_node_gets_one_at_each_end_of_the_cut(tmp_path):
    t = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = {"closed": True, "points": np.c_[30 * np.cos(t), 30 * np.sin(t), 0 * t].tolist(), "normals": UP}
    network = network_of(tmp_path, curves={"rim": rim}, patches={"disk": {"around": ["rim"]}})
    [disk] = network.patches
    turned, node = with_node(network, "disk", 5, "n")
    np.testing.assert_array_equal(turned.stretches["rim"].vertices[0], disk.boundary.vertices[5])
    assert turned.nodes[node] is not None and turned.patches[0].boundary.stretches[0].first == 5
    result = divide(network, "disk", straight_cut(disk.boundary, 5, 17), "cut", ("one", "two"), ("a", "b"))
    assert list(result.stretches) == ["rim:a..b", "rim:b..a", "cut"]
    for patch in result.patches:
        np.testing.assert_array_equal(patch.boundary.vertices, along(result, patch))
