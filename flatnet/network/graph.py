"""The network as a graph: the order of the curves around every node, and the loops that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import dot, unit
from flatnet.network.network import GeometryError, SampledStretch
from flatnet.project.curve_specs import CurveSpec, NodeSpec
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]

#: A vertex of the graph: (node, 0), or (stretch, 1), (stretch, 2) inside a stretch, in its direction.
Vertex = tuple[str, int]

#: Two curves that leave a node closer than this in its tangent plane, rad, have no sure order.
SMALLEST_ANGLE = np.radians(1.0)
#: The mean of the unit normals around a node is shorter than this where they cancel.
SHORTEST_MEAN = 0.05


class Dart(NamedTuple):
    """A stretch run forwards, or backwards; as a string it is written as in `around`."""

    stretch: str
    reversed: bool

    @property
    def opposite(self) -> Dart:
        return Dart(self.stretch, not self.reversed)

    def __str__(self) -> str:
        return f"-{self.stretch}" if self.reversed else self.stretch


@dataclass(frozen=True)
class Face:
    """A loop of darts with one face on its left."""

    darts: tuple[Dart, ...]


@dataclass(frozen=True)
class TracedFaces:
    """All loops of the network, and V - E + F of every connected component."""

    faces: tuple[Face, ...]
    euler_characteristics: tuple[int, ...]


def darts_at_nodes(stretches: Mapping[str, SampledStretch]) -> dict[str, list[Dart]]:
    """The darts that leave every node, in the order of the stretches."""
    leaving: dict[str, list[Dart]] = {}
    for name, stretch in stretches.items():
        if stretch.start is not None and stretch.end is not None:
            leaving.setdefault(stretch.start, []).append(Dart(name, False))
            leaving.setdefault(stretch.end, []).append(Dart(name, True))
    return leaving


def dangling_ends(
    stretches: Mapping[str, SampledStretch],
    places: Mapping[str, Floats],
    curves: Mapping[str, CurveSpec],
) -> list[Problem]:
    """A problem for every curve that ends inside a face and is no slit: the nearest node, and the gap.

    Nodes of curves that could not be sampled are passed over: those curves may well go on there.
    """
    problems = []
    sampled = {stretch.curve for stretch in stretches.values()}
    unsure = {node for curve in curves.values() if curve.name not in sampled for node in curve.nodes}
    for node, leaving in darts_at_nodes(stretches).items():
        stretch = stretches[leaving[0].stretch]
        if len(leaving) > 1 or stretch.slit or node in unsure:
            continue
        here = places[node]
        others = {name: float(np.linalg.norm(place - here)) for name, place in places.items() if name != node}
        nearest = min(others, key=lambda name: (others[name], name))
        message = (
            f"curve '{stretch.curve}' ends inside a face at node '{node}', where no other curve begins; "
            f"the nearest node is '{nearest}', gap {others[nearest]:.3f} mm"
        )
        gaps = {s.curve: _distance(here, s.vertices) for s in stretches.values() if s.curve != stretch.curve}
        if gaps and min(gaps.values()) < others[nearest]:
            curve = min(gaps, key=lambda name: (gaps[name], name))
            message += f"; nearer is curve '{curve}', gap {gaps[curve]:.3f} mm: let it pass through '{node}'"
        message += " (or say slit: true to cut the face open along it)"
        problems.append(Problem(curves[stretch.curve].mark, message))
    return problems


def _distance(point: Floats, polyline: Floats) -> float:
    start, chord = polyline[:-1], np.diff(polyline, axis=0)
    fraction = dot(point - start, chord) / dot(chord, chord)
    nearest = start + np.clip(fraction, 0.0, 1.0)[:, None] * chord
    return float(np.linalg.norm(point - nearest, axis=1).min())


def rotation_system(
    stretches: Mapping[str, SampledStretch],
    nodes: Mapping[str, NodeSpec],
    known: Mapping[str, list[Dart]] | None = None,
) -> tuple[dict[str, list[Dart]], list[Problem]]:
    """The darts that leave every node, anticlockwise seen against the normals, and what makes that unsure.

    `known` : node -> darts whose order is settled without the normals; others there keep their place among them.
    """
    rotation = {}
    problems = []
    for node, leaving in darts_at_nodes(stretches).items():
        settled = (known or {}).get(node, [])
        if len(settled) == len(leaving):
            rotation[node] = settled
            continue
        try:
            order = _order_around(node, leaving, stretches, nodes[node])
            rotation[node] = _settle(order, settled) if settled else order
        except GeometryError as found:
            problems.append(found.problem)
    return rotation, problems


def _order_around(
    node: str, leaving: list[Dart], stretches: Mapping[str, SampledStretch], spec: NodeSpec
) -> list[Dart]:
    """Sort darts by their angle in the node's tangent plane, whose normal is the mean of those around."""
    if len(leaving) == 1:
        return leaving
    directions = np.array([_direction(stretches[d.stretch], d.reversed) for d in leaving])
    names = ", ".join(f"'{dart}'" for dart in leaving)
    normals = np.concatenate([_normals_at(stretches[d.stretch], d.reversed) for d in leaving])
    normals = normals[np.linalg.norm(normals, axis=1) > 0.0]
    mean = normals.mean(axis=0) if len(normals) else np.zeros(3)
    if np.linalg.norm(mean) < SHORTEST_MEAN:
        if len(leaving) == 2:
            return leaving  # two darts have one order only
        cancel = "have normals that cancel: some point to the other side"
        what = cancel if len(normals) else "have no normals"
        raise GeometryError(
            spec.mark, f"node '{node}': the curves that meet there ({names}) {what}; their order is unknown"
        )
    normal = mean / np.linalg.norm(mean)
    flat = directions - (directions @ normal)[:, None] * normal
    size = np.linalg.norm(flat, axis=1)
    if size.min() < np.sin(SMALLEST_ANGLE):
        if len(leaving) == 2:
            return leaving
        steepest = leaving[int(size.argmin())].stretch
        raise GeometryError(
            spec.mark,
            f"ambiguous_faces: curve '{steepest}' leaves node '{node}' along the mean normal of the curves "
            "there, so that its place among them is unknown; check their normals",
        )
    x = flat[0] / size[0]
    angles = np.arctan2(flat @ np.cross(normal, x), flat @ x) % (2.0 * np.pi)
    order = np.argsort(angles, kind="stable")
    gaps = np.diff(np.append(angles[order], angles[order[0]] + 2.0 * np.pi))
    if gaps.min() < SMALLEST_ANGLE:
        k = int(gaps.argmin())
        one, other = leaving[order[k]], leaving[order[(k + 1) % len(order)]]
        raise GeometryError(
            spec.mark,
            f"ambiguous_faces: curves '{one.stretch}' and '{other.stretch}' leave node '{node}' within "
            f"{np.degrees(gaps[k]):.2f} degrees of each other in its tangent plane (at least "
            f"{np.degrees(SMALLEST_ANGLE):g} are needed to tell their order); join them, "
            "part them, or give one of the curves there other normals, as on both sides of a crease",
        )
    return [leaving[i] for i in order]


