"""Where curves cross on the surface without a node of both, and joining them there."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, count

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.failure import spoken
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.triangles import cross, dot
from flatnet.network.curves import DrawnCurve
from flatnet.project.curve_specs import CurveSpec, NodeSpec
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Two curves that both come this near to a common node, in edge lengths, meet in it: it is no second crossing.
AT_NODE = 0.25
#: A node or an end this near to a curve, in edge lengths, lies on it.
TOUCHING = 0.01
#: Where a node is this near to a crossing, in edge lengths, the curves are joined in that node.
JOINED_IN_NODE = 0.1
#: Segments meet if they do so up to this share of their lengths: where the points of two curves coincide, the
#: tangent planes that they are seen in may differ a little.
SLACK = 1e-3


@dataclass(frozen=True, eq=False)
class Crossing:
    """Two curves and their parameters where they cross, or where one ends on the other, at `position`, (3,) mm.

    `node` : the node of one of them that lies there, which the other does not pass.
    """

    curves: tuple[str, str]
    parameters: tuple[float, float]
    position: Floats
    node: str | None = None


def join_crossings(
    curves: Mapping[str, CurveSpec],
    nodes: Mapping[str, NodeSpec],
    drawn: Mapping[str, DrawnCurve],
    surface: ReferenceSurface,
) -> tuple[dict[str, DrawnCurve], dict[str, NodeSpec], list[Problem]]:
    """The curves cut where they cross, the new nodes (`a.b` where b crosses a, then `a.b.2`), and what can't be joined.

    Where one of them has a node there already, that of another crossing too, they are joined in it.
    """
    joined = dict(drawn)
    new: dict[str, NodeSpec] = {}
    problems = []
    for crossing in find_crossings(curves, drawn, surface):
        near = JOINED_IN_NODE * min(curves[name].edge_length for name in crossing.curves)
        there = [_node_near(joined[name], crossing.position, near) for name in crossing.curves]
        names = [name for name in there if name is not None]
        if len(set(names)) == 2:
            one, other = names
            message = f"nodes '{one}' and '{other}' are nearly at the same place, {spoken(crossing.position)}; keep one"
            problems.append(Problem(curves[crossing.curves[1]].mark, message))
            continue
        if names:
            [name] = set(names)
            owner = joined[crossing.curves[there.index(name)]]
            position = next(owner.points[index] for index, node in owner.nodes if node == name)
        else:
            name, position = _free_name(".".join(crossing.curves), {*nodes, *new}), crossing.position
            new[name] = NodeSpec(name, position, True, curves[crossing.curves[1]].mark)
        for curve, parameter, node in zip(crossing.curves, crossing.parameters, there):
            if node is None:
                joined[curve] = joined[curve].cut(parameter, name, position)
    return joined, new, list(dict.fromkeys(problems))


def _node_near(drawn: DrawnCurve, position: Floats, near: float) -> str | None:
    """The node of a curve that is nearest to a place, if it is near."""
    distances = [(float(np.linalg.norm(drawn.points[index] - position)), node) for index, node in drawn.nodes]
    distance, node = min(distances, default=(np.inf, None))
    return node if distance <= near else None


def _free_name(base: str, taken: Container[str]) -> str:
    names = (base if i == 1 else f"{base}.{i}" for i in count(1))
    return next(name for name in names if name not in taken)


def name_ends(
    curves: Mapping[str, CurveSpec], nodes: Container[str], drawn: Mapping[str, DrawnCurve]
) -> tuple[dict[str, DrawnCurve], dict[str, NodeSpec]]:
    """The open curves with nodes `curve.start` and `curve.end` where their ends have none, and these nodes."""
    named = dict(drawn)
    new: dict[str, NodeSpec] = {}
    for curve, each in drawn.items():
        for index, what in _free_ends(each):
            name = _free_name(f"{curve}.{what}", nodes)
            new[name] = NodeSpec(name, each.points[index], True, curves[curve].mark)
            named[curve] = named[curve].cut(float(each.parameters[index]), name, each.points[index])
    return named, new


def _free_ends(drawn: DrawnCurve) -> list[tuple[int, str]]:
    """The ends of an open curve that are no nodes."""
    taken = {index for index, _ in drawn.nodes}
    ends = [] if drawn.control.closed else [(0, "start"), (len(drawn.points) - 1, "end")]
    return [(index, what) for index, what in ends if index not in taken]


def crossing_problems(
    curves: Mapping[str, CurveSpec], drawn: Mapping[str, DrawnCurve], surface: ReferenceSurface
) -> list[Problem]:
    """A problem for every place where two curves cross without a common node."""
    problems = []
    for crossing in find_crossings(curves, drawn, surface):
        one, other = crossing.curves
        where = spoken(crossing.position)
        if crossing.node is None:
            message = f"curves '{one}' and '{other}' cross at {where} without a node of both; give them one there"
        else:
            passing = one if all(node != crossing.node for _, node in drawn[one].nodes) else other
            message = f"node '{crossing.node}' lies on curve '{passing}' at {where}; let the curve pass through it"
        problems.append(Problem(curves[other].mark, f"{message}, or say join: crossings at the top of the file"))
    return problems


def find_crossings(
    curves: Mapping[str, CurveSpec], drawn: Mapping[str, DrawnCurve], surface: ReferenceSurface
) -> list[Crossing]:
    """Every crossing of two curves on the surface, in the order of the curves and then along the first."""
    found = []
    on_surface = [name for name in drawn if curves[name].on_surface]
    pairs = list(combinations(on_surface, 2))
    meetings = _meetings(drawn, pairs, surface)
    for one, other in pairs:
        edge_length = min(curves[one].edge_length, curves[other].edge_length)
        touching = _touching((one, other), (drawn[one], drawn[other]), edge_length)
        passed = {node for _, node in drawn[other].nodes}
        known = [drawn[one].points[index] for index, node in drawn[one].nodes if node in passed]
        known += [each.position for each in touching]
        crossing = []
        for each in meetings.get((one, other), []):
            apart = np.linalg.norm(np.reshape(known, (-1, 3)) - each.position, axis=1)
            if apart.min(initial=np.inf) > AT_NODE * edge_length:
                crossing.append(each)
                known.append(each.position)
        found += touching + crossing
    return found


def _middles(points: Floats) -> Floats:
    return 0.5 * (points[:-1] + points[1:])


def _touching(
    names: tuple[str, str], pair: tuple[DrawnCurve, DrawnCurve], edge_length: float
) -> list[Crossing]:
    """Nodes and ends of one curve that lie on the other, which does not pass them."""
    found: list[Crossing] = []
    for here, there in ((0, 1), (1, 0)):
        passed = {node for _, node in pair[there].nodes}
        starts, chords = pair[there].points[:-1], np.diff(pair[there].points, axis=0)
        ends = [(index, None) for index, _ in _free_ends(pair[here])]
        for index, node in [*pair[here].nodes, *ends]:
            place = pair[here].points[index]
            # Where both end at the same place, one of them says it all.
            said = any(np.linalg.norm(each.position - place) <= TOUCHING * edge_length for each in found)
            if node in passed or (node is None and said):
                continue
            squared = np.maximum(dot(chords, chords), 1e-300)
            part = np.clip(dot(place - starts, chords) / squared, 0.0, 1.0)
            distances = np.linalg.norm(starts + part[:, None] * chords - place, axis=1)
            k = int(distances.argmin())
            if distances[k] <= TOUCHING * edge_length:
                at = [0.0, 0.0]
                at[here] = float(pair[here].parameters[index])
                at[there] = float(np.interp(k + part[k], np.arange(len(chords) + 1), pair[there].parameters))
                found.append(Crossing(names, (at[0], at[1]), place, node))
    return found


def _near_segments(
    drawn: Mapping[str, DrawnCurve], pairs: Sequence[tuple[str, str]]
) -> tuple[Ints, Ints, Ints]:
    """Every pair of curves' segments that may meet: index of the pair, and of the segment of either curve."""
    names = {name for pair in pairs for name in pair}
    trees = {name: cKDTree(_middles(drawn[name].points)) for name in names}
    longest = {
        name: float(np.linalg.norm(np.diff(drawn[name].points, axis=0), axis=1).max()) for name in names
    }
    found = [np.empty((0, 3), dtype=np.int64)]
    for k, (one, other) in enumerate(pairs):
        reach = 0.5 * (longest[one] + longest[other]) * (1.0 + SLACK)
        near = trees[one].query_ball_tree(trees[other], reach)
        i = np.repeat(np.arange(len(near)), [len(each) for each in near])
        j = np.array([each for row in near for each in row], dtype=np.int64)
        found.append(np.stack([np.full(len(i), k), i, j], axis=1))
    pair, i, j = np.concatenate(found).T
    return pair, i, j


