"""The section `curves` of a project file -> curve specs, in mm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np
import yaml

from flatnet.project.curve_specs import CurveSpec, Floats, NodeSpec, NormalList, NormalSpec, OnLine
from flatnet.project.drawings import READERS
from flatnet.project.imports import ImportedCurve, read_drawing_at
from flatnet.project.nodes import NOWHERE, on_surface, read_on_line
from flatnet.project.paths import PATH_KEYS, read_path
from flatnet.project.section import Section
from flatnet.project.sewing import SEAM_KEYS, read_seam
from flatnet.project.values import (
    NotFiniteError,
    WrongValueError,
    direction,
    flag,
    frozen,
    is_number,
    length_in,
    nearest,
    one_of,
    point_in,
    scalar,
    wrong,
)
from flatnet.project.yaml_nodes import mark_of

_DRAWN_KEYS = ("kind", "on", "slit", "edge_length", "normals", *SEAM_KEYS)
_CURVE_KEYS = (
    "from",
    "to",
    "points",
    "closed",
    "kind",
    "on",
    *PATH_KEYS,
    "slit",
    "edge_length",
    "normals",
    *SEAM_KEYS,
)
_KINDS = ("polyline", "spline", "geodesic", "fair")
#: Kinds that are drawn on the surface only.
_SURFACE_KINDS = ("geodesic", "fair")
#: Points nearer than this, in edge lengths, are the same place.
_SAME_PLACE = 1e-6
#: A curve that would be divided into more edges than this has its edge_length in a wrong unit.
_MOST_EDGES = 20_000


@dataclass(frozen=True, eq=False)
class CurveSetting:
    """What the rest of the file means for its curves: its unit, surface, edge length (mm) and nodes."""

    file: Path
    mm_per_unit: float
    has_surface: bool
    edge_length: float
    nodes: Mapping[str, NodeSpec]


@dataclass(frozen=True, eq=False)
class _Place:
    """One of a curve's from, points, to; `projected` onto the surface, or known at all, later on."""

    label: str
    node: str | None
    position: Floats
    projected: bool
    later: bool
    yaml_node: yaml.Node
    on_line: OnLine | None = None


def read_curves(
    sections: Section, setting: CurveSetting, imported: Mapping[str, ImportedCurve]
) -> dict[str, CurveSpec]:
    """The curves of the imports, as the section changes them where it names them, and the section's own."""
    given = {key: (mark, node) for key, mark, node in sections.named()}
    curves = {}
    for key, drawn in imported.items():
        mark, node = given.get(key, (drawn.section.mark, yaml.MappingNode("", [])))
        section = Section(node, f"curve {key!r}", mark, _DRAWN_KEYS, sections.problems)
        for word in ("on", "normals", "edge_length"):  # said of all curves of the import
            if word in drawn.section.values:
                section.values.setdefault(word, drawn.section.values[word])
        curves[key] = _curve(key, section, setting, drawn)
    for key, (mark, node) in given.items():
        if key not in imported:
            section = Section(node, f"curve {key!r}", mark, _CURVE_KEYS, sections.problems)
            curves[key] = _curve(key, section, setting)
    return curves


