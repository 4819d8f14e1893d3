"""Nodes on rays, at landmarks, at fractions of lines and curves."""

import numpy as np
import pytest
from drawn import ball, flat, line, prism, project_of, square

from flatnet.forms.mannequin import mannequin
from flatnet.network.assembly import sample_stretches

H = 10.0


def places_of(folder, surface=None, **sections):
    sections.setdefault("curves", {"c": line("a", "b")})
    sections["patches"] = {"unused": {"around": [next(iter(sections["curves"]))]}}
    places, stretches, _, problems = sample_stretches(project_of(folder, surface, **sections), surface)
    return places, stretches, [problem.message for problem in problems]


B = [0, 0, 500]


class TestRays:
    def test_the_first_meeting_counts_from_outside_and_from_inside(self, tmp_path):
        for start, direction, hit in (
            ([200, 0, 63], [-1, 0, 0], [50, 0, 63]),
            ([0, 0, 63], [-3, 0, 0], [-50, 0, 63]),
            ([200, 0, 100], [-1, 0, 0], [50, 0, 100]),  # a vertex
        ):
            nodes = {"a": {"ray": {"from": start, "direction": direction}}, "b": B}
            places, _, problems = places_of(tmp_path, prism(), nodes=nodes)
            assert not problems
            assert places["a"] == pytest.approx(hit, abs=1e-9)

    def test_no_ray_slips_between_triangles(self, tmp_path):
        surface = ball(50.0, 2)
        edges = surface.mesh.edges_unique[::7]
        for middle in surface.mesh.vertices[edges].mean(axis=1):
            nodes = {"a": {"ray": {"from": [0, 0, 0], "direction": middle.tolist()}}, "b": B}
            places, _, problems = places_of(tmp_path, surface, nodes=nodes)
            assert not problems and places["a"] == pytest.approx(middle, abs=1e-9)

    def test_a_miss_is_an_error_with_its_place(self, tmp_path):
        nodes = {"a": {"ray": {"from": [200, 0, 63], "direction": [1, 0, 0]}}, "b": B}
        _, _, [message] = places_of(tmp_path, prism(), nodes=nodes)
        assert message == (
            "node 'a': its ray from (200.0, 0.0, 63.0) misses the surface; turn it round, or aim nearer to the nearest "
            "place on it, (50.0, 0.0, 63.0)"
        )


class TestGuides:
    """Points of a curve at fractions of lines: it passes there, and has no node."""

    def test_a_curve_passes_its_guides_and_is_not_cut(self, tmp_path):
        surface = mannequin({"half": "both"})
        nodes = {name: {"at": {"line": "waist", "t": t}} for name, t in (("a", 0.1), ("b", 0.4))}
        guide = {"line": "hip", "t": 0.25}
        curves = {"c": {"kind": "fair", "from": "a", "to": "b", "points": [guide], "edge_length": 2}}
        places, stretches, problems = places_of(tmp_path, surface, nodes=nodes, curves=curves)
        assert not problems and set(places) == {"a", "b"} and list(stretches) == ["c"]
        line = surface.lines["hip"].points
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        there = np.array([np.interp(0.25 * along[-1], along, column) for column in line.T])
        assert np.linalg.norm(stretches["c"].vertices - there, axis=1).min() < 1.01  # half an edge

    def test_an_unknown_line_is_named(self, tmp_path):
        nodes = {name: {"at": {"line": "waist", "t": t}} for name, t in (("a", 0.1), ("b", 0.4))}
        curves = {"c": {"kind": "fair", "from": "a", "to": "b", "points": [{"line": "hips", "t": 0.25}]}}
        _, _, [message] = places_of(tmp_path, mannequin({"half": "both"}), nodes=nodes, curves=curves)
        assert message.startswith("curve 'c': there is no line 'hips'; did you mean 'hip'?")


class TestForms:
    def test_landmarks_and_fractions_of_lines(self, tmp_path):
        surface = mannequin({"half": "both"})
        nodes = {"a": {"landmark": "left_knee_front"}, "b": {"at": {"line": "waist", "t": 0.75}}}
        places, _, problems = places_of(tmp_path, surface, nodes=nodes)
        assert not problems
        assert places["a"].tolist() == surface.landmarks["left_knee_front"].tolist()
        # From the centre front over the right: three quarters on is the left outside.
        assert places["b"] == pytest.approx(surface.landmarks["left_waist_outside"], abs=1e-6)

    def test_unknown_names(self, tmp_path):
        nodes = {"a": {"landmark": "nose"}, "b": {"at": {"line": "waste", "t": 0.5}}}
        _, _, messages = places_of(tmp_path, mannequin({"half": "right"}), nodes=nodes)
        assert messages[0].startswith("node 'a': there is no landmark 'nose'; known landmarks: 'crotch', ")
        assert messages[1] == "node 'b': there is no line 'waste'; did you mean 'waist'?"


