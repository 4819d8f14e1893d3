"""Normals of a network that has none: from the curves' tangents at the nodes, on one side of the whole network.

A curve whose normals come from the curves takes them from the nodes at its ends. A node's normal is that of the plane
that its curves leave in; where the graph has one planar embedding only (`embedding`), the order of the curves in it
tells the side, elsewhere the side is carried from node to node along the curves that turn least (as Hoppe et al. 1992
orient the tangent planes of a point cloud).
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import dot, unit
from flatnet.network.embedding import chains, head, unique_embedding
from flatnet.network.graph import Dart, darts_at_nodes
from flatnet.network.network import SampledStretch
from flatnet.project.curve_specs import CurveSpec, NodeSpec
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]
Rotation = dict[str, list[Dart]]

#: Two curves that meet at a sharper corner than this span a tangent plane; others go on through the node, sine.
CORNER = 0.5
#: The curves of a node leave in no common plane where their third singular value is more than this part of the second.
ISOTROPIC = 0.8
#: Lengths below this, of vectors made of unit vectors, are no direction.
SHORTEST = 0.05
#: Volume under a network's normals, over that of a ball as large, below which it has no inside.
FLAT = 0.02


def normals_from_curves(
    stretches: Mapping[str, SampledStretch], curves: Mapping[str, CurveSpec], nodes: Mapping[str, NodeSpec]
) -> tuple[dict[str, SampledStretch], Rotation, list[Problem]]:
    """Give normals to the stretches whose curves say `normals: curves`.

    All normals of a connected part stand on one side: that of the normals given there, else away from the middle
    of the part, else, of a flat one, up.

    Returns
    -------
    stretches : all of them, in their order.
    rotation : junction -> its darts, anticlockwise seen against the normals, in the parts whose graph leaves no choice.
    problems : nodes and curves that show no plane.
    """
    done = dict(stretches)
    rotation: Rotation = {}
    problems: list[Problem] = []
    leaving = darts_at_nodes(stretches)
    graph = nx.Graph((head(stretches, d.opposite), head(stretches, d)) for darts in leaving.values() for d in darts)
    parts = [{node: leaving[node] for node in leaving if node in part} for part in nx.connected_components(graph)]
    for part in parts:
        wanting = {d.stretch for darts in part.values() for d in darts if _wants(stretches[d.stretch], curves)}
        if wanting:
            normals, order, found = _part_normals(stretches, part, nodes, wanting)
            rotation |= order
            problems += found
            done |= {name: _with_normals(stretches[name], normals[name]) for name in wanting & normals.keys()}
    for name, stretch in stretches.items():
        if stretch.start is None and _wants(stretch, curves):
            done[name] = _with_normals(stretch, _loop_normals(stretch.vertices))
    problems += [
        Problem(
            curves[stretch.curve].normals.mark,
            f"curve '{stretch.curve}': the curves show no plane that it could take its normals from; give 'normals'",
        )
        for stretch in done.values()
        if _wants(stretch, curves) and not problems and not stretch.left_normals.any()
    ]
    return done, rotation, problems


def _wants(stretch: SampledStretch, curves: Mapping[str, CurveSpec]) -> bool:
    return curves[stretch.curve].normals.source == "curves"


def _with_normals(stretch: SampledStretch, normals: Floats) -> SampledStretch:
    return replace(stretch, left_normals=normals, right_normals=normals)


def _part_normals(
    stretches: Mapping[str, SampledStretch],
    leaving: Mapping[str, list[Dart]],
    nodes: Mapping[str, NodeSpec],
    wanting: set[str],
) -> tuple[dict[str, Floats], Rotation, list[Problem]]:
    """Edge normals of the wanting stretches of a connected part, and its rotation where there is no choice."""
    given = _given_normals(stretches, leaving, wanting)
    rotation = unique_embedding(stretches, leaving) or {}
    axes: dict[str, Floats] = {}
    problems = []
    for node, darts in leaving.items():
        directions = np.array([_direction(stretches, dart) for dart in rotation.get(node, darts)])
        axis = _turning(directions) if node in rotation else _plane(directions)
        if axis is not None:
            axes[node] = axis
        elif node in given:
            axes[node] = given[node]
        elif len(darts) > 2:
            names = ", ".join(f"'{dart}'" for dart in darts)
            message = f"the curves that meet there ({names}) leave in no common plane; give one of them normals"
            problems.append(Problem(nodes[node].mark, f"ambiguous_faces: node '{node}': {message}"))
    if problems:
        return {}, {}, problems
    if not axes:  # a loop without corner
        return _lone_loop(stretches, leaving), {}, []

    runs = [_Run(stretches, run) for run in chains(stretches, leaving, axes)]
    sure = set(rotation) or {next((node for node in axes if node in given), next(iter(axes)))}
    _turn_to_one_side(axes, runs, sure)
    side = _side(axes, given, runs)
    axes = {node: given.get(node, side * axis) for node, axis in axes.items()}
    normals = {name: piece for run in runs for name, piece in run.stretch_normals(axes).items()}
    if side < 0.0:
        rotation = {node: darts[::-1] for node, darts in rotation.items()}
    return normals, rotation, []


def _given_normals(
    stretches: Mapping[str, SampledStretch], leaving: Mapping[str, list[Dart]], wanting: set[str]
) -> dict[str, Floats]:
    """Mean of the normals that a node's other curves have of their own."""
    given = {}
    for node, darts in leaving.items():
        own = [stretches[dart.stretch] for dart in darts if dart.stretch not in wanting]
        ends = [-1 if dart.reversed else 0 for dart in darts if dart.stretch not in wanting]
        mean = sum((s.left_normals[i] + s.right_normals[i] for s, i in zip(own, ends)), np.zeros(3))
        if np.linalg.norm(mean) > SHORTEST:
            given[node] = unit(mean)
    return given