def _settle(order: list[Dart], settled: list[Dart]) -> list[Dart]:
    """A cyclic order with some of its darts as they are settled, each followed by the same others as before."""
    start = order.index(settled[0])
    followers: dict[Dart, list[Dart]] = {}
    for dart in order[start:] + order[:start]:
        if dart in settled:
            last = followers.setdefault(dart, [])
        else:
            last.append(dart)
    return [each for dart in settled for each in (dart, *followers[dart])]


def _direction(stretch: SampledStretch, reversed_: bool) -> Floats:
    """Unit direction of a dart's first edge."""
    v = stretch.vertices
    return unit(v[-2] - v[-1] if reversed_ else v[1] - v[0])


def _normals_at(stretch: SampledStretch, reversed_: bool) -> Floats:
    """Left and right normal of a dart's first edge, (2, 3)."""
    edge = -1 if reversed_ else 0
    return np.stack([stretch.left_normals[edge], stretch.right_normals[edge]])


def trace_faces(stretches: Mapping[str, SampledStretch], rotation: Mapping[str, list[Dart]]) -> TracedFaces:
    """Walk every loop of the network with its face on the left, each connected component alone.

    The graph of the rotation system gives every stretch two inner vertices of its own (a closed curve without
    node three), so that curves between the same nodes are not parallel edges. `networkx` walks faces on the
    right of their half-edges; handed the anticlockwise order as a clockwise one, it walks those on the left.
    It is not asked whether the embedding is planar: the network of a torus is as good.
    """
    neighbours: dict[Vertex, list[Vertex]] = {}
    for name, stretch in stretches.items():
        a, b, c = (name, 1), (name, 2), (name, 3)
        if stretch.start is None or stretch.end is None:
            neighbours |= {a: [c, b], b: [a, c], c: [b, a]}
        else:
            neighbours |= {a: [(stretch.start, 0), b], b: [a, (stretch.end, 0)]}
    for node, order in rotation.items():
        neighbours[node, 0] = [(dart.stretch, 2 if dart.reversed else 1) for dart in order]
    embedding = nx.PlanarEmbedding()
    embedding.set_data(neighbours)

    walked: set[tuple[Vertex, Vertex]] = set()
    faces: list[Face] = []
    characteristics = []
    for vertices in _components(neighbours, stretches):
        names = [name for name in stretches if (name, 1) in vertices]
        loops = [
            embedding.traverse_face(*half_edge, mark_half_edges=walked)
            for name in names
            for half_edge in (((name, 1), (name, 2)), ((name, 2), (name, 1)))
            if half_edge not in walked
        ]
        faces += [Face(_darts(loop)) for loop in loops]
        edges = sum(len(neighbours[v]) for v in vertices) // 2
        characteristics.append(len(vertices) - edges + len(loops))
    return TracedFaces(tuple(faces), tuple(characteristics))


