"""What must hold whatever the method: congruence, invariance, the unrolled cylinder and cone."""

import numpy as np
import pytest
import shapely
from benchmark.boundaries import boundary_curve, bowed, line, on_surface
from scipy.spatial import cKDTree

from flatnet.fitting.fit import fit_patch
from flatnet.geometry.triangles import bending
from flatnet.network.patch import BoundaryCurve, Patch, Stretch
from flatnet.parameters import FairParameters
from flatnet.report.metrics import normal_deviations


def asymmetric(n=90):
    """A bowed outline without any symmetry on a doubly curved surface."""

    def surface(q):
        x, y = q.T
        return np.c_[x, y, 0.25 * np.sin(2.2 * x) + 0.15 * x * y - 0.1 * y**2]

    sides = [
        bowed(line((0, 0), (2, 0.3)), -0.15),
        line((2, 0.3), (2.2, 1.4)),
        bowed(line((2.2, 1.4), (0.1, 1.2)), 0.12),
        line((0.1, 1.2), (0, 0)),
    ]
    return boundary_curve(*on_surface(sides, surface, n))


def fitted(boundary, edge_length=4.0):
    return fit_patch(Patch("p", boundary, edge_length, "m"), FairParameters(), {})


def curve(vertices, normals):
    n = len(vertices)
    return BoundaryCurve(vertices, normals, (Stretch("rim", 0, n, False),), np.zeros(n))


def moved(boundary, frame, shift, scale):
    return curve(scale * boundary.vertices @ frame.T + shift, boundary.normals @ frame.T)


@pytest.fixture(scope="module")
def reference():
    boundary = asymmetric()
    edge = np.linalg.norm(np.diff(boundary.vertices, axis=0), axis=1).mean()
    return boundary, edge, fitted(boundary, edge)


def triangle_set(triangles):
    return {tuple(sorted(triangle)) for triangle in triangles.tolist()}


def assert_same_shape(a, b):
    """Equally exact, and as fair to 1 %."""
    assert b.mesh.max_flattenability <= 1e-9
    assert bending(b.mesh.vertices, b.mesh.triangles) == pytest.approx(
        bending(a.mesh.vertices, a.mesh.triangles), rel=0.01
    )
    assert normal_deviations(b).mean() == pytest.approx(normal_deviations(a).mean(), rel=0.01)


@pytest.mark.parametrize("scale", [1.0, 0.01, 39.37])
def test_rigid_motion_and_scale(reference, scale):
    boundary, edge, a = reference
    frame = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    shift = np.array([100.0, -2000.0, 30.0])
    b = fitted(moved(boundary, frame, shift, scale), edge * scale)
    size = 200.0 * scale
    np.testing.assert_allclose(
        b.planar_boundary.positions, scale * a.planar_boundary.positions, atol=1e-9 * size
    )
    assert triangle_set(a.planar.triangles) == triangle_set(b.planar.triangles)
    np.testing.assert_allclose(b.planar.positions, scale * a.planar.positions, atol=1e-9 * size)
    np.testing.assert_allclose(
        b.warped.vertices, scale * a.warped.vertices @ frame.T + shift, atol=1e-9 * max(size, 2000.0)
    )
    assert_same_shape(a, b)


def matched(points, others, tolerance):
    """For every point the other one at the same place."""
    distance, index = cKDTree(others).query(points)
    assert distance.max() <= tolerance
    assert len(np.unique(index)) == len(points)
    return index


def test_start_vertex(reference):
    boundary, edge, a = reference
    n = len(boundary.vertices)
    b = fitted(curve(np.roll(boundary.vertices, 17, axis=0), np.roll(boundary.normals, 17, axis=0)), edge)
    np.testing.assert_allclose(
        np.roll(b.planar_boundary.positions, -17, axis=0), a.planar_boundary.positions, atol=1e-9 * 200
    )
    index = matched(a.planar.positions, b.planar.positions, 1e-9 * 200)
    assert np.array_equal(index[:n], (np.arange(n) + 17) % n)
    np.testing.assert_allclose(b.warped.vertices[index], a.warped.vertices, atol=1e-9 * 200)
    assert_same_shape(a, b)


