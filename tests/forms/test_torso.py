"""The mannequin up to the neck has the measurements it was asked for, told by cutting its mesh with planes."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from flatnet.forms.body import Body
from flatnet.forms.mannequin import mannequin
from flatnet.forms.measurements import MeasurementError

UK_20 = {"waist": 880.0, "hip": 1120.0, "thigh": 640.0, "knee": 420.0, "calf": 410.0, "ankle": 256.0}
UK_20 |= {"under_bust": 890.0, "bust": 1040.0, "high_bust": 970.0, "neck": 410.0, "bust_span": 185.0}
UK_20 |= {"back_width": 392.0, "front_width": 380.0, "shoulder": 128.0, "back_length": 426.0}
MAN = {"waist": 810.0, "hip": 1020.0, "thigh": 625.0, "rise": 340.0, "inseam": 780.0}
MAN |= {"under_bust": 930.0, "bust": 985.0, "high_bust": 980.0, "neck": 400.0, "bust_span": 180.0}
MAN |= {"back_width": 400.0, "front_width": 380.0, "shoulder": 150.0, "back_length": 460.0}
BODIES = {"uk 12": {}, "uk 20": UK_20, "man": MAN}
GIRTHS = ("hip", "waist", "under_bust", "bust", "high_bust", "neck")


@pytest.fixture(scope="module", params=BODIES)
def torso(request):
    measurements = {**BODIES[request.param], "top": "neck"}
    return Body(**measurements), mannequin(measurements), mannequin({**measurements, "half": "right"})


def tape(points: np.ndarray) -> float:
    """Length of a tape around points of the plane: ConvexHull's `area` of a polygon is its perimeter."""
    return ConvexHull(points[:, :2]).area


def way(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def test_girths(torso):
    body, both, _ = torso
    for name in GIRTHS:
        height = body.heights[name] - (0.01 if name == "neck" else 0.0)  # a hair inside the rim
        cut = trimesh.intersections.mesh_plane(both.mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height])
        # Chords of 10 mm cut off less than 0.2 % of radii above 50 mm.
        assert tape(cut.reshape(-1, 3)) == pytest.approx(getattr(body, name), rel=2e-3), name
        ring = both.lines[name]
        assert ring.closed and (ring.points[:, 2] == body.heights[name]).all()
        assert tape(ring.points) == pytest.approx(getattr(body, name), rel=2e-3), name


def test_heights_and_shoulders(torso):
    body, both, right = torso
    at = right.landmarks
    nape, waist = at["neck_centre_back"], at["waist_centre_back"]
    assert nape[2] - waist[2] == pytest.approx(body.back_length, abs=1e-9)
    assert at["underarm"][2] < at["across_back"][2] < at["shoulder_point"][2] < nape[2]
    along = at["shoulder_point"] - at["neck_outside"]
    assert np.hypot(along[0], along[2]) == pytest.approx(body.shoulder, rel=1e-9)
    points = both.landmarks
    assert np.linalg.norm(points["right_bust_point"] - points["left_bust_point"]) == pytest.approx(body.bust_span)


def test_widths_from_arm_to_arm(torso):
    """Half the width lies between the sagittal plane and the landmark, along the level cut."""
    body, _, right = torso
    for side, width in (("front", body.front_width), ("back", body.back_width)):
        place = right.landmarks[f"across_{side}"]
        cut = trimesh.intersections.mesh_plane(right.mesh, [0.0, 0.0, 1.0], [0.0, 0.0, place[2] + 1e-6])
        middle = cut.mean(axis=1)
        sign = 1.0 if side == "front" else -1.0
        # From the centre to the landmark: what is nearer to the centre, on its side of the outermost point.
        outermost = middle[middle[:, 0].argmax(), 1]
        between = (middle[:, 0] < place[0]) & (sign * (middle[:, 1] - outermost) > 0.0)
        lengths = np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1)
        assert lengths[between].sum() == pytest.approx(width / 2, abs=8.0)  # the edge that it lies on may be missed