def _curve(key: str, section: Section, setting: CurveSetting, drawn: ImportedCurve | None = None) -> CurveSpec:
    path = None if drawn else read_path(section, setting.mm_per_unit, setting.has_surface)
    usual: str = drawn.kind if drawn else "polyline"
    kind = section.get("kind", one_of(*_KINDS), usual)
    if kind in _SURFACE_KINDS and not setting.has_surface:
        message = f"kind: {kind} is drawn on a surface, but the file has none; add `surface: ...` at its top"
        section.problem(section.values["kind"], message)
    cast_along = drawn.cast if drawn else None
    projected = on_surface(section, setting.has_surface) or kind in _SURFACE_KINDS or path is not None
    projected |= cast_along is not None
    edge_length = section.get(
        "edge_length", length_in(setting.mm_per_unit, positive=True), setting.edge_length
    )
    places = _drawn_places(drawn, section, setting, projected) if drawn else _places(section, setting, projected)
    closed = drawn.curve.closed if drawn else _is_closed(section, places)
    slit = section.get("slit", flag, False)
    if slit and closed and path is None:
        section.problem(section.values["slit"], "a closed curve can't be a slit: it has no tip")
    positions = np.array([place.position for place in places]).reshape(-1, 3)
    joined = closed and not (places and places[0].label == "from")  # the last point to the first
    polygon = np.concatenate([positions, positions[:1]]) if joined else positions
    needed = 0 if path else 3 if closed else 2
    _check_places(section, places, polygon, closed, needed, edge_length)
    readable = (path is not None or len(places) > 0) and all(place.label != "points" for place in places)
    ends = ("from" in section.values) + ("to" in section.values)
    count = _Count(len(places), len(polygon) - 1, joined) if readable and ends != 1 else None
    normals = _normals(section, setting.has_surface, count)
    return CurveSpec(
        name=key,
        start=places[0].node if places and places[0].label == "from" else None,
        end=places[-1].node if places and places[-1].label == "to" else None,
        points=tuple(
            place.on_line or (place.position if place.node is None else place.node)
            for place in places
            if place.label not in ("from", "to")
        ),
        closed=closed,
        kind=cast(Literal["polyline", "spline", "geodesic", "fair"], kind),
        on_surface=projected,
        slit=slit,
        edge_length=edge_length,
        normals=normals,
        mark=section.mark,
        seam=read_seam(section, setting.mm_per_unit),
        cast=cast_along,
        path=path,
    )


def _drawn_places(drawn: ImportedCurve, section: Section, setting: CurveSetting, projected: bool) -> list[_Place]:
    """The nodes and points of an imported curve; problems with them stand where the file is named."""
    node = drawn.section.values["file"]
    last = len(drawn.curve.places) - 1
    places = []
    for i, place in enumerate(drawn.curve.places):
        if isinstance(place, str):
            spec = setting.nodes[place]
            label = "from" if i == 0 else "to" if i == last else f"point {i}"
            places.append(_Place(label, place, spec.position, projected or spec.on_surface, False, node))
        else:
            places.append(_Place(f"point {i}", None, frozen(np.array(place)), projected, False, node))
    return places


def _places(section: Section, setting: CurveSetting, projected: bool) -> list[_Place]:
    """from, points and to of a curve, as far as they are there."""
    anywhere = point_in(setting.mm_per_unit)

    def point(node: yaml.Node) -> Floats:
        try:
            return anywhere(node)
        except NotFiniteError as error:
            raise WrongValueError(error.node, f"degenerate_curve: {error.message}") from None

    def place(label: str, node: yaml.Node) -> _Place:
        if isinstance(node, yaml.SequenceNode) and label not in ("from", "to"):
            return _Place(label, None, section.read(label, node, point, NOWHERE), projected, False, node)
        if isinstance(node, yaml.MappingNode) and label not in ("from", "to"):
            on_line = read_on_line(section, label, node, setting.has_surface)
            return _Place(label, None, NOWHERE, projected, True, node, on_line)
        text = section.read(label, node, scalar("the name of a node"), "")
        spec = setting.nodes.get(text)
        if text and spec is None:
            hint = "a point is a list [x, y, z]" if is_number(node) else nearest(text, setting.nodes, "nodes")
            section.problem(node, f"{label}: there is no node {text!r}; {hint}")
        if spec is None:
            return _Place(label, text, NOWHERE, projected, False, node)
        return _Place(label, text, spec.position, projected or spec.on_surface, spec.place is not None, node)

    places = [place("from", section.values["from"])] if "from" in section.values else []
    if "points" in section.values:
        node = section.values["points"]
        if isinstance(node, yaml.ScalarNode) and Path(node.value).suffix.lower() in READERS:
            places += _file_points(section, setting, projected, node)
        else:
            items = section.items("points", node, "a list of points and nodes, or the path of a drawing")
            places += [place(label.replace("points, item", "point"), item) for label, item in items]
            if not isinstance(node, yaml.SequenceNode):
                places.append(_Place("points", None, NOWHERE, projected, False, node))
    if "to" not in section.values:
        return places
    to = place("to", section.values["to"])
    if len(places) > 1 and places[-1].yaml_node is section.values["points"]:
        places = _without_ends(places, to, _SAME_PLACE * setting.edge_length)
    return [*places, to]


