"""Sampling of curves, and their normals: what must hold of every vertex and edge."""

import numpy as np
import pytest
from drawn import UP, Cylinder, Sphere, Valley, flat, line, network_of, stretches_of
from scipy.interpolate import CubicSpline

H = 10.0


#: An octant of a sphere.
SPHERE = Sphere(50.0)
OCTANT = {
    "nodes": {"a": [60, 0, 0], "b": {"at": [0, 55, 3], "on": "surface"}, "c": [0, 0, 45.0]},
    "curves": {
        "ab": line("a", "b", on="surface", kind="spline", points=[[40, 40, 5]]),
        "bc": line("b", "c", on="surface"),
        "ca": line("c", "a", on="surface", points=[[40, 0, 35]]),
    },
    "patches": {"octant": {"around": ["ab", "bc", "ca"]}},
    "rest": "openings",
}
ENDS = {"a": [0, 0, 0], "b": [60, 0, 0]}


def edges(vertices):
    return np.linalg.norm(np.diff(vertices, axis=0), axis=1)


def closed(points, **rest):
    return {"closed": True, "points": [list(map(float, p)) for p in points], **rest}


def circle(count, radius=50.0):
    t = 2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(t), radius * np.sin(t), 0 * t], axis=1)


def one_curve(tmp_path, curve, surface=None, **sections):
    """The one stretch of a closed curve."""
    return stretches_of(tmp_path, surface, curves={"c": curve}, **sections)[0]["c"]


class TestPolyline:
    def test_keeps_every_point_and_divides_long_segments_only(self, tmp_path):
        points = np.array([[0, 0, 0], [25, 0, 0], [25, 3, 0], [25, 7, 1], [0, 40, 0]], float)
        stretch = one_curve(tmp_path, closed(points, normals=UP))
        lengths = edges(np.vstack([points, points[:1]]))
        parts = [3, 1, 1, 5, 4]  # 25, 3, 4.1, 41.4 and 40 mm
        wanted = np.concatenate([[length / n] * n for length, n in zip(lengths, parts, strict=True)])
        assert edges(stretch.vertices) == pytest.approx(wanted, rel=1e-12)
        starts = np.cumsum([0, *parts[:-1]])
        assert np.array_equal(stretch.vertices[starts], points)
        assert np.array_equal(stretch.vertices[-1], points[0])

    def test_a_segment_of_whole_edge_lengths_is_not_divided_once_more(self, tmp_path):
        side = 3 * 0.1  # 0.30000000000000004
        triangle = closed([[0, 0, 0], [side, 0, 0], [0, side, 0]], normals=UP)
        stretch = one_curve(tmp_path, triangle, edge_length=0.1)
        assert len(stretch.vertices) - 1 == 3 + 3 + 5

    def test_points_that_meet_on_the_surface_only_are_named(self, tmp_path):
        nodes = {"a": {"at": [60, 0, 0], "on": "surface"}, "b": {"at": [70, 0, 0], "on": "surface"}}
        curves = {"c": line("a", "b", on="surface"), "d": line("a", "b", points=[[0, 60, 0]], on="surface")}
        _, [message] = stretches_of(tmp_path, Sphere(50.0), nodes=nodes, curves=curves)
        assert "curve 'c': point 1 and the next, both at (50.0, 0.0, 0.0), coincide" in message