@pytest.mark.parametrize("measurements", [{}, UK_20], ids=["uk 12", "uk 20"])
def test_what_the_bust_asks_for_beyond_the_ribs_stands_out_about_the_bust_points(measurements):
    """Only between the rings above and below, only in front, and most at the bust point."""
    body = Body(**measurements, top="neck")
    whole = mannequin({**measurements, "top": "neck", "half": "right"})
    flat = mannequin({**measurements, "top": "neck", "half": "right", "bust": body.high_bust})
    moved = whole.mesh.vertices[:, 1] - flat.mesh.vertices[:, 1]
    assert moved.min() >= -1e-9 and moved.max() > 20.0
    out = whole.mesh.vertices[moved > 1e-6]
    assert out[:, 2].min() > body.heights["under_bust"] and out[:, 2].max() < body.heights["high_bust"]
    assert (out[:, 1] > 0.0).all()
    assert moved[whole.mesh.vertices[:, 0] == 0.0].max() < 0.5  # cut from edges that cross the plane
    most = whole.mesh.vertices[moved.argmax()]
    assert np.linalg.norm((most - whole.landmarks["bust_point"])[[0, 2]]) < 6.0  # between vertices 10 mm apart


def test_the_surface_is_one_and_smooth(torso):
    body, both, right = torso
    for surface, euler in ((both, -2), (right, 0)):  # open at the neck and two ankles; a tube
        assert surface.mesh.is_winding_consistent and surface.mesh.body_count == 1
        assert surface.mesh.euler_number == euler + (1 if surface is both else 0)
    folds = np.degrees(right.mesh.face_adjacency_angles)
    height = right.mesh.vertices[right.mesh.face_adjacency_edges][:, :, 2].min(axis=1)
    assert folds[height < body.heights["across"]].max() < 20.0
    assert folds.max() < 40.0  # over the shoulder, some 20 mm round


def test_lines_and_landmarks_are_on_the_surface(torso):
    _, _, right = torso
    for name, line in right.lines.items():
        feet, _ = right.nearest(line.points[::3])
        assert np.linalg.norm(feet - line.points[::3], axis=1).max() < 1e-9, name
        assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).max() < 15.0, name
    landmarks = np.array(list(right.landmarks.values()))
    assert np.linalg.norm(right.nearest(landmarks)[0] - landmarks, axis=1).max() < 1e-9


def test_lines_of_the_torso_meet_in_the_landmarks(torso):
    _, _, right = torso
    at, lines = right.landmarks, {name: line.points for name, line in right.lines.items()}
    ends = {
        "centre_front": ("neck_centre_front", "waist_centre_front"),
        "centre_back": ("neck_centre_back", "waist_centre_back"),
        "side": ("underarm", "waist_outside"),
        "shoulder": ("neck_outside", "shoulder_point"),
        "front_rise": ("waist_centre_front", "crotch"),
        "bust": ("bust_centre_front", "bust_centre_back"),
    }
    for name, (start, end) in ends.items():
        assert lines[name][0].tolist() == at[start].tolist(), name
        assert lines[name][-1].tolist() == at[end].tolist(), name
    assert {"left_side", "right_bust_point", "right_front", "centre_back"} <= set(
        mannequin({"top": "neck"}).lines
    ) | set(mannequin({"top": "neck"}).landmarks)


def test_the_legs_are_those_of_the_body_without_a_torso():
    """Below the hip nothing depends on what is above it."""
    lower, whole = (mannequin({"half": "right", "top": top}).mesh for top in ("waist", "neck"))
    legs = [mesh.vertices[mesh.vertices[:, 2] < 760.0] for mesh in (lower, whole)]
    assert np.array_equal(np.unique(legs[0], axis=0), np.unique(legs[1], axis=0))


@pytest.mark.parametrize(
    ("measurements", "message"),
    [
        ({"bust": 900.0}, "bust is measured above the waist; say `top: neck`"),
        ({"top": "head"}, "top must be waist or neck"),
        ({"top": "neck", "bust": 1200.0}, "bust must be in [823, 933] mm over ribs"),
        ({"top": "neck", "neck": 1000.0}, "neck must be at most 0.6 times high_bust"),
        ({"top": "neck", "shoulder": 300.0}, "shoulder must be at most 0.45 times back_length"),
        ({"top": "neck", "back_width": 600.0}, "back_width must be at most"),
        ({"top": "neck", "bust_span": 310.0}, "bust_span must be at most 286 mm on these ribs"),
    ],
)
def test_impossible_measurements(measurements, message):
    with pytest.raises(MeasurementError) as caught:
        mannequin(measurements)
    assert message in str(caught.value)
