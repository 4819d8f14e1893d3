"""Nicks: where an allowance is folded over a strong curve, as wide as what has to vanish."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from pieces import cloth, fitted

from flatnet.fitting.results import FlattenableMesh
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.seams import Seam
from flatnet.project.seam_specs import NickSpec, NotchSpec, SeamSpec


def lens(radius, hollow):
    """An arc of a third of a circle and what closes it: outwards its chord, hollow a rectangle round it."""
    angle = np.linspace(-np.pi / 3, np.pi / 3, 81) + np.pi / 2
    arc = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    if hollow:  # the piece lies above the arc
        left, right = arc[-1, 0] - 30.0, arc[0, 0] + 30.0
        return np.concatenate([arc[::-1], [[right, 0.5 * radius], [right, 2 * radius], [left, 2 * radius],
                                           [left, 0.5 * radius]]]), 80
    return np.concatenate([arc, [[arc[-1, 0], 0.0], [arc[0, 0], 0.0]]]), 80


def nicked(bend, hollow=False, width=15.0, notches=(), **spec):
    outline, count = lens(bend, hollow)
    n = len(outline)
    stretches = (Stretch("feather", 0, count, False), Stretch("rest", count, n - count, False))
    feather = SeamSpec(width, width, notches=NotchSpec(), nicks=NickSpec(8.0, **spec))
    seams = {
        "feather": Seam("feather", 1, "feather", feather, ("piece",), 1.0, notches),
        "rest": Seam("rest", 2, "rest", SeamSpec(0.0, 0.0), ("piece",), 1.0),
    }
    return make_piece(fitted(outline, stretches=stretches), cloth(), seams)


@pytest.mark.parametrize("radius", [30.0, 49.0])
def test_a_bulge_loses_the_width_that_has_to_vanish(radius):
    made = nicked(radius)
    length = 2.0 / 3.0 * np.pi * radius
    assert len(made.nicks) == int(length / 8.0 - 1e-6)
    step = length / len(made.nicks)
    cut = shapely.LinearRing(made.cut_line)
    for nick in made.nicks:
        left, tip, right = nick.points
        assert np.linalg.norm(tip) == pytest.approx(radius + 3.0, abs=0.05)  # of a polygon of 80 edges
        wanted = min(2.0 * 15.0 / radius, 0.6 * (1.0 + 15.0 / radius)) * step
        assert np.linalg.norm(left - right) == pytest.approx(wanted, rel=0.02)
        assert shapely.distance(cut, shapely.points([left, right])).max() < 1e-9


def test_a_hollow_is_slit():
    made = nicked(40.0, hollow=True)
    assert made.nicks
    for nick in made.nicks:
        foot, tip = nick.points
        assert np.linalg.norm(tip) == pytest.approx(37.0, abs=0.05)
        assert np.linalg.norm(foot) == pytest.approx(25.0, abs=0.05)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_straight_margin_round_an_edge_is_nicked_where_it_is_folded_under(sign):
    """A band bent round a cylinder, outside or inside: its margin goes onto the end of the cylinder."""
    radius, count = 30.0, 40
    angle = np.linspace(0.0, np.pi, count + 1)
    flat = np.concatenate([np.column_stack([radius * angle, 0 * angle]),
                           np.column_stack([radius * angle[::-1], 20.0 + 0 * angle])])
    rim = np.column_stack([radius * np.sin(angle), 0 * angle, sign * radius * np.cos(angle)])
    space = np.concatenate([rim, (rim + [0, 20, 0])[::-1]])
    first, top = np.arange(count), 2 * count + 1 - np.arange(count)
    triangles = np.concatenate([np.column_stack([first, first + 1, top]), np.column_stack([first + 1, top - 1, top])])
    n = 2 * count + 2
    stretches = (Stretch("feather", 0, count, False), Stretch("rest", count, n - count, False))
    made = fitted(flat, stretches=stretches)
    mesh = FlattenableMesh(space, triangles, n, "fair", {}, "converged", 1)
    made = replace(made, mesh=mesh)
    for folded, nicked_under in (("under", True), ("back", False)):
        feather = SeamSpec(15.0, 15.0, nicks=NickSpec(8.0, folded=folded))
        seams = {
            "feather": Seam("feather", 1, "feather", feather, ("p",), 1.0),
            "rest": Seam("rest", 2, "rest", SeamSpec(0.0, 0.0), ("p",), 1.0),
        }
        nicks = make_piece(made, cloth(), seams).nicks
        assert bool(nicks) == nicked_under
        for nick in nicks[1:-1]:  # at both ends the edge is seen on one side only
            assert len(nick.points) == (3 if sign > 0 else 2)
            if sign > 0:
                step = np.pi * radius / int(np.pi * radius / 8.0)
                assert np.linalg.norm(nick.points[0] - nick.points[-1]) == pytest.approx(step * 15.0 / radius, rel=0.02)


def test_there_are_none_where_it_is_straight_or_the_allowance_is_too_narrow_or_at_a_notch():
    assert nicked(51.0).nicks == ()  # the rest of the outline is straight
    assert nicked(51.0, radius=60.0).nicks != ()
    assert nicked(30.0, width=3.0).nicks == ()
    bare = nicked(30.0)
    at = SeamNotch(40, 0.0, 1.0)  # in the middle of the arc
    kept = nicked(30.0, notches=(at,)).nicks
    assert len(kept) == len(bare.nicks) - (len(bare.nicks) % 2)