class TestSpline:
    @pytest.mark.parametrize("tolerance", [1.0, 0.1, 0.01])
    def test_edges_are_short_even_and_near_the_curve(self, tmp_path, tolerance):
        nodes = {"a": [0, 0, 0], "b": [100, 0, 0]}
        middle = [[20, 30, 0], [50, -10, 20], [80, 10, 0]]
        curves = flat({"c": line("a", "b", kind="spline", points=middle)})
        stretches, _ = stretches_of(tmp_path, nodes=nodes, curves=curves, chord_tolerance=tolerance)
        vertices = stretches["c"].vertices
        points = np.array([nodes["a"], *middle, nodes["b"]], float)
        knots = np.concatenate([[0], np.cumsum(edges(points))])
        spline = CubicSpline(knots, points, bc_type="natural")
        dense = spline(np.linspace(0, knots[-1], 20_001))
        gap = edges(dense).max()
        distances = np.linalg.norm(vertices[:, None] - dense, axis=2)
        assert distances.min(axis=1).max() <= gap  # the vertices are on the spline
        arcs = np.concatenate([[0], np.cumsum(edges(dense))])[distances.argmin(axis=1)]
        assert edges(vertices).max() <= H
        assert np.ptp(np.diff(arcs)) <= 0.01 * np.diff(arcs).mean() + 2 * gap
        start, chord = vertices[:-1, None], np.diff(vertices, axis=0)[:, None]
        part = ((dense - start) * chord).sum(2, keepdims=True) / (chord**2).sum(2, keepdims=True)
        off = np.linalg.norm(dense - start - np.clip(part, 0, 1) * chord, axis=2).min(axis=0).max()
        assert off <= tolerance * 1.02  # measured at eighths of the edges, which miss the top of an arc by 1/64

    def test_closed_spline_through_a_circle_is_smooth_where_it_closes(self, tmp_path):
        radius, count = 50.0, 16
        stretch = one_curve(tmp_path, closed(circle(count, radius), kind="spline", normals=UP))
        # Error of cubic interpolation: at most 5/384 step^4 times the fourth derivative, here radius.
        bound = 5 / 384 * (2 * np.pi / count) ** 4 * radius
        assert np.linalg.norm(stretch.vertices, axis=1) == pytest.approx(radius, abs=2 * bound)
        assert np.array_equal(stretch.vertices[0], stretch.vertices[-1])
        assert edges(stretch.vertices).max() / edges(stretch.vertices).min() <= 1.01

    def test_nodes_on_the_way_are_vertices_and_the_curve_stays_smooth_there(self, tmp_path):
        nodes = {"a": [0, 0, 0], "b": [37, 13, 0], "c": [80, 0, 0]}
        curves = flat({"s": line("a", "c", kind="spline", points=["b"])})
        stretches, _ = stretches_of(tmp_path, nodes=nodes, curves=curves)
        first, second = stretches["s:a..b"], stretches["s:b..c"]
        assert np.array_equal(first.vertices[-1], nodes["b"])
        assert np.array_equal(second.vertices[0], nodes["b"])
        before, after = first.vertices[-1] - first.vertices[-2], second.vertices[1] - second.vertices[0]
        turn = np.arccos(before @ after / np.linalg.norm(before) / np.linalg.norm(after))
        assert turn < np.radians(20)  # the polyline turns by 36 degrees there


class TestOnSurface:
    def test_every_vertex_is_on_the_surface_and_edges_are_short_and_even(self, tmp_path):
        network = network_of(tmp_path, SPHERE, **OCTANT)
        for stretch in network.stretches.values():
            assert np.linalg.norm(stretch.vertices, axis=1) == pytest.approx(50.0, rel=1e-14)
            assert edges(stretch.vertices).max() <= H * (1 + 1e-9)
            assert edges(stretch.vertices).min() >= 0.9 * edges(stretch.vertices).max()

    def test_a_node_has_one_position_for_all_its_curves(self, tmp_path):
        network = network_of(tmp_path, SPHERE, **OCTANT)
        for stretch in network.stretches.values():
            assert np.array_equal(stretch.vertices[0], network.nodes[stretch.start])
            assert np.array_equal(stretch.vertices[-1], network.nodes[stretch.end])

    def test_normals_are_the_surface_s_at_mid_edges(self, tmp_path):
        network = network_of(tmp_path, SPHERE, **OCTANT)
        for stretch in network.stretches.values():
            middles = 0.5 * (stretch.vertices[:-1] + stretch.vertices[1:])
            wanted = middles / np.linalg.norm(middles, axis=1, keepdims=True)  # orthogonal to chords as it is
            assert stretch.left_normals == pytest.approx(wanted, abs=1e-12)
            assert stretch.left_normals is stretch.right_normals

    @pytest.mark.parametrize("off_axis", [0.1, 1.0, 8.0])
    def test_a_chord_through_the_body_jumps(self, tmp_path, off_axis):
        nodes = {"a": [50, 0, 0], "b": [-50, 0, 40]}
        curves = {"chord": line("a", "b", on="surface", points=[[0, off_axis, 20]]),
                  "round": line("a", "b", on="surface", points=[[0, 50, 0]])}
        stretches, [message] = stretches_of(tmp_path, Cylinder(50.0), nodes=nodes, curves=curves)
        assert "curve 'chord': its projection onto the surface jumps by" in message
        along = float(message.split(" mm along the curve")[0].split()[-1])
        assert along == pytest.approx(np.hypot(50, 20), abs=2 * H)  # where it passes the axis
        assert list(stretches) == ["round"]

    @pytest.mark.parametrize("sides", [3, 6])
    def test_chords_of_a_part_of_the_round_do_not(self, tmp_path, sides):
        """Of a triangle they lie half a radius below the cylinder."""
        stretch = one_curve(tmp_path, closed(circle(sides, 50.0), on="surface"), Cylinder(50.0))
        assert np.hypot(*stretch.vertices[:, :2].T) == pytest.approx(50.0, rel=1e-14)
        assert edges(stretch.vertices).max() <= H * (1 + 1e-9)
        assert stretch.length == pytest.approx(2 * np.pi * 50, rel=(H / 50) ** 2 / 24 * 1.5)

    def test_over_a_valley_it_may_leap_by_less(self, tmp_path):
        """6 mm above the bottom of a right-angled valley the nearest points leap from wall to wall, by 6 mm."""
        nodes = {"a": [-40, 0, 40], "b": [40, 0, 40]}
        curves = {"c": line("a", "b", on="surface", points=[[0, 0, 6]])}
        stretches, _ = stretches_of(tmp_path, Valley(), nodes=nodes, curves=curves)
        x, _, z = stretches["c"].vertices.T
        assert z == pytest.approx(np.abs(x), abs=1e-12)
        assert edges(stretches["c"].vertices).max() <= H * (1 + 1e-9)


