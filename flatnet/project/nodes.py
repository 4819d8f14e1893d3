"""The section `nodes` of a project file -> node specs in mm; the curves that nodes lie on, cut there."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from typing import Any

import numpy as np
import yaml

from flatnet.project.curve_specs import AtLandmark, CurveSpec, Fraction, NodeSpec, OnCurve, OnLine, OnRay
from flatnet.project.problems import Problem
from flatnet.project.section import Section
from flatnet.project.values import (
    NAME,
    WrongValueError,
    between,
    direction,
    frozen,
    nearest,
    number,
    one_of,
    point_in,
    scalar,
    wrong,
)
from flatnet.project.yaml_nodes import describe, mark_of

_NODE_KEYS = ("at", "ray", "landmark", "on")
_RAY_KEYS = ("from", "direction")
_AT_KEYS = ("curve", "line", "t")
_GUIDE_KEYS = ("line", "t")
_STRETCH = re.compile(rf"({NAME})(?::({NAME})\.\.({NAME}))?")
#: Stands for a point that could not be read, or that only the geometry tells; it is nowhere, so that no other
#: check complains about it.
NOWHERE = frozen(np.full(3, np.nan))


def read_nodes(
    sections: Section, mm_per_unit: float, has_surface: bool, imported: Mapping[str, NodeSpec]
) -> dict[str, NodeSpec]:
    """The nodes of the imports and those of the section, in file order; two at one place are a problem."""
    point = point_in(mm_per_unit)
    nodes = dict(imported)
    first: dict[tuple[Any, ...], str] = {(False, *node.position.tolist()): key for key, node in imported.items()}
    for key, mark, node in sections.named():
        if key in imported:
            sections.problem(mark, f"{key!r} is a node of an import too; give that a prefix, or this another name")
            continue
        if not isinstance(node, yaml.MappingNode):
            nodes[key] = NodeSpec(key, sections.read(repr(key), node, point, NOWHERE), False, mark)
        else:
            section = Section(node, f"node {key!r}", mark, _NODE_KEYS, sections.problems)
            nodes[key] = _node(key, section, mm_per_unit, has_surface)
        position = nodes[key].position
        other = first.setdefault((nodes[key].on_surface, *position.tolist()), key)
        if other != key and np.isfinite(position).all():
            message = f"{key!r} is at the same place as {other!r}; keep one, and their curves meet"
            sections.problem(mark, message)
    return nodes


def on_surface(section: Section, has_surface: bool) -> bool:
    """Whether a node or curve says `on: surface`."""
    said = section.get("on", one_of("surface"), "") == "surface"
    if said and not has_surface:
        section.problem(
            section.values["on"],
            "on: surface, but the file has no surface; add `surface: ...` at its top, or leave `on` out",
        )
    return said


def _node(key: str, section: Section, mm_per_unit: float, has_surface: bool) -> NodeSpec:
    """A node that is said by keys: `at`, `ray` or `landmark`."""
    place: OnRay | AtLandmark | OnLine | OnCurve | None = None
    position = NOWHERE
    ways = [way for way in ("at", "ray", "landmark") if way in section.values]
    if len(ways) != 1 and section.is_mapping:
        said = "is missing" if not ways else f"and {ways[1]!r} exclude each other"
        section.problem(section.mark, f"'at' {said}" if not ways else f"{ways[0]!r} {said}; keep one")
    elif ways == ["ray"]:
        place = _ray(section, mm_per_unit)
    elif ways == ["landmark"]:
        place = AtLandmark(section.get("landmark", scalar("the name of a landmark"), ""))
    elif isinstance(section.values["at"], yaml.MappingNode):
        place = _at_fraction(section)
    else:
        position = section.get("at", point_in(mm_per_unit), NOWHERE)
    if place is not None and "on" in section.values:
        section.problem(section.keys["on"], f"'on' goes with a point [x, y, z], not with {ways[0]!r} as it stands here")
    if isinstance(place, OnRay | AtLandmark | OnLine) and not has_surface:
        message = "lies on a surface, but the file has none; add `surface: ...` at its top"
        section.problem(section.mark, message)
    projected = on_surface(section, has_surface) or isinstance(place, OnRay | AtLandmark | OnLine)
    return NodeSpec(key, position, projected, section.mark, place)


def _ray(section: Section, mm_per_unit: float) -> OnRay:
    ray = section.section("ray", _RAY_KEYS)
    return OnRay(
        ray.require("from", point_in(mm_per_unit), NOWHERE), ray.require("direction", direction, NOWHERE)
    )


def _at_fraction(section: Section) -> OnLine | OnCurve | None:
    at = section.section("at", _AT_KEYS)
    ways = [way for way in ("curve", "line") if way in at.values]
    if len(ways) != 1:
        at.problem(at.mark, "give 'curve' and 't', or 'line' and 't' (or a point [x, y, z])")
        return None
    if ways == ["line"]:
        return _on_line(at)
    t = at.require("t", _inner_fraction, np.nan, "the fraction of its length, 0 to 1")
    nothing: tuple[str, tuple[str, str] | None] = ("", None)
    curve, stretch = at.get("curve", _stretch, nothing)
    return OnCurve(curve, stretch, t)


def read_on_line(section: Section, label: str, node: yaml.Node, has_surface: bool) -> OnLine:
    """A point among a curve's, {line: ..., t: ...}, that only guides it."""
    place = Section(node, f"{section.title}: {label}", mark_of(node), _GUIDE_KEYS, section.problems)
    if not has_surface:
        place.problem(node, "lies on a line of a form, but the file has no surface; add `surface: ...` at its top")
    return _on_line(place)


