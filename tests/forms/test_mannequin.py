"""The mannequin has the measurements it was asked for, told by cutting its mesh with planes."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from flatnet.forms import make_surface
from flatnet.forms.body import Body, profile
from flatnet.forms.mannequin import mannequin
from flatnet.forms.measurements import MeasurementError
from flatnet.project import ProjectError, load_project

UK_12 = {}
MAN = {"waist": 810.0, "hip": 1020.0, "thigh": 625.0, "knee": 410.0, "calf": 395.0, "ankle": 235.0}
MAN |= {"rise": 340.0, "inseam": 780.0}
CHILD = {"waist": 540.0, "hip": 620.0, "thigh": 350.0, "knee": 260.0, "calf": 245.0, "ankle": 180.0}
CHILD |= {"rise": 190.0, "inseam": 480.0}
BODIES = pytest.mark.parametrize("measurements", [UK_12, MAN, CHILD], ids=["uk 12", "man", "child"])


def boundary_vertices(mesh: trimesh.Trimesh) -> np.ndarray:
    edges, counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    return np.unique(edges[counts == 1])


def section(mesh: trimesh.Trimesh, height: float) -> np.ndarray:
    cut = trimesh.intersections.mesh_plane(mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height])
    return cut.reshape(-1, 3)[:, :2]


def tape(points: np.ndarray) -> float:
    """Length of a tape around points of the plane: ConvexHull's `area` of a polygon is its perimeter."""
    return ConvexHull(points).area


@BODIES
def test_girths(measurements):
    body = Body(**measurements)
    mesh = mannequin({**measurements, "half": "both"}).mesh
    for level in ("waist", "hip", "thigh", "knee", "calf", "ankle"):
        # A hair inside, so that the plane cuts the rims at waist and ankle too.
        height = body.heights[level] + {"waist": -0.01, "ankle": 0.01}.get(level, 0.0)
        cut = section(mesh, height)
        around = cut if level in ("waist", "hip") else cut[cut[:, 0] > 0]
        assert tape(around) == pytest.approx(getattr(body, level), rel=2e-3), level


@BODIES
def test_rise_and_inseam_are_exact(measurements):
    body = Body(**measurements)
    mesh = mannequin({**measurements, "half": "right"}).mesh
    in_the_middle = mesh.vertices[mesh.vertices[:, 0] == 0.0]
    assert in_the_middle[:, 2].min() == pytest.approx(body.inseam, abs=1e-9)
    assert in_the_middle[:, 2].max() == pytest.approx(body.inseam + body.rise, abs=1e-9)


@BODIES
def test_the_right_half_is_one_smooth_leg_open_at_ankle_waist_and_rises(measurements):
    mesh = mannequin({**measurements, "half": "right"}).mesh
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.euler_number == 0  # a tube: its outer rim is waist and rises, its inner one the ankle
    assert (mesh.vertices[:, 0] >= 0.0).all()
    body = Body(**measurements)
    rim = mesh.vertices[boundary_vertices(mesh)]
    ends = np.isclose(rim[:, 2], body.heights["waist"]) | np.isclose(rim[:, 2], body.heights["ankle"])
    assert (rim[~ends, 0] == 0.0).all()  # exactly in the sagittal plane
    folds = np.degrees(mesh.face_adjacency_angles)
    assert folds.max() < 15.0  # nothing is creased; 4 mm on a radius of 35 mm turn by 7 degrees


def test_the_crotch_is_a_u(tmp_path):
    """Where the rises meet, the rim turns by small steps: no corner under the body."""
    mesh = mannequin({"half": "right"}).mesh
    rim = mesh.vertices[boundary_vertices(mesh)]
    under = rim[(rim[:, 0] == 0.0) & (rim[:, 2] < 820.0)]
    under = under[np.argsort(under[:, 1])]
    steps = np.diff(under[:, 1:], axis=0)
    steps = steps[np.linalg.norm(steps, axis=1) > 0.5]  # where the cut passes near a vertex, steps are tiny
    turns = np.degrees(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
    assert np.abs(turns).max() < 15.0


def test_halves_mirror_each_other_and_join():
    left, right, both = (mannequin({"half": half}).mesh for half in ("left", "right", "both"))
    assert np.array_equal(np.abs(right.vertices), np.abs(left.vertices))
    # z up, y to the front: x points to the right of a body that looks along y.
    assert right.vertices[:, 0].min() == 0.0 and left.vertices[:, 0].max() == 0.0
    assert both.area == pytest.approx(2.0 * left.area, rel=1e-12)
    assert both.euler_number == -1  # open at waist and two ankles
    assert both.is_winding_consistent and right.is_winding_consistent
    rim = boundary_vertices(both)
    assert set(np.round(both.vertices[rim, 2])) == {76.0, 1040.0}  # the rises are closed


def test_normals_point_outwards():
    surface = mannequin({"half": "both"})
    places = np.array(
        [[0, 200, 950], [0, -200, 950], [300, 0, 900], [-300, 0, 500], [75, 200, 400], [75, -200, 400]]
    )
    feet, normals = surface.nearest(places)
    outward = places - feet
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    assert (np.einsum("ij,ij->i", normals, outward) > 0.99).all()


def test_legs_part_at_the_crotch_alone():
    body = Body()
    heights = np.linspace(body.heights["ankle"], body.heights["waist"], 2001)
    cx, _, a, b = profile(body, heights)
    assert (a > 0).all() and (b > 0).all()
    assert (cx[heights < body.inseam] > a[heights < body.inseam]).all()
    assert (cx[heights > body.inseam] < a[heights > body.inseam]).all()


@BODIES
@pytest.mark.parametrize("half", ["left", "right", "both"])
def test_lines_and_landmarks_are_on_the_surface(measurements, half):
    surface = mannequin({**measurements, "half": half})
    for name, line in surface.lines.items():
        feet, _ = surface.nearest(line.points)
        # Between two rows a line across the columns leaves the triangles by less than the chords the ellipses.
        assert np.linalg.norm(feet - line.points, axis=1).max() < 1e-9, name
        assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).max() < 8.0, name  # two edges of the grid
    landmarks = np.array(list(surface.landmarks.values()))
    assert np.linalg.norm(surface.nearest(landmarks)[0] - landmarks, axis=1).max() < 1e-9


