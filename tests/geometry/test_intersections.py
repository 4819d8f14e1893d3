"""Self-intersections that can be counted by hand."""

import numpy as np
from scipy.spatial import Delaunay

from flatnet.geometry.intersections import self_intersections


def test_two_crossing_triangles():
    vertices = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.4, 0.4, -1], [0.5, 0.5, 1], [5, 5, 1.0]])
    triangles = np.array([[0, 1, 2], [3, 4, 5]])
    assert self_intersections(vertices, triangles).tolist() == [[0, 1]]


def test_neighbours_and_separate_triangles_do_not_count():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.2], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [4, 5, 6]])
    assert len(self_intersections(vertices, triangles)) == 0


def test_triangles_that_share_one_vertex_can_cross():
    """The second triangle hangs on vertex 0 and its far edge passes through the first."""
    vertices = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1.0]])
    assert self_intersections(vertices, np.array([[0, 1, 2], [0, 3, 4]])).tolist() == [[0, 1]]


def test_a_flat_mesh_in_a_slanted_plane_does_not_cross_itself():
    """Its triangles lie in one plane up to round-off, which gives their volumes any sign."""
    points = np.random.default_rng(1).uniform(0, 100, (300, 2))
    frame = np.array([[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36]])
    vertices = points @ frame + [100, 700, -300]
    assert len(self_intersections(vertices, Delaunay(points).simplices)) == 0
