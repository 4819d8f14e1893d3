"""Divide a patch of the network by a cut: two patches with a new seam between them, and no vertex moved.

A cut begins and ends at vertices of the patch's boundary, so that the patches next door keep their vertices; where
no node stands there yet, one is made and the seam through it becomes two.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import unit
from flatnet.network.network import CurveNetwork, Loops, SampledStretch
from flatnet.network.patch import BoundaryCurve, Grain, Patch, Stretch

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cut:
    """A curve across a patch.

    Attributes
    ----------
    start, end : the vertices of the patch's boundary that it joins.
    vertices : (k + 1, 3) float, mm; the first and last are those two, to the last bit.
    normals : (k, 3) float, unit; of its edges, orthogonal to them.
    """

    start: int
    end: int
    vertices: Floats
    normals: Floats

    def __post_init__(self) -> None:
        for array in (self.vertices, self.normals):
            array.setflags(write=False)

    @property
    def length(self) -> float:
        """mm."""
        return polyline_length(self.vertices)

    @property
    def reversed(self) -> Cut:
        """The same cut from its end to its start."""
        return Cut(self.end, self.start, self.vertices[::-1].copy(), self.normals[::-1].copy())


def halves(boundary: BoundaryCurve, cut: Cut, seam: str) -> tuple[BoundaryCurve, BoundaryCurve]:
    """The boundaries on the left and on the right of a cut, each with the cut as its last stretch.

    `min_angles` stay with their vertices, but for the two ends of the cut, where the corner is divided.
    """
    return _left_of(boundary, cut, seam, False), _left_of(boundary, cut.reversed, seam, True)


def divide(
    network: CurveNetwork, name: str, cut: Cut, seam: str, parts: tuple[str, str], nodes: tuple[str, str]
) -> CurveNetwork:
    """The network in which a patch is divided by a cut.

    Parameters
    ----------
    name : of the patch.
    seam : name of the new stretch.
    parts : names of the patches on the left and on the right of the cut; they take the place of the patch.
    nodes : names for new nodes at the cut's start and end; not used where a node is there.
    """
    network, start = with_node(network, name, cut.start, nodes[0])
    network, end = with_node(network, name, cut.end, nodes[1])
    patch = next(patch for patch in network.patches if patch.name == name)
    divided = tuple(
        replace(patch, name=part, boundary=boundary, grain=_grain_of(patch, boundary), mirror_of=None)
        for part, boundary in zip(parts, halves(patch.boundary, cut, seam), strict=True)
    )
    stretch = SampledStretch(seam, seam, start, end, cut.vertices, cut.normals, cut.normals)
    return replace(
        network,
        stretches={**network.stretches, seam: stretch},
        patches=tuple(
            part for other in network.patches for part in (divided if other.name == name else (other,))
        ),
        face_count=network.face_count + 1,
    )


def with_node(network: CurveNetwork, patch: str, vertex: int, name: str) -> tuple[CurveNetwork, str]:
    """The network with a node at a vertex of a patch's boundary, and the node's name."""
    boundary = next(p.boundary for p in network.patches if p.name == patch)
    n = len(boundary.vertices)
    run = next(s for s in boundary.stretches if (vertex - s.first) % n < s.count)
    offset = (vertex - run.first) % n
    return node_on_seam(network, run.seam, run.count - offset if run.reversed else offset, name)


def node_on_seam(network: CurveNetwork, seam_name: str, at: int, name: str) -> tuple[CurveNetwork, str]:
    """The network with a node at vertex `at` of a seam, and the node's name; the old one where there is one.

    The seam becomes two, `curve:from..to`, in every patch and opening along it.
    """
    seam = network.stretches[seam_name]
    there = {0: seam.start, len(seam.vertices) - 1: seam.end}.get(at)
    if there is not None:
        return network, there
    parts = _split(seam, at, name)
    place = seam.vertices[at].copy()
    place.setflags(write=False)
    stretches: dict[str, SampledStretch] = {}
    for key, stretch in network.stretches.items():
        stretches |= {part.name: part for part in parts} if key == seam.name else {key: stretch}
    return replace(
        network,
        nodes={**network.nodes, name: place},
        stretches=stretches,
        patches=tuple(_with_parts(p, seam, at, parts) for p in network.patches),
        rings=_loops_with_parts(network.rings, seam.name, parts),
        openings=_loops_with_parts(network.openings, seam.name, parts),
    ), name


def _split(seam: SampledStretch, at: int, node: str) -> tuple[SampledStretch, ...]:
    """The parts of a seam before and after its vertex `at`; a closed one without node is turned to begin there."""
    edges = np.arange(len(seam.left_normals))
    if seam.start is None or seam.end is None:
        return (_part(seam, seam.name, node, node, np.roll(edges, -at)),)
    return (
        _part(seam, f"{seam.curve}:{seam.start}..{node}", seam.start, node, edges[:at]),
        _part(seam, f"{seam.curve}:{node}..{seam.end}", node, seam.end, edges[at:]),
    )


def _part(seam: SampledStretch, name: str, start: str, end: str, edges: NDArray[np.int64]) -> SampledStretch:
    """Some edges of a seam, one after the other, as a seam; one array for both sides' normals stays one."""
    left = seam.left_normals[edges]
    right = seam.right_normals[edges] if seam.crease else left
    vertices = seam.vertices[np.append(edges, edges[-1] + 1)]
    return replace(
        seam, name=name, start=start, end=end, vertices=vertices, left_normals=left, right_normals=right
    )


