"""M^p: a triangulated disk inside any simple outline, of good triangles, the same whichever vertex is first."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from flatnet.failure import PatchFailure
from flatnet.fitting.results import PlanarBoundary, PlanarMesh
from flatnet.fitting.tessellation import sample, tessellate
from flatnet.geometry.delaunay import planar_cross
from flatnet.geometry.triangles import (
    angle_sums,
    corner_angles,
    edge_lengths,
    edges_of,
    hinges_of,
    signed_areas,
)


def divided(corners, length):
    """A polygon whose sides are divided into edges of about the given length, centred."""
    corners = np.array(corners, dtype=float)
    parts = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        count = max(1, round(np.linalg.norm(b - a) / length))
        parts.append(a + (b - a) * np.arange(count)[:, None] / count)
    outline = np.concatenate(parts)
    return outline - outline.mean(axis=0)


def round_outline(angles, radius=1.0):
    return np.asarray(radius)[..., None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def hook():
    """A broad body with an arm that hooks upwards and a second one to the right, a bay between."""
    t = np.arange(110) / 110
    spine = [(0, 0), (6, 0), (7, 1), (9, 1.2), (11, 2.5), (10.3, 3.4), (8.6, 2.4), (6.5, 2.6), (5.8, 4), (6.2, 6)]
    spine += [(5.2, 7.6), (3.2, 7.8), (1.8, 6.6), (2.2, 5.6), (3.4, 6.4), (4.4, 5.6), (3.8, 3.8), (2, 3.2)]
    spine += [(0.2, 2.4)]
    spine = np.array([*spine, spine[0]])
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(spine, axis=0), axis=1))]
    return np.stack([np.interp(t * along[-1], along, spine[:, c]) for c in range(2)], axis=1) - [5, 4]


def uneven(seed, count=60):
    """An ellipse with edges of random lengths, up to 1 : 10."""
    weights = np.exp(np.random.default_rng(seed).uniform(0, np.log(10), count))
    return round_outline(np.cumsum(weights) / weights.sum() * 2 * np.pi, 3.0) * [1.4, 1.0]


def blob(seed, count):
    rng = np.random.default_rng(seed)
    angles = np.arange(count) / count * 2 * np.pi
    waves = np.arange(1, 7)
    height, phase = 0.12 * rng.normal(size=6), rng.uniform(0, 2 * np.pi, 6)
    return round_outline(angles, 1 + (height * np.cos(angles[:, None] * waves + phase)).sum(axis=1))


def circle(count, radius=1.0):
    return round_outline(np.arange(count) / count * 2 * np.pi, radius)


def star():
    return divided(round_outline(np.arange(10) / 10 * 2 * np.pi, np.where(np.arange(10) % 2, 1.6, 4.0)), 0.4)


#: name -> outline, edge length, degrees that no angle may be below, save at corners that sharpness explains
OUTLINES = {
    "square": (divided([(-5, -5), (5, -5), (5, 5), (-5, 5)], 1), 1.0, 35),
    "circle": (circle(40, 6.4), 1.0, 35),
    "strip": (divided([(-20, -1), (20, -1), (20, 1), (-20, 1)], 1), 1.0, 35),
    "narrow strip": (divided([(-20, -0.4), (20, -0.4), (20, 0.4), (-20, 0.4)], 1), 1.0, 30),
    "L": (divided([(-4, -4), (6, -4), (6, 0), (0, 0), (0, 6), (-4, 6)], 1), 1.0, 35),
    "hook": (hook(), 0.35, 25),
    "star": (star(), 0.4, 25),
    "sharp tip": (divided([(-6, 0), (6, -2.1), (6, 2.1)], 0.6), 0.6, 20),
    "U": (divided([(-4, -4), (4, -4), (4, 6), (2, 6), (2, -2), (-2, -2), (-2, 6), (-4, 6)], 0.7), 0.7, 35),
    "blob": (blob(0, 80), 0.09, 27),
    "uneven": (uneven(0), 0.4, 25),
    "uneven, coarse inside": (uneven(2), 0.8, 25),
    "fine boundary": (circle(400), 0.5, 25),
    "coarse boundary": (divided([(-5, -3), (5, -3), (5, 3), (-5, 3)], 2.0), 0.4, 20),
    "wide edges": (divided([(-5, -0.7), (5, -0.7), (5, 0.7), (-5, 0.7)], 3), 3.0, 10),
    "triangle": (divided([(0, 0), (2, 0), (1, 1.7)], 9), 1.0, 8),
    "quadrilateral": (divided([(-1, -1), (1.5, -1), (1, 1), (-1, 0.4)], 9), 1.0, 10),
    "twelve edges": (circle(12, 1.9), 1.0, 30),
}


def boundary_of(outline) -> PlanarBoundary:
    zeros = np.zeros((3, len(outline)))
    return PlanarBoundary(np.array(outline, dtype=float), *zeros)


def tessellated(outline, edge_length) -> PlanarMesh:
    return tessellate(boundary_of(outline), edge_length)


def degrees_of(mesh):
    return np.bincount(edges_of(mesh.triangles).ravel(), minlength=len(mesh.positions))


def assert_good_disk(mesh, outline):
    n = len(outline)
    assert mesh.boundary_count == n
    assert np.array_equal(mesh.positions[:n], outline)
    edges, hinges = edges_of(mesh.triangles), hinges_of(mesh.triangles)
    assert len(mesh.positions) - len(edges) + len(mesh.triangles) == 1
    rim = {tuple(edge) for edge in edges.tolist()} - {tuple(edge) for edge in hinges[:, :2].tolist()}
    assert rim == {tuple(sorted((i, (i + 1) % n))) for i in range(n)}
    areas = signed_areas(mesh.positions, mesh.triangles)
    assert areas.min() > 0
    area = 0.5 * planar_cross(outline, np.roll(outline, -1, axis=0)).sum()
    assert areas.sum() == pytest.approx(area, rel=1e-12)
    assert not (hinges[:, :2] < n).all(axis=1).any(), "an interior edge joins two boundary vertices"
    degrees = degrees_of(mesh)
    assert degrees[:n].min() >= 3, "a triangle has two boundary edges"
    assert degrees[n:].min() >= 4


@pytest.mark.parametrize("name", OUTLINES)
def test_every_outline_gets_a_disk_of_good_triangles(name):
    outline, edge_length, least = OUTLINES[name]
    mesh = tessellated(outline, edge_length)
    assert_good_disk(mesh, outline)

    angles = np.degrees(corner_angles(mesh.positions, mesh.triangles))
    corner = np.degrees(angle_sums(mesh.positions, mesh.triangles))
    corner[len(outline) :] = 360.0
    # A corner below 50 degrees is halved, as no triangle may have two boundary edges.
    bound = np.minimum(least, 0.45 * corner[mesh.triangles])
    assert (angles >= bound).all()


@pytest.mark.parametrize(
    ("name", "enough"), [("triangle", 12), ("quadrilateral", 20), ("twelve edges", 30), ("L", 30)]
)
def test_small_patches_get_about_forty_interior_vertices(name, enough):
    outline, _, _ = OUTLINES[name]
    mesh = tessellated(outline, 100.0)
    assert enough <= len(mesh.positions) - len(outline) <= 60


def test_inside_a_large_patch_the_triangles_are_regular_and_as_long_as_asked():
    outline, _, _ = OUTLINES["square"]
    points, triangles = sample(outline, 0.5, np.radians(120))
    assert np.allclose(edge_lengths(points, edges_of(triangles)), 0.5, rtol=1e-12)
    assert (signed_areas(points, triangles) > 0).all()

    mesh = tessellated(outline, 0.5)
    lengths = edge_lengths(mesh.positions, edges_of(mesh.triangles))
    assert np.median(lengths) == pytest.approx(0.5, rel=0.01)


def test_triangles_grade_from_short_boundary_edges():
    outline, edge_length, _ = OUTLINES["fine boundary"]
    mesh = tessellated(outline, edge_length)
    lengths = edge_lengths(mesh.positions, edges_of(mesh.triangles))
    assert lengths.max() > 8 * 2 * np.pi / 400
    # Graded, not fine all over: a uniform mesh of the boundary's edges would have 29,000 vertices.
    assert len(mesh.positions) < 3 * len(outline)


def asymmetric():
    rng = np.random.default_rng(1)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
    return divided(round_outline(angles, rng.uniform(0.4, 1.0, 9)), 0.1)


@pytest.mark.parametrize("outline", [uneven(1), hook() / 4, asymmetric()], ids=["uneven", "hook", "polygon"])
@pytest.mark.parametrize("change", ["start", "scale", "mirror", "round-off"])
def test_the_same_outline_gets_the_same_mesh(outline, change):
    start, scale, signs = 0, 1.0, np.ones(2)
    changed = outline
    if change == "start":
        start = len(outline) // 3
        changed = np.roll(outline, -start, axis=0)
    elif change == "scale":
        scale = 3.7
        changed = outline * scale
    elif change == "mirror":
        signs = np.array([1.0, -1.0])
        changed = (outline * signs)[::-1]
    else:
        changed = outline * (1 + 1e-13 * np.random.default_rng(0).normal(size=outline.shape))
    first, second = tessellated(outline, 0.12), tessellated(changed, 0.12 * scale)

    back = second.positions * signs / scale
    distance, partner = cKDTree(first.positions).query(back)
    assert len(first.positions) == len(second.positions)
    assert distance.max() <= 1e-10 * np.ptp(outline)
    renamed = partner[second.triangles]
    assert {frozenset(t) for t in first.triangles.tolist()} == {frozenset(t) for t in renamed.tolist()}


def test_a_second_run_gives_the_same_arrays():
    outline, edge_length, _ = OUTLINES["uneven"]
    first, second = tessellated(outline, edge_length), tessellated(outline, edge_length)
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.triangles, second.triangles)


SLITS = {
    "straight": [(-5, -5), (5, -5), (5, 5), (0.5, 5), (0, 0), (0.5, 5), (-5, 5)],
    "bent": [(-5, -5), (5, -5), (5, 5), (1, 5), (0, 2), (1.5, 0), (0, 2), (1, 5), (-5, 5)],
    "ring": [(-5, -5), (0, -5), (0, -2), (-2, 0), (0, 2), (2, 0), (0, -2), (0, -5), (5, -5), (5, 5), (-5, 5)],
    "forked": [(-5, -5), (5, -5), (5, 5), (0, 5), (0, 1), (2, -1), (0, 1), (-2, -1), (0, 1), (0, 5), (-5, 5)],
}


@pytest.mark.parametrize("name", SLITS)
def test_the_sides_of_a_closed_slit_stay_apart(name):
    outline = divided(SLITS[name], 1.0)
    outline -= outline.mean(axis=0)
    n = len(outline)
    previous, following = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    tips = tuple(np.flatnonzero(np.linalg.norm(previous - following, axis=1) < 1e-9).tolist())
    assert len(tips) == {"forked": 2, "ring": 0}.get(name, 1)
    mesh = tessellated(outline, 1.0)

    assert_good_disk(mesh, outline)
    assert np.degrees(corner_angles(mesh.positions, mesh.triangles)).min() > 20
    # The turning of the outline decides the angle at every boundary vertex, 2 pi at the tip.
    arriving, leaving = outline - previous, following - outline
    turn = np.arctan2(planar_cross(arriving, leaving), (arriving * leaving).sum(axis=1))
    turn[list(tips)] = -np.pi
    inner = angle_sums(mesh.positions, mesh.triangles)[:n]
    assert np.allclose(inner, np.pi - turn, atol=1e-9)


@pytest.mark.parametrize(
    "corners",
    [[(0, 0), (4, 4), (4, 0), (0, 4)], [(0, 0), (8, 0), (8, 4), (4, 0), (0, 4)]],
    ids=["crosses", "touches"],
)
def test_an_outline_that_meets_itself_fails(corners):
    with pytest.raises(PatchFailure) as caught:
        tessellated(divided(corners, 1.0), 1.0)
    finding = caught.value.finding
    assert finding.code == "self_intersection"
    assert finding.stage == "tessellation"
    assert "boundary edges" in finding.where
