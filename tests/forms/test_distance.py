"""Signed distance: exact on a ball and a box, the side right at edges and corners, none beside the rim."""

import numpy as np
import pytest
import trimesh

from flatnet.forms.distance import signed_distance
from flatnet.forms.surface import ReferenceSurface


def test_a_box_has_exact_distances_on_both_sides_at_faces_edges_and_corners():
    surface = ReferenceSurface(trimesh.creation.box((20, 20, 20)))
    points = np.random.default_rng(1).uniform(-16, 16, (400, 3))
    beyond = np.abs(points) - 10
    outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
    exact = np.where(outside > 0, outside, beyond.max(axis=1))
    np.testing.assert_allclose(signed_distance(surface, points), exact, atol=1e-9)
    assert (exact < 0).any() and ((beyond > 0).sum(axis=1) == 3).any()


def blade(angle):
    """A wedge, sharp along the y axis, its tip at x = 0 and its back at x = 30."""
    height = 30 * np.tan(0.5 * angle)
    outline = [[0, 0], [30, -height], [30, height]]
    mesh = trimesh.creation.extrude_triangulation(outline, [[0, 1, 2]], 40)
    return ReferenceSurface(mesh)


@pytest.mark.parametrize("degrees", [5, 40])
def test_the_side_is_right_in_front_of_a_sharp_edge(degrees):
    """There the smooth normals of one triangle's corners may point anywhere; all the points are outside."""
    points = np.random.default_rng(2).uniform([-6, -3, 1], [-0.1, 3, 39], (200, 3))
    assert (signed_distance(blade(np.radians(degrees)), points) > 0).all()


def tube():
    """An open tube of radius 50 round the z axis, from -20 to 20."""
    tube = trimesh.creation.cylinder(50, 40, sections=120)
    tube.update_faces(np.abs(tube.face_normals[:, 2]) < 0.5)
    tube.remove_unreferenced_vertices()
    return ReferenceSurface(tube)


#: How far a chord of the tube lies inside its circle.
SAGITTA = 50 * (1 - np.cos(np.pi / 120))


@pytest.mark.parametrize("height", [-20.0, -1.0, 1.0, 30.0])
def test_a_tube_to_the_height_of_its_facets(height):
    around = np.random.default_rng(3).uniform(0, 2 * np.pi, 200)
    points = np.c_[(50 + height) * np.cos(around), (50 + height) * np.sin(around), np.linspace(-19, 19, 200)]
    np.testing.assert_allclose(signed_distance(tube(), points), height, atol=2 * SAGITTA)


@pytest.mark.parametrize("height", [-2.0, 0.5, 2.0])
def test_a_point_beside_the_rim_counts_by_its_height_alone(height):
    """Thirty mm beyond the end of the tube it is no 30 mm inside it."""
    around = np.random.default_rng(3).uniform(0, 2 * np.pi, 200)
    points = np.c_[(50 + height) * np.cos(around), (50 + height) * np.sin(around), np.full(200, 50.0)]
    np.testing.assert_allclose(signed_distance(tube(), points), height, atol=2 * SAGITTA)
