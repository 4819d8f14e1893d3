"""A network of the mannequin's rings and lines: a changed measurement moves it, and changes nothing else."""

import numpy as np
import pytest
from drawn import network_of

from flatnet.forms.mannequin import mannequin

BODIES = {
    "uk 12": {},
    "man": {"waist": 810.0, "hip": 1020.0, "thigh": 625.0, "knee": 410.0, "calf": 395.0, "rise": 340.0,
            "inseam": 780.0},
    "child": {"waist": 540.0, "hip": 620.0, "thigh": 350.0, "knee": 260.0, "calf": 245.0, "ankle": 180.0,
              "rise": 190.0, "inseam": 480.0},
}
RINGS = ["waist", "hip", "thigh", "knee", "calf", "ankle"]
LINES = ["front", "outside", "back", "inside", "front_rise", "back_rise"]


def trousers():
    """One leg: every ring, every line, and a ring half way between waist and hip."""
    curves = {name: {"line": name} for name in RINGS + LINES}
    curves["yoke"] = {"section": {"normal": [0, 0, -1]}, "from": "f", "to": "b"}
    nodes = {"f": {"at": {"curve": "front_rise", "t": 0.3}}, "b": {"at": {"curve": "back_rise", "t": 0.3}}}
    downs = [("front_rise", "front"), ("front", "outside"), ("outside", "back"), ("back", "back_rise")]
    patches = {}
    for upper, lower in (("waist", "yoke"), ("yoke", "hip")):
        for one, other in downs:
            patches[f"{upper}_{one}"] = {"around": [upper, other, f"-{lower}", f"-{one}"]}
    patches["seat_front"] = {"around": ["hip", "front", "-thigh", "-inside", "-front_rise"]}
    patches["seat_back"] = {"around": ["hip", "back_rise", "inside", "-thigh", "-back"]}
    for one, other in downs[1:3]:
        patches[f"hip_{one}"] = {"around": ["hip", other, "-thigh", f"-{one}"]}
    for upper, lower in (("thigh", "knee"), ("knee", "calf"), ("calf", "ankle")):
        for one, other in (("inside", "front"), ("front", "outside"), ("outside", "back"), ("back", "inside")):
            patches[f"{upper}_{one}"] = {"around": [upper, other, f"-{lower}", f"-{one}"]}
    openings = {"top": {"around": ["-waist", "front_rise", "-back_rise"]}, "leg": {"around": ["ankle"]}}
    return {"nodes": nodes, "curves": curves, "patches": patches, "openings": openings, "join": "crossings"}


@pytest.mark.parametrize("body", BODIES)
def test_the_same_file_fits_every_body(tmp_path, body):
    measurements = BODIES[body]
    surface = mannequin({**measurements, "half": "right"})
    network = network_of(tmp_path, surface, **trousers())
    assert len(network.patches) == 24 and not network.failed
    assert network.euler_characteristics == (2,)
    around = [s for s in network.stretches.values() if s.curve == "knee"]
    # The knee's girth, less what chords of 10 mm cut off on radii above 30 mm.
    knee = measurements.get("knee", 361.0)
    assert knee * (1 - (10 / 30) ** 2 / 24) < sum(stretch.length for stretch in around) < knee
    for name, landmark in surface.landmarks.items():
        at = [node for node, place in network.nodes.items() if np.linalg.norm(place - landmark) < 0.1]
        assert len(at) == 1, name
    for stretch in network.stretches.values():
        feet, _ = surface.nearest(stretch.vertices)
        assert np.linalg.norm(feet - stretch.vertices, axis=1).max() < 1e-3 * 10
        if stretch.curve.endswith("rise"):
            assert np.abs(stretch.vertices[:, 0]).max() < 1e-9


def test_both_legs_meet_in_the_rises(tmp_path):
    surface = mannequin({})
    curves = {name: {"line": name} for name in surface.lines}
    network = network_of(
        tmp_path, surface, curves=curves, patches={"p": {"around": ["right_front", "-hip", "-front_rise", "waist"]}},
        rest="openings", join="crossings",
    )
    # Eight lines from waist to hip, four from there on round each leg, through four bands; the waist and two ankles.
    assert network.face_count == 8 + 2 * 4 * 4 + 3


def test_a_bodice_is_drawn_on_rings_lines_and_landmarks(tmp_path):
    larger = {"bust": 1000.0, "under_bust": 850.0, "high_bust": 935.0, "waist": 840.0, "hip": 1080.0}
    surface = mannequin({**larger, "top": "neck", "half": "right"})
    lines = ("neck", "shoulder", "side", "waist", "centre_front", "centre_back")
    curves = {name: {"line": name} for name in lines}
    for side in ("front", "back"):
        curves[f"armhole_{side}"] = {"kind": "fair", "from": "tip", "to": "underarm", "points": [f"across_{side}"]}
    curves["dart"] = {"kind": "geodesic", "from": "dart_waist", "to": "bust_point", "slit": True}
    places = ("underarm", "bust_point", "across_front", "across_back")
    nodes = {name: {"landmark": name} for name in places} | {
        "tip": {"landmark": "shoulder_point"}, "dart_waist": {"landmark": "waist_front"},
    }
    patches = {"front": {"around": ["neck", "shoulder", "armhole_front", "side", "-waist", "dart", "-dart", "-waist",
                                    "-centre_front"]},
               "back": {"around": ["neck", "centre_back", "-waist", "-side", "-armhole_back", "-shoulder"]}}
    network = network_of(
        tmp_path, surface, nodes=nodes, curves=curves, patches=patches, rest="openings", join="crossings"
    )
    assert [patch.name for patch in network.patches] == ["front", "back"] and not network.failed
    assert np.linalg.norm(network.nodes["bust_point"] - surface.landmarks["bust_point"]) < 1e-9
