"""Marks: carried from the fitted mesh to the flat piece by the same place of the same triangle."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
from pieces import SQUARE, cloth, fitted, seams_of

from flatnet.export.svg import write_piece
from flatnet.fitting.results import FlattenableMesh
from flatnet.pattern import make_piece
from flatnet.pattern.marks import carry
from flatnet.project.patch_specs import MarkSpec
from flatnet.project.problems import Mark as Place

RADIUS, COLUMNS, ROWS = 60.0, 9, 6


@pytest.fixture(scope="module")
def bent():
    """A sheet of 8 x 5 squares of 12 mm bent to a prism, its outline first, and flat."""
    column, row = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS), indexing="ij")
    places = np.column_stack([column.ravel(), row.ravel()])
    rim = [*((i, 0) for i in range(COLUMNS - 1)), *((COLUMNS - 1, j) for j in range(ROWS - 1))]
    rim += [*((i, ROWS - 1) for i in range(COLUMNS - 1, 0, -1)), *((0, j) for j in range(ROWS - 1, 0, -1))]
    inner = [tuple(p) for p in places.tolist() if tuple(p) not in set(rim)]
    order = {place: number for number, place in enumerate([*rim, *inner])}
    flat = 12.0 * np.array([*rim, *inner], float)
    turn = 2.0 * np.arcsin(6.0 / RADIUS) * flat[:, 0] / 12.0  # chords of 12 mm
    space = np.column_stack([RADIUS * np.sin(turn), flat[:, 1], RADIUS * np.cos(turn)])
    triangles = np.array(
        [
            [order[i + a, j + b] for a, b in corners]
            for i in range(COLUMNS - 1)
            for j in range(ROWS - 1)
            for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1)))
        ]
    )
    sheet = fitted(flat[: len(rim)], stretches=None)
    mesh = FlattenableMesh(space, triangles, len(rim), "fair", {}, "converged", 1)
    return replace(sheet, mesh=mesh, flat=flat)


@pytest.mark.parametrize("seed", range(5))
def test_points_of_the_mesh_keep_their_barycentric_coordinates(bent, seed):
    random = np.random.default_rng(seed)
    triangles = random.integers(0, len(bent.mesh.triangles), 40)
    weights = random.dirichlet(np.ones(3), 40)
    corners = bent.mesh.triangles[triangles]
    points = np.einsum("kc,kcd->kd", weights, bent.mesh.vertices[corners])
    flat, distance = carry(bent, points)
    assert np.abs(flat - np.einsum("kc,kcd->kd", weights, bent.flat[corners])).max() <= 1e-9
    assert distance.max() <= 1e-9


def spec(points, name="m", kind="line", **rest):
    usual = {"spline": False, "closed": False, "diameter": None, "mark": Place(1, 1)}
    return MarkSpec(name, kind, tuple(np.array(points, float)), **{**usual, **rest})


def made(bent, *marks):
    return make_piece(bent, cloth(), seams_of(bent), marks=marks)


def over(bent, flat):
    """Points in space of places on the flat sheet."""
    flat = np.array(flat, float)
    panel = np.minimum(flat[:, 0] // 12.0, COLUMNS - 2)
    turn = 2.0 * np.arcsin(6.0 / RADIUS)
    left, right = (np.column_stack([np.sin(t), np.cos(t)]) * RADIUS for t in (panel * turn, (panel + 1) * turn))
    part = (flat[:, 0] / 12.0 - panel)[:, None]
    round_ = (1 - part) * left + part * right
    return np.column_stack([round_[:, 0], flat[:, 1], round_[:, 1]])


def test_a_line_along_the_surface_keeps_its_length_and_its_ends(bent):
    places = [[6.0 * k, 7.0 + 5.0 * k] for k in range(10)]  # a straight line of the flat sheet, on every crease a point
    (mark,) = made(bent, spec(over(bent, places), kind="stitch")).marks
    assert mark.points[[0, -1]] == pytest.approx(np.array(places)[[0, -1]], abs=1e-9)
    straight = np.hypot(54.0, 45.0)
    assert shapely.LineString(mark.points).length == pytest.approx(straight, abs=1e-9)


def test_a_closed_spline_comes_back(bent):
    (mark,) = made(bent, spec(over(bent, [[20, 20], [60, 20], [40, 45]]), spline=True, closed=True)).marks
    assert mark.points[0] == pytest.approx(mark.points[-1], abs=1e-9)
    assert shapely.LinearRing(mark.points).is_simple


def test_a_hole_is_a_circle_of_its_diameter(bent):
    (mark,) = made(bent, spec(over(bent, [[40, 30]]), kind="eyelet", diameter=5.0)).marks
    assert mark.points == pytest.approx(np.array([[40.0, 30.0]]), abs=1e-9)
    *cross, circle = mark.lines
    assert np.linalg.norm(circle - mark.points, axis=1) == pytest.approx(2.5)
    assert [np.linalg.norm(line[1] - line[0]) for line in cross] == pytest.approx([6.0, 6.0])


def test_a_mark_off_its_patch_is_a_warning(bent):
    (place,) = over(bent, [[42, 30]])  # the middle of a panel, whose normal points away from the axis
    out = place * [1, 0, 1] / np.hypot(place[0], place[2])
    piece = made(bent, spec([place + 30.0 * out]))
    (warning,) = [w for w in piece.warnings if w.code == "mark_off"]
    assert warning.amount == pytest.approx(30.0, abs=1e-6) and "'m'" in warning.where


def test_marks_are_internal_lines_that_text_keeps_clear_of(bent, tmp_path):
    lines = [spec(over(bent, [[x, 5], [x, 55]]), f"stripe_{x}", "stripe") for x in (30, 60)]
    piece = made(bent, *lines)
    write_piece(tmp_path / "p.svg", piece)
    paths = [e for e in ElementTree.parse(tmp_path / "p.svg").iter() if e.get("class") == "internal"]
    assert [(path.get("data-name"), path.get("data-kind")) for path in paths] == [
        ("stripe_30", "stripe"), ("stripe_60", "stripe")
    ]  # fmt: skip
    drawn = shapely.MultiLineString([mark.points for mark in piece.marks])
    for label in [piece.label, *(run.label for run in piece.seams if run.label)]:
        assert not label.box.intersects(drawn)


def test_a_piece_without_marks_has_none():
    patch = fitted(SQUARE)
    assert make_piece(patch, cloth(), seams_of(patch)).marks == ()