def lone_slits(
    traced: TracedFaces, stretches: Mapping[str, SampledStretch], curves: Mapping[str, CurveSpec]
) -> list[Problem]:
    """A problem for every loop that runs along slits only, there and back: nothing joins them to a face's boundary."""
    problems = []
    for face in traced.faces:
        darts = set(face.darts)
        if all(stretches[dart.stretch].slit and dart.opposite in darts for dart in darts):
            names = list(dict.fromkeys(stretches[dart.stretch].curve for dart in face.darts))
            verb = "is a slit" if len(names) == 1 else "are slits"
            problems.append(
                Problem(
                    curves[names[0]].mark,
                    f"{' and '.join(f'curve {name!r}' for name in names)} {verb} joined to no other curve, and no face "
                    "is cut open: let one end be a node of a curve around the face",
                )
            )
    return problems


def _components(
    neighbours: Mapping[Vertex, list[Vertex]], stretches: Mapping[str, SampledStretch]
) -> list[set[Vertex]]:
    """The vertices of every connected component, in the order of their first stretch."""
    rank = {(name, 1): i for i, name in enumerate(stretches)}
    parts = nx.connected_components(nx.Graph(neighbours))
    return sorted(parts, key=lambda part: min(rank[v] for v in part if v in rank))


def _darts(loop: list[Vertex]) -> tuple[Dart, ...]:
    """The darts of a loop of vertices: its steps between the first and second inner vertex of a stretch."""
    steps = zip(loop, loop[1:] + loop[:1])
    return tuple(Dart(a[0], a[1] == 2) for a, b in steps if a[0] == b[0] and {a[1], b[1]} == {1, 2})