def _meetings(
    drawn: Mapping[str, DrawnCurve], pairs: Sequence[tuple[str, str]], surface: ReferenceSurface
) -> dict[tuple[str, str], list[Crossing]]:
    """Where segments of two curves cross, in the order of the first curve; near a point of a curve perhaps twice.

    Seen along the surface's normal they cross, and the gap between them is less than they are long: not two sides of
    a thin body.
    """
    pair, i, j = _near_segments(drawn, pairs)
    if len(pair) == 0:
        return {}
    first, second = (
        np.array([drawn[pairs[k][side]].points[index : index + 2] for k, index in zip(pair, indices)])
        for side, indices in ((0, i), (1, j))
    )
    a, c, u, v = first[:, 0], second[:, 0], first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    lengths = np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1)
    one_side, other_side = (surface.nearest(segment.mean(axis=1))[1] for segment in (first, second))
    normals = one_side + other_side
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    w = c - a
    area = dot(cross(u, v), normals)
    safe = np.where(area == 0.0, 1.0, area)
    s, t = dot(cross(w, v), normals) / safe, dot(cross(w, u), normals) / safe
    gap = np.abs(dot(w + t[:, None] * v - s[:, None] * u, normals))
    meets = np.flatnonzero(
        (np.abs(area) > 1e-9 * lengths[0] * lengths[1])
        & (np.abs(s - 0.5) <= 0.5 + SLACK)
        & (np.abs(t - 0.5) <= 0.5 + SLACK)
        & (gap <= 0.5 * np.maximum(*lengths))
        & (dot(one_side, other_side) > 0.0)
    )
    middles = 0.5 * (a + s[:, None] * u + c + t[:, None] * v)[meets]
    found: dict[tuple[str, str], list[Crossing]] = {}
    for k, place in zip(meets, surface.nearest(middles)[0]):
        names = pairs[pair[k]]
        at = [
            float(np.interp(index + fraction, np.arange(len(drawn[name].parameters)), drawn[name].parameters))
            for name, index, fraction in zip(names, (i[k], j[k]), (s[k], t[k]))
        ]
        found.setdefault(names, []).append(Crossing(names, (at[0], at[1]), place))
    for crossings in found.values():
        crossings.sort(key=lambda each: each.parameters)
    return found
