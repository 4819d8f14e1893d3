"""Points cast along a direction land where the ray first meets the surface."""

import numpy as np
import pytest
import trimesh

from flatnet.forms.casting import first_hits
from flatnet.forms.surface import ReferenceSurface

BOX = ReferenceSurface(trimesh.creation.box((2, 4, 6)))


def test_the_first_face_of_a_box():
    points = np.array([[0, 0, 9], [0.5, -1.5, 9], [0, 0, 0], [5, 0, 9], [0, 0, -9], [1, 2, 9]], float)
    hits = first_hits(BOX, points, np.array([0, 0, -1.0]))
    expected = [[0, 0, 3], [0.5, -1.5, 3], [0, 0, -3], [np.nan] * 3, [np.nan] * 3, [1, 2, 3]]
    np.testing.assert_allclose(hits, expected, atol=1e-12)


@pytest.mark.parametrize("direction", [[0, 0, -1], [1, 2, 3], [-1, 0, 0.2]])
def test_against_trimesh_on_a_ball(direction):
    """Its ray tracer, on a mesh; both meet the same triangle's plane."""
    mesh = trimesh.creation.icosphere(3, 10.0)
    direction = np.array(direction, float) / np.linalg.norm(direction)
    points = np.random.default_rng(2).uniform(-9, 9, (60, 3)) - 30 * direction
    hits = first_hits(ReferenceSurface(mesh), points, direction)
    places, rays, _ = mesh.ray.intersects_location(points, np.tile(direction, (60, 1)), multiple_hits=False)
    assert set(np.flatnonzero(~np.isnan(hits[:, 0]))) == set(rays)
    np.testing.assert_allclose(hits[rays], places, atol=1e-9)
    np.testing.assert_allclose(np.cross(hits[rays] - points[rays], direction), 0.0, atol=1e-9)
