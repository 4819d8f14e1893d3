"""Put the nodes in their places: at a point, on a ray, at a landmark, along a line or a drawn curve."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import spoken
from flatnet.forms.casting import first_hits
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import arclengths
from flatnet.network.curves import DrawnCurve
from flatnet.network.network import GeometryError
from flatnet.project.curve_specs import AtLandmark, CurveSpec, NodeSpec, OnCurve, OnLine, OnRay
from flatnet.project.problems import Problem
from flatnet.project.values import nearest

Floats = NDArray[np.float64]
T = TypeVar("T")

#: A fraction of a curve's length is at one of its points where it is nearer than this, in edge lengths.
SAME_PLACE = 1e-6


def place_nodes(
    nodes: Mapping[str, NodeSpec], curves: Mapping[str, CurveSpec], surface: ReferenceSurface | None
) -> tuple[dict[str, Floats], list[Problem]]:
    """The positions of the nodes that lie at no curve, mm, and what is wrong with others.

    They are on the surface where the node or a curve through it says so.
    """
    projected = {name for name, node in nodes.items() if node.on_surface}
    for curve in curves.values():
        if curve.on_surface:
            projected.update(curve.own_nodes)
    places: dict[str, Floats] = {}
    problems = []
    for name, node in nodes.items():
        if not isinstance(node.place, OnCurve):
            try:
                places[name] = _position(node, surface)
            except GeometryError as found:
                problems.append(found.problem)
    on_surface = [name for name in places if name in projected]
    if on_surface:
        assert surface is not None, "a project whose nodes lie on a surface has one"
        feet, _ = surface.nearest(np.array([places[name] for name in on_surface]))
        places |= zip(on_surface, np.array(feet), strict=True)
    return places, problems


def _position(node: NodeSpec, surface: ReferenceSurface | None) -> Floats:
    """Where a node is said to be, (3,) mm; not yet taken to the surface."""
    if node.place is None:
        return np.array(node.position, dtype=float)
    assert surface is not None, "a project whose nodes lie on a surface has one"
    if isinstance(node.place, OnRay):
        return _first_hit(node, node.place, surface)
    if isinstance(node.place, AtLandmark):
        return np.array(_named(node, f"node '{node.name}'", "landmark", node.place.landmark, surface.landmarks))
    assert isinstance(node.place, OnLine), "a node on a curve is placed when that is drawn"
    return _on_line(node, f"node '{node.name}'", node.place, surface)


def place_guides(curve: CurveSpec, surface: ReferenceSurface | None) -> dict[OnLine, Floats]:
    """The positions, (3,) mm, of a curve's points on lines of the form, which guide it and are no nodes.

    Raises
    ------
    GeometryError
        The surface has no such line.
    """
    guides = {}
    for point in curve.points:
        if isinstance(point, OnLine):
            assert surface is not None, "a project whose curves lie on a surface has one"
            guides[point] = _on_line(curve, f"curve '{curve.name}'", point, surface)
    return guides


def _on_line(spec: NodeSpec | CurveSpec, who: str, place: OnLine, surface: ReferenceSurface) -> Floats:
    line = _named(spec, who, "line", place.line, surface.lines).points
    along = arclengths(line)
    return np.array([np.interp(place.t * along[-1], along, column) for column in line.T])


def _named(spec: NodeSpec | CurveSpec, who: str, what: str, name: str, known: Mapping[str, T]) -> T:
    if name not in known:
        hint = nearest(name, known, f"{what}s").replace("the file has", "the surface has")
        raise GeometryError(spec.mark, f"{who}: there is no {what} '{name}'; {hint}")
    return known[name]


def _first_hit(node: NodeSpec, ray: OnRay, surface: ReferenceSurface) -> Floats:
    """Where a node's ray first meets the surface."""
    [landed] = first_hits(surface, ray.origin[None], ray.direction)
    if np.isnan(landed).any():
        raise GeometryError(
            node.mark,
            f"node '{node.name}': its ray from {spoken(ray.origin)} misses the surface; turn it round, or aim nearer "
            f"to the nearest place on it, {spoken(surface.nearest(ray.origin[None])[0][0])}",
        )
    return landed


def cut_at_fractions(curve: CurveSpec, drawn: DrawnCurve) -> tuple[DrawnCurve, dict[str, Floats]]:
    """The curve with the nodes at fractions of its length, and their places."""
    arcs = drawn.arclengths
    own = [index for index, _ in drawn.nodes]
    ends = own + [len(arcs) - 1] if drawn.control.closed and own else own or [0, len(arcs) - 1]
    places = {}
    cuts = []
    for each in curve.fractions:
        # Counted in the order of the file; a closed curve starts at its first node there, too.
        first, last = arcs[ends[each.stretch]], arcs[ends[each.stretch + 1]]
        along = first + each.t * (last - first)
        near = int(np.abs(arcs - along).argmin())
        if abs(arcs[near] - along) <= SAME_PLACE * curve.edge_length:  # at a point of a polyline: not an edge beside it
            parameter, places[each.node] = float(drawn.parameters[near]), drawn.points[near].copy()
        else:
            parameter = float(np.interp(along, arcs, drawn.parameters))
            places[each.node] = drawn.at(np.array([parameter]))[0]
        cuts.append((parameter, each.node))
    for parameter, node in cuts:
        drawn = drawn.cut(parameter, node, places[node])
    return drawn, places