def _on_line(section: Section) -> OnLine:
    line = section.require("line", scalar("the name of a line of the form"), "")
    return OnLine(line, section.require("t", between(number, 0.0, 1.0), np.nan, "the fraction of its length, 0 to 1"))


def _inner_fraction(node: yaml.Node) -> float:
    value = number(node)
    if not 0.0 < value < 1.0:
        raise WrongValueError(
            node, f"must be greater than 0 and less than 1, got {describe(node)}; at its ends a curve has nodes"
        )
    return value


def _stretch(node: yaml.Node) -> tuple[str, tuple[str, str] | None]:
    expected = "a curve: side, or a stretch of one, side:a..b"
    match = _STRETCH.fullmatch(scalar(expected)(node))
    if match is None:
        raise wrong(node, expected)
    curve, first, last = match.groups()
    return curve, (first, last) if first else None


def cut_at_fractions(
    nodes: Mapping[str, NodeSpec], curves: Mapping[str, CurveSpec]
) -> tuple[dict[str, CurveSpec], list[Problem]]:
    """The curves with the nodes that lie at a fraction of their length, and what is wrong with those nodes."""
    problems: list[Problem] = []
    found: dict[str, list[Fraction]] = {}
    for node in nodes.values():
        if isinstance(node.place, OnCurve) and node.place.curve:
            if node.place.curve not in curves:
                message = f"there is no curve {node.place.curve!r}; {nearest(node.place.curve, curves, 'curves')}"
                problems.append(Problem(node.mark, f"node {node.name!r}: at: {message}"))
                continue
            curve = curves[node.place.curve]
            if node.name in curve.own_nodes:
                message = f"is drawn through node {node.name!r}, which lies on it; leave the node out here"
                problems.append(Problem(curve.mark, f"curve {curve.name!r}: {message}"))
                continue
            index, message = _stretch_index(curve, node.place.stretch)
            if message:
                problems.append(Problem(node.mark, f"node {node.name!r}: at: {message}"))
            else:
                found.setdefault(curve.name, []).append(Fraction(index, node.place.t, node.name))
    cut = dict(curves)
    for name, fractions in found.items():
        fractions.sort(key=lambda each: (each.stretch, each.t))
        for one, other in pairwise(fractions):
            if (one.stretch, one.t) == (other.stretch, other.t):
                message = f"{other.node!r} is at the same place as {one.node!r}; keep one"
                problems.append(Problem(nodes[other.node].mark, message))
        cut[name] = replace(curves[name], fractions=tuple(fractions))
    try:
        drawing_order(nodes, cut)
    except CycleError as error:
        names = error.args[1][::-1]
        if len(names) == 3:  # a curve drawn through a node that lies on it, said above
            return cut, problems
        written = " on ".join(f"{kind} {name!r}" for kind, name in names)
        mark = min(nodes[name].mark for kind, name in names if kind == "node")
        problems.append(Problem(mark, f"none of these can be drawn first, each depends on the next: {written}"))
    return cut, problems


def _stretch_index(curve: CurveSpec, stretch: tuple[str, str] | None) -> tuple[int, str]:
    """Which of the stretches between a curve's own nodes is meant, and a message if none is."""
    own = curve.own_nodes
    pairs = list(pairwise(own + own[:1] if curve.closed and curve.start is None else own))
    if stretch is None and len(pairs) < 2:
        return 0, ""
    if stretch in pairs:
        return pairs.index(stretch), ""
    written = ", ".join(f"{curve.name}:{a}..{b}" for a, b in pairs)
    if stretch is None:
        return 0, f"curve {curve.name!r} passes nodes on its way; say between which: {written}"
    return 0, f"{curve.name!r} has no stretch {stretch[0]}..{stretch[1]}" + (f"; it has {written}" if written else "")


def drawing_order(
    nodes: Mapping[str, NodeSpec], curves: Mapping[str, CurveSpec]
) -> list[tuple[str, str]]:
    """Every ("node", name) and ("curve", name), each after those that it depends on.

    Raises
    ------
    CycleError
        A node lies on a curve that is drawn through it, perhaps over other curves.
    """
    sorter: TopologicalSorter[tuple[str, str]] = TopologicalSorter()
    for node in nodes.values():
        before = [("curve", node.place.curve)] if isinstance(node.place, OnCurve) else []
        sorter.add(("node", node.name), *(each for each in before if each[1] in curves))
    for curve in curves.values():
        sorter.add(("curve", curve.name), *(("node", name) for name in curve.own_nodes if name in nodes))
    return list(sorter.static_order())
