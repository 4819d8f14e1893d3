"""Curves along sections, boundaries, sharp edges and named lines."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import ball, box, line, prism, sheet, stretches_of

from flatnet.forms.mannequin import mannequin
from flatnet.forms.surface import Line

H = 10.0


def drawn(folder, surface, curve, **nodes):
    """The stretches of one curve, and the problems."""
    return stretches_of(folder, surface, nodes=nodes, curves={"c": curve})


def one(folder, surface, curve, **nodes):
    stretches, problems = drawn(folder, surface, curve, **nodes)
    assert not problems
    [stretch] = stretches.values()
    return stretch.vertices


def message(folder, surface, curve, **nodes):
    _, [problem] = drawn(folder, surface, curve, **nodes)
    return problem


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def angle(vertices):
    """Longitude passed along a curve, signed."""
    return np.diff(np.unwrap(np.arctan2(vertices[:, 1], vertices[:, 0]))).sum()


class TestSections:
    def test_a_closed_ring_runs_anticlockwise_seen_against_the_normal(self, tmp_path):
        for sense in (1, -1):
            ring = {"section": {"point": [0, 0, 63], "normal": [0, 0, sense]}}
            vertices = one(tmp_path, prism(), ring)
            assert vertices[:, 2] == pytest.approx(63.0, abs=1e-12)
            assert np.array_equal(vertices[0], vertices[-1])
            assert angle(vertices) == pytest.approx(sense * 2 * np.pi)
            lengths = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
            assert lengths.max() <= H and lengths.min() > 0.9 * lengths.max()

    @pytest.mark.parametrize("z", [0.0, 200.0, 100.0])
    def test_in_the_plane_of_a_rim_or_of_vertices_it_goes_through_them(self, tmp_path, z):
        vertices = one(tmp_path, prism(), {"section": {"point": [0, 0, z], "normal": [0, 0, 1]}})
        assert vertices[:, 2] == pytest.approx(z, abs=1e-12)
        assert angle(vertices) == pytest.approx(2 * np.pi)

    def test_a_slanted_section_of_a_tube_is_an_ellipse(self, tmp_path):
        normal = np.array([0.0, -1.0, 1.0]) / np.sqrt(2)
        cut = {"section": {"point": [0, 0, 100], "normal": normal.tolist()}, "edge_length": 2}
        vertices = one(tmp_path, prism(192), cut)
        assert np.abs((vertices - [0, 0, 100]) @ normal).max() < 1e-9
        # Perimeter of the ellipse with half axes 50 and 50 sqrt 2: 382.0; chords of 192 sides and of 2 mm less.
        assert length(vertices) == pytest.approx(382.0, abs=0.1)

    def test_of_two_legs_the_one_near_the_point(self, tmp_path):
        for x in (80, -80):
            ring = {"section": {"point": [x, 0, 500], "normal": [0, 0, 1]}}
            vertices = one(tmp_path, mannequin({}), ring)
            assert (np.sign(vertices[:, 0]) == np.sign(x)).all()

    def test_between_two_nodes_the_shorter_way_unless_a_point_shows_the_other(self, tmp_path):
        surface, radius = prism(192), 50.0
        nodes = {"a": [radius, 0, 80], "b": [0, radius, 80]}
        cut = {"section": {"normal": [0, 0, 1]}}
        assert angle(one(tmp_path, surface, line("a", "b", **cut), **nodes)) == pytest.approx(np.pi / 2)
        assert angle(one(tmp_path, surface, line("b", "a", **cut), **nodes)) == pytest.approx(-np.pi / 2)
        over = line("a", "b", points=[[0, -60, 90]], **cut)
        assert angle(one(tmp_path, surface, over, **nodes)) == pytest.approx(-3 * np.pi / 2)
        # With a point in place of the normal the plane goes through the three.
        bent = one(tmp_path, surface, line("a", "b", section={"point": [40, 40, 120]}), **nodes)
        normal = np.cross([-50, 50, 0], [-10, 40, 40])
        assert np.abs((bent - [50, 0, 80]) @ normal).max() < 1e-6 * np.linalg.norm(normal)
        assert bent[:, 2].max() > 100

    def test_the_normal_is_turned_until_the_plane_goes_through_both_nodes(self, tmp_path):
        surface = prism(192)
        vertices = one(tmp_path, surface, line("a", "b", section={"normal": [0, 0, 1]}), a=[50, 0, 80], b=[-50, 0, 100])
        chord = np.array([-100.0, 0, 20])
        normal = np.array([0, 0, 1.0]) - chord * chord[2] / (chord @ chord)
        assert np.abs((vertices - [50, 0, 80]) @ normal).max() < 1e-6
        said = message(tmp_path, surface, line("a", "b", section={"normal": [0, 0, 1]}), a=[50, 0, 10], b=[-50, 0, 190])
        assert "a plane through 'from' and 'to' is turned by 61 degrees against 'normal' (at most 30)" in said

    def test_nodes_on_the_way_cut_it_and_lie_on_it(self, tmp_path):
        surface = prism(192)
        cut = {"section": {"point": [0, 0, 80], "normal": [0, 0, 1]}}
        nodes = {"a": [50, 0, 80], "b": [0, 50, 80.5], "c": [-50, 0, 80]}
        stretches, problems = drawn(tmp_path, surface, line("a", "c", points=["b"], **cut), **nodes)
        assert not problems and list(stretches) == ["c:a..b", "c:b..c"]
        heights = stretches["c:a..b"].vertices[:, 2]
        assert heights[-1] == pytest.approx(80.5) and (np.diff(heights) > 0).all()  # led through it, without a step
        nodes["b"][2] = 82
        said = message(tmp_path, surface, line("a", "c", points=["b"], **cut), **nodes)
        assert "node 'b' lies 2.00 mm off the section, more than 0.1 edge lengths of 10 mm" in said

    def test_it_misses_or_has_the_wrong_order(self, tmp_path):
        said = message(tmp_path, prism(), {"section": {"point": [0, 0, 300], "normal": [0, 0, 1]}})
        assert said == "curve 'c': the plane of its section misses the surface"
        cut = {"section": {"point": [0, 0, 80], "normal": [0, 0, 1]}}
        nodes = {"a": [50, 0, 80], "b": [0, 50, 80], "c": [-50, 0, 80], "d": [0, -50, 80]}
        said = message(tmp_path, prism(192), line("a", "b", points=["c", "d"], **cut), **nodes)
        # a, c, d, b goes on anticlockwise past a again, and clockwise so, too.
        assert "the section does not pass its points in their order" in said

    def test_a_section_from_rim_to_rim_ends_in_nodes_of_its_own(self, tmp_path):
        stretches, problems = drawn(tmp_path, sheet(), {"section": {"point": [30, 0, 0], "normal": [1, 0, 0]}})
        assert not problems
        stretch = stretches["c"]
        assert (stretch.start, stretch.end) == ("c.start", "c.end")
        assert stretch.vertices[:, 0] == pytest.approx(30.0)
        assert stretch.vertices[[0, -1], 1].tolist() == [0.0, 100.0]  # x cross z is against y: so upwards in y


class TestMeshEdges:
    def test_the_rim_nearest_to_the_point_with_the_surface_on_its_left(self, tmp_path):
        for z, sense in ((0, 1), (200, -1)):
            vertices = one(tmp_path, prism(192), {"along": "boundary", "points": [[50, 0, z]]})
            assert vertices[:, 2] == pytest.approx(z, abs=1e-12)
            assert angle(vertices) == pytest.approx(sense * 2 * np.pi)
        said = message(tmp_path, prism(), {"along": "boundary"})
        assert "there are 2 chains of boundary edges; give a point near the one meant in 'points'" in said
        assert "the surface is closed, it has no boundary" in message(tmp_path, ball(), {"along": "boundary"})

    def test_from_node_to_node_along_the_edges_of_a_box(self, tmp_path):
        nodes = {"a": [-20, -30, 40], "b": [20, 10, 40]}
        vertices = one(tmp_path, box(40, 60, 80), line("a", "b", along="feature"), **nodes)
        assert length(vertices) == pytest.approx(40 + 40)  # the corner is a vertex
        assert np.abs(vertices[:, 2] - 40).max() < 1e-9
        long = line("a", "b", along="feature", points=[[-20, 30, 40]])
        assert length(one(tmp_path, box(40, 60, 80), long, **nodes)) == pytest.approx(60 + 40 + 20)

    def test_corners_of_a_closed_rim_stay_vertices(self, tmp_path):
        vertices = one(tmp_path, sheet(), {"along": "boundary", "edge_length": 7})
        corners = [[x, y, 0] for x in (0, 100) for y in (0, 100)]
        assert all(corner in vertices.tolist() for corner in corners)
        assert length(vertices) == pytest.approx(400)
        assert len(vertices) - 1 == 4 * 15  # 100 / 7 rounded up, on each side

    def test_branching_edges_need_nodes(self, tmp_path):
        said = message(tmp_path, box(40, 60, 80), {"along": "feature"})
        assert "the feature edges branch, so that they make no one closed curve; give 'from' and 'to'" in said

    def test_an_angle_decides_what_is_sharp(self, tmp_path):
        said = message(tmp_path, prism(12), {"along": {"feature": 31}})
        assert "no two faces of the mesh meet at more than 31 degrees" in said
        nodes = {"a": [50, 0, 20], "b": [50, 0, 150]}
        assert length(one(tmp_path, prism(12), line("a", "b", along={"feature": 29}), **nodes)) == pytest.approx(130)


class TestLines:
    def test_a_ring_of_the_form_moves_with_its_measurement(self, tmp_path):
        for knee in (361.0, 400.0):
            surface = mannequin({"half": "right", "knee": knee})
            # Chords of 10 mm on radii of 55 mm are shorter by (10 / 55)^2 / 24.
            assert length(one(tmp_path, surface, {"line": "knee"})) == pytest.approx(knee, rel=3e-3)

    def test_a_part_of_a_line_between_nodes_at_landmarks(self, tmp_path):
        surface = mannequin({"half": "right"})
        nodes = {"a": {"landmark": "knee_inside"}, "b": {"landmark": "crotch"}}
        vertices = one(tmp_path, surface, line("a", "b", line="inside"), **nodes)
        assert vertices[0].tolist() == surface.landmarks["knee_inside"].tolist()
        assert vertices[-1].tolist() == surface.landmarks["crotch"].tolist()
        assert (np.diff(vertices[:, 2]) > 0).all()

    def test_unknown_names_and_an_open_line_that_should_close(self, tmp_path):
        surface = mannequin({"half": "right"})
        said = message(tmp_path, surface, {"line": "nee"})
        assert said == "curve 'c': line: there is no line 'nee'; did you mean 'knee'?"
        assert message(tmp_path, ball(), {"line": "knee"}) == (
            "curve 'c': line: there is no line 'knee'; the surface has no lines"
        )
        ends = line("a", "a", line="inside", points=[[20, 5, 600]])
        said = message(tmp_path, surface, ends, a={"landmark": "crotch"})
        assert "line 'inside' is open, so that no way leads round to 'a' again" in said

    def test_a_rough_line_is_taken_to_the_surface(self, tmp_path):
        surface = ball(50.0, 5)
        angles = np.linspace(0, 2, 30)
        points = 50.4 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        vertices = one(tmp_path, replace(surface, lines={"arc": Line(points)}), {"line": "arc"})
        assert np.linalg.norm(surface.nearest(vertices)[0] - vertices, axis=1).max() < 1e-3 * H


def test_every_path_lies_on_the_surface(tmp_path):
    surface = mannequin({"half": "right"})
    curves = {
        "ring": {"section": {"point": [0, 0, 500], "normal": [0, 1, 5]}},
        "hem": {"along": "boundary", "points": [[75, 0, 76]]},
        "line": {"line": "front"},
    }
    stretches, problems = stretches_of(tmp_path, surface, curves=curves, join="crossings")
    assert not problems
    for stretch in stretches.values():
        feet, _ = surface.nearest(stretch.vertices)
        assert np.linalg.norm(feet - stretch.vertices, axis=1).max() < 1e-3 * H
