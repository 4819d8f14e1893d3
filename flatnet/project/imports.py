"""The section `import` of a project file: whole networks from drawings -> nodes and curves in mm."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np
import yaml

from flatnet.failure import Finding
from flatnet.project.curve_specs import Floats, NodeSpec
from flatnet.project.drawings import DrawingError, FileCurve, read_drawing
from flatnet.project.drawings.joining import SMALLEST_SNAP, JoinedCurve, join_curves
from flatnet.project.problems import Mark
from flatnet.project.section import Section
from flatnet.project.values import (
    LARGEST_LENGTH,
    TO_Z_UP,
    WrongValueError,
    direction,
    flag,
    frozen,
    length_in,
    name,
    one_of,
    point_in,
    scalar,
    unit,
)
from flatnet.project.yaml_nodes import is_null, mark_of

_IMPORT_KEYS = (
    "file", "units", "up", "place", "prefix", "snap", "join", "trim", "kind", "on", "cast", "normals", "edge_length",
)  # fmt: skip
_PLACE_KEYS = ("origin", "x", "y")
#: Points of a curve that is cast are no farther apart, in edge lengths; between them it lies on the nearest points.
CAST_POINTS = 0.5
#: The cosine of the angle between `x` and `y` of a place, at most.
_ORTHOGONAL = 1e-6


@dataclass(frozen=True, eq=False)
class ImportedCurve:
    """A curve of a drawing, and what its import says of all its curves.

    Attributes
    ----------
    kind : `polyline` or `spline`.
    cast : direction in which it is cast onto the surface, unit; None where it is not.
    section : of the import; `on`, `normals` and `edge_length` of its curves stand there.
    """

    curve: JoinedCurve
    kind: Literal["polyline", "spline"]
    cast: Floats | None
    section: Section


@dataclass(frozen=True, eq=False)
class Imports:
    """What all imports of a project bring in: nodes and curves by name, and what was done to them."""

    nodes: Mapping[str, NodeSpec]
    curves: Mapping[str, ImportedCurve]
    findings: tuple[Finding, ...]


def read_imports(file: Path, top: Section, mm_per_unit: float, edge_length: float, has_surface: bool) -> Imports:
    """All drawings that a project imports, each joined to a network of its own."""
    nodes: dict[str, NodeSpec] = {}
    curves: dict[str, ImportedCurve] = {}
    findings: list[Finding] = []
    for label, mark, node in _entries(top):
        section = Section(node, label, mark, _IMPORT_KEYS, top.problems)
        drawn = _file_curves(file, section, mm_per_unit)
        if not drawn:
            continue
        none: Floats | None = None
        cast_along = section.get("cast", direction, none)
        if cast_along is not None:
            if not has_surface:
                message = "cast, but the file has no surface; add `surface: ...` at its top"
                section.problem(section.keys["cast"], message)
            drawn = [_divided(curve, CAST_POINTS * edge_length) for curve in drawn]
        extent = float(np.ptp(np.concatenate([curve.points for curve in drawn]), axis=0).max())
        joined = join_curves(
            drawn,
            snap=section.get("snap", length_in(mm_per_unit, negative=False), SMALLEST_SNAP * extent),
            join_crossings=section.get("join", one_of("crossings"), "") == "crossings",
            trim=section.get("trim", flag, False),
            prefix=section.get("prefix", name, ""),
        )
        findings += joined.findings
        kind = section.get("kind", one_of("polyline", "spline"), "")
        for key, curve in joined.curves.items():
            own = kind or ("spline" if curve.smooth else "polyline")
            if key in curves:
                section.problem(mark, f"another import has a curve {key!r} too; give one a prefix")
                break
            curves[key] = ImportedCurve(curve, cast(Literal["polyline", "spline"], own), cast_along, section)
        for key, place in joined.nodes.items():
            nodes[key] = NodeSpec(key, frozen(place), cast_along is not None, mark, cast=cast_along)
        if not joined.curves:
            section.problem(mark, "nothing is left of its curves: all end by themselves, and trim leaves them out")
    return Imports(nodes, curves, tuple(findings))


def _entries(top: Section) -> list[tuple[str, Mark, yaml.Node]]:
    """The imports with labels: the one mapping under `import`, or each of a list."""
    node = top.values.get("import")
    if node is None or is_null(node):
        return []
    if isinstance(node, yaml.SequenceNode):
        return [(label, mark_of(item), item) for label, item in top.items("import", node, "")]
    return [("import", mark_of(top.keys["import"]), node)]


def _file_curves(file: Path, section: Section, mm_per_unit: float) -> list[FileCurve]:
    """The curves of an import's files, in mm, where the project puts them."""
    if "file" not in section.values:
        if section.is_mapping:
            section.problem(section.mark, "'file' is missing; the drawing, or a list of them")
        return []
    node = section.values["file"]
    items = section.items("file", node, "") if isinstance(node, yaml.SequenceNode) else [("file", node)]
    drawn = [curve for label, item in items for curve in read_drawing_at(file, section, label, item)]
    scale = section.get("units", unit, mm_per_unit)
    turn, origin = _frame(section, mm_per_unit)
    curves = [FileCurve(c.name, scale * c.points @ turn.T + origin, c.smooth) for c in drawn]
    largest = max((float(np.abs(curve.points).max()) for curve in curves), default=0.0)
    if largest > LARGEST_LENGTH:
        section.problem(section.mark, f"a point of it is {largest:g} mm away; is the unit right?")
        return []
    return curves