def test_reversal_with_flipped_normals_gives_the_mirror_image(reference):
    """The same patch seen from the other side."""
    boundary, edge, a = reference
    # Vertex i goes to -i; the edge from i to i + 1 becomes the one from -(i + 1) to -i.
    b = fitted(
        curve(np.roll(boundary.vertices[::-1], 1, axis=0), -boundary.normals[::-1]), edge
    )
    mirror = np.array([1.0, -1.0])
    np.testing.assert_allclose(
        np.roll(b.planar_boundary.positions[::-1], 1, axis=0) * mirror, a.planar_boundary.positions, atol=2e-7
    )
    index = matched(a.planar.positions * mirror, b.planar.positions, 1e-9 * 200)
    np.testing.assert_allclose(b.warped.vertices[index], a.warped.vertices, atol=1e-9 * 200)
    assert_same_shape(a, b)


def congruent(points, others):
    """Largest distance left by the best rigid motion (no mirroring) of one (n, 2) figure onto the other."""
    a, b = points - points.mean(axis=0), others - others.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    u[:, -1] *= np.sign(np.linalg.det(u @ v))
    return np.linalg.norm(a @ u @ v - b, axis=1).max()


def test_a_planar_boundary_comes_back_congruent():
    """Also one with reflex corners, in a slanted plane far from the origin."""
    outline = np.array([[0, 0], [120, 0], [120, 80], [70, 80], [70, 30], [40, 40], [40, 90], [0, 90.0]])
    outline = shapely.segmentize(shapely.linearrings(outline), 11.0)
    outline = shapely.get_coordinates(outline)[:-1]
    frame = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    vertices = np.c_[outline, np.zeros(len(outline))] @ frame.T + [500, 600, 700]
    result = fitted(curve(vertices, np.tile(frame[:, 2], (len(outline), 1))), 11.0)
    assert congruent(result.planar_boundary.positions, outline) <= 1e-9 * 120
    assert congruent(result.outline, outline) <= 1e-8 * 120


def rolled(surface, unrolled, n):
    """Boundary through n points of an ellipse-like outline in the plane, carried to a developable surface."""
    t = (np.arange(n) + 0.25) * 2 * np.pi / n
    q = np.c_[0.9 * np.cos(t) + 0.15 * np.cos(2 * t), 0.6 * np.sin(t)]
    middle = 0.5 * (q + np.roll(q, -1, axis=0))
    step = 1e-6
    normals = np.cross(
        surface(middle + [step, 0]) - surface(middle - [step, 0]),
        surface(middle + [0, step]) - surface(middle - [0, step]),
    )
    return boundary_curve(surface(q), normals), 100.0 * unrolled(q)


def cylinder(q):
    return np.c_[np.sin(q[:, 0]), q[:, 1], np.cos(q[:, 0])]


def cone(q):
    """The plane's point at distance r and angle phi from the apex (0, -3) goes to a cone of half angle 30 degrees."""
    x, y = q[:, 0], q[:, 1] + 3.0
    r, phi = np.hypot(x, y), np.arctan2(x, y)
    return np.c_[0.5 * r * np.sin(2 * phi), 0.5 * r * np.cos(2 * phi), -np.sqrt(0.75) * r]


@pytest.mark.parametrize("surface", [cylinder, cone])
def test_a_boundary_on_a_developable_surface_comes_back_unrolled(surface, capsys):
    """The flat outline tends to the unrolled curve with the mesh, at least linearly (the edges follow no ruling)."""
    counts, errors = np.array([40, 80, 160]), []
    for n in counts:
        boundary, unrolled = rolled(surface, lambda q: q, n)
        edge = np.linalg.norm(np.diff(boundary.vertices, axis=0), axis=1).mean()
        errors.append(congruent(fitted(boundary, edge).outline, unrolled))
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    with capsys.disabled():
        print(f"\n{surface.__name__}: outline off by {np.round(errors, 4)} mm of 180, fitted order {order:.2f}")
    assert order >= 1.0
    assert errors[-1] < 0.5
