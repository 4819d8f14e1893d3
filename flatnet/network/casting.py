"""Cast the nodes and curves of drawings onto the surface, before anything is sampled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flatnet.failure import spoken
from flatnet.forms.casting import first_hits
from flatnet.forms.surface import ReferenceSurface
from flatnet.project.curve_specs import CurveSpec, Floats, NodeSpec
from flatnet.project.model import Project
from flatnet.project.problems import Problem, ProjectError
from flatnet.project.values import frozen


def cast_drawings(project: Project, surface: ReferenceSurface | None) -> Project:
    """The project with the points of its cast nodes and curves where their rays first meet the surface.

    Raises
    ------
    ProjectError
        A ray misses the surface.
    """
    if surface is None or all(curve.cast is None for curve in project.curves.values()):
        return project
    problems: list[Problem] = []
    nodes = {name: _cast_node(node, surface, problems) for name, node in project.nodes.items()}
    curves = {name: _cast_curve(curve, surface, problems) for name, curve in project.curves.items()}
    if problems:
        raise ProjectError(project.file, problems)
    return replace(project, nodes=nodes, curves=curves)


def _cast_node(node: NodeSpec, surface: ReferenceSurface, problems: list[Problem]) -> NodeSpec:
    if node.cast is None:
        return node
    [landed] = first_hits(surface, node.position[None], node.cast)
    if np.isnan(landed).any():
        problems.append(_miss(f"node '{node.name}'", node.position, node))
    return replace(node, position=frozen(landed))


def _cast_curve(curve: CurveSpec, surface: ReferenceSurface, problems: list[Problem]) -> CurveSpec:
    points = [i for i, point in enumerate(curve.points) if isinstance(point, np.ndarray)]
    if curve.cast is None or not points:
        return curve
    places = np.array([curve.points[i] for i in points])
    landed = first_hits(surface, places, curve.cast)
    missed = np.isnan(landed).any(axis=1)
    if missed.any():
        what = f"curve '{curve.name}': {missed.sum()} of its {len(places)} points, the first"
        problems.append(_miss(what, places[missed.argmax()], curve))
    at: Mapping[int, Floats] = {i: frozen(place) for i, place in zip(points, landed)}
    return replace(curve, points=tuple(at.get(i, point) for i, point in enumerate(curve.points)))


def _miss(what: str, place: Floats, spec: NodeSpec | CurveSpec) -> Problem:
    misses = "cast along its direction misses the surface; move or turn the drawing by 'place'"
    return Problem(spec.mark, f"{what} at {spoken(place)}, {misses}")
