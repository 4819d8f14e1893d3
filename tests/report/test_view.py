"""What is nearer covers what is farther, and the outside is what one sees first."""

import numpy as np
import pytest
import trimesh

from flatnet.fitting.results import SurfaceMesh
from flatnet.report.view import FROM_THE_FRONT, Camera, Surface, cameras

SQUARE = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def sheet(normal, shift=(0.0, 0.0, 0.0)):
    """A square whose outside looks along `normal`."""
    to = trimesh.geometry.align_vectors([0, 0, 1], normal)[:3, :3]
    return SurfaceMesh(SQUARE @ to.T + shift, HALVES, 4)


def ball():
    sphere = trimesh.creation.icosphere(subdivisions=2, radius=10.0)
    zeros = np.zeros(len(sphere.faces))
    return Surface(np.array(sphere.triangles), np.empty((0, 2, 3)), zeros, zeros)


@pytest.mark.parametrize("camera", [FROM_THE_FRONT, Camera(-90.0, 50.0), Camera(200.0, -30.0)])
def test_a_camera_neither_mirrors_nor_distorts_and_keeps_z_upright(camera):
    axes = camera.axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    right, up, _ = camera.project(np.array([0.0, 0.0, 1.0]))
    assert right == 0.0 and up > 0.0


@pytest.mark.parametrize("normal", [*np.eye(3), *-np.eye(3), np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)])
def test_a_sheet_shows_its_outside(normal):
    """Tilted by 10 and turned by 25 degrees, or held 50 degrees over the floor: within 41 degrees."""
    surface = Surface.of([sheet(normal)])
    first, _ = cameras(surface)
    assert first.axes[2] @ normal >= np.cos(np.radians(41.0))
    assert surface.light(first)[1].all()


def test_a_body_is_seen_from_the_front_and_from_behind():
    first, second = cameras(ball())
    assert first == FROM_THE_FRONT and first.axes[2, 1] > 0.0
    np.testing.assert_allclose(second.axes[2] * [-1, -1, 1], first.axes[2], atol=1e-15)


def test_a_body_open_on_one_side_is_seen_from_the_other():
    """Nothing at x < -0.8 r: the mean normal points to +x; mirrored in x = 0, the camera is mirrored, too."""
    whole = ball()
    kept = whole.corners[whole.corners[..., 0].mean(axis=1) > -8.0]
    mirrored = (kept * [-1.0, 1.0, 1.0])[:, ::-1]
    zeros = np.zeros(len(kept))
    seen = [cameras(Surface(c, whole.boundaries, zeros, zeros))[0].axes[2] for c in (kept, mirrored)]
    assert seen[0][0] > 0.0
    np.testing.assert_allclose(seen[0] * [-1, 1, 1], seen[1], atol=1e-15)


@pytest.mark.parametrize("azimuth, nearer", [(90.0, 1), (-90.0, 0)])
def test_patches_cover_each_other_as_they_stand_in_space(azimuth, nearer):
    """Two sheets across y, 30 mm apart: what is drawn last is the nearer one, and last of it its rim."""
    surface = Surface.of([sheet([0, 1, 0]), sheet([0, 1, 0], [0.0, 30.0, 0.0])])
    _, order = surface.back_to_front(Camera(azimuth, 0.0))
    of_sheet = np.concatenate([np.repeat([0, 1], 2), np.repeat([0, 1], 4)])
    assert (of_sheet[order[-6:]] == nearer).all()
    assert set(order[-4:]) == set(np.flatnonzero(of_sheet == nearer)[2:])


def test_both_sides_are_lit_alike_and_told_apart():
    surface = ball()
    inside_out = Surface(surface.corners[:, ::-1], surface.boundaries, surface.flattenability, surface.strain)
    brightness, outside = surface.light(FROM_THE_FRONT)
    other_brightness, other_outside = inside_out.light(FROM_THE_FRONT)
    np.testing.assert_allclose(brightness, other_brightness, atol=1e-12)
    assert (outside != other_outside).all()
    centres = FROM_THE_FRONT.project(surface.corners.mean(axis=1))
    assert (outside == (centres[:, 2] > 0.0)).all()
    brightest = centres[np.argmax(np.where(outside, brightness, 0.0))]
    assert brightest[0] < 0.0 < brightest[1], "light from above left"


def test_a_triangle_has_the_flattenability_of_its_worst_corner():
    """A pyramid of four equal sides: 2 pi less four apex angles, in every triangle; its foot is boundary."""
    apex = np.vstack([SQUARE, [[5.0, 5.0, 4.0]]])
    fan = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    half = np.arctan2(5.0, np.hypot(5.0, 4.0))
    found = Surface.of([SurfaceMesh(apex, fan, 4), sheet([0, 0, 1])]).flattenability
    np.testing.assert_allclose(found, [2.0 * np.pi - 8.0 * half] * 4 + [0.0] * 2, atol=1e-14)
