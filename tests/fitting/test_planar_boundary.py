"""B^p: congruent for planar curves, unrolled on developables, free of frame and first vertex; its failures."""

import numpy as np
import pytest

from flatnet.failure import PatchFailure
from flatnet.fitting.planar_boundary import canonical_frame, fit_planar_boundary
from flatnet.network.patch import BoundaryCurve, Stretch

TURN = 2.0 * np.pi


def boundary_of(vertices, normals, min_angles=None, slit_tips=()):
    """The curve in two seams, with the normals made orthogonal to their edges."""
    n = len(vertices)
    edges = np.roll(vertices, -1, axis=0) - vertices
    normals = np.cross(np.cross(edges, normals), edges)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    stretches = (Stretch("front", 0, n // 2, False), Stretch("back", n // 2, n - n // 2, True))
    bounds = np.zeros(n) if min_angles is None else np.asarray(min_angles, dtype=float)
    return BoundaryCurve(np.array(vertices, dtype=float), normals, stretches, bounds, slit_tips)


def rotation(seed):
    q = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return q * np.linalg.det(q)


def planar(outline, seed=1):
    """A plane outline somewhere in space."""
    frame = rotation(seed)
    vertices = np.c_[outline, np.zeros(len(outline))] @ frame.T + [100.0, -50.0, 20.0]
    return boundary_of(vertices, np.tile(frame[:, 2], (len(outline), 1)))


def edge_lengths(positions):
    return np.linalg.norm(np.roll(positions, -1, axis=0) - positions, axis=1)


def distances(positions):
    return np.linalg.norm(positions[:, None] - positions[None], axis=2)


def blob(n):
    """A non-convex outline without symmetry."""
    t = TURN * np.arange(n) / n
    radius = 50 * (1 + 0.35 * np.cos(3 * t) + 0.15 * np.sin(2 * t + 0.4))
    return radius[:, None] * np.c_[1.3 * np.cos(t), np.sin(t)]


def dome(n=60):
    """A closed curve on a paraboloid with its normals: nothing flat fits it exactly."""
    outline = blob(n) / 60

    def surface(xy):
        return 60 * np.c_[xy, 0.3 * xy[:, 0] ** 2 + 0.2 * xy[:, 1] ** 2]

    middle = 0.5 * (outline + np.roll(outline, -1, axis=0))
    return boundary_of(surface(outline), np.c_[-0.6 * middle[:, 0], -0.4 * middle[:, 1], np.ones(n)])


@pytest.mark.parametrize(
    "outline",
    [
        np.array([[0, 0], [70, 0], [10, 40]]),
        np.array([[0, 0], [60, 0], [60, 40], [0, 40]]),
        np.array([[0, 0], [60, 0], [60, 40], [40, 40], [40, 15], [20, 15], [20, 40], [0, 40]]),
        60 * np.c_[np.cos(TURN * np.arange(300) / 300), np.sin(TURN * np.arange(300) / 300)],
        blob(400),
    ],
    ids=["triangle", "rectangle", "U", "circle", "blob"],
)
def test_a_planar_boundary_comes_back_congruent(outline):
    flat = fit_planar_boundary(planar(outline.astype(float)))
    assert distances(flat.positions) == pytest.approx(distances(outline), abs=1e-10 * np.ptp(outline))
    assert flat.angle_error < 1e-20
    x, y = flat.positions.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0.0


def test_edge_lengths_are_those_of_the_curve():
    boundary = dome(200)
    flat = fit_planar_boundary(boundary)
    assert edge_lengths(flat.positions) == pytest.approx(edge_lengths(boundary.vertices), rel=1e-12)
    assert (flat.inner_angles >= flat.lower_bounds).all()


def test_min_angle_is_kept():
    wanted = np.zeros(60)
    wanted[7] = np.radians(200.0)
    boundary = dome()
    assert fit_planar_boundary(boundary).inner_angles[7] < wanted[7]
    raised = BoundaryCurve(boundary.vertices, boundary.normals, boundary.stretches, wanted)
    assert fit_planar_boundary(raised).inner_angles[7] == pytest.approx(wanted[7], abs=1e-12)


def roll_up(radius):
    """Isometric image of the plane on a cylinder, and its normals."""

    def surface(uv):
        angle = uv[:, 0] / radius
        return np.c_[radius * np.sin(angle), uv[:, 1], radius * np.cos(angle)]

    def normal(uv):
        angle = uv[:, 0] / radius
        return np.c_[np.sin(angle), 0 * angle, np.cos(angle)]

    return surface, normal


def roll_up_cone(slope=0.6, apex=120.0):
    """Isometric image of the plane on a cone: polar coordinates about (-apex, 0) with stretched angle."""

    def polar(uv):
        moved = uv + [apex, 0.0]
        return np.linalg.norm(moved, axis=1), np.arctan2(moved[:, 1], moved[:, 0]) / np.cos(slope)

    def surface(uv):
        r, angle = polar(uv)
        return r[:, None] * np.c_[np.cos(slope) * np.cos(angle), np.cos(slope) * np.sin(angle), 0 * r - np.sin(slope)]

    def normal(uv):
        _, angle = polar(uv)
        return np.c_[np.sin(slope) * np.cos(angle), np.sin(slope) * np.sin(angle), 0 * angle + np.cos(slope)]

    return surface, normal


@pytest.mark.parametrize("roll", [roll_up(60.0), roll_up_cone()], ids=["cylinder", "cone"])
def test_a_curve_on_a_developable_comes_back_unrolled(roll):
    """Chords and mid-edge normals are exact to second order in the edge length."""
    surface, normal = roll
    errors = []
    for n in (100, 200, 400):
        outline = blob(n) * 0.6
        middle = 0.5 * (outline + np.roll(outline, -1, axis=0))
        flat = fit_planar_boundary(boundary_of(surface(outline), normal(middle)))
        errors.append(np.abs(flat.positions - canonical_frame(outline)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    print(f"errors {errors} mm, orders {orders}")
    assert errors[-1] < 0.02
    assert (orders > 1.8).all()


def test_rigid_motion_and_scale_do_not_matter():
    boundary = dome()
    flat = fit_planar_boundary(boundary)
    turn = rotation(4)
    moved = boundary_of(2.5 * boundary.vertices @ turn.T + [1e3, 2e3, -5e2], boundary.normals @ turn.T)
    scale = np.ptp(flat.positions)
    assert fit_planar_boundary(moved).positions == pytest.approx(2.5 * flat.positions, abs=1e-9 * scale)


@pytest.mark.parametrize("shift", [1, 17, 44])
def test_the_first_vertex_does_not_matter(shift):
    boundary = dome()
    flat = fit_planar_boundary(boundary)
    rolled = boundary_of(np.roll(boundary.vertices, -shift, axis=0), np.roll(boundary.normals, -shift, axis=0))
    again = np.roll(fit_planar_boundary(rolled).positions, shift, axis=0)
    assert again == pytest.approx(flat.positions, abs=1e-9 * np.ptp(flat.positions))


def test_the_other_side_is_the_mirror_image():
    boundary = dome()
    flat = fit_planar_boundary(boundary)
    turned = boundary_of(boundary.vertices[::-1], -np.roll(boundary.normals[::-1], -1, axis=0))
    mirrored = fit_planar_boundary(turned).positions[::-1]
    assert mirrored == pytest.approx(flat.positions * [1.0, -1.0], abs=1e-9 * np.ptp(flat.positions))


@pytest.mark.parametrize("sides", [3, 4, 6])
def test_a_regular_polygon_points_along_x(sides):
    t = TURN * np.arange(sides) / sides + 0.3
    framed = canonical_frame(np.c_[np.cos(t), np.sin(t)] + [5.0, 7.0])
    assert framed[0] == pytest.approx([1.0, 0.0], abs=1e-12)


def test_the_frame_lies_along_the_longer_side_of_a_rectangle():
    corners = np.array([[0, 0], [3, 0], [3, 1], [0, 1]]) - [1.5, 0.5]
    for angle in np.linspace(0, TURN, 7):
        c, s = np.cos(angle), np.sin(angle)
        assert np.abs(canonical_frame(corners @ [[c, s], [-s, c]])) == pytest.approx(np.abs(corners), abs=1e-12)


@pytest.mark.parametrize("shift", range(4))
def test_the_frame_of_a_mirror_symmetric_shape_has_one_sense(shift):
    """No third moment along x: that of y decides, not round-off."""
    trapezium = np.array([[-3, 0], [3, 0], [2, 1], [-2, 1]]) * 10.0
    c, s = np.cos(1.0 + 2.0 * shift), np.sin(1.0 + 2.0 * shift)
    framed = np.roll(canonical_frame(np.roll(trapezium, shift, axis=0) @ [[c, s], [-s, c]]), -shift, axis=0)
    assert framed == pytest.approx(canonical_frame(trapezium), abs=1e-12)


def test_lemma_2_never_fires_on_closed_polygons():
    """Fenchel: the angles of a closed polygon in space add up to at most (n - 2) pi."""
    rng = np.random.default_rng(11)
    for _ in range(200):
        n = int(rng.integers(3, 30))
        vertices = rng.normal(size=(n, 3)) * [1, 1, rng.choice([0.0, 1e-6, 1.0])]
        try:
            flat = fit_planar_boundary(boundary_of(vertices, rng.normal(size=(n, 3))))
        except PatchFailure as failure:
            assert failure.finding.code == "self_intersection"
        else:
            assert flat.lemma_2_margin > -1e-13 * n


@pytest.mark.parametrize("n", [3, 4, 50, 3000])
def test_planar_convex_patches_have_no_margin_and_pass(n):
    t = TURN * np.arange(n) / n
    flat = fit_planar_boundary(planar(100 * np.c_[1.5 * np.cos(t), np.sin(t)]))
    assert flat.lemma_2_margin == pytest.approx(0.0, abs=1e-13 * n)


def test_lemma_2_fires_by_the_amount_that_min_angle_adds():
    square = np.array([[0, 0], [60, 0], [60, 60], [0, 60]], dtype=float)
    vertices = np.c_[square, np.zeros(4)]
    raised = np.radians([95.0, 0.0, 92.0, 0.0])
    with pytest.raises(PatchFailure) as caught:
        fit_planar_boundary(boundary_of(vertices, np.tile([0, 0, 1.0], (4, 1)), raised))
    finding = caught.value.finding
    assert finding.code == "lemma_2"
    assert finding.amount == pytest.approx(np.radians(7.0), abs=1e-12)
    assert "'front' at 0.0 mm" in finding.where and "'back'" in finding.where


def helix_strip(turns):
    """A strip of constant width up a spiral staircase: unrolled, an annulus that goes round `turns` times."""
    t = np.linspace(0.0, TURN * turns, int(30 * turns))
    inner, outer = (np.c_[r * np.cos(t), r * np.sin(t), 8.0 * t] for r in (40.0, 60.0))
    return boundary_of(np.concatenate([outer, inner[::-1]]), np.tile([0, 0, 1.0], (2 * len(t), 1)))


def test_a_boundary_whose_outline_crosses_itself_names_the_places():
    fit_planar_boundary(helix_strip(0.8))
    with pytest.raises(PatchFailure) as caught:
        fit_planar_boundary(helix_strip(1.7))
    finding = caught.value.finding
    assert finding.code == "self_intersection"
    assert finding.amount >= 1
    assert "'front' at " in finding.where and " mm" in finding.where


def test_opposed_normals_are_warned_about_and_take_the_angle_in_space():
    square = np.array([[0, 0, 0], [60, 0, 0], [60, 60, 0], [0, 60, 0]], dtype=float)
    normals = np.array([[0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, 1]], dtype=float)
    flat = fit_planar_boundary(boundary_of(square, normals))
    assert [warning.code for warning in flat.warnings] == ["opposed_normals"] * 2
    assert "'front' at 60.0 mm" in flat.warnings[0].where
    assert flat.predicted_angles[1] == pytest.approx(np.pi / 2)


def slit_sheet(height):
    """A square on z = height(x) with a slit from the middle of its lower side to its centre."""
    step = np.linspace(0, 1, 11)[:-1]
    corners = np.array([[0, 0], [30, 0], [30, 30], [30, 0], [60, 0], [60, 60], [0, 60]], dtype=float)
    outline = np.concatenate([a + step[:, None] * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0))])
    vertices = np.c_[outline, height(outline[:, 0])]
    middle = 0.5 * (outline[:, 0] + np.roll(outline[:, 0], -1))
    slope = (height(middle + 1e-3) - height(middle - 1e-3)) / 2e-3
    return boundary_of(vertices, np.c_[-slope, 0 * slope, 0 * slope + 1], slit_tips=(20,))


@pytest.mark.parametrize("bend", [0.0, 8.0])
def test_a_slit_may_touch_itself_and_its_tip_turns_by_a_full_circle(bend):
    flat = fit_planar_boundary(slit_sheet(lambda x: bend * np.cos(x / 15)))
    assert flat.predicted_angles[20] == TURN
    assert flat.inner_angles[20] == pytest.approx(TURN, abs=1e-3)
    assert edge_lengths(flat.positions)[10:20] == pytest.approx(np.full(10, 3.0), rel=1e-12)


def test_malformed_boundaries_are_refused():
    with pytest.raises(PatchFailure, match=r"degenerate_curve: .* longer than 0; the edge from 'a' at 0\.0 mm"):
        fit_planar_boundary(
            BoundaryCurve(np.zeros((4, 3)), np.tile([0, 0, 1.0], (4, 1)), (Stretch("a", 0, 4, False),), np.zeros(4))
        )