def _direction(stretches: Mapping[str, SampledStretch], dart: Dart) -> Floats:
    v = stretches[dart.stretch].vertices
    return unit(v[-2] - v[-1] if dart.reversed else v[1] - v[0])


def _turning(directions: Floats) -> Floats | None:
    """Normal of the closed polygon of unit directions in their cyclic order."""
    area = np.cross(directions, np.roll(directions, -1, axis=0)).sum(axis=0)
    return unit(area) if np.linalg.norm(area) > SHORTEST else None


def _plane(directions: Floats) -> Floats | None:
    """Normal, on either side, of the plane through the tips of unit directions; of two at a corner, of their plane."""
    if len(directions) < 3:
        across = np.cross(directions[0], directions[-1])
        return unit(across) if np.linalg.norm(across) > CORNER else None
    _, sizes, axes = np.linalg.svd(directions - directions.mean(axis=0))
    if sizes[1] < SHORTEST or sizes[2] > ISOTROPIC * sizes[1]:
        return None
    return np.array(axes[2])


class _Run:
    """Consecutive darts as one polyline from node `start` to node `end`, whose normals turn evenly between them."""

    def __init__(self, stretches: Mapping[str, SampledStretch], darts: Sequence[Dart]) -> None:
        self.darts = darts
        self.start, self.end = head(stretches, darts[0].opposite), head(stretches, darts[-1])
        lines = [stretches[d.stretch].vertices[:: -1 if d.reversed else 1] for d in darts]
        self.counts = [len(line) - 1 for line in lines]
        self.vertices = np.concatenate([lines[0][:1], *(line[1:] for line in lines)])
        edges = np.diff(self.vertices, axis=0)
        self.lengths = np.linalg.norm(edges, axis=1)
        self.tangents = edges / self.lengths[:, None]

    @property
    def middles(self) -> Floats:
        return 0.5 * (self.vertices[1:] + self.vertices[:-1])

    def carried(self, normal: Floats) -> Floats:
        """A normal at the first edge, carried on by the least rotation from edge to edge, (k, 3)."""
        t = self.tangents
        normals = np.empty_like(t)
        normals[0] = normal
        for i in range(1, len(t)):
            bend = 1.0 + t[i - 1] @ t[i]
            lean = normals[i - 1] @ t[i] / bend if bend > 1e-9 else 0.0
            normals[i] = normals[i - 1] - lean * (t[i - 1] + t[i])
        return normals

    def agreement(self, axes: Mapping[str, Floats]) -> float:
        """How well the axes at both ends agree, in [-1, 1]; negative where one should be turned round."""
        start, end = self._ends(axes)
        return float(self.carried(start)[-1] @ end)

    def _ends(self, axes: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """The axes at both ends, as far as they are orthogonal to the first and last edge; 0 at a dead end."""
        first, last = self.tangents[0], self.tangents[-1]
        start, end = axes[self.start], axes.get(self.end, np.zeros(3))
        return start - (start @ first) * first, end - (end @ last) * last

    def stretch_normals(self, axes: Mapping[str, Floats]) -> dict[str, Floats]:
        """Unit normals of the edges of every stretch, in its own direction; 0 where neither end has one."""
        start, end = self._ends(axes)
        if np.linalg.norm(start) < SHORTEST:
            start = np.zeros(3)
            if np.linalg.norm(end) >= SHORTEST:  # carried back from the end: the least rotation has an inverse
                backwards = np.stack([self.carried(column)[-1] for column in np.eye(3)], axis=1)
                start = backwards.T @ end
        normals = self.carried(start)
        if np.linalg.norm(start) and np.linalg.norm(end) >= SHORTEST:
            last = self.tangents[-1]
            twist = np.arctan2(np.cross(normals[-1], end) @ last, normals[-1] @ end)
            angle = (twist * (np.cumsum(self.lengths) - 0.5 * self.lengths) / self.lengths.sum())[:, None]
            normals = np.cos(angle) * normals + np.sin(angle) * np.cross(self.tangents, normals)
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0.0)
        pieces = np.split(normals, np.cumsum(self.counts)[:-1])
        return {d.stretch: piece[::-1] if d.reversed else piece for d, piece in zip(self.darts, pieces)}


