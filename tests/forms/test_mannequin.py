"""The mannequin has the measurements it was asked for, told by cutting its mesh with planes."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from flatnet.forms import make_surface
from flatnet.forms.mannequin import LowerBody, mannequin, profile
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
    body = LowerBody(**measurements)
    mesh = mannequin({**measurements, "half": "both"}).mesh
    for level in ("waist", "hip", "thigh", "knee", "calf", "ankle"):
        # A hair inside, so that the plane cuts the rims at waist and ankle too.
        height = body.heights[level] + {"waist": -0.01, "ankle": 0.01}.get(level, 0.0)
        cut = section(mesh, height)
        around = cut if level in ("waist", "hip") else cut[cut[:, 0] > 0]
        assert tape(around) == pytest.approx(getattr(body, level), rel=2e-3), level


@BODIES
def test_rise_and_inseam_are_exact(measurements):
    body = LowerBody(**measurements)
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
    body = LowerBody(**measurements)
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
    body = LowerBody()
    heights = np.linspace(body.heights["ankle"], body.heights["waist"], 2001)
    cx, _, a, b = profile(body, heights)
    assert (a > 0).all() and (b > 0).all()
    assert (cx[heights < body.inseam] > a[heights < body.inseam]).all()
    assert (cx[heights > body.inseam] < a[heights > body.inseam]).all()


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
