"""Crossings and touches of closed polygons, against all pairs tested by shapely, and along slits."""

import numpy as np
import pytest
import shapely

from flatnet.geometry.crossings import SLIT_TOLERANCE, polygon_crossings

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_simple_polygons_have_none():
    t = 2 * np.pi * np.arange(500) / 500
    star = (1 + 0.5 * np.cos(7 * t))[:, None] * np.c_[np.cos(t), np.sin(t)]
    assert polygon_crossings(SQUARE) == []
    assert polygon_crossings(SQUARE[:3]) == []
    assert polygon_crossings(star) == []
    assert polygon_crossings(star + [1e5, -1e5]) == []


def test_a_bow_tie_crosses_once_in_its_middle():
    assert polygon_crossings(SQUARE[[0, 1, 3, 2]]) == [(1, pytest.approx(0.5), 3, pytest.approx(0.5))]


def test_a_vertex_on_another_edge_and_edges_that_overlap_count():
    touching = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]])
    assert [(i, j) for i, _, j, _ in polygon_crossings(touching)] == [(0, 2), (0, 3)]
    overlapping = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [3.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert (0, 3) in [(i, j) for i, _, j, _ in polygon_crossings(overlapping)]


def test_same_pairs_and_places_as_shapely_on_random_polygons():
    rng = np.random.default_rng(5)
    for _ in range(40):
        n = int(rng.integers(4, 30))
        p = rng.normal(size=(n, 2))
        lines = [shapely.LineString([p[k], p[(k + 1) % n]]) for k in range(n)]
        expected = [
            (i, j) for i in range(n) for j in range(i + 2, n) if j - i < n - 1 and lines[i].intersects(lines[j])
        ]
        found = polygon_crossings(p)
        assert [(i, j) for i, _, j, _ in found] == expected
        for i, s, j, t in found:
            assert p[i] + s * (p[(i + 1) % n] - p[i]) == pytest.approx(p[j] + t * (p[(j + 1) % n] - p[j]), abs=1e-9)


def slit_square(overlap=0.0):
    """A square with a slit from the middle of its lower side to its centre; its sides pass over each other."""
    flat = np.array(
        [[0, 0], [0.5, 0], [0.5, 0.25], [0.5, 0.5], [0.5, 0.25], [0.5, 0], [1, 0], [1, 1], [0, 1]], dtype=float
    )
    space = np.c_[flat, np.zeros(len(flat))]
    flat[2, 0] += overlap
    flat[4, 0] -= overlap
    return flat, space


def test_the_sides_of_a_slit_may_touch_and_overlap_a_little():
    flat, space = slit_square()
    mean_edge = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1).mean()
    assert polygon_crossings(flat)
    assert polygon_crossings(flat, space) == []
    assert polygon_crossings(slit_square(0.3 * SLIT_TOLERANCE * mean_edge)[0], space) == []
    assert polygon_crossings(slit_square(10 * SLIT_TOLERANCE * mean_edge)[0], space)
