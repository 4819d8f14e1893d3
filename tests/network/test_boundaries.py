"""Boundaries of patches: normals on one side, closed to the last bit, angles at their nodes."""

import numpy as np
import pytest
from drawn import SQUARE_AROUND, UP, flat, line, network_of, square

from flatnet.network import SampledStretch
from flatnet.network.boundaries import open_gap
from flatnet.network.graph import Dart
from flatnet.project import ProjectError

DOWN = [0, 0, -1]


def build(tmp_path, curves=None, **patch):
    nodes, drawn = square()
    patches = {"p": {"around": SQUARE_AROUND, **patch}}
    drawn = flat(drawn) | (curves or {})
    return network_of(tmp_path, nodes=nodes, curves=drawn, patches=patches, rest="openings")


class TestSideOfNormals:
    def test_one_curve_turned_round_is_named_at_its_normals(self, tmp_path):
        with pytest.raises(ProjectError) as caught:
            build(tmp_path, {"east": line("se", "ne", normals=DOWN)})
        [problem] = caught.value.problems
        said = "the normals of curve 'east' change side along patch 'p', from 'east' at 0.0 mm on: 4 of its 4"
        assert said in problem.message
        text = (tmp_path / "project.yaml").read_text().splitlines()
        assert "normals" in text[problem.mark.line - 2]  # the list stands below its key
        assert text[problem.mark.line - 1].strip() == "- 0"

    def test_a_flip_within_a_curve_is_placed(self, tmp_path):
        east = line("se", "ne", points=[[40, 20, 0], [40, 30, 0]], normals=[UP, UP, DOWN])
        with pytest.raises(ProjectError, match=r"from 'east' at 30.0 mm on: 1 of its 4 edges"):
            build(tmp_path, {"east": east})

    def test_normals_that_turn_along_a_curve_do_not_flip(self, tmp_path):
        """Half a turn to one side along the east, back along the west."""
        turns = [UP, [1, 0, 1], [1, 0, 0]]
        points = [[40, 15, 0]]
        east = line("se", "ne", points=points, normals=turns)
        north = line("ne", "nw", normals=[0, 1, 0.2])
        west = line("nw", "sw", points=[[0, 15, 0]], normals=[[-1, 0, 0], [-1, 0, 1], UP])
        assert build(tmp_path, {"east": east, "north": north, "west": west}).patches

    @pytest.mark.parametrize("fold", [90.0, 150.0])
    def test_over_a_sharp_edge_they_do_not_flip(self, tmp_path, fold):
        """A strip bent over an edge along x: its normals turn about that edge, its boundary with them."""
        t = np.radians(fold)
        down = [0.0, float(-np.cos(t)), float(-np.sin(t))]  # the way down from the edge
        front, top = [0, down[2], -down[1]], UP
        nodes = {"c": [20, 30, 0], "d": [0, 30, 0]}
        nodes |= {name: [x, 30 * down[1], 30 * down[2]] for name, x in (("a", 0), ("b", 20))}
        over = {"left": [0, 0, 0], "right": [20, 0, 0]}
        curves = {
            "low": line("a", "b", normals=front),
            "right": line("b", "c", points=[over["right"]], normals=[front, top]),
            "far": line("c", "d", normals=top),
            "left": line("d", "a", points=[over["left"]], normals=[top, front]),
        }
        patches = {"p": {"around": ["low", "right", "far", "left"]}}
        [patch] = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings").patches
        assert np.abs(np.einsum("ij,ij->i", np.roll(patch.boundary.vertices, -1, 0) - patch.boundary.vertices,
                                patch.boundary.normals)).max() < 1e-12


class TestMinAngle:
    def test_it_stands_at_the_node_s_vertex(self, tmp_path):
        boundary = build(tmp_path, min_angle={"ne": 100}).patches[0].boundary
        [corner] = np.flatnonzero(boundary.min_angles)
        assert boundary.vertices[corner].tolist() == [40, 40, 0]
        assert boundary.min_angles[corner] == pytest.approx(np.radians(100))

    def test_at_a_node_of_another_part_of_a_curve_it_is_refused(self, tmp_path):
        nodes, curves = square()
        nodes |= {"m": [20, 0, 0], "top": [20, 40, 0]}
        curves["south"]["points"], curves["north"]["points"] = ["m"], ["top"]
        curves["middle"] = line("m", "top")
        patches = {"p": {"around": ["south", "middle", "north", "west"], "min_angle": {"se": 80}}}
        with pytest.raises(ProjectError, match="patch 'p': min_angle at node 'se', which is not on its"):
            network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches, rest="openings")


def test_the_boundary_starts_where_around_does(tmp_path):
    for shift in range(4):
        around = SQUARE_AROUND[shift:] + SQUARE_AROUND[:shift]
        boundary = build(tmp_path, around=around).patches[0].boundary
        assert [s.seam for s in boundary.stretches] == around
        assert boundary.stretches[0].first == 0


def test_stretches_that_miss_each_other_by_a_bit_are_an_open_boundary():
    def stretch(name, *points):
        normals = np.tile([0.0, 0, 1], (len(points) - 1, 1))
        return SampledStretch(name, name, None, None, np.array(points, float), normals, normals)

    loop = (Dart("a", False), Dart("b", True))
    a, b = stretch("a", [0, 0, 0], [3, 0, 0], [3, 4, 0]), stretch("b", [0, 0, 0], [0, 4, 0], [3, 4, 0])
    whole = {"a": a, "b": b}
    assert open_gap("p", loop, whole) is None
    broken = whole | {"b": stretch("b", [0, 0, 0], [0, 4, 0], [3, 4.25, 0])}
    finding = open_gap("p", loop, broken)
    assert (finding.code, finding.patch, finding.amount) == ("open_boundary", "p", 0.25)
    assert "between 'a' and '-b'" in finding.message