@BODIES
def test_rings_have_the_measured_girths(measurements):
    body = Body(**measurements)
    whole = mannequin({**measurements, "half": "both"}).lines
    leg = mannequin({**measurements, "half": "right"}).lines
    for rings, names in ((whole, ("waist", "hip")), (leg, ("thigh", "knee", "calf", "ankle"))):
        for name in names:
            points = rings[name].points
            assert rings[name].closed
            assert (points[:, 2] == body.heights[name]).all()
            assert tape(points[:, :2]) == pytest.approx(getattr(body, name), rel=2e-3), name


@BODIES
def test_lines_down_start_and_end_at_the_rings_and_meet_in_the_landmarks(measurements):
    body = Body(**measurements)
    surface = mannequin({**measurements, "half": "right"})
    lines, landmarks = surface.lines, surface.landmarks
    crotch = landmarks["crotch"]
    assert crotch[0] == 0.0 and crotch[2] == body.inseam
    for name in ("front_rise", "back_rise", "inside"):
        assert crotch.tolist() == lines[name].points[-1 if name.endswith("rise") else 0].tolist()
    for name in ("front_rise", "back_rise"):
        assert (lines[name].points[:, 0] == 0.0).all()
    for level in ("waist", "hip", "thigh", "knee", "calf", "ankle"):
        for side in ("front", "outside", "back"):
            place = landmarks[f"{level}_{side}"]
            assert place[2] == body.heights[level]
            assert place.tolist() in lines[side].points.tolist()
            ring = lines[level].points
            assert np.linalg.norm(ring - place, axis=1).min() < 3.0  # between two of its points, 6 mm apart at most


def test_lines_down_are_fair():
    """No corner: in steps of about 12 mm, on radii above 70 mm, they turn by less than 10 degrees."""
    for name in ("front", "outside", "back", "inside"):
        points = mannequin({"half": "right"}).lines[name].points[::3]
        steps = np.diff(points, axis=0)
        steps /= np.linalg.norm(steps, axis=1, keepdims=True)
        assert np.degrees(np.arccos(np.einsum("ij,ij->i", steps[:-1], steps[1:]))).max() < 10.0, name


def test_both_halves_name_their_lines_by_side():
    right, both = (mannequin({"half": half}) for half in ("right", "both"))
    assert both.lines["front_rise"].points.tolist() == right.lines["front_rise"].points.tolist()
    assert both.lines["right_inside"].points.tolist() == right.lines["inside"].points.tolist()
    assert both.lines["left_inside"].points.tolist() == (right.lines["inside"].points * [-1, 1, 1]).tolist()
    assert {"crotch", "waist_centre_front", "left_knee_outside"} <= set(both.landmarks)
    assert len(both.lines["waist"].points) == 2 * len(right.lines["waist"].points) - 1


def test_two_makings_are_equal():
    first, second = mannequin({}).mesh, mannequin({}).mesh
    assert np.array_equal(first.vertices, second.vertices)
    assert np.array_equal(first.faces, second.faces)


@pytest.mark.parametrize(
    ("measurements", "message"),
    [
        ({"wasit": 700.0}, "did you mean 'waist'"),
        ({"waist": 72.0}, "waist must be in [240, 2160] mm, got 72 mm"),
        ({"waist": "wide"}, "waist must be a length"),
        ({"waist": float("nan")}, "waist must be a length"),
        ({"half": "front"}, "half must be left, right or both"),
        ({"waist": 1300.0}, "waist must be 0.4 to 1.2 times hip"),
        ({"thigh": 800.0}, "two thighs of 800 mm side by side"),
    ],
)
def test_impossible_measurements(measurements, message):
    with pytest.raises(MeasurementError) as caught:
        mannequin(measurements)
    assert message in str(caught.value)


PROJECT = """\
flatnet: 1
name: try
edge_length: 10
units: cm
surface:
{surface}
nodes: {{a: [0, 0, 0]}}
curves:
  c: {{kind: spline, from: a, to: a, points: [[1, 0, 0], [1, 1, 0]], normals: [0, 0, 1]}}
patches:
  p: {{around: [c]}}
rest: openings
"""


def project(folder: Path, surface: str):
    file = folder / "project.yaml"
    file.write_text(PROJECT.format(surface=surface))
    return load_project(file)


def test_a_form_by_name_in_the_units_of_the_project(tmp_path):
    surface = make_surface(project(tmp_path, "  form: mannequin\n  inseam: 70\n  half: left"))
    assert surface.mesh.bounds[1, 2] == pytest.approx(700.0 + 280.0)


def test_all_problems_of_a_form_are_told_with_their_place(tmp_path):
    with pytest.raises(ProjectError) as caught:
        make_surface(project(tmp_path, "  form: mannequin\n  wasit: 70\n  hip: 9"))
    assert len(caught.value.problems) == 2
    assert all(problem.mark.line in (5, 6, 7, 8) for problem in caught.value.problems)


def test_an_unknown_form(tmp_path):
    with pytest.raises(ProjectError, match="unknown form 'manequin'; did you mean 'mannequin'"):
        make_surface(project(tmp_path, "  form: manequin"))