def _turn_to_one_side(axes: dict[str, Floats], runs: Sequence[_Run], sure: set[str]) -> None:
    """Turn axes round that stand against the sure ones, from node to node along the curve with the surest agreement."""
    at: dict[str, list[int]] = {}
    for i, run in enumerate(runs):
        at.setdefault(run.start, []).append(i)
        at.setdefault(run.end, []).append(i)
    surest = [abs(run.agreement(axes)) for run in runs]
    reached = set(sure)
    queue = sorted((-surest[i], i) for node in sure for i in at.get(node, []))
    while queue:
        _, i = heapq.heappop(queue)
        new = next((node for node in (runs[i].start, runs[i].end) if node in axes and node not in reached), None)
        if new is None:
            continue
        if runs[i].agreement(axes) < 0.0:
            axes[new] = -axes[new]
        reached.add(new)
        for j in at[new]:
            heapq.heappush(queue, (-surest[j], j))


def _side(axes: Mapping[str, Floats], given: Mapping[str, Floats], runs: Sequence[_Run]) -> float:
    """1 or -1: what the axes, all on one side, are to be multiplied by."""
    agreement = sum(float(axes[node] @ normal) for node, normal in given.items())
    if abs(agreement) > SHORTEST:
        return 1.0 if agreement > 0.0 else -1.0
    pieces = [run.stretch_normals(axes) for run in runs]
    normals = np.concatenate([p[d.stretch][:: -1 if d.reversed else 1] for r, p in zip(runs, pieces) for d in r.darts])
    weights = np.concatenate([run.lengths for run in runs])[:, None]
    middles = np.concatenate([run.middles for run in runs])
    return outer_side(middles, weights * normals)


def outer_side(places: Floats, normals: Floats) -> float:
    """1 where normals (weighted by what they stand for) point away from the middle of their places, -1 inwards.

    Where they do neither, as on a flat network, 1 if they point up (z, else y, else x), -1 down.
    """
    weights = np.linalg.norm(normals, axis=1)
    arms = places - np.average(places, axis=0, weights=weights)
    outwards = float(dot(arms, normals).sum())
    if abs(outwards) > FLAT * float((weights * np.linalg.norm(arms, axis=1)).sum()):
        return 1.0 if outwards > 0.0 else -1.0
    total = normals.sum(axis=0)[::-1]
    up = next((part for part in total if abs(part) > SHORTEST * weights.sum()), 1.0)
    return 1.0 if up > 0.0 else -1.0


def _lone_loop(stretches: Mapping[str, SampledStretch], leaving: Mapping[str, list[Dart]]) -> dict[str, Floats]:
    """Normals of stretches that are one loop without corner: those of its plane."""
    [run] = [_Run(stretches, darts) for darts in chains(stretches, leaving, [next(iter(leaving))])]
    if run.start != run.end:
        return {dart.stretch: np.zeros((count, 3)) for dart, count in zip(run.darts, run.counts)}
    pieces = np.split(_loop_normals(run.vertices), np.cumsum(run.counts)[:-1])
    return {d.stretch: piece[::-1] if d.reversed else piece for d, piece in zip(run.darts, pieces)}


def _loop_normals(vertices: Floats) -> Floats:
    """Edge normals of a closed polyline (the last vertex is the first): up from its mean plane; 0 if it has none."""
    arms = vertices - vertices[:-1].mean(axis=0)
    area = np.cross(arms[:-1], arms[1:]).sum(axis=0)
    edges = np.diff(vertices, axis=0)
    tangents = unit(edges)
    length = np.linalg.norm(edges, axis=1).sum()
    if np.linalg.norm(area) < SHORTEST * length**2 / (2.0 * np.pi):  # of a circle it is length^2 / (2 pi)
        return np.zeros_like(edges)
    axis = unit(area)
    axis = axis * outer_side(vertices[:-1], np.broadcast_to(axis, (len(edges), 3)))
    across = axis - (tangents @ axis)[:, None] * tangents
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.divide(across, size, out=np.zeros_like(across), where=size > SHORTEST)
