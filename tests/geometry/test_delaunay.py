"""Flips reach the Delaunay triangulation whatever they start from; vertices go in and out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from flatnet.geometry.delaunay import delaunay_flips, drop_degree_three, insert, locate, twins_of
from flatnet.geometry.triangles import signed_areas


def as_sets(triangles):
    return {frozenset(t) for t in triangles.tolist()}


def grown(points):
    """A poor triangulation of points in a square: each joined to the corners of the triangle it falls into."""
    positions = np.array([(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    for point in points:
        place = locate(positions, triangles, twins_of(triangles), point[None], np.array([0]))
        positions, triangles = insert(positions, triangles, point[None], place)
    return positions, triangles


def test_flips_give_the_delaunay_triangulation():
    positions, triangles = grown(np.random.default_rng(0).uniform(-1, 1, (200, 2)))
    assert (signed_areas(positions, triangles) > 0).all()
    flipped = delaunay_flips(positions, triangles, boundary_count=0)
    assert (signed_areas(positions, flipped) > 0).all()
    assert as_sets(flipped) == as_sets(Delaunay(positions).simplices)


def test_the_diagonals_of_squares_do_not_hang_on_where_they_start():
    side = 8
    number = np.arange(side * side).reshape(side, side)
    positions = 0.3 * np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    found = []
    for seed in range(3):
        rising = np.random.default_rng(seed).integers(0, 2, a.shape).astype(bool)
        first = np.stack([a, b, np.where(rising, c, d)], axis=-1).reshape(-1, 3)
        second = np.stack([np.where(rising, a, b), c, d], axis=-1).reshape(-1, 3)
        flipped = delaunay_flips(positions, np.concatenate([first, second]), boundary_count=0)
        found.append(as_sets(flipped))
    assert found[0] == found[1] == found[2]


def test_flips_make_no_chord():
    positions = np.array([(0.0, 0.0), (1.0, -0.2), (2.0, 0.0), (1.0, 0.2)])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    across = {frozenset({0, 1, 3}), frozenset({1, 2, 3})}
    assert as_sets(delaunay_flips(positions, triangles, boundary_count=0)) == across
    assert as_sets(delaunay_flips(positions, triangles, boundary_count=4)) == as_sets(triangles)


def test_a_walk_finds_the_triangle_or_leaves_the_mesh():
    positions, triangles = grown(np.random.default_rng(1).uniform(-1, 1, (50, 2)))
    triangles = delaunay_flips(positions, triangles, boundary_count=0)
    centres = positions[triangles].mean(axis=1)
    points = np.concatenate([centres, [(5.0, 0.0)]])
    place = locate(positions, triangles, twins_of(triangles), points, np.zeros(len(points), dtype=np.int64))
    assert place.tolist() == [*range(len(triangles)), -1]


@pytest.mark.parametrize("vertex_is_free", [True, False])
def test_a_vertex_of_degree_three_is_taken_out_only_where_it_is_free(vertex_is_free):
    positions, triangles = grown(np.array([(0.5, 0.0)]))
    free = np.array([False] * 4 + [vertex_is_free])
    left = drop_degree_three(positions, triangles, free)
    assert as_sets(left) == ({frozenset({0, 1, 2}), frozenset({0, 2, 3})} if vertex_is_free else as_sets(triangles))
    assert (signed_areas(positions, left) > 0).all()