class TestFractions:
    def test_the_curve_is_cut_at_the_fraction_of_its_length(self, tmp_path):
        nodes, curves = square(40.0)
        nodes |= {"x": {"at": {"curve": "south", "t": 0.3}}, "y": {"at": {"curve": "north", "t": 0.75}}}
        curves |= {"across": line("x", "y")}
        places, stretches, problems = places_of(tmp_path, nodes=nodes, curves=flat(curves))
        assert not problems
        assert places["x"] == pytest.approx([12.0, 0, 0])
        assert places["y"] == pytest.approx([10.0, 40, 0])
        assert {"south:sw..x", "south:x..se", "north:ne..y", "north:y..nw", "across"} <= set(stretches)
        assert stretches["south:sw..x"].vertices[-1].tolist() == places["x"].tolist()
        assert stretches["across"].vertices[0].tolist() == stretches["south:x..se"].vertices[0].tolist()

    def test_of_a_stretch_and_in_a_chain_of_curves(self, tmp_path):
        nodes, curves = square(40.0)
        nodes |= {"m": [20, 0, 0], "x": {"at": {"curve": "south:m..se", "t": 0.5}}}
        nodes |= {"z": {"at": {"curve": "down", "t": 0.25}}}
        curves["south"]["points"] = ["m"]
        curves = flat({"last": line("z", "nw"), "down": line("ne", "x"), **curves})
        places, stretches, problems = places_of(tmp_path, nodes=nodes, curves=curves)
        assert not problems
        assert places["x"] == pytest.approx([30.0, 0, 0])
        assert places["z"] == pytest.approx([37.5, 30, 0])  # although both stand before what they depend on
        assert {"south:sw..m", "south:m..x", "south:x..se", "down:ne..z", "down:z..x"} <= set(stretches)

    def test_a_closed_curve_without_nodes_is_cut_in_two(self, tmp_path):
        surface = prism(192)
        nodes = {"p": {"at": {"curve": "ring", "t": 0.25}}, "q": {"at": {"curve": "ring", "t": 0.75}}}
        ring = {"section": {"point": [0, 0, 80], "normal": [0, 0, 1]}}
        curves = {"ring": ring, "across": line("p", "q", kind="geodesic")}
        places, stretches, problems = places_of(tmp_path, surface, nodes=nodes, curves=curves)
        assert not problems
        assert {"ring:p..q", "ring:q..p"} <= set(stretches)
        for name, (start, end) in {"ring:p..q": "pq", "ring:q..p": "qp"}.items():
            vertices = stretches[name].vertices
            assert vertices[0].tolist() == places[start].tolist() and vertices[-1].tolist() == places[end].tolist()
            assert np.linalg.norm(np.diff(vertices, axis=0), axis=1).sum() == pytest.approx(np.pi * 50, rel=2e-3)
            assert vertices[:, 2] == pytest.approx(80.0)

    def test_a_spline_keeps_its_shape_and_its_normals(self, tmp_path):
        normals = [[0, 0, 1], [0, 1, 1], [0, 1, 1], [0, 0, 1]]
        spline = {"s": line("a", "b", kind="spline", points=[[10, 30, 0], [40, -20, 0]], normals=normals)}
        nodes = {"a": [0, 0, 0], "b": [60, 0, 0]}
        _, whole, _ = places_of(tmp_path, nodes=nodes, curves=spline)
        _, cut, problems = places_of(tmp_path, nodes=nodes | {"x": {"at": {"curve": "s", "t": 0.5}}}, curves=spline)
        assert not problems
        both = [cut["s:a..x"], cut["s:x..b"]]
        lengths = [stretch.length for stretch in both]
        assert lengths[0] == pytest.approx(lengths[1], rel=2e-3)  # chords of an S
        assert sum(lengths) == pytest.approx(whole["s"].length, rel=2e-3)
        middle = whole["s"].left_normals[len(whole["s"].left_normals) // 2]
        assert both[1].left_normals[0] == pytest.approx(middle, abs=0.1)
