"""Curves that cross on the surface: joined when asked, else an error that names both and the place."""

import numpy as np
import pytest
from drawn import ball, line, network_of, prism, sheet, stretches_of

from flatnet.forms.mannequin import mannequin
from flatnet.project import ProjectError

H = 10.0
SQUARE = {"sw": [10, 10, 0], "se": [90, 10, 0], "ne": [90, 90, 0], "nw": [10, 90, 0]}
DIAGONALS = {"up": line("sw", "ne", kind="geodesic"), "down": line("nw", "se", kind="geodesic")}


def ring(z):
    return {"section": {"point": [0, 0, z], "normal": [0, 0, 1]}}


def meridian(x, y):
    """From rim to rim of the prism, down."""
    return {"section": {"point": [x, y, 100], "normal": [-y, x, 0]}}


def test_without_being_asked_it_is_an_error_that_names_both_and_the_place(tmp_path):
    _, [message] = stretches_of(tmp_path, sheet(), nodes=SQUARE, curves=DIAGONALS)
    assert message == (
        "curves 'up' and 'down' cross at (50.0, 50.0, 0.0) without a node of both; give them one there, or say "
        "join: crossings at the top of the file"
    )


def test_joined_they_share_a_node_to_the_last_bit(tmp_path):
    stretches, problems = stretches_of(tmp_path, sheet(), nodes=SQUARE, curves=DIAGONALS, join="crossings")
    assert not problems
    assert list(stretches) == ["up:sw..up.down", "up:up.down..ne", "down:nw..up.down", "down:up.down..se"]
    ends = [stretches[name].vertices[i] for name, i in zip(stretches, (-1, 0, -1, 0))]
    assert all(end.tolist() == ends[0].tolist() for end in ends)
    assert ends[0] == pytest.approx([50, 50, 0], abs=1e-9)


@pytest.mark.parametrize("shift", [0.0, 1e-9, 0.37, 4.2])
def test_every_crossing_is_found_wherever_the_samples_lie(tmp_path, shift):
    """Rings and meridians of a tube, some right through vertices of its mesh."""
    meridians = {f"m{k}": meridian(float(np.cos(t)), float(np.sin(t))) for k, t in enumerate((0.0, 0.5, np.pi / 3))}
    rings = {f"r{k}": ring(z + shift) for k, z in enumerate((20.0, 100.0, 150.3))}
    surface = prism()
    stretches, problems = stretches_of(tmp_path, surface, curves=meridians | rings, join="crossings")
    assert not problems
    nodes = {node for stretch in stretches.values() for node in (stretch.start, stretch.end)}
    # A meridian's plane cuts the tube twice; the nearer one is meant: three crossings each.
    assert nodes == {f"m{i}.r{j}" for i in range(3) for j in range(3)} | {
        f"m{i}.{end}" for i in range(3) for end in ("start", "end")
    }


