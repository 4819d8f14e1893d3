"""The formulas of the verifier against others, and against shapes whose figures are known."""

import numpy as np
import pytest

from flatnet.verify.mesh import WrittenMesh, aligned, corner_angles, covered_twice, farthest, side_lengths
from flatnet.verify.round_trip import fold


def strip(count, width=10.0, length=40.0):
    """A flat strip of rectangles, each of two triangles, along x."""
    flat = np.array([[k * width, y] for k in range(count + 1) for y in (0.0, length)])
    corners = np.arange(count)[:, None] * 2
    triangles = np.concatenate([corners + [0, 2, 1], corners + [1, 2, 3]])
    return flat, triangles


def prism(count, width=10.0, length=40.0, closed_by=8):
    """The same strip on a prism of `closed_by` sides, seen from outside."""
    turned = 2.0 * np.pi / closed_by
    steps = width * np.exp(-1j * turned * np.arange(count))
    places = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([[place.real, y, place.imag] for place in places for y in (0.0, length)]), turned


@pytest.mark.parametrize("thin", [1.0, 1e-3, 1e-6])
def test_angles_from_lengths_are_those_of_the_cross_and_dot_product(thin):
    random = np.random.default_rng(0)
    points = random.uniform(-100.0, 100.0, (300, 3))
    points[2::3] = 0.5 * (points[::3] + points[1::3]) + thin * points[2::3]
    triangles = np.arange(300).reshape(-1, 3)
    u, v = points[1::3] - points[::3], points[2::3] - points[::3]
    expected = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
    angles = corner_angles(side_lengths(points, triangles))
    # A length that is off by 1e-16 of itself moves a corner of a thin triangle by 1e-16 / thin.
    assert np.abs(angles[:, 0] - expected).max() < 1e-13 / thin
    assert np.abs(angles.sum(axis=1) - np.pi).max() < 1e-14


def test_angles_are_nan_where_there_is_no_such_triangle():
    assert np.isnan(corner_angles(np.array([[1.0, 1.0, 3.0]]))).any()


def test_dihedral_angles_of_a_prism():
    vertices, turned = prism(4)
    flat, triangles = strip(4)
    mesh = WrittenMesh(vertices, flat, triangles)
    assert mesh.faults == ()
    ends = mesh.half_edges[mesh.hinges] // 2  # which edge of the prism a vertex is on
    expected = np.where(ends[:, 0] == ends[:, 1], turned, 0.0)
    assert np.abs(mesh.dihedral_angles - expected).max() < 1e-14


def test_a_strip_folds_to_the_prism():
    vertices, _ = prism(6)
    flat, triangles = strip(6)
    mesh = WrittenMesh(vertices, flat, triangles)
    folded = fold(mesh, mesh.dihedral_angles)
    linear, shift = aligned(folded.vertices, vertices)
    assert farthest(folded.vertices @ linear.T + shift, vertices) < 1e-12
    assert np.linalg.det(linear) > 0.0
    inside_out = fold(mesh, -mesh.dihedral_angles)
    linear, shift = aligned(inside_out.vertices, vertices)
    assert farthest(inside_out.vertices @ linear.T + shift, vertices) > 1.0


def test_folds_that_do_not_close_are_told_by_the_gap():
    """Six triangles about a vertex, one of the hinges folded by 0.01: one triangle is not where it belongs."""
    ring = np.exp(2j * np.pi * np.arange(6) / 6)
    flat = 10.0 * np.array([[0.0, 0.0], *([z.real, z.imag] for z in ring)])
    triangles = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    mesh = WrittenMesh(np.column_stack([flat, np.zeros(7)]), flat, triangles)
    assert fold(mesh, np.zeros(6)).gap < 1e-14
    height = 10.0 * np.sin(np.pi / 3.0)
    for hinge in range(6):
        angles = np.zeros(6)
        angles[hinge] = 0.01
        gap = fold(mesh, angles).gap
        assert 0.5 * height * 0.01 <= gap <= 2.0 * height * 0.01


@pytest.mark.parametrize(
    "outline, area",
    [
        ([[0, 0], [2, 0], [2, 2], [0, 2]], 0.0),
        ([[0, 0], [2, 0], [0, 2], [2, 2]], 2.0),  # a bow tie: one of its halves runs the wrong way
        ([[0, 0], [4, 0], [4, 3], [1, 3], [1, 1], [3, 1], [3, 2], [0, 2]], 1.0),  # laps over itself
        ([[0, 0], [4, 0], [4, 2], [2, 2], [2, 1], [2, 2], [0, 2]], 0.0),  # a slit that touches itself
    ],
)
def test_what_an_outline_covers_twice(outline, area):
    if area == 0.0:
        assert covered_twice(np.array(outline, float)) == 0.0
    else:
        assert covered_twice(np.array(outline, float)) >= area


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_figure_is_congruent_with_its_image_on_one_side_only(mirrored):
    figure = np.array([[0, 0], [20, 0], [20, 40], [60, 40], [60, 60], [0, 100]], float)
    c, s = np.cos(0.7), np.sin(0.7)
    image = figure @ np.diag([1.0, -1.0 if mirrored else 1.0]) @ np.array([[c, s], [-s, c]]) + [5.0, -3.0]
    for side in (False, True):
        linear, shift = aligned(figure, image, side)
        off = farthest(figure @ linear.T + shift, image)
        assert (off < 1e-13) if side is mirrored else (off > 1.0)
