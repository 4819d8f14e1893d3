"""The last has the measurements it was asked for, told by cutting its mesh with planes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from flatnet.forms import make_surface
from flatnet.forms.measurements import MeasurementError
from flatnet.forms.shoe_last import ShoeLast, shoe_last
from flatnet.geometry.chains import boundary_edges, chains
from flatnet.project import load_project

LASTS = {
    "42": {},
    "38": {"size": 38.0},
    "25": {"size": 25.0, "heel": 12.0},
    "slim 40, high heel": {"size": 40.0, "ball": 225.0, "waist": 212.0, "instep": 232.0, "heel": 60.0},
    "wide 46, left": {"size": 46.0, "ball": 282.0, "waist": 270.0, "instep": 288.0, "side": "left", "toe": "square"},
    "mean forme": {"halves": "mean", "tread": 85.0, "seat": 60.0, "spring": 12.0, "toe": "almond"},
}
EVERY = pytest.mark.parametrize("measurements", LASTS.values(), ids=LASTS.keys())


@EVERY
def test_girths(measurements):
    surface, last = shoe_last(measurements), ShoeLast(**measurements)
    points = surface.landmarks
    planes = {"ball": [points[name] for name in ("inner_ball", "vamp_point", "outer_ball")]}
    for name in ("waist", "instep"):
        line = surface.lines[f"{name}_line"].points
        planes[name] = [line[0], points[f"{name}_point"], line[-1]]
    for name, (inner, top, outer) in planes.items():
        across = (outer - inner) / np.linalg.norm(outer - inner)
        up = (top - inner) - (top - inner) @ across * across
        up /= np.linalg.norm(up)
        normal = np.cross(across, up)
        cut = surface.mesh.section(normal, top).vertices - top
        tape = ConvexHull(np.stack([cut @ across, cut @ up], axis=1)).area  # of a polygon, its perimeter
        assert tape == pytest.approx(last.measured(name), rel=2e-4), name
        assert np.abs((surface.lines[f"{name}_line"].points - top) @ normal).max() < 1e-6


@EVERY
def test_length_widths_and_heights(measurements):
    surface, last = shoe_last(measurements), ShoeLast(**measurements)
    assert np.ptp(surface.mesh.vertices[:, 0]) == pytest.approx(last.length, abs=1e-9)
    assert last.length == pytest.approx(last.size * 20 / 3)
    feather = surface.lines["feather"].points
    for name, part in (("tread", feather[:, 0] > 0.5 * last.length), ("seat", feather[:, 0] < 0.25 * last.length)):
        # Between the grid's rows the widest place is missed by less than 9 / 8 r, with r over 100 mm.
        assert np.ptp(feather[part, 1]) == pytest.approx(last.measured(name), abs=0.1)
    assert surface.landmarks["heel_point"][2] == last.heel
    assert surface.landmarks["toe_point"][2] == pytest.approx(last.measured("spring"), abs=1e-9)


@EVERY
def test_one_smooth_surface_between_feather_edge_and_cone(measurements):
    surface = shoe_last(measurements)
    mesh = surface.mesh
    assert mesh.is_winding_consistent and mesh.body_count == 1 and mesh.euler_number == 0
    rims = [mesh.vertices[loop] for loop in chains(boundary_edges(mesh.faces))]
    assert len(rims) == 2
    for name in ("feather", "cone_edge"):
        line = surface.lines[name]
        assert line.closed
        assert any(set(map(tuple, line.points)) == set(map(tuple, rim)) for rim in rims), name
    # Nothing is creased: at the heel 3 mm on a radius of a twelfth of the length, 14 mm at size 25, are 12 degrees.
    assert np.degrees(mesh.face_adjacency_angles).max() < 15.0


@EVERY
def test_normals_point_outwards(measurements):
    surface, last = shoe_last(measurements), ShoeLast(**measurements)
    length = last.length
    outside = np.array([[-60, 0, 70], [0.2 * length, 150, 90], [0.2 * length, -150, 90], [length + 60, 0, 30]])
    outside = np.vstack([outside, [0.7 * length, 0, 200]])
    feet, normals = surface.nearest(outside)
    towards = (outside - feet) / np.linalg.norm(outside - feet, axis=1, keepdims=True)
    assert (np.einsum("ij,ij->i", normals, towards) > 0.9).all()


@EVERY
def test_landmarks_and_lines_lie_on_the_mesh(measurements):
    surface = shoe_last(measurements)
    named = {name: line.points for name, line in surface.lines.items()}
    named |= {name: point[None] for name, point in surface.landmarks.items()}
    for name, points in named.items():
        feet, _ = surface.nearest(points)
        assert np.linalg.norm(feet - points, axis=1).max() < 1e-9, name


def test_the_points_a_last_is_measured_by():
    surface = shoe_last({"side": "right"})
    points = surface.landmarks
    x = np.linspace(0.0, 280.0, 2001)
    feather = surface.lines["feather"].points
    outer = feather[len(feather) // 2 :][::-1]
    # Standard last length by tape, along the outer feather edge seen from the side: it lies as high as the bottom's
    # middle, but ends some mm short of heel and toe, so that a level end piece stands for a rise of up to 1 mm.
    standard = np.hypot(np.diff(x), np.diff(np.interp(x, outer[:, 0], outer[:, 2]))).sum()
    back = surface.lines["back_line"].points
    up = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(back, axis=0), axis=1))])
    assert np.allclose(points["counter_point"], [np.interp(standard / 5 + 3, up, c) for c in back.T], atol=0.3)
    assert np.linalg.norm(points["vamp_point"] - points["counter_point"]) == pytest.approx(0.75 * standard, abs=1.0)
    assert points["heel_point"] == pytest.approx(back[0]) and points["cone_back"] == pytest.approx(back[-1])
    front = surface.lines["front_line"].points
    assert points["cone_front"] == pytest.approx(front[0]) and points["toe_point"] == pytest.approx(front[-1])
    order = ["instep_point", "waist_point", "vamp_point", "toe_point"]
    assert np.all(np.diff([points[name][0] for name in order]) > 0)
    # The inner ball lies before the outer one, and on the inner side, which of a right last is the left one.
    assert points["inner_ball"][0] > points["outer_ball"][0]
    assert points["inner_ball"][1] > 0 > points["outer_ball"][1]


def test_stations_run_from_the_feather_edge_to_ridge_or_cone():
    lines = shoe_last({}).lines
    feather, front = lines["feather"].points, lines["front_line"].points
    for percent in range(5, 100, 5):
        inner, outer = (lines[f"{side}_{percent}"].points for side in ("inner", "outer"))
        assert (feather == inner[0]).all(axis=1).any() and (feather == outer[0]).all(axis=1).any()
        if np.array_equal(inner[-1], outer[-1]):
            assert (np.abs(front - inner[-1]).max(axis=1) < 1e-9).any()
        else:
            assert inner[-1][2] == pytest.approx(35.0 + 0.345 * 280.0) and percent <= 30
        assert abs(inner[:, 0].mean() - 2.8 * percent) < 12.0  # rows lean at heel and toe


def test_left_and_right_mirror_each_other():
    right, left = shoe_last({"side": "right"}), shoe_last({"side": "left"})
    assert np.array_equal(left.mesh.vertices * [1, -1, 1], right.mesh.vertices)
    assert left.mesh.is_winding_consistent and left.mesh.volume * right.mesh.volume > 0
    for name, line in right.lines.items():
        assert np.array_equal(left.lines[name].points * [1, -1, 1], line.points)
    for name, point in right.landmarks.items():
        assert np.array_equal(left.landmarks[name] * [1, -1, 1], point)


def test_the_mean_forme_is_symmetric_and_a_last_is_not():
    for halves, alike in (("mean", True), ("own", False)):
        lines = shoe_last({"halves": halves}).lines
        apart = [
            np.abs(lines[f"inner_{percent}"].points * [1, -1, 1] - lines[f"outer_{percent}"].points).max()
            for percent in (35, 45, 60)
        ]
        assert (max(apart) < 1e-9) if alike else (min(apart) > 3.0)


def test_toes_from_pointed_to_square():
    widths = []
    for toe in ("pointed", "almond", "round", "square"):
        lines = shoe_last({"toe": toe}).lines
        widths.append(np.linalg.norm(lines["inner_95"].points[0] - lines["outer_95"].points[0]))
    assert (np.diff(widths) > 3.0).all()


def test_the_arch_is_hollow_on_the_inner_side():
    """There the wall goes in by several mm from its fullest place to the feather edge; outside hardly."""
    lines = shoe_last({}).lines
    tucked = {side: np.abs(lines[f"{side}_45"].points[:, 1]) for side in ("inner", "outer")}
    assert tucked["inner"].max() - tucked["inner"][0] > 6.0
    assert tucked["outer"].max() - tucked["outer"][0] < 5.0


def test_two_makings_are_equal():
    first, second = shoe_last({}).mesh, shoe_last({}).mesh
    assert np.array_equal(first.vertices, second.vertices) and np.array_equal(first.faces, second.faces)


@pytest.mark.parametrize(
    ("measurements", "message"),
    [
        ({"sise": 38.0}, "did you mean 'size'"),
        ({"size": 280.0}, "size must be in [16, 52], got 280"),
        ({"size": "small"}, "size must be a number"),
        ({"ball": "wide"}, "ball must be a length"),
        ({"ball": 24.7}, "ball must be in [198, 309] mm at size 42, got 24.7 mm"),
        ({"heel": 90.0}, "heel must be in [0, 70] mm at size 42"),
        ({"toe": "open"}, "toe must be round, almond, pointed or square, got 'open'"),
        ({"side": "both"}, "side must be left or right, got 'both'"),
        ({"halves": "half"}, "halves must be own or mean"),
    ],
)
def test_impossible_measurements(measurements, message):
    with pytest.raises(MeasurementError) as caught:
        shoe_last(measurements)
    assert message in str(caught.value)


def test_the_size_is_no_length(tmp_path: Path):
    file = tmp_path / "project.yaml"
    file.write_text(
        "flatnet: 1\nname: try\nedge_length: 1\nunits: cm\nsurface: {form: shoe_last, size: 38, ball: 23}\n"
        "nodes: {a: [0, 0, 0]}\n"
        "curves:\n  c: {kind: spline, from: a, to: a, points: [[1, 0, 0], [1, 1, 0]], normals: [0, 0, 1]}\n"
        "patches:\n  p: {around: [c]}\nrest: openings\n"
    )
    surface = make_surface(load_project(file))
    assert np.ptp(surface.mesh.vertices[:, 0]) == pytest.approx(38 * 20 / 3)
