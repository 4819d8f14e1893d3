"""The section `marks` of a patch: lines and points that are drawn on its piece and not cut."""

from __future__ import annotations

import numpy as np
import yaml

from flatnet.project.patch_specs import LINE_MARKS, POINT_MARKS, MarkSpec
from flatnet.project.section import Section
from flatnet.project.values import flag, frozen, length_in, one_of, point_in
from flatnet.project.yaml_nodes import mark_of

MARK_KEYS = ("at", "points", "kind", "spline", "closed", "diameter")


def read_marks(patch: Section, mm_per_unit: float) -> tuple[MarkSpec, ...]:
    """The marks of a patch, in the order of the file."""
    every = patch.section("marks", None)
    found = [_mark(name, Section(node, f"{every.title}: {name}", mark, MARK_KEYS, every.problems), mm_per_unit)
             for name, mark, node in every.named()]
    return tuple(mark for mark in found if mark is not None)


def _mark(name: str, section: Section, mm_per_unit: float) -> MarkSpec | None:
    if not section.is_mapping:
        return None
    if ("at" in section.values) == ("points" in section.values):
        section.problem(section.mark, "needs either 'at: [x, y, z]' for a point or 'points: [...]' for a line")
        return None
    is_point = "at" in section.values
    point = point_in(mm_per_unit)
    nowhere = frozen(np.zeros(3))
    if is_point:
        points = [section.get("at", point, nowhere)]
    else:
        node = section.values["points"]
        points = [section.read(label, item, point, nowhere) for label, item in section.items("points", node, "a list")]
        if isinstance(node, yaml.SequenceNode) and (short := 2 - len(points)) > 0:
            section.problem(node, f"points: a line needs at least 2, {short} more")
        for label, a, b in zip(range(2, len(points) + 1), points, points[1:]):
            if np.array_equal(a, b):
                section.problem(mark_of(node), f"points: point {label} repeats the one before it; leave it out")
    for key in ("spline", "closed") if is_point else ("diameter",):
        if key in section.values:
            section.problem(section.keys[key], f"'{key}' is for {'lines' if is_point else 'points'} only")
    kinds = POINT_MARKS if is_point else LINE_MARKS
    return MarkSpec(
        name=name,
        kind=section.get("kind", one_of(*kinds), kinds[0]),
        points=tuple(points),
        spline=section.get("spline", flag, False),
        closed=section.get("closed", flag, False),
        diameter=section.get("diameter", length_in(mm_per_unit, positive=True), None),
        mark=section.mark,
    )
