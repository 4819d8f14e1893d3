"""What a curve follows on the surface: the keys `line`, `section` and `along` of a curve."""

from __future__ import annotations

from typing import Literal, cast

import numpy as np
import yaml

from flatnet.project.curve_specs import Floats, MeshEdges, NamedLine, PlaneSection
from flatnet.project.section import Section
from flatnet.project.values import WrongValueError, between, direction, number, point_in, scalar, wrong
from flatnet.project.yaml_nodes import describe

PATH_KEYS = ("line", "section", "along")
_SECTION_KEYS = ("point", "normal")
#: Degrees between two faces of a mesh beyond which their edge is a feature, where `along: feature` says no angle.
_FEATURE_ANGLE = 30.0


def read_path(
    section: Section, mm_per_unit: float, has_surface: bool
) -> PlaneSection | MeshEdges | NamedLine | None:
    """What a curve follows; None where it is drawn from point to point."""
    said = [key for key in PATH_KEYS if key in section.values]
    if not said:
        return None
    key = section.keys[said[0]]
    for other in [*said[1:], *(each for each in ("kind", "on") if each in section.values)]:
        section.problem(section.keys[other], f"{said[0]!r} and {other!r} exclude each other; keep one")
    if not has_surface:
        section.problem(key, f"{said[0]}: lies on a surface, but the file has none; add `surface: ...` at its top")
    if said[0] == "line":
        return NamedLine(section.get("line", scalar("the name of a line of the form"), ""))
    if said[0] == "along":
        what, angle = section.get("along", _along, ("boundary", _FEATURE_ANGLE))
        return MeshEdges(cast(Literal["boundary", "feature"], what), float(np.radians(angle)))
    plane = section.section("section", _SECTION_KEYS)
    nothing: Floats | None = None
    point = plane.get("point", point_in(mm_per_unit), nothing)
    normal = plane.get("normal", direction, nothing)
    has_ends = "from" in section.values and "to" in section.values
    if not has_ends and not {"point", "normal"} <= set(plane.values):
        plane.problem(plane.mark, "a closed section needs 'point' and 'normal'")
    elif not plane.values and plane.is_mapping:
        plane.problem(plane.mark, "between two nodes a section needs 'point' or 'normal', or both")
    return PlaneSection(point, normal)


def _along(node: yaml.Node) -> tuple[str, float]:
    """`boundary`, `feature`, or {feature: degrees}."""
    expected = "'boundary', 'feature' or {feature: <degrees>}"
    if isinstance(node, yaml.MappingNode):
        entries = [(key.value, value) for key, value in node.value if isinstance(key, yaml.ScalarNode)]
        if [key for key, _ in entries] != ["feature"]:
            raise wrong(node, expected)
        return "feature", between(number, 1.0, 179.0)(entries[0][1])
    word = scalar(expected)(node)
    if word not in ("boundary", "feature"):
        raise WrongValueError(node, f"expected {expected}, got {describe(node)}")
    return word, _FEATURE_ANGLE