def read_drawing_at(file: Path, section: Section, label: str, node: yaml.Node) -> list[FileCurve]:
    """The curves of the drawing whose path, relative to the project file, stands at a node."""

    def read(node: yaml.Node) -> list[FileCurve]:
        path = file.parent / scalar("the path of a drawing")(node)
        if not os.path.isfile(path):  # unlike Path.is_file it takes any text without raising
            message = f"there is no file {str(path)!r}; a path is relative to the project file"
            raise WrongValueError(node, message)
        try:
            return read_drawing(path)
        except DrawingError as error:
            raise WrongValueError(node, f"{path}: {error}") from None

    return section.read(label, node, read, [])


def _divided(curve: FileCurve, longest: float) -> FileCurve:
    """The curve with points no farther apart than `longest`, mm."""
    steps = np.linalg.norm(np.diff(curve.points, axis=0), axis=1)
    counts = np.maximum(np.ceil(np.nan_to_num(steps / longest)).astype(int), 1)
    index = np.repeat(np.arange(len(counts)), counts)
    fraction = np.concatenate([np.arange(count) / count for count in counts])[:, None]
    points = curve.points[index] + fraction * (curve.points[index + 1] - curve.points[index])
    return FileCurve(curve.name, np.vstack([points, curve.points[-1:]]), curve.smooth)


def _frame(section: Section, mm_per_unit: float) -> tuple[Floats, Floats]:
    """Turn (3, 3) and origin (mm) that take the points of a file to their place in space."""
    turn, origin = TO_Z_UP[section.get("up", one_of(*TO_Z_UP), "z")], np.zeros(3)
    if "place" not in section.values:
        return turn, origin
    if "up" in section.values:
        section.problem(section.keys["up"], "'up' and 'place' exclude each other; keep one")
    place = section.section("place", _PLACE_KEYS)
    x, y = (place.require(key, direction, axis) for key, axis in zip(("x", "y"), np.eye(3)))
    if abs(x @ y) > _ORTHOGONAL:
        place.problem(place.mark, f"x and y are to be at a right angle, got {np.degrees(np.arccos(x @ y)):.4g} degrees")
    return np.stack([x, y, np.cross(x, y)], axis=1), place.get("origin", point_in(mm_per_unit), origin)
