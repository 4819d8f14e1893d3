"""Loops that are special: without a node, several to a face, cut by a slit, crossing themselves, hard to order."""

import numpy as np
import pytest
from drawn import SQUARE_AROUND, UP, excess, flat, line, network_of, square

from flatnet.geometry.polygon import predicted_angles
from flatnet.project import ProjectError

TURN = 2 * np.pi * np.arange(24) / 24
CIRCLE = 20 * np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], axis=1)
OUTSIDE = {"outside": {"around": ["-west", "-north", "-east", "-south"]}}
HOLE = {"hole": {"closed": True, "points": [[10, 10, 0], [30, 10, 0], [30, 30, 0], [10, 30, 0]]}}
DISK = {"disk": {"around": ["hole"]}}


class TestClosedCurve:
    """CIRCLE as a closed curve without node, anticlockwise seen from above."""

    def build(self, tmp_path, around, normals=(0, 0, 1), points=CIRCLE):
        curves = {"c": {"closed": True, "points": points.tolist(), "normals": list(normals)}}
        return network_of(tmp_path, curves=curves, patches={"p": {"around": [around]}})

    @pytest.mark.parametrize(("around", "normals"), [("c", (0, 0, 1)), ("-c", (0, 0, -1))])
    def test_sign_and_normals_tell_the_inside(self, tmp_path, around, normals):
        network = self.build(tmp_path, around, normals)
        assert (network.face_count, network.euler_characteristics) == (2, (2,))
        assert excess(network.patches[0]) == pytest.approx(0.0, abs=1e-12)
        assert network.patches[0].boundary.stretches[0].reversed == around.startswith("-")

    @pytest.mark.parametrize(("around", "normals"), [("-c", (0, 0, 1)), ("c", (0, 0, -1))])
    def test_the_outside_is_no_disk(self, tmp_path, around, normals):
        network = self.build(tmp_path, around, normals)
        assert not network.patches
        [finding] = network.failed
        assert (finding.code, finding.patch) == ("not_disk", "p")
        assert finding.amount == pytest.approx(4 * np.pi)
        assert "runs clockwise" in finding.message

    def test_a_figure_eight_is_no_disk(self, tmp_path):
        t = TURN + np.pi / 24
        eight = 20 * np.stack([np.sin(t), np.sin(2 * t), 0 * t], axis=1)
        [finding] = self.build(tmp_path, "c", points=eight).failed
        assert finding.code == "not_disk"
        assert finding.amount == pytest.approx(2 * np.pi)
        assert "winds 0 times" in finding.message

    def test_a_loop_run_twice_is_no_disk(self, tmp_path):
        r = 20 + 15 * np.cos(TURN)
        twice = np.stack([r * np.cos(2 * TURN), r * np.sin(2 * TURN), 0 * TURN], axis=1)
        [finding] = self.build(tmp_path, "c", points=twice).failed
        assert finding.amount == pytest.approx(-2 * np.pi)

    def test_with_a_node_it_is_the_same(self, tmp_path):
        nodes = {"n": CIRCLE[0].tolist()}
        curves = flat({"c": line("n", "n", points=CIRCLE[1:].tolist())})
        patches = {"p": {"around": ["c"]}}
        network = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings")
        wanted = self.build(tmp_path, "c").patches[0].boundary
        assert np.array_equal(network.patches[0].boundary.vertices, wanted.vertices)


class TestSeveralLoops:
    """A square with a square hole: two parts that no curve joins."""

    def build(self, tmp_path, **sections):
        nodes, curves = square()
        return network_of(tmp_path, nodes=nodes, curves=flat({**curves, **HOLE}), **sections)

    def test_where_the_project_says_so_they_bound_one_face_which_is_no_disk(self, tmp_path):
        ring = {"ring": {"around": [SQUARE_AROUND, ["-hole"]]}}
        network = self.build(tmp_path, patches={**ring, **DISK}, openings=OUTSIDE)
        assert [patch.name for patch in network.patches] == ["disk"]
        [finding] = network.failed
        assert (finding.code, finding.patch, finding.amount) == ("not_disk", "ring", 2)
        assert network.euler_characteristics == (2, 2)

    def test_a_loop_left_out_is_ambiguous(self, tmp_path):
        patches = {"all": {"around": SQUARE_AROUND}, **DISK}
        with pytest.raises(ProjectError, match="ambiguous_faces: the network has 2 parts") as caught:
            self.build(tmp_path, patches=patches, openings=OUTSIDE)
        assert "[-hole]" in str(caught.value)

    def test_an_opening_may_have_several(self, tmp_path):
        openings = {"ring": {"around": [SQUARE_AROUND, ["-hole"]]}, **OUTSIDE}
        network = self.build(tmp_path, patches=DISK, openings=openings)
        assert network.openings["ring"] == (tuple(SQUARE_AROUND), ("-hole",))

    def test_joined_by_a_curve_the_ring_is_a_disk_whose_sides_meet(self, tmp_path):
        """Cut open along the joining curve: both its sides are on the boundary."""
        nodes, curves = square()
        nodes["h"] = [10, 10, 0]
        curves["hole"] = {"from": "h", "to": "h", "points": [[30, 10, 0], [30, 30, 0], [10, 30, 0]]}
        curves["join"] = line("sw", "h")
        patches = {"ring": {"around": [*SQUARE_AROUND, "join", "-hole", "-join"]}}
        network = network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches, rest="openings")
        assert not network.failed
        assert [s.seam for s in network.patches[0].boundary.stretches].count("join") == 2
        assert excess(network.patches[0]) == pytest.approx(0.0, abs=1e-12)


