"""The thickness of a material: its middle keeps lengths, and both sides of a seam keep one curve."""

import numpy as np
import pytest
import yaml

from flatnet.geometry.polygon import polyline_length
from flatnet.network.assembly import make_network
from flatnet.network.thickness import laid_back
from flatnet.project import ProjectError, load_project


def network_of(tmp_path, content):
    project = {"flatnet": 1, "name": "thick", "edge_length": 100, "rest": "openings", **content}
    (tmp_path / "thick.yaml").write_text(yaml.safe_dump(project))
    return make_network(load_project(tmp_path / "thick.yaml"), None)


def cloth(thickness):
    return {"width": 1500, "thickness": thickness}


def arc(radius, height, start, end, count=24):
    """Points and normals of a part of a circle of latitude, between its end points."""
    angle = np.linspace(start, end, count + 1)
    out = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count + 1)])
    middle = 0.5 * (angle[1:] + angle[:-1])
    normals = np.column_stack([np.cos(middle), np.sin(middle), np.zeros(count)])
    return (radius * out + [0, 0, height]), normals


def tube(radius, halves, sign=1.0):
    """A tube in two halves of materials 0 and 1, its normals outwards, or inwards with sign -1."""
    curves, nodes = {}, {}
    for level, height in (("low", 0.0), ("high", 80.0)):
        for name, start in (("front", 0.0), ("back", np.pi)):
            points, normals = arc(radius, height, start, start + np.pi)
            ends = [f"{level}_{'a' if start == at else 'b'}" for at in (0.0, np.pi)]
            nodes[ends[0]] = points[0].tolist()
            curves[f"{name}_{level}"] = {
                "from": ends[0], "to": ends[1], "points": points[1:-1].tolist(), "normals": (sign * normals).tolist()
            }  # fmt: skip
    for end, x in (("a", 1.0), ("b", -1.0)):
        curves[f"side_{end}"] = {"from": f"low_{end}", "to": f"high_{end}", "normals": [sign * x, 0, 0]}
    around = {
        "front": ["front_low", "side_b", "-front_high", "-side_a"],
        "back": ["back_low", "side_a", "-back_high", "-side_b"],
    }
    if sign < 0:
        around = {name: [f"-{c}".replace("--", "") for c in reversed(loop)] for name, loop in around.items()}
    patches = {name: {"around": loop, "material": name} for name, loop in around.items() if name in halves}
    materials = {name: cloth(thickness) for name, thickness in halves.items()}
    return {"nodes": nodes, "curves": curves, "patches": patches, "materials": materials}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_round_a_tube_the_middle_is_as_long_as_its_radius_says(tmp_path, sign):
    radius, thickness = 50.0, 3.0
    network = network_of(tmp_path, tube(radius, {"front": thickness, "back": thickness}, sign))
    around = network.stretches["front_low"].length + network.stretches["back_low"].length
    chords = np.sin(np.pi / 48) / (np.pi / 48)  # of a polygon of 48 edges, over its circle
    assert around / chords == pytest.approx(2.0 * np.pi * (radius + 0.5 * sign * thickness), rel=1e-12)
    for stretch in network.stretches.values():
        assert np.linalg.norm(stretch.vertices[:, :2], axis=1) == pytest.approx(radius + 0.5 * sign * thickness)
        edges = np.diff(stretch.vertices, axis=0)
        assert np.abs(np.einsum("ij,ij->i", edges, stretch.left_normals)).max() < 1e-12
    assert network.stretches["side_a"].length == pytest.approx(80.0, rel=1e-12)
    for name, place in network.nodes.items():
        assert np.array_equal(place, network.stretches[f"front_{name[:-2]}"].vertices[0 if name[-1] == "a" else -1])


def test_at_the_end_of_a_sheet_it_goes_on_as_it_turns(tmp_path):
    network = network_of(tmp_path, tube(50.0, {"front": 3.0}))
    for stretch in network.stretches.values():
        if stretch.curve.startswith(("front", "side")):
            assert np.linalg.norm(stretch.vertices[:, :2], axis=1) == pytest.approx(51.5, rel=1e-12)
    assert network.stretches["back_low"].vertices[0] == pytest.approx([-51.5, 0, 0])  # it still ends in its nodes


def test_between_two_thicknesses_a_smooth_seam_moves_by_the_mean(tmp_path):
    network = network_of(tmp_path, tube(50.0, {"front": 4.0, "back": 0.0}))
    radii = {name: np.linalg.norm(s.vertices[1:-1, :2], axis=1) for name, s in network.stretches.items()}
    assert radii["front_low"] == pytest.approx(52.0) and radii["back_low"] == pytest.approx(50.0)
    ends = network.stretches["side_a"].vertices
    assert np.linalg.norm(ends[:, :2], axis=1) == pytest.approx(51.0)


