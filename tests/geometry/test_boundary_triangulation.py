"""The triangulation of a boundary alone: a disk, flat where it can be, along the rulings of a cylinder."""

import numpy as np
import pytest

from flatnet.geometry.boundary_triangulation import triangulate_boundary
from flatnet.geometry.triangles import (
    angles_between,
    bending,
    boundary_triangle_normals,
    edges_of,
    hinge_angles,
    hinges_of,
    signed_areas,
)


def test_a_plane_outline_with_a_bay_is_filled_without_a_bend():
    outline = np.array([[0, 0], [30, 0], [30, 20], [20, 20], [20, 8], [10, 8], [10, 20], [0, 20.0]])
    triangles = triangulate_boundary(np.c_[outline, np.zeros(8)], np.tile([0.0, 0.0, 1.0], (8, 1)))
    areas = signed_areas(outline, triangles)
    assert len(triangles) == 6 and (areas > 0.0).all()
    assert areas.sum() == pytest.approx(30 * 20 - 10 * 12)
    assert bending(np.c_[outline, np.zeros(8)], triangles) == pytest.approx(0.0, abs=1e-20)


@pytest.mark.parametrize("count", [12, 24])
def test_a_strip_of_a_cylinder_is_ruled(count):
    """The bends are those between neighbouring rulings, and all normals are nearly those of the cylinder."""
    t = np.linspace(0.0, 2.0, count + 1)
    low, high = (np.c_[50 * np.cos(t), 50 * np.sin(t), np.full(len(t), z)] for z in (0.0, 40.0))
    vertices = np.concatenate([low, high[::-1]])
    middle = 0.5 * (vertices + np.roll(vertices, -1, axis=0)) * [1, 1, 0]
    normals = middle / np.linalg.norm(middle, axis=1)[:, None]
    triangles = triangulate_boundary(vertices, normals)
    n = len(vertices)
    assert len(triangles) == n - 2 and len(edges_of(triangles)) == 2 * n - 3  # a disk without inner vertices
    step = 2.0 / count
    assert np.abs(hinge_angles(vertices, hinges_of(triangles))).max() <= 1.001 * step
    assert angles_between(boundary_triangle_normals(vertices, triangles, n), normals).max() <= 0.501 * step


def test_points_on_a_line_have_no_triangulation():
    line = np.c_[[0.0, 1.0, 2.0, 3.0], np.zeros((4, 2))]
    assert len(triangulate_boundary(line, np.tile([0.0, 0.0, 1.0], (4, 1)))) == 0
