"""Smoothing keeps what is regular, betters what is not, and turns no triangle over."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from flatnet.geometry.smoothing import _energy, _newton_steps, area_smoothing, shape_smoothing
from flatnet.geometry.triangles import corner_angles, signed_areas


def wheel(hub, rim):
    """A vertex `hub` joined to the points around it."""
    positions = np.concatenate([[hub], rim])
    count = len(rim)
    triangles = np.array([(0, 1 + i, 1 + (i + 1) % count) for i in range(count)])
    return positions, triangles, np.arange(count + 1) == 0


def hexagon(radius=1.0):
    angles = np.arange(6) / 6 * 2 * np.pi
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@pytest.mark.parametrize("smooth", [lambda *a: area_smoothing(*a, 200, 0.25), lambda *a: shape_smoothing(*a, 200)])
def test_the_hub_of_a_regular_hexagon_goes_to_its_centre_and_stays(smooth):
    centre = np.array([7.0, -3.0])
    positions, triangles, free = wheel(centre + [0.4, 0.2], hexagon() + centre)
    smoothed = smooth(positions, triangles, free)
    assert np.allclose(smoothed[0], centre, atol=1e-9)
    assert np.array_equal(smoothed[1:], positions[1:])


def test_area_smoothing_moves_a_quarter_of_the_way_to_the_area_weighted_centre():
    rim = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0)])
    positions, triangles, free = wheel((1.0, 0.5), rim)
    # The triangles fill the rectangle; their area-weighted centre is its centre.
    assert np.allclose(area_smoothing(positions, triangles, free, 1, 0.25)[0], (1.125, 0.5), rtol=1e-14)


def test_area_smoothing_turns_no_triangle_over():
    # The centre of area of this L lies near its inner corner, out of sight of the far ends.
    rim = np.array([(0.0, 0.0), (9.0, 0.0), (9.0, 0.4), (0.5, 0.5), (0.4, 9.0), (0.0, 9.0)])
    positions, triangles, free = wheel((0.2, 0.2), rim)
    smoothed = area_smoothing(positions, triangles, free, 50, 1.0)
    assert (signed_areas(smoothed, triangles) > 0).all()


def test_newton_steps_agree_with_central_differences():
    positions, triangles, free = wheel((0.1, -0.2), hexagon() * [1.0, 0.7])

    def energy(x, y):
        moved = positions.copy()
        moved[0] += x, y
        return _energy(moved[triangles]).sum()

    h = 1e-4
    gradient = np.array([energy(h, 0) - energy(-h, 0), energy(0, h) - energy(0, -h)]) / (2 * h)
    xx = (energy(h, 0) - 2 * energy(0, 0) + energy(-h, 0)) / h**2
    yy = (energy(0, h) - 2 * energy(0, 0) + energy(0, -h)) / h**2
    xy = (energy(h, h) - energy(h, -h) - energy(-h, h) + energy(-h, -h)) / (4 * h**2)
    expected = -np.linalg.solve([[xx, xy], [xy, yy]], gradient)
    # Central differences err by h^2 times the fourth derivative, here about 1e3 of the second.
    assert np.allclose(_newton_steps(positions, triangles, free)[0], expected, rtol=1e-4)


def test_shape_smoothing_raises_the_smallest_angle():
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9)), axis=-1).reshape(-1, 2)
    free = (np.abs(grid) < 0.99).all(axis=1)
    positions = grid + 0.07 * rng.uniform(-1, 1, grid.shape) * free[:, None]
    triangles = Delaunay(positions).simplices.astype(np.int64)
    triangles = triangles[signed_areas(positions, triangles) > 1e-9]
    before = np.degrees(corner_angles(positions, triangles)).min()
    smoothed = shape_smoothing(positions, triangles, free, 30)
    assert (signed_areas(smoothed, triangles) > 0).all()
    assert np.degrees(corner_angles(smoothed, triangles)).min() > before + 10
