"""Angles of closed polygons: what geometry says of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flatnet.geometry.polygon import polygon_angles, predicted_angles

UP = np.array([0.0, 0.0, 1.0])
ARROW = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0]], float)


def excess(vertices, normals):
    """sum(alpha) - (n - 2) pi."""
    return predicted_angles(vertices, normals)[0].sum() - (len(vertices) - 2) * np.pi


def test_planar_polygon_has_its_own_angles_reflex_ones_too():
    notch = np.arctan2(1.5, 1.0)
    wanted = [np.pi / 2, np.pi / 2, np.pi / 2 - notch, np.pi + 2 * notch, np.pi / 2 - notch]
    turn = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_matrix()
    alpha, opposed = predicted_angles(ARROW @ turn.T + 7.0, np.tile(turn @ UP, (5, 1)))
    assert alpha == pytest.approx(wanted, abs=1e-14)
    assert not opposed.any()


def test_angles_in_space_are_at_most_pi():
    inner = predicted_angles(ARROW, np.tile(UP, (5, 1)))[0]
    assert polygon_angles(ARROW) == pytest.approx(np.minimum(inner, 2 * np.pi - inner), abs=1e-14)


def test_the_sum_tells_how_a_planar_loop_winds():
    normals = np.tile(UP, (40, 1))
    t = np.linspace(0.0, 2 * np.pi, 40, endpoint=False) + 0.1
    circle = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    eight = np.stack([np.sin(t), np.sin(2 * t), 0 * t], axis=1)
    assert excess(circle, normals) == pytest.approx(0.0, abs=1e-12)
    assert excess(circle[::-1], normals) == pytest.approx(4 * np.pi, abs=1e-12)
    assert excess(eight, normals) == pytest.approx(2 * np.pi, abs=1e-12)


@pytest.mark.parametrize("edges", [10, 40])
def test_octant_of_a_sphere_has_its_solid_angle_as_excess(edges):
    """Gauss-Bonnet; on great circles the mean of the edge normals is exact at all but the corners."""
    corners = np.eye(3)
    t = np.linspace(0.0, np.pi / 2, edges, endpoint=False)[:, None]
    sides = [np.cos(t) * corners[i] + np.sin(t) * corners[(i + 1) % 3] for i in range(3)]
    vertices = np.concatenate(sides)
    middles = vertices + np.roll(vertices, -1, axis=0)
    normals = middles / np.linalg.norm(middles, axis=1, keepdims=True)
    h = np.pi / 2 / edges
    # At a corner the edges dip by h / 2 and the mean normal leans by as much: second order.
    assert excess(vertices, normals) == pytest.approx(np.pi / 2, abs=3 * h**2)


def test_tip_of_a_slit_turns_by_two_pi():
    vertices = np.array([[0, 0, 0], [2, 0, 0], [1, 0.5, 0], [2, 0, 0], [2, 2, 0]], float)
    alpha, _ = predicted_angles(vertices, np.tile(UP, (5, 1)))
    assert alpha[2] == 2 * np.pi
    assert alpha.sum() == pytest.approx(3 * np.pi, abs=1e-14)


def test_opposed_normals_take_the_angle_in_space():
    normals = np.tile(UP, (5, 1))
    normals[2] = -UP
    alpha, opposed = predicted_angles(ARROW, normals)
    assert opposed.tolist() == [False, False, True, True, False]
    assert alpha[opposed] == pytest.approx(polygon_angles(ARROW)[opposed], abs=0)
