"""The curvature that normals ask for: spherical caps, cylinders and cones as truths."""

import numpy as np
import pytest
from benchmark.boundaries import CASES, case

from flatnet.fitting.results import FittedPatch
from flatnet.fitting.run import run_patch
from flatnet.geometry.asked_curvature import asked_curvature, least_normal_deviation
from flatnet.geometry.polygon import predicted_angles
from flatnet.geometry.triangles import unit
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters


def asked(vertices, normals):
    alpha, _ = predicted_angles(vertices, normals)
    return asked_curvature(alpha), least_normal_deviation(vertices, alpha)


def latitude(half_angle, n=400):
    """A circle of latitude of the unit sphere and the sphere's normals at mid-edge."""
    t = np.arange(n) / n * 2.0 * np.pi
    s, c = np.sin(half_angle), np.cos(half_angle)
    middle = t + np.pi / n
    return np.c_[s * np.cos(t), s * np.sin(t), c + 0 * t], np.c_[s * np.cos(middle), s * np.sin(middle), c + 0 * t]


@pytest.mark.parametrize("degrees", [5, 25, 40, 80, 120])
def test_a_cap_asks_for_the_area_of_its_gauss_image_and_must_leave_the_normals_by_its_half_angle(degrees):
    """2 pi (1 - cos a), exact but for the polygon, whose angles err by the square of its turning angle.

    The only flat piece on a circle is its disk, a degrees from all normals; the last step to it changes the turning
    by the square of the step, so an error e of the turning shows as sqrt(e).
    """
    a = np.radians(degrees)
    curvature, least = asked(*latitude(a))
    turn = 2.0 * np.pi / 400
    assert curvature == pytest.approx(2.0 * np.pi * (1.0 - np.cos(a)), abs=2.0 * np.pi * turn**2)
    assert least == pytest.approx(a, abs=2.0 * turn)


def test_a_developable_asks_for_nothing():
    """A cone's and a cylinder's outline with their own normals: 0 up to the square of the turning from edge to edge."""
    t = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    u, v = 1.0 + 0.4 * np.cos(t), 0.5 * np.sin(t)

    def cone(u, v):
        return np.c_[u * np.cos(v), u * np.sin(v), 0.7 * u]

    def cylinder(u, v):
        return np.c_[np.sin(u), v, np.cos(u)]

    middle = t + np.pi / 400
    mu, mv = 1.0 + 0.4 * np.cos(middle), 0.5 * np.sin(middle)
    for surface, normals in (
        (cone, np.c_[-0.7 * np.cos(mv), -0.7 * np.sin(mv), np.ones(400)]),
        (cylinder, np.c_[np.sin(mu), 0.0 * mu, np.cos(mu)]),
    ):
        curvature, least = asked(surface(u, v), unit(normals))
        assert abs(curvature) < 1e-3
        assert least < 1e-3


def test_neither_scale_nor_motion_changes_what_is_asked_for():
    boundary, _ = case("saddle", 60)
    frame = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    moved = asked(7.0 * boundary.vertices @ frame.T + 5.0, boundary.normals @ frame.T)
    assert moved == pytest.approx(asked(boundary.vertices, boundary.normals), abs=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_what_is_warned_of_is_what_the_fit_had_to_leave(name):
    """At normal weight 1 the meshes are smooth, so their worst deviation is at least the bound (within 3 degrees: they
    are polygons); the warning names it where it is above 15 degrees."""
    boundary, edge_length = case(name, 60)
    made = run_patch(Patch("p", boundary, edge_length, "m"), FairParameters())
    assert isinstance(made, FittedPatch)
    least = np.degrees(asked(boundary.vertices, boundary.normals)[1])
    left = np.degrees(made.mesh.normal_deviations(boundary.normals))
    assert left.max() >= least - 3.0
    warned = [w for w in made.warnings if w.code == "normals_contradict"]
    assert len(warned) == (least > 15.0)
    if warned:
        assert f"{least:.0f} degrees at least" in warned[0].message
        assert ("dome" if warned[0].amount > 0 else "saddle") in warned[0].message
