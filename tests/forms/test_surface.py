"""Nearest points and normals of a reference surface, against surfaces whose answer is known."""

import numpy as np
import pytest
import trimesh

from flatnet.forms.surface import ReferenceSurface, tidy_mesh


def sphere(radius: float, subdivisions: int) -> ReferenceSurface:
    mesh = trimesh.creation.icosphere(subdivisions, radius)
    return ReferenceSurface(tidy_mesh(mesh.vertices, mesh.faces))


def test_the_nearest_point_of_a_box_is_the_clamped_one():
    box = trimesh.creation.box([2.0, 4.0, 6.0])
    surface = ReferenceSurface(tidy_mesh(box.vertices, box.faces))
    half = np.array([1.0, 2.0, 3.0])
    points = np.random.default_rng(0).uniform(-10.0, 10.0, (500, 3))
    points = points[(np.abs(points) > half).any(axis=1)]
    feet, _ = surface.nearest(points)
    assert np.allclose(feet, np.clip(points, -half, half), atol=1e-12)


def test_normals_of_a_sphere():
    radius = 50.0
    surface = sphere(radius, 4)
    points = np.random.default_rng(1).normal(size=(2000, 3))
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    feet, normals = surface.nearest(points)
    edge = surface.mesh.edges_unique_length.max()
    # A chord of length e leaves the sphere by e^2 / (6 r) at the middle of a triangle; the facet's own normal
    # turns by e / r towards its corners, the interpolated one by a small part of that.
    assert np.linalg.norm(feet - points, axis=1).max() < edge**2 / (6.0 * radius)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-12)
    turned = np.arccos(np.clip(np.einsum("ij,ij->i", normals, points) / radius, -1.0, 1.0))
    assert turned.max() < 0.1 * edge / radius


def test_normals_turn_smoothly_across_edges():
    """The interpolated normal is continuous: along a great circle it never turns faster than the circle."""
    surface = sphere(50.0, 2)  # coarse: facet normals would jump by 18 degrees
    angles = np.linspace(0.0, 2.0 * np.pi, 3601)
    circle = 50.0 * np.column_stack([np.cos(angles), np.sin(angles), 0.3 * np.sin(angles)])
    _, normals = surface.nearest(circle)
    steps = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normals[:-1], normals[1:]), -1.0, 1.0)))
    assert steps.max() < 1.0


def test_a_point_of_the_surface_is_its_own_foot():
    surface = sphere(10.0, 2)
    feet, normals = surface.nearest(surface.mesh.vertices)
    assert np.allclose(feet, surface.mesh.vertices, atol=1e-12)
    assert np.allclose(normals, surface.mesh.vertices / 10.0, atol=0.02)


def test_no_points():
    feet, normals = sphere(10.0, 1).nearest(np.zeros((0, 3)))
    assert feet.shape == normals.shape == (0, 3)


def test_normals_do_not_depend_on_how_a_plane_is_cut_up():
    """Angle-weighted: a box's corner that one face meets with two triangles points along the diagonal."""
    box = trimesh.creation.box([2.0, 2.0, 2.0])
    surface = ReferenceSurface(tidy_mesh(box.vertices, box.faces))
    _, normals = surface.nearest(np.array([[3.0, 3.0, 3.0], [3.0, -3.0, 3.0]]))
    assert np.allclose(normals, np.array([[1, 1, 1], [1, -1, 1]]) / np.sqrt(3.0), atol=1e-12)


def test_the_same_answer_twice():
    points = np.random.default_rng(2).normal(scale=20.0, size=(500, 3))
    first, second = (sphere(10.0, 3).nearest(points) for _ in range(2))
    assert np.array_equal(first[0], second[0]) and np.array_equal(first[1], second[1])
