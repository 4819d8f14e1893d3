"""Unfolding: exact where the mesh is flattenable, and laid with the grain along +x."""

import numpy as np
import pytest

from flatnet.fitting.results import SurfaceMesh
from flatnet.fitting.unfold import along_grain, unfold
from flatnet.geometry.triangles import edge_strain, signed_areas


def rolled_grid(rows=9, columns=13, radius=40.0, edge=10.0):
    """A grid whose rows run round a cylinder about z, boundary vertices first, and the same grid flat."""
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    flat = np.c_[column.ravel(), row.ravel()] * edge
    chord = 2 * radius * np.sin(edge / (2 * radius))
    angle = column.ravel() * edge / radius
    vertices = np.c_[radius * np.sin(angle), -radius * np.cos(angle), row.ravel() * edge]
    flat[:, 0] *= chord / edge
    cell = (row[:-1, :-1] * columns + column[:-1, :-1]).ravel()
    triangles = np.concatenate(
        [np.c_[cell, cell + 1, cell + columns + 1], np.c_[cell, cell + columns + 1, cell + columns]]
    )
    rim = np.r_[
        np.arange(columns), np.arange(2, rows + 1) * columns - 1,
        np.arange(rows * columns - 2, (rows - 1) * columns - 1, -1), np.arange(rows - 2, 0, -1) * columns,
    ]  # fmt: skip
    order = np.r_[rim, np.setdiff1d(np.arange(rows * columns), rim)]
    place = np.argsort(order)
    return SurfaceMesh(vertices[order], place[triangles], len(rim)), flat[order]


def test_a_cylinder_unrolls_to_its_rectangle_with_the_axis_along_x():
    mesh, flat = rolled_grid()
    unrolled = along_grain(unfold(mesh), mesh, np.array([0.0, 0.0, 1.0]))
    assert np.abs(edge_strain(mesh.vertices, unrolled, mesh.triangles)).max() < 1e-12
    assert (signed_areas(unrolled, mesh.triangles) > 0).all()
    # +z lies along +x, so the way round the cylinder (x of `flat`, anticlockwise of it) runs along -y.
    expected = np.c_[flat[:, 1], -flat[:, 0]]
    np.testing.assert_allclose(
        unrolled - unrolled.mean(axis=0), expected - expected.mean(axis=0), atol=1e-9
    )


def test_without_a_direction_the_longest_extent_lies_along_x():
    mesh, _ = rolled_grid()
    extent = np.ptp(unfold(mesh), axis=0)
    assert extent[0] > extent[1]


def test_a_direction_across_the_mesh_everywhere_is_no_grain():
    """The normal of a plane has no direction in it."""
    mesh, flat = rolled_grid()
    plane = SurfaceMesh(np.c_[flat, np.zeros(len(flat))], mesh.triangles, mesh.boundary_count)
    assert along_grain(unfold(plane), plane, np.array([0.0, 0.0, 1.0])) is None


def test_a_mesh_that_is_not_flattenable_is_strained():
    """A cube's corner, angle sum 3 pi / 2: its three squares can't lie in the plane, and the figures say so."""
    vertices = np.array(
        [[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1], [0, 0, 0]], dtype=float
    )
    mesh = SurfaceMesh(vertices, np.array([[k, (k + 1) % 6, 6] for k in range(6)]), 6)
    assert mesh.max_flattenability == pytest.approx(np.pi / 2)
    assert np.abs(edge_strain(vertices, unfold(mesh), mesh.triangles)).max() > 0.05
