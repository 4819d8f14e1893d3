"""Join the two loops of a ring by a seam, along which the patch is cut open: then it is a disk."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import unit
from flatnet.network.boundaries import join, make_patch, start_of
from flatnet.network.division import node_on_seam
from flatnet.network.graph import Dart
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch
from flatnet.project.model import Project
from flatnet.remedies.cut_curve import STEEPEST, curve_between
from flatnet.remedies.diagnose import FitAll, Result, free_name
from flatnet.remedies.seam_spec import seam_spec

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RingSeam:
    """The seam between the nearest places of a ring's loops, and what came of the patch with it.

    Attributes
    ----------
    before, network : without the seam, and with it.
    patch : the ring cut open.
    places : where it begins and ends, in words.
    """

    before: CurveNetwork
    network: CurveNetwork
    seam: str
    patch: Patch
    places: tuple[str, str]
    result: Result


def ring_seam(
    project: Project, network: CurveNetwork, name: str, surface: ReferenceSurface | None, fit_all: FitAll
) -> RingSeam | None:
    """A seam tried on a patch that has two loops; None where it has more, or no curve joins them to a disk."""
    spec = project.patches[name]
    if len(network.rings[name]) != 2:
        return None
    seam = free_name(f"{name}_seam", network.stretches)
    after, nodes, places = network, [], []
    for loop, vertex, end in zip(range(2), _nearest_vertices(network, name), "ab", strict=True):
        met, at = _seam_at(after, _darts(after, name)[loop], vertex)
        places.append(f"'{met}' at {_arclength(after.stretches[met], at):.1f} mm")
        after, node = node_on_seam(after, met, at, free_name(f"{seam}_{end}", after.nodes))
        nodes.append(node)
    loops = [
        _from_node(loop, after, node) for loop, node in zip(_darts(after, name), nodes, strict=True)
    ]
    drawn = _drawn([join(loop, after.stretches, {}) for loop in loops], spec.edge_length, surface)
    if drawn is None:
        return None
    vertices, normals = drawn
    stretch = SampledStretch(seam, seam, nodes[0], nodes[1], vertices, normals, normals)
    after = replace(after, stretches={**after.stretches, seam: stretch})
    darts = (*loops[0], Dart(seam, False), *loops[1], Dart(seam, True))
    curves = {**project.curves, seam: seam_spec(stretch, spec)}
    patch, _ = make_patch(spec, (darts,), after.stretches, curves)
    if not isinstance(patch, Patch):
        return None
    after = replace(
        after,
        patches=(*after.patches, patch),
        rings={other: found for other, found in after.rings.items() if other != name},
        failed=tuple(finding for finding in after.failed if finding.patch != name),
    )
    [result] = fit_all([patch])
    return RingSeam(network, after, seam, patch, (places[0], places[1]), result)


def _darts(network: CurveNetwork, name: str) -> list[list[Dart]]:
    return [[Dart(signed.removeprefix("-"), signed.startswith("-")) for signed in loop] for loop in network.rings[name]]


def _nearest_vertices(network: CurveNetwork, name: str) -> tuple[int, int]:
    """The two vertices, counted along each loop, where the loops come nearest to each other.

    The start of a closed curve is none of them: no fraction of its length names it in a project file.
    """
    loops = _darts(network, name)
    first, second = (join(loop, network.stretches, {}).vertices for loop in loops)
    skipped = [int(len(loop) == 1) for loop in loops]
    gaps, nearest = cKDTree(second[skipped[1] :]).query(first[skipped[0] :])
    return int(gaps.argmin()) + skipped[0], int(nearest[gaps.argmin()]) + skipped[1]


def _seam_at(network: CurveNetwork, loop: list[Dart], vertex: int) -> tuple[str, int]:
    """The seam that a vertex of a loop lies on, and its index along the seam."""
    for dart in loop:
        count = len(network.stretches[dart.stretch].left_normals)
        if vertex < count:
            return dart.stretch, count - vertex if dart.reversed else vertex
        vertex -= count
    raise IndexError("the loop has fewer vertices")


def _arclength(seam: SampledStretch, at: int) -> float:
    return polyline_length(seam.vertices[: at + 1])


def _from_node(loop: list[Dart], network: CurveNetwork, node: str) -> list[Dart]:
    start = next(i for i, dart in enumerate(loop) if start_of(network.stretches[dart.stretch], dart) == node)
    return loop[start:] + loop[:start]


def _drawn(
    loops: list[BoundaryCurve], edge_length: float, surface: ReferenceSurface | None
) -> tuple[Floats, Floats] | None:
    """The seam between the first vertices of two loops, as `curve_between` draws it."""
    ends = np.stack([loop.vertices[0] for loop in loops])
    normals = unit(np.stack([loop.normals[0] + loop.normals[-1] for loop in loops]))
    chord = unit(ends[1] - ends[0])
    directions = np.stack([chord, -chord])
    directions -= np.sum(directions * normals, axis=1)[:, None] * normals
    if np.linalg.norm(directions, axis=1).min() < np.cos(STEEPEST):
        return None
    return curve_between(ends, unit(directions), normals, edge_length, surface)