def test_two_crossings_of_the_same_curves_have_two_names(tmp_path):
    curves = {"flat": {"section": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
              "steep": {"section": {"point": [0, 0, 0], "normal": [1, 0, 0.2]}}}
    stretches, problems = stretches_of(tmp_path, ball(), curves=curves, join="crossings")
    assert not problems
    assert {"flat:flat.steep..flat.steep.2", "flat:flat.steep.2..flat.steep"} < set(stretches)


def test_three_curves_through_one_place_share_one_node(tmp_path):
    nodes = {**SQUARE, "w": [10, 50, 0], "e": [90, 50, 0]}
    curves = DIAGONALS | {"level": line("w", "e", kind="geodesic")}
    stretches, problems = stretches_of(tmp_path, sheet(), nodes=nodes, curves=curves, join="crossings")
    assert not problems
    assert {"level:w..up.down", "level:up.down..e"} < set(stretches)
    assert len(stretches) == 6


def test_a_node_of_one_curve_on_the_other_joins_them(tmp_path):
    nodes = {**SQUARE, "m": [50, 50, 0], "s": [50, 10, 0]}
    curves = {"up": DIAGONALS["up"], "stem": line("s", "m", kind="geodesic")}
    stretches, problems = stretches_of(tmp_path, sheet(), nodes=nodes, curves=curves, join="crossings")
    assert not problems and list(stretches) == ["up:sw..m", "up:m..ne", "stem"]
    _, [message] = stretches_of(tmp_path, sheet(), nodes=nodes, curves=curves)
    assert message.startswith("node 'm' lies on curve 'up' at (50.0, 50.0, 0.0); let the curve pass through it")


def test_the_two_walls_of_a_thin_body_do_not_touch(tmp_path):
    from drawn import box

    nodes = {"a": [-40, 0, 0.2], "b": [40, 0, 0.2], "c": [0, -40, -0.2], "d": [0, 40, -0.2]}
    curves = {"above": line("a", "b", on="surface"), "below": line("c", "d", on="surface")}
    stretches, problems = stretches_of(tmp_path, box(100, 100, 0.4), nodes=nodes, curves=curves)
    assert not problems and list(stretches) == ["above", "below"]


def test_curves_that_meet_in_a_node_do_not_cross_there(tmp_path):
    nodes = {"a": [10, 10, 0], "b": [90, 12, 0], "c": [90, 8, 0]}  # 3 degrees between them
    curves = {"one": line("a", "b", kind="geodesic"), "two": line("a", "c", kind="geodesic")}
    _, problems = stretches_of(tmp_path, sheet(), nodes=nodes, curves=curves)
    assert not problems


def test_two_nodes_at_one_place_are_an_error(tmp_path):
    nodes = {**SQUARE, "m": [50, 50, 0], "n": [50, 50.02, 0]}
    curves = {"up": {**DIAGONALS["up"], "points": ["m"]}, "down": {**DIAGONALS["down"], "points": ["n"]}}
    _, [message] = stretches_of(tmp_path, sheet(), nodes=nodes, curves=curves, join="crossings")
    assert message == "nodes 'm' and 'n' are nearly at the same place, (50.0, 50.0, 0.0); keep one"


LEG = {
    "thigh": {"section": {"point": [90, 0, 605], "normal": [0, 0, -1]}},
    "knee": {"line": "knee"},
    "front": {"line": "front", "slit": True},
    "outside": {"line": "outside", "slit": True},
}


def test_rings_and_lines_of_a_form_become_faces_by_their_names_alone(tmp_path):
    surface = mannequin({"half": "right"})
    patches = {"p": {"around": ["thigh", "outside", "-knee", "-front"]}}
    network = network_of(tmp_path, surface, curves=LEG, patches=patches, rest="openings", join="crossings")
    [patch] = network.patches
    assert [stretch.seam for stretch in patch.boundary.stretches] == [
        "thigh:thigh.front..thigh.outside", "outside:thigh.outside..knee.outside",
        "knee:knee.front..knee.outside", "front:thigh.front..knee.front",
    ]


def test_stretches_between_joined_nodes_can_be_named(tmp_path):
    surface = mannequin({"half": "right"})
    around = ["thigh:thigh.front..thigh.outside", "outside", "-knee", "-front:thigh.front..knee.front"]
    network = network_of(
        tmp_path, surface, curves=LEG, patches={"p": {"around": around}}, rest="openings", join="crossings"
    )
    assert len(network.patches) == 1
    around[0] = "thigh:thigh.front..thigh.back"
    with pytest.raises(ProjectError, match="is no face of the network"):
        network_of(tmp_path, surface, curves=LEG, patches={"p": {"around": around}}, rest="openings", join="crossings")


def test_the_grain_may_run_between_joined_nodes(tmp_path):
    surface = mannequin({"half": "right"})
    around = ["thigh", "outside", "-knee", "-front"]

    def network(grain):
        patches = {"p": {"around": around, "grain": grain}}
        return network_of(tmp_path, surface, curves=LEG, patches=patches, rest="openings", join="crossings")

    [patch] = network({"from": "knee.front", "to": "thigh.front"}).patches
    first, last = patch.boundary.vertices[list(patch.grain.chord)]
    assert (first[2], last[2]) == pytest.approx((455.0, 605.0))
    with pytest.raises(ProjectError, match=r"no curve passes a node 'knee\.back'"):
        network({"from": "knee.back", "to": "thigh.front"})
    with pytest.raises(ProjectError, match=r"no stretch 'front:thigh\.front\.\.knee\.back'"):
        network({"along": "front:thigh.front..knee.back"})