def _file_points(section: Section, setting: CurveSetting, projected: bool, node: yaml.Node) -> list[_Place]:
    """The points of the one curve of a drawing; a closed one's first point is not repeated."""
    curves = read_drawing_at(setting.file, section, "points", node)
    if len(curves) != 1:
        if curves:
            found = f"{node.value} has {len(curves)} curves, and one is wanted"
            section.problem(node, f"points: {found}; import: {{file: ...}} takes all")
        return [_Place("points", None, NOWHERE, projected, False, node)]
    points = setting.mm_per_unit * curves[0].points[: -1 if curves[0].closed else None]
    return [_Place(f"point {i}", None, frozen(point), projected, False, node) for i, point in enumerate(points, 1)]


def _without_ends(places: list[_Place], to: _Place, same: float) -> list[_Place]:
    """from and a drawing's points, less those that repeat from and to."""

    def repeats(point: _Place, node: _Place) -> bool:
        return float(np.linalg.norm(point.position - node.position)) <= same

    start, *points = places
    if points and repeats(points[0], start):
        points = points[1:]
    if points and repeats(points[-1], to):
        points = points[:-1]
    return [start, *points]


def _is_closed(section: Section, places: list[_Place]) -> bool:
    ends = [key for key in ("from", "to") if key in section.values]
    if len(ends) == 1:
        missing = "to" if ends == ["from"] else "from"
        section.problem(
            section.keys[ends[0]],
            f"'{ends[0]}' without '{missing}'; give both, or neither for a closed curve without a node",
        )
    closed = not ends or (len(ends) == 2 and places[0].node == places[-1].node)
    said = section.get("closed", flag, closed)
    if said and len(ends) == 2 and not closed:
        message = "closed: true, but 'from' and 'to' are two nodes; name one twice"
        section.problem(section.values["closed"], message)
    if not said and closed:
        why = "ends where it starts" if ends else "has no ends; give 'from' and 'to'"
        section.problem(section.values["closed"], f"closed: false, but the curve {why}")
    return closed


def _check_places(
    section: Section, places: list[_Place], path: Floats, closed: bool, needed: int, edge_length: float
) -> None:
    """Enough different places, none twice in a row, no node twice, not more edges than can be meant.

    `path` : the positions of `places`, and the first once more where the last is joined to it; nan where only
    the geometry tells them.
    """
    unknown = np.isnan(path).any(axis=1)
    unreadable = any(np.isnan(place.position).any() and not place.later for place in places)
    if not section.is_mapping or unreadable or np.isnan(edge_length):
        return
    later = {place.on_line or place.node for place in places if place.later}
    different = len(np.unique(path[~unknown], axis=0)) + len(later)
    if different < needed:
        what = "a closed curve" if closed else "a curve"
        message = f"degenerate_curve: {what} needs at least {needed} different places, got {different}"
        section.problem(section.mark, message)
        return
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    for i in np.flatnonzero(steps <= _SAME_PLACE * edge_length) if len(places) > 1 else ():
        _note_repeat(section, places, int(i))
    passed: set[str | None] = set()
    for place in places[:-1] if closed and len(path) == len(places) else places:
        if place.node is not None and place.node in passed:
            message = f"{place.label}: the curve passes node {place.node!r} twice; divide it there in two"
            section.problem(place.yaml_node, message)
        passed.add(place.node)
    total = float(np.nansum(steps))
    if total > _MOST_EDGES * edge_length:
        section.problem(
            section.mark,
            f"would be divided into {total / edge_length:.3g} edges of {edge_length:g} mm, more than "
            f"{_MOST_EDGES}; are 'units' and 'edge_length' right?",
        )


def _note_repeat(section: Section, places: list[_Place], i: int) -> None:
    """Place i and the next are the same, unless only one of them will be moved to the surface."""
    a, b = places[i], places[(i + 1) % len(places)]
    if a.projected != b.projected:
        return
    if a.yaml_node is b.yaml_node and not isinstance(a.yaml_node, yaml.SequenceNode):
        message = f"{a.label} and {b.label} of the drawing are at the same place for edges as long as edge_length"
        if not any(problem.message.startswith(section.title) for problem in section.problems):
            section.problem(a.yaml_node, f"degenerate_curve: {message}")
        return
    if i + 1 == len(places):
        message = f"{a.label} repeats {b.label}: the last point is joined to the first; leave it out"
        section.problem(a.yaml_node, f"degenerate_curve: {message}")
        return
    repeat, other = (a, b) if b.label == "to" and a.label != "from" else (b, a)
    message = f"{repeat.label} is at the same place as {other.label}; leave one of them out"
    section.problem(repeat.yaml_node, f"degenerate_curve: {message}")


