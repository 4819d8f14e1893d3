"""Wrinkles: none on what bends one way, known ones on a corrugated sheet, and those of the benchmark in order."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from benchmark.fits import sized_case
from scipy.spatial import Delaunay

from flatnet.fitting.fit import fit_patch
from flatnet.geometry.triangles import signed_areas
from flatnet.geometry.wrinkles import NOISE, REACH, WRINKLED, find_wrinkles
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters
from flatnet.report.warnings import patch_warnings


def sheet(edge, width=200.0, height=150.0):
    """An irregular triangulation of a rectangle: (m, 2), (t, 3), and how many of the first are its outline."""
    outline = shapely.get_coordinates(shapely.segmentize(shapely.box(0, 0, width, height), edge))[:-1]
    x, y = np.meshgrid(np.arange(0, width, edge), np.arange(0, height, edge * np.sqrt(0.75)))
    x[::2] += 0.5 * edge
    points = np.c_[x.ravel(), y.ravel()]
    points += np.random.default_rng(3).uniform(-0.15, 0.15, points.shape) * edge
    inside = (np.minimum(points, [width, height] - points) > 0.5 * edge).all(axis=1)
    flat = np.concatenate([outline, points[inside]])
    triangles = Delaunay(flat).simplices.astype(np.int64)
    return flat, triangles[signed_areas(flat, triangles) > 1e-6 * edge**2], len(outline)


def on_cylinder(flat, radius=90.0):
    return np.c_[radius * np.sin(flat[:, 0] / radius), flat[:, 1], radius * np.cos(flat[:, 0] / radius)]


def on_cone(flat):
    """Unrolled about an apex beside the sheet, at half angle 30 degrees."""
    r, phi = np.hypot(*(flat - [100, -120]).T), np.arctan2(*(flat - [100, -120]).T)
    return np.c_[0.5 * r * np.sin(2 * phi), 0.5 * r * np.cos(2 * phi), -np.sqrt(0.75) * r]


def corrugated(flat, amplitude, length):
    """Waves along x that end at their tops: small, so that they bend without stretch to second order."""
    return np.c_[flat, amplitude * np.cos(2 * np.pi * flat[:, 0] / length)]


@pytest.mark.parametrize("edge", [5.0, 10.0, 25.0])
@pytest.mark.parametrize("shape", [on_cylinder, on_cone])
def test_what_bends_one_way_has_no_wrinkles(shape, edge):
    flat, triangles, rim = sheet(edge)
    wrinkles = find_wrinkles(shape(flat), triangles, rim)
    assert wrinkles.turning <= 1e-12
    assert (wrinkles.ridges, wrinkles.valleys, wrinkles.depth) == (0, 0, 0.0)


@pytest.mark.parametrize("edge", [2.5, 5.0])
def test_turning_and_depth_of_waves_are_as_derived(edge):
    """Averages over a width divide a wave cos(k x) by 1 + (k width)^2.

    Of |cos| = 2 / pi - 4 / pi sum (-1)^j cos(2 j k x) / (4 j^2 - 1) as of everything else; what is bent nearby is
    most at a top, what cancels is most where the wave crosses 0: cos(2 j k x) = (-1)^j.
    """
    amplitude, length = 2.0, 40.0
    flat, triangles, rim = sheet(edge, 240.0, 150.0)
    size = np.sqrt(240.0 * 150.0)
    reach, k, j = REACH * size, 2 * np.pi / length, np.arange(1, 100)
    clean = amplitude * k**2 / (1 + (k * NOISE * size) ** 2)
    nearby = 2 / np.pi - 4 / np.pi * np.sum(1 / (4 * j**2 - 1) / (1 + (2 * j * k * reach) ** 2))
    q = (k * reach) ** 2
    wrinkles = find_wrinkles(corrugated(flat, amplitude, length), triangles, rim)
    assert wrinkles.turning == pytest.approx(reach * clean * nearby, rel=0.1)
    assert wrinkles.depth == pytest.approx(2 * amplitude * (q / (1 + q)) ** 2, rel=0.05)
    assert (wrinkles.ridges, wrinkles.valleys) == (7, 6)


def test_it_depends_on_neither_place_nor_scale_and_the_other_side_sees_ridges_as_valleys():
    flat, triangles, rim = sheet(5.0)
    waves = corrugated(flat, 3.0, 40.0)
    frame = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    one, other = find_wrinkles(waves, triangles, rim), find_wrinkles(25.4 * waves @ frame.T + 500, triangles, rim)
    assert other.turning == pytest.approx(one.turning, rel=1e-9)
    assert other.depth == pytest.approx(25.4 * one.depth, rel=1e-9)
    below = find_wrinkles(waves, triangles[:, ::-1], rim)
    assert below.turning == pytest.approx(one.turning, rel=1e-9)
    assert (below.ridges, below.valleys) == (one.valleys, one.ridges)
    assert one.ridges != one.valleys


def fitted(name, vertices):
    boundary, edge_length = sized_case(name, vertices)
    return fit_patch(Patch(name, boundary, edge_length, "sheet"), FairParameters(), {})


@pytest.fixture(scope="module", params=[350, 650])
def benchmark(request):
    """Boundaries of the benchmark, fitted at about so many vertices."""
    return {name: fitted(name, request.param) for name in ("w05", "w12", "w20", "vamp", "cap", "cylinder")}


def test_wrinkled_boundaries_are_told_from_smooth_ones_and_in_order(benchmark):
    """The steeper the waves, the more: where the mesh resolves them."""
    turning = {name: one.mesh.wrinkles.turning for name, one in benchmark.items()}
    assert WRINKLED < turning["w05"] < min(turning["w12"], turning["w20"])
    if len(benchmark["w20"].mesh.vertices) > 500:
        assert turning["w12"] < turning["w20"]
    assert max(turning["vamp"], turning["cap"], turning["cylinder"]) < 0.5 * WRINKLED
    assert max(turning["vamp"], turning["cap"]) < 1e-4  # the cap is flat but for round-off


def test_the_warning_says_how_much_and_where_unless_wrinkles_are_expected(benchmark):
    (warning,) = patch_warnings(benchmark["w12"], None, 0.0)
    wrinkles = benchmark["w12"].mesh.wrinkles
    assert (warning.code, warning.unit) == ("wrinkled", "deg")
    assert warning.amount == np.degrees(wrinkles.turning)
    x, y, z = benchmark["w12"].mesh.vertices[wrinkles.vertex]
    assert warning.where.startswith("near 'boundary' at ")
    assert f"({x:.1f}, {y:.1f}, {z:.1f}) mm" in warning.where
    assert f"{wrinkles.ridges} ridge" in warning.message
    meant = replace(benchmark["w12"], patch=replace(benchmark["w12"].patch, wrinkles_expected=True))
    assert patch_warnings(meant, None, 0.0) == []
    assert patch_warnings(benchmark["cylinder"], None, 0.0) == []
