"""Geodesics and fair curves on meshes whose answer is known."""

from itertools import pairwise

import numpy as np
import pytest
from drawn import Sphere, ball, line, prism, sheet, stretches_of
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from flatnet.network.geodesics import geodesics

H = 10.0


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


class TestGeodesics:
    @pytest.mark.parametrize("turn", [0.3, 1.2, 2.5])
    @pytest.mark.parametrize("rise", [0.0, 17.0, 150.0])
    def test_on_a_prism_it_is_straight_when_unrolled(self, turn, rise):
        columns, radius = 48, 50.0
        surface = prism(columns, radius)
        step = 2 * np.pi / columns
        side = 2 * radius * np.sin(step / 2)

        def at(columns_round, z):  # a point of the prism by the columns passed, also between two
            k, part = divmod(columns_round, 1)
            corners = radius * np.array([[np.cos(j * step), np.sin(j * step)] for j in (k, k + 1)])
            return np.append((1 - part) * corners[0] + part * corners[1], z)

        start, passed = 1.37, turn / step
        points = np.array([at(start, 21.3), at(start + passed, 21.3 + rise)])
        [way] = geodesics(surface.mesh, points)
        assert length(way) == pytest.approx(np.hypot(passed * side, rise), rel=1e-9)
        assert way[[0, -1]] == pytest.approx(points, abs=1e-9)

    def test_on_a_sphere_it_is_a_great_circle(self):
        surface = ball(50.0, 5)
        points = np.random.default_rng(0).normal(size=(6, 3))
        points *= 50.0 / np.linalg.norm(points, axis=1, keepdims=True)
        # Facets of 1.8 mm lie up to 0.013 mm inside, so ways are shorter by 2.7e-4 of their lengths at most, and
        # bow out of the plane by the square root of that.
        for way, a, b in zip(geodesics(surface.mesh, points), points[:-1], points[1:]):
            arc = 50.0 * np.arccos(a @ b / 2500.0)
            assert arc * (1 - 2.7e-4) <= length(way) <= arc
            plane = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
            assert np.abs(way @ plane).max() < 0.01 * arc

    def test_points_at_vertices_on_edges_and_twice_in_a_triangle(self):
        surface = sheet(100.0, 10)
        points = np.array([[10.0, 10, 0], [15.0, 10, 0], [18.0, 11, 0], [19.0, 12, 0], [15.0, 15, 0], [0.0, 33, 0]])
        for way, a, b in zip(geodesics(surface.mesh, points), points[:-1], points[1:]):
            assert length(way) == pytest.approx(np.linalg.norm(b - a), rel=1e-12)

    def test_a_curve_through_points_keeps_them_as_vertices_and_lies_on_the_surface(self, tmp_path):
        nodes = {"a": [60, 0, 10], "b": [-60, 10, 150]}
        curves = {"c": line("a", "b", kind="geodesic", points=[[0, 70, 30]])}
        surface = prism()
        stretches, problems = stretches_of(tmp_path, surface, nodes=nodes, curves=curves)
        assert not problems
        vertices = stretches["c"].vertices
        feet, normals = surface.nearest(vertices)
        assert np.linalg.norm(feet - vertices, axis=1).max() < 1e-9
        corner = surface.nearest(np.array([[0.0, 70, 30]]))[0][0]
        assert np.linalg.norm(vertices - corner, axis=1).min() < 1e-9
        lengths = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
        assert lengths.max() <= H and lengths.min() > 0.8 * H
        radial = vertices * [1, 1, 0] / np.linalg.norm(vertices[:, :2], axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", normals, radial).min() > 0.999

    def test_parts_that_do_not_hang_together_have_no_way_between_them(self, tmp_path):
        from flatnet.forms.surface import ReferenceSurface, tidy_mesh

        one = sheet().mesh
        vertices = np.vstack([one.vertices, one.vertices + [0, 0, 50]])
        two = ReferenceSurface(tidy_mesh(vertices, np.vstack([one.faces, one.faces + len(one.vertices)])))
        nodes = {"a": [10, 10, 0], "b": [60, 60, 50]}
        _, [message] = stretches_of(tmp_path, two, nodes=nodes, curves={"c": line("a", "b", kind="geodesic")})
        assert "curve 'c': points 1 and 2 lie on two parts of the surface" in message


class TestFairCurves:
    POINTS = np.array([[10.0, 10, 0], [30, 80, 0], [60, 20, 0], [90, 70, 0]])

    def test_on_a_plane_it_is_the_spline(self, tmp_path):
        a, *between, b = self.POINTS.tolist()
        curves = {"c": {**line("a", "b"), "kind": "fair", "points": between, "edge_length": 4}}
        stretches, problems = stretches_of(tmp_path, sheet(), nodes={"a": a, "b": b}, curves=curves)
        assert not problems
        knots = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(self.POINTS, axis=0), axis=1))])
        spline = CubicSpline(knots, self.POINTS, bc_type="natural")(np.linspace(0, knots[-1], 20001))
        off = np.linalg.norm(stretches["c"].vertices[:, None] - spline, axis=2).min(axis=1)
        # Second differences at 2 mm: the error of the discrete spline falls with their square.
        assert off.max() < 0.05

    def test_closed_on_a_plane_too(self, tmp_path):
        angles = np.linspace(0, 2 * np.pi, 9)[:-1]
        points = np.stack([50 + 30 * np.cos(angles), 50 + 30 * np.sin(angles), 0 * angles], axis=1)
        curve = {"closed": True, "kind": "fair", "points": points.tolist(), "edge_length": 4}
        stretches, problems = stretches_of(tmp_path, sheet(), curves={"c": curve})
        assert not problems
        # Eight points: a cubic spline leaves the circle by 5/384 (pi/4)^4 R at most.
        radii = np.linalg.norm(stretches["c"].vertices[:, :2] - 50, axis=1)
        assert np.abs(radii - 30).max() < 5 / 384 * (np.pi / 4) ** 4 * 30 + 0.03

    def test_on_a_sphere_points_of_a_great_circle_stay_on_it(self, tmp_path):
        axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)
        u = np.cross(axis, [0, 0, 1]) / np.linalg.norm(np.cross(axis, [0, 0, 1]))
        v = np.cross(axis, u)
        a, m, b = (50 * (np.cos(t) * u + np.sin(t) * v) for t in (0.0, 1.1, 1.9))
        curves = {"c": line("a", "b", kind="fair", points=[m.tolist()])}
        stretches, problems = stretches_of(
            tmp_path, ball(50.0, 5), nodes={"a": a.tolist(), "b": b.tolist()}, curves=curves
        )
        assert not problems
        assert np.abs(stretches["c"].vertices @ axis).max() < 0.05  # facets of 1.8 mm
        assert np.linalg.norm(stretches["c"].vertices, axis=1) == pytest.approx(50.0, abs=0.014)

    def test_it_bends_no_more_than_any_other_curve_of_the_sphere(self):
        """Against a minimiser that knows nothing of tangent planes: angles of the samples, scipy's BFGS."""
        from flatnet.network.fair_curves import relaxed

        corners = np.array([[0.2, 0.0], [1.2, 0.9], [2.2, -0.3]])  # longitude, latitude

        def on_sphere(angles):
            longitude, latitude = angles.reshape(-1, 2).T
            return 50 * np.stack(
                [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=1
            )

        legs = [on_sphere(np.linspace(a, b, 200)) for a, b in pairwise(corners)]
        through, ends = relaxed(legs, False, 30.0, Sphere(50.0))
        steps = np.concatenate([np.full(n, length(leg) / n) for n, leg in zip(np.diff(ends), legs)])

        def bending(points):
            slopes = np.diff(points, axis=0) / steps[:, None]
            return np.sum(np.diff(slopes, axis=0) ** 2 / ((steps[1:] + steps[:-1]) / 2)[:, None])

        free = np.setdiff1d(np.arange(len(through)), ends)

        def energy(angles):
            points = through.copy()
            points[free] = on_sphere(angles)
            return bending(points)

        start = np.stack([np.arctan2(through[free, 1], through[free, 0]), np.arcsin(through[free, 2] / 50)], axis=1)
        best = minimize(energy, start.ravel(), method="BFGS", options={"gtol": 1e-9}).fun
        assert bending(through) == pytest.approx(best, rel=1e-3)