@dataclass(frozen=True)
class _Count:
    """How many points and segments a curve has; `joined`: it is closed, without from and to."""

    points: int
    segments: int
    joined: bool

    def mismatch(self, given: int) -> str:
        """What is wrong with so many normals, and how many there should be."""
        if self.points == 0:
            return f"{given} given, but the curve has no points; give one direction for all of it"
        if self.joined:
            said = f"the closed curve has {self.segments} segments; give {self.segments}"
        else:
            said = (
                f"that fits neither the {self.points} points (from, points, to) nor the {self.segments} "
                f"segments between them; give {self.points} or {self.segments}"
            )
        return f"{given} given, but {said}, or one direction for the whole curve"


def _normals(section: Section, has_surface: bool, count: _Count | None) -> NormalSpec:
    node = section.values.get("normals")
    if node is None:
        return NormalSpec("surface" if has_surface else "none", mark=section.mark)
    mark = mark_of(node)
    if isinstance(node, yaml.ScalarNode):
        word = section.read("normals", node, _normals_word, "")
        if word == "curves":
            return NormalSpec("curves", mark=mark)
        if word and not has_surface:
            section.problem(node, "normals: surface, but the file has no surface; give a list of normals")
        return NormalSpec("surface" if has_surface else "none", mark=mark)
    if isinstance(node, yaml.MappingNode) and not {"per", "values"} & _texts(node):
        sides = Section(node, f"{section.title}: normals", mark, ("left", "right"), section.problems)
        for side in ("left", "right"):
            if side not in sides.values:
                sides.problem(mark, f"'{side}' is missing; a crease has normals on both sides")
        left, right = (
            _normal_list(section, f"normals: {side}", sides.values[side], count)
            if side in sides.values
            else None
            for side in ("left", "right")
        )
        return NormalSpec("given", left, right, mark)
    both = _normal_list(section, "normals", node, count)
    return NormalSpec("given", both, both, mark)


def _texts(node: yaml.MappingNode) -> set[str]:
    return {key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)}


def _normals_word(node: yaml.Node) -> str:
    if node.value not in ("surface", "curves"):
        raise wrong(node, "'surface', 'curves', a direction [x, y, z] or a list of directions")
    return node.value


def _normal_list(
    section: Section, label: str, node: yaml.Node, count: _Count | None
) -> NormalList | None:
    """Normals of one side: a single direction, or one per point or segment, told apart by their number."""
    per: str | None = None
    if isinstance(node, yaml.MappingNode):
        inner = Section(
            node, f"{section.title}: {label}", section.mark, ("per", "values"), section.problems
        )
        per = inner.require("per", one_of("point", "segment"), "")
        if "values" not in inner.values:
            inner.problem(node, "'values' is missing")
            return None
        node = inner.values["values"]
    elif isinstance(node, yaml.SequenceNode) and any(isinstance(x, yaml.ScalarNode) for x in node.value):
        values = section.read(label, node, direction, NOWHERE)[None]
        return NormalList("curve", frozen(values))
    items = section.items(label, node, "a list of directions [x, y, z]")
    values = frozen(
        np.array([section.read(each, item, direction, NOWHERE) for each, item in items]).reshape(-1, 3)
    )
    if not isinstance(node, yaml.SequenceNode) or per == "" or count is None:
        return None
    wanted = {"segment": count.segments, "point": count.points}
    per = per or next((each for each in wanted if wanted[each] == len(values)), None)
    if per is None:
        section.problem(node, f"{label}: {count.mismatch(len(values))}")
        return None
    if wanted[per] != len(values):
        section.problem(node, f"{label}: expected {wanted[per]} normals, one per {per}, got {len(values)}")
        return None
    return NormalList(cast(Literal["point", "segment"], per), values)