class TestDanglingEnd:
    def build(self, tmp_path, tip, around, **rest):
        nodes, curves = square()
        nodes |= {"m": [20, 0, 0], "tip": tip}
        curves["south"]["points"] = ["m"]
        curves["dart"] = line("m", "tip", **rest)
        patches = {"p": {"around": around}}
        return network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches, rest="openings")

    def test_it_names_the_nearest_node_and_the_gap(self, tmp_path):
        with pytest.raises(ProjectError, match=r"curve 'dart' ends inside a face at node 'tip'") as caught:
            self.build(tmp_path, [38, 39, 0], SQUARE_AROUND)
        message = str(caught.value)
        assert f"the nearest node is 'ne', gap {np.hypot(2, 1):.3f} mm" in message
        assert "nearer is curve 'north', gap 1.000 mm" in message

    def test_a_curve_that_could_not_be_sampled_makes_no_neighbour_dangle(self, tmp_path):
        nodes, curves = square()
        nodes["m"] = [20, 0, 0]
        along = {"per": "segment", "values": [UP, [1, 0, 0]]}  # its second stretch has normals along itself
        curves = flat(curves) | {"south": line("sw", "se", points=["m"], normals=along)}
        with pytest.raises(ProjectError) as caught:
            network_of(tmp_path, nodes=nodes, curves=curves, patches={"p": {"around": SQUARE_AROUND}})
        (problem,) = caught.value.problems
        assert "curve 'south': the normal at 25.0 mm along it points along the curve" in problem.message

    def test_two_curves_that_just_miss_each_other_are_both_told(self, tmp_path):
        nodes, curves = square()
        nodes["nw2"] = [0, 40.25, 0]
        curves["west"]["from"] = "nw2"
        patches = {"p": {"around": SQUARE_AROUND}}
        with pytest.raises(ProjectError) as caught:
            network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches)
        first, second = (problem.message for problem in caught.value.problems)
        assert "'north'" in first and "the nearest node is 'nw2', gap 0.250 mm" in first
        assert "'west'" in second and "the nearest node is 'nw', gap 0.250 mm" in second

    def test_a_slit_has_two_sides_and_a_tip(self, tmp_path):
        around = ["south", "dart", "-dart", "south", "east", "north", "west"]
        [patch] = self.build(tmp_path, [20, 25, 0], around, slit=True).patches
        boundary = patch.boundary
        [tip] = boundary.slit_tips
        assert boundary.vertices[tip].tolist() == [20, 25, 0]
        for k in range(1, 4):  # 25 mm in edges of at most 10: three on each side, vertices of their own
            assert np.array_equal(boundary.vertices[tip - k], boundary.vertices[tip + k])
        assert len(boundary.vertices) == 2 + 3 + 3 + 2 + 4 + 4 + 4
        alpha, _ = predicted_angles(boundary.vertices, boundary.normals)
        assert alpha[tip] == 2 * np.pi
        assert excess(patch) == pytest.approx(0.0, abs=1e-12)


class TestOrderAroundNodes:
    def fan(self, degrees):
        """A square with two curves from its corner into it, the second `degrees` beside the first."""
        nodes, curves = square()
        nodes["m"] = [40, 20, 0]
        curves["east"]["points"] = ["m"]
        y = 20 * np.tan(np.arctan(0.5) + np.radians(degrees))
        curves |= {"one": line("sw", "m"), "two": line("sw", "m", points=[[20, float(y), 0]])}
        return {"nodes": nodes, "curves": flat(curves), "rest": "openings",
                "patches": {"between": {"around": ["one", "-two"]}}}

    @pytest.mark.parametrize("degrees", [0.0, 0.9, -0.9])
    def test_within_one_degree_it_is_ambiguous(self, tmp_path, degrees):
        with pytest.raises(ProjectError, match=r"ambiguous_faces: .* leave node 'sw' within") as caught:
            network_of(tmp_path, **self.fan(degrees))
        assert f"{abs(degrees):.2f} degrees" in str(caught.value)

    def test_beyond_it_is_clear(self, tmp_path):
        [patch] = network_of(tmp_path, **self.fan(1.5)).patches
        assert excess(patch) == pytest.approx(0.0, abs=1e-12)

    def test_normals_that_cancel_leave_it_unknown(self, tmp_path):
        """Two of the four curves that meet in the middle have their normals on the other side."""
        nodes = {"o": [0, 0, 0], "e": [20, 0, 0], "n": [0, 20, 0], "w": [-20, 0, 0], "s": [0, -20, 0]}
        curves = flat({f"o{x}": line("o", x) for x in "enws"})
        curves |= flat({a + b: line(a, b) for a, b in ("en", "nw", "ws", "se")})
        patches = {"p": {"around": ["oe", "en", "-on"]}}
        assert network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings").patches
        curves |= {name: {**curves[name], "normals": [0, 0, -1]} for name in ("on", "os")}
        with pytest.raises(ProjectError, match=r"node 'o': .* have normals that cancel"):
            network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings")
