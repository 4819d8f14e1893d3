"""How pieces are cut along a curve: the keys of a curve that say it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Literal, cast

import yaml

from flatnet.project.seam_specs import DartSpec, Ends, NotchSpec, SeamSpec
from flatnet.project.section import Section
from flatnet.project.values import Parser, between, flag, integer, length_in, one_of, wrong
from flatnet.project.yaml_nodes import is_number, mark_of

SEAM_KEYS = ("allowance", "ends", "notches", "dart")
_DART_KEYS = ("fold", "drill")
_NOTCH_KEYS = ("every", "at", "nodes", "kind", "marks", "depth")
_PART = re.compile(r"(\d+(?:\.\d*)?)\s*%", re.ASCII)


def read_seam(section: Section, mm_per_unit: float) -> SeamSpec:
    """What a curve says about its allowances and notches."""
    left, right = _allowances(section, allowance_in(mm_per_unit))
    ends = section.get("ends", _ends_in(mm_per_unit), Ends())
    return SeamSpec(
        left=left,
        right=right,
        ends=ends,
        notches=_notches(section, mm_per_unit) if "notches" in section.values else None,
        dart=_dart(section, mm_per_unit) if "dart" in section.values else None,
    )


def allowance_in(mm_per_unit: float) -> Parser[float | None]:
    """A width of an allowance -> mm."""
    return length_in(mm_per_unit, negative=False)


def _allowances(section: Section, width: Parser[float | None]) -> tuple[float | None, float | None]:
    """`allowance: 10` on both sides of the curve, or `{left: 10, right: 0}`; a side that is not named says nothing."""
    node = section.values.get("allowance")
    if not isinstance(node, yaml.MappingNode):
        both = section.get("allowance", width, None)
        return both, both
    title = f"{section.title}: allowance"
    sides = Section(node, title, mark_of(node), ("left", "right"), section.problems)
    return sides.get("left", width, None), sides.get("right", width, None)


def _ends_in(mm_per_unit: float) -> Parser[Ends]:
    words = one_of("mitre", "bevel", "mirrored", "square")
    length = length_in(mm_per_unit, positive=True)

    def parser(node: yaml.Node) -> Ends:
        if is_number(node):
            return Ends("mitre", length(node))
        return Ends(cast(Literal["mitre", "bevel", "mirrored", "square"], words(node)))

    return parser


def _notches(section: Section, mm_per_unit: float) -> NotchSpec:
    """`notches: 100` for a row of that step, or what more there is to say."""
    usual = NotchSpec()
    step = length_in(mm_per_unit, positive=True)
    node = section.values["notches"]
    if not isinstance(node, yaml.MappingNode):
        return replace(usual, every=section.get("notches", step, 1.0))
    inner = Section(node, f"{section.title}: notches", mark_of(node), _NOTCH_KEYS, section.problems)
    at: list[float] = []
    parts: list[float] = []
    if "at" in inner.values:
        length = length_in(mm_per_unit, negative=False)
        for label, item in inner.items("at", inner.values["at"], "a list of lengths and percentages"):
            if isinstance(item, yaml.ScalarNode) and _PART.fullmatch(item.value):
                parts.append(inner.read(label, item, _part, 0.5))
            else:
                at.append(inner.read(label, item, length, 0.0))
    kinds = one_of("slit", "T", "V", "castle")
    return NotchSpec(
        every=inner.get("every", step, None),
        at=tuple(at),
        at_parts=tuple(parts),
        nodes=inner.get("nodes", flag, usual.nodes),
        kind=cast(Literal["slit", "T", "V", "castle"], inner.get("kind", kinds, "slit")),
        marks=inner.get("marks", between(integer, 1, 3), None),
        depth=inner.get("depth", step, usual.depth),
    )


def _dart(section: Section, mm_per_unit: float) -> DartSpec:
    """`dart: left` or `{fold: left, drill: 10}`."""
    node = section.values["dart"]
    if "slit" not in section.values:
        section.problem(node, "dart: only a curve with slit: true can be a dart")
    sides = one_of("left", "right")
    if not isinstance(node, yaml.MappingNode):
        return DartSpec(cast(Literal["left", "right"], section.get("dart", sides, "left")))
    inner = Section(node, f"{section.title}: dart", mark_of(node), _DART_KEYS, section.problems)
    fold = inner.require("fold", sides, "left", "the side of the curve that the dart is folded to")
    drill = inner.get("drill", length_in(mm_per_unit, positive=True), DartSpec.drill)
    return DartSpec(cast(Literal["left", "right"], fold), drill)


def _part(node: yaml.Node) -> float:
    """A percentage -> its part of 1."""
    percent = float(node.value.rstrip("% "))
    if percent > 100.0:
        raise wrong(node, "at most 100%")
    return percent / 100.0
