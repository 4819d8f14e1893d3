"""Every derivative against central differences, on a crumpled mesh where no symmetry hides a wrong sign."""

import numpy as np
import pytest

from flatnet.geometry.derivatives import (
    area_gradients,
    corner_angle_gradients,
    edge_length_gradients,
    hinge_angle_gradients,
)
from flatnet.geometry.triangles import (
    area_vectors,
    corner_angles,
    edge_lengths,
    edges_of,
    hinge_angles,
    hinges_of,
)

STEP = 1e-5
# A central difference with step e errs by e^2 f'''/6; third derivatives of these are below 1e4 on this mesh.
TOLERANCE = 1e4 * STEP**2 / 6


@pytest.fixture
def mesh():
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0))
    vertices = np.c_[x.ravel(), y.ravel(), np.zeros(16)]
    vertices += np.random.default_rng(3).uniform(-0.25, 0.25, vertices.shape)
    i = np.array([r * 4 + c for r in range(3) for c in range(3)])
    triangles = np.concatenate([np.c_[i, i + 1, i + 5], np.c_[i, i + 5, i + 4]])
    return vertices, triangles


def central_difference(value, vertices, elements):
    """Derivative of value(vertices) (e, ...) by each element's own vertices, (e, ..., k, 3)."""
    result = []
    for corner in range(elements.shape[1]):
        per_axis = []
        for axis in range(3):
            columns = []
            for element, ids in enumerate(elements):
                sides = []
                for sign in (1, -1):
                    moved = vertices.copy()
                    moved[ids[corner], axis] += sign * STEP
                    sides.append(value(moved)[element])
                columns.append((sides[0] - sides[1]) / (2 * STEP))
            per_axis.append(columns)
        result.append(np.moveaxis(np.array(per_axis), 0, -1))
    return np.stack(result, axis=-2)


def test_corner_angles(mesh):
    vertices, triangles = mesh
    expected = central_difference(lambda v: corner_angles(v, triangles), vertices, triangles)
    np.testing.assert_allclose(corner_angle_gradients(vertices, triangles), expected, atol=TOLERANCE)


def test_hinge_angles(mesh):
    vertices, triangles = mesh
    hinges = hinges_of(triangles)
    expected = central_difference(lambda v: hinge_angles(v, hinges), vertices, hinges)
    np.testing.assert_allclose(hinge_angle_gradients(vertices, hinges), expected, atol=TOLERANCE)


def test_edge_lengths(mesh):
    vertices, triangles = mesh
    edges = edges_of(triangles)
    expected = central_difference(lambda v: edge_lengths(v, edges), vertices, edges)
    np.testing.assert_allclose(edge_length_gradients(vertices, edges), expected, atol=TOLERANCE)


def test_areas(mesh):
    vertices, triangles = mesh
    expected = central_difference(
        lambda v: np.linalg.norm(area_vectors(v, triangles), axis=1), vertices, triangles
    )
    np.testing.assert_allclose(area_gradients(vertices, triangles), expected, atol=TOLERANCE)


def test_a_ridge_is_positive_and_a_valley_negative():
    """Two triangles, the outer corners bent down (a ridge seen from +z) by 30 degrees each."""
    drop, run = np.sin(np.pi / 6), np.cos(np.pi / 6)
    triangles = np.array([[0, 1, 2], [1, 0, 3]])
    for sign in (1, -1):
        vertices = np.array([[0, 0, 0], [0, 1, 0], [-run, 0.5, -sign * drop], [run, 0.5, -sign * drop]])
        np.testing.assert_allclose(hinge_angles(vertices, hinges_of(triangles)), sign * np.pi / 3, rtol=1e-14)