def box(thicknesses):
    """Three faces of a cube at its corner (1, 1, 1), each normal outwards."""
    nodes = {f"{x}{y}{z}": [100 * x, 100 * y, 100 * z] for x in (0, 1) for y in (0, 1) for z in (0, 1) if x + y + z}
    faces = {"x": ["100", "110", "111", "101"], "y": ["010", "011", "111", "110"], "z": ["001", "101", "111", "011"]}
    normal = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}
    curves, around, sides = {}, {}, {}
    for face, loop in faces.items():
        around[face] = []
        for p, q in zip(loop, loop[1:] + loop[:1]):
            key = f"e{min(p, q)}.{max(p, q)}"
            back = p > q
            around[face].append(f"-{key}" if back else key)
            sides.setdefault(key, {})["right" if back else "left"] = normal[face]
    for key, found in sides.items():
        p, q = key[1:].split(".")
        normals = found if len(found) == 2 else next(iter(found.values()))
        curves[key] = {"from": p, "to": q, "normals": normals}
    materials = {face: cloth(t) for face, t in zip("xyz", thicknesses)}
    patches = {face: {"around": loop, "material": face} for face, loop in around.items()}
    return {"nodes": nodes, "curves": curves, "patches": patches, "materials": materials}


def test_creases_and_corners_go_to_where_the_middles_meet(tmp_path):
    network = network_of(tmp_path, box([2.0, 4.0, 6.0]))
    assert network.nodes["111"] == pytest.approx([101, 102, 103])
    assert network.nodes["110"] == pytest.approx([101, 102, 0])
    assert network.nodes["100"] == pytest.approx([101, 0, 0])


def test_a_curve_in_the_middle_is_laid_back_to_where_it_came_from(tmp_path):
    made = network_of(tmp_path, tube(50.0, {"front": 3.0, "back": 3.0})).stretches["front_low"]
    came_from, _ = arc(50.0, 0.0, 0.0, np.pi)
    np.testing.assert_allclose(laid_back(made, 1.5), came_from[1:-1], atol=1e-9)


def test_without_thickness_nothing_moves_and_too_much_of_it_is_a_problem(tmp_path):
    content = tube(50.0, {"front": 0.0, "back": 0.0})
    network = network_of(tmp_path, content)
    assert np.array_equal(network.nodes["low_a"], content["nodes"]["low_a"])
    with pytest.raises(ProjectError, match=r"curve .front_low.: at .* it is hollow with a radius below half"):
        network_of(tmp_path, tube(50.0, {"front": 102.0, "back": 102.0}, -1.0))


def test_mirror_images_stay_exact(tmp_path):
    points, normals = arc(60.0, 0.0, 0.0, 0.5 * np.pi)
    content = {
        "mirror": {"normal": [1, 0, 0]},
        "nodes": {"a": [60, 0, 0], "b": [0, 60, 0], "c": [60, 0, 50], "d": [0, 60, 50]}
        | {f"{n}2": {"mirror_of": n} for n in "ac"},
        "curves": {
            "low": {"from": "a", "to": "b", "points": points[1:-1].tolist(), "normals": normals.tolist()},
            "high": {"from": "c", "to": "d", "points": (points[1:-1] + [0, 0, 50]).tolist(),
                     "normals": normals.tolist()},
            "side": {"from": "a", "to": "c", "normals": [1, 0, 0]},
            "centre": {"from": "b", "to": "d", "normals": [0, 1, 0]},
        } | {f"{n}2": {"mirror_of": n} for n in ("low", "high", "side")},
        "patches": {"right": {"around": ["low", "centre", "-high", "-side"]}, "left": {"mirror_of": "right"}},
        "materials": {"cloth": cloth(3.0)},
    }  # fmt: skip
    stretches = network_of(tmp_path, content).stretches
    assert (stretches["centre"].vertices[:, 0] == 0.0).all()
    for name in ("low", "high", "side"):
        assert np.array_equal(stretches[f"{name}2"].vertices, stretches[name].vertices * [-1.0, 1.0, 1.0])
        radii = np.linalg.norm(stretches[name].vertices[:, :2], axis=1)
        assert radii == pytest.approx(61.5, rel=1e-12)
    assert polyline_length(stretches["low"].vertices) > 90.0


def test_a_level_face_stays_level_where_the_normals_beside_it_differ(tmp_path):
    # Along the edges of the level face the two others say that they lean by 6 degrees, along their common edge upright.
    content = box([1.6, 1.6, 1.6])
    for edge, outwards in (("e101.111", np.array([1.0, 0.0, 0.0])), ("e011.111", np.array([0.0, 1.0, 0.0]))):
        said = content["curves"][edge]["normals"]
        leaning = {side: np.add(n, [0.0, 0.0, 0.1]).tolist() for side, n in said.items() if n == outwards.tolist()}
        assert leaning
        content["curves"][edge]["normals"] = {**said, **leaning}
    network = network_of(tmp_path, content)
    corners = [network.nodes[name] for name in ("001", "011", "101", "111")]
    assert max(abs(corner[2] - 100.8) for corner in corners) < 1e-9
    assert network.nodes["111"] != pytest.approx([100.8, 100.8, 100.8], abs=1e-3)  # the other two are tilted