def _with_parts(patch: Patch, seam: SampledStretch, at: int, parts: tuple[SampledStretch, ...]) -> Patch:
    """The patch with the parts of a seam in the seam's place along its boundary."""
    n = len(patch.boundary.vertices)
    stretches: list[Stretch] = []
    for run in patch.boundary.stretches:
        if run.seam != seam.name:
            stretches.append(run)
        elif len(parts) == 1:  # closed: the run begins at the node now
            shift = run.count - at if run.reversed else at
            stretches.append(replace(run, first=(run.first + shift) % n))
        else:
            order = parts[::-1] if run.reversed else parts
            first = run.first
            for part in order:
                count = len(part.vertices) - 1
                stretches.append(Stretch(part.name, first % n, count, run.reversed))
                first += count
    return replace(patch, boundary=replace(patch.boundary, stretches=tuple(stretches)))


def _loops_with_parts(
    faces: Mapping[str, Loops], seam: str, parts: tuple[SampledStretch, ...]
) -> dict[str, Loops]:
    forwards = tuple(part.name for part in parts)
    backwards = tuple(f"-{name}" for name in reversed(forwards))
    put = {seam: forwards, f"-{seam}": backwards}
    return {
        name: tuple(tuple(new for old in loop for new in put.get(old, (old,))) for loop in loops)
        for name, loops in faces.items()
    }


def _grain_of(patch: Patch, boundary: BoundaryCurve) -> Grain | None:
    """The grain of a half: between the same two vertices, or in their direction where it has not got both."""
    if patch.grain is None or patch.grain.chord is None:
        return patch.grain
    first, last = patch.boundary.vertices[list(patch.grain.chord)]
    at = [np.flatnonzero((boundary.vertices == place).all(axis=1)) for place in (first, last)]
    if all(len(found) for found in at):
        return replace(patch.grain, chord=(int(at[0][0]), int(at[1][0])))
    return replace(patch.grain, chord=None, direction=unit(last - first))


def _left_of(boundary: BoundaryCurve, cut: Cut, seam: str, reversed_: bool) -> BoundaryCurve:
    """The boundary from the cut's end on to its start, closed by the cut."""
    n = len(boundary.vertices)
    count = (cut.start - cut.end) % n or n
    kept = (cut.end + np.arange(count)) % n
    least = boundary.min_angles[kept]
    least[0] = 0.0
    tips = {int(vertex): i for i, vertex in enumerate(kept)}
    return BoundaryCurve(
        vertices=np.concatenate([boundary.vertices[kept], cut.vertices[:-1]]),
        normals=np.concatenate([boundary.normals[kept], cut.normals]),
        stretches=(
            *_stretches_between(boundary, cut.end, count),
            Stretch(seam, count, len(cut.normals), reversed_),
        ),
        min_angles=np.concatenate([least, np.zeros(len(cut.normals))]),
        slit_tips=tuple(tips[tip] for tip in boundary.slit_tips if tip in tips and tip not in (cut.start, cut.end)),
    )


def _stretches_between(boundary: BoundaryCurve, first: int, count: int) -> list[Stretch]:
    """The runs along `count` edges from the vertex `first`; runs end there (`with_node`) or are cut short."""
    n = len(boundary.vertices)
    seams = [(s.seam, s.reversed, i) for i, s in enumerate(boundary.stretches) for _ in range(s.count)]
    offset = boundary.stretches[0].first
    runs: list[Stretch] = []
    last: tuple[str, bool, int] | None = None
    for k in range(count):
        here = seams[(first + k - offset) % n]
        if here == last:
            runs[-1] = replace(runs[-1], count=runs[-1].count + 1)
        else:
            runs.append(Stretch(here[0], k, 1, here[1]))
        last = here
    return runs