class TestNormals:
    """Along the x axis; the first segment is 20 mm, the second 40 mm."""

    def normals(self, tmp_path, given):
        curves = {"c": line("a", "b", points=[[20, 0, 0]], normals=given)}
        stretch = stretches_of(tmp_path, nodes=ENDS, curves=curves)[0]["c"]
        return stretch, 0.5 * (stretch.vertices[:-1, 0] + stretch.vertices[1:, 0])

    def test_per_point_they_are_interpolated_by_arclength(self, tmp_path):
        stretch, x = self.normals(tmp_path, [[0, 0, 2], [0, 3, 3], [0, 5, 0]])
        root = np.sqrt(0.5)
        y = np.where(x < 20, root * x / 20, root + (1 - root) * (x - 20) / 40)
        z = np.where(x < 20, 1 + (root - 1) * x / 20, root * (60 - x) / 40)
        wanted = np.stack([0 * x, y, z], axis=1) / np.hypot(y, z)[:, None]
        assert stretch.left_normals == pytest.approx(wanted, abs=1e-14)

    def test_per_segment_they_are_constant_and_made_orthogonal(self, tmp_path):
        stretch, x = self.normals(tmp_path, [[7, 0, 1], [-3, 2, 0]])
        wanted = np.where((x < 20)[:, None], [0.0, 0, 1], [0.0, 1, 0])
        assert np.array_equal(stretch.left_normals, wanted)

    def test_on_a_crease_each_side_keeps_its_own(self, tmp_path):
        stretch, x = self.normals(tmp_path, {"left": [0, -1, 1], "right": [0, 1, 1]})
        root = np.sqrt(0.5)
        assert stretch.crease
        assert stretch.left_normals == pytest.approx(np.tile([0, -root, root], (len(x), 1)), abs=1e-15)
        assert stretch.right_normals == pytest.approx(np.tile([0, root, root], (len(x), 1)), abs=1e-15)

    @pytest.mark.parametrize(
        ("given", "at"),
        [
            ([[0, 0, 1], [1, 0, 0]], 24.0),  # in the middle of the second segment's first edge
            ([[0, 0, 1], [0, 1, 0], [0, -1, 0]], 40.0),  # half-way between opposed ones
        ],
    )
    def test_along_the_curve_or_vanishing_they_are_refused(self, tmp_path, given, at):
        curves = {"c": line("a", "b", points=[[20, 0, 0]], normals=given, edge_length=8)}
        _, [message] = stretches_of(tmp_path, nodes=ENDS, curves=curves)
        assert f"curve 'c': the normal at {at:.1f} mm along it points along the curve or vanishes" in message

    def test_of_a_closed_curve_that_starts_at_a_node_they_stay_with_their_points(self, tmp_path):
        """The node is the third point; the normal of each segment leans towards its own side."""
        points = [[0, 0, 0], [10, 0, 0], "n", [0, 10, 0]]
        leans = [[0, -1, 1], [1, 0, 1], [0, 1, 1], [-1, 0, 1]]
        curves = {"c": {"closed": True, "points": points, "normals": leans}}
        stretch = stretches_of(tmp_path, nodes={"n": [10, 10, 0]}, curves=curves)[0]["c"]
        assert np.array_equal(stretch.vertices, [[10, 10, 0], [0, 10, 0], [0, 0, 0], [10, 0, 0], [10, 10, 0]])
        wanted = np.roll(np.array(leans, float), -2, axis=0) / np.sqrt(2)
        assert stretch.left_normals == pytest.approx(wanted, abs=1e-15)
