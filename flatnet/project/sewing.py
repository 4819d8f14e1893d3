"""How pieces are cut along a curve: the keys of a curve that say it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, cast

import yaml

from flatnet.project.curve_specs import CurveSpec
from flatnet.project.problems import Problem
from flatnet.project.seam_specs import DartSpec, Ends, NickSpec, NotchSpec, SeamSpec, SewnTo
from flatnet.project.section import Section
from flatnet.project.values import (
    NAME,
    Parser,
    WrongValueError,
    between,
    flag,
    integer,
    length_in,
    nearest,
    one_of,
    scalar,
    wrong,
)
from flatnet.project.yaml_nodes import is_number, mark_of

SEAM_KEYS = ("allowance", "ends", "notches", "dart", "nicks", "sewn_to")
_DART_KEYS = ("fold", "drill")
_NOTCH_PLACES = ("every", "at", "nodes")
_NOTCH_KEYS = (*_NOTCH_PLACES, "kind", "marks", "depth")
_NICK_KEYS = ("every", "radius", "clear", "folded")
_SEWN_KEYS = ("curves", "ease")
_PART = re.compile(r"(\d+(?:\.\d*)?)\s*%", re.ASCII)
_SIGNED = re.compile(rf"(-?)({NAME})")
#: More ease than this part of the length is a slip of the pen: gathers take two to three times the length.
_MOST_EASE = 9.0


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
        nicks=_nicks(section, mm_per_unit) if "nicks" in section.values else None,
        sewn_to=_sewn_to(section, mm_per_unit) if "sewn_to" in section.values else None,
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
            if is_number(item):
                at.append(inner.read(label, item, length, 0.0))
            else:
                parts.append(inner.read(label, item, _part_up_to(1.0), 0.5))
    if not any(key in inner.values for key in _NOTCH_PLACES):
        section.problem(node, "notches: says no place; give 'every', 'at' or 'nodes'")
    kinds = one_of("slit", "T", "V", "castle")
    return NotchSpec(
        every=inner.get("every", step, None),
        at=tuple(at),
        at_parts=tuple(parts),
        nodes=_named_nodes(inner),
        kind=cast(Literal["slit", "T", "V", "castle"], inner.get("kind", kinds, "slit")),
        marks=inner.get("marks", between(integer, 1, 3), None),
        depth=inner.get("depth", step, usual.depth),
    )


def _named_nodes(section: Section) -> bool | tuple[str, ...]:
    """`nodes: true` for all that the curve passes, or a list of names."""
    node = section.values.get("nodes")
    if not isinstance(node, yaml.SequenceNode):
        return section.get("nodes", flag, False)
    items = section.items("nodes", node, "true, false or a list of nodes")
    return tuple(section.read(label, item, scalar("the name of a node"), "") for label, item in items)


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


def _nicks(section: Section, mm_per_unit: float) -> NickSpec:
    """`nicks: 8` for their distance, or `{every: 8, radius: 50, clear: 3}`."""
    node = section.values["nicks"]
    positive = length_in(mm_per_unit, positive=True)
    if not isinstance(node, yaml.MappingNode):
        return NickSpec(section.get("nicks", positive, 1.0))
    inner = Section(node, f"{section.title}: nicks", mark_of(node), _NICK_KEYS, section.problems)
    return NickSpec(
        every=inner.require("every", positive, 1.0, "the distance between nicks along the sew line"),
        radius=inner.get("radius", positive, NickSpec.radius),
        clear=inner.get("clear", length_in(mm_per_unit, negative=False), NickSpec.clear),
        folded=cast(Literal["back", "under"], inner.get("folded", one_of("back", "under"), "back")),
    )


def _part_up_to(most: float) -> Parser[float]:
    """A percentage, where a length could stand too -> its part of 1."""

    def parser(node: yaml.Node) -> float:
        if not isinstance(node, yaml.ScalarNode) or not _PART.fullmatch(node.value):
            raise wrong(node, f"a length, or a percentage from 0% to {100.0 * most:g}%")
        part = float(node.value.rstrip("% ")) / 100.0
        if part > most:
            raise wrong(node, f"at most {100.0 * most:g}%")
        return part

    return parser


def _sewn_to(section: Section, mm_per_unit: float) -> SewnTo:
    """`sewn_to: waist`, a list of signed curves, or `{curves: ..., ease: 3%}`."""
    node = section.values["sewn_to"]
    part = length = 0.0
    curves: tuple[tuple[str, bool], ...] = ()
    if isinstance(node, yaml.MappingNode):
        inner = Section(node, f"{section.title}: sewn_to", mark_of(node), _SEWN_KEYS, section.problems)
        if "ease" in inner.values and not is_number(inner.values["ease"]):
            part = inner.get("ease", _part_up_to(_MOST_EASE), 0.0)
        else:
            length = inner.get("ease", length_in(mm_per_unit, negative=False), 0.0)
        curves = inner.require("curves", _signed_curves, curves, "the curves that it is sewn to")
    else:
        curves = section.get("sewn_to", _signed_curves, curves)
    return SewnTo(curves, part, length, mark_of(node))


def _signed_curves(node: yaml.Node) -> tuple[tuple[str, bool], ...]:
    """A curve's name, or a list of them, those that are run backwards behind a minus."""
    nodes = node.value if isinstance(node, yaml.SequenceNode) else [node]
    expected = "a curve, or a list of curves in the order in which they are met: [front, -back]"
    if not nodes:
        raise wrong(node, expected)
    found = []
    for each in nodes:
        match = _SIGNED.fullmatch(scalar(expected)(each))
        if match is None:
            raise WrongValueError(each, wrong(each, expected).message)
        found.append((match[2], bool(match[1])))
    return tuple(found)


def notch_problems(curves: Mapping[str, CurveSpec]) -> list[Problem]:
    """Nodes that are named for notches and that their curve does not pass."""
    problems = []
    for curve in curves.values():
        named = curve.seam.notches.nodes if curve.seam.notches and curve.mirror_of is None else ()
        for name in named if isinstance(named, tuple) else ():
            if name not in curve.nodes:
                hint = nearest(name, curve.nodes, "nodes on it")
                message = f"curve {curve.name!r}: notches: nodes: it passes no node {name!r}; {hint}"
                problems.append(Problem(curve.mark, message))
    return problems


def sewn_problems(curves: Mapping[str, CurveSpec]) -> list[Problem]:
    """What is wrong with the curves that curves are sewn to."""
    problems = []
    notched_by: dict[str, str] = {}
    for curve in curves.values():
        sewn = curve.seam.sewn_to
        met: set[str] = set()
        for name, _ in sewn.curves if sewn else ():
            other = curves.get(name)
            message = None
            if name in met:
                message = f"{name!r} is met twice; name each curve once"
            elif other is None:
                message = f"there is no curve {name!r}; {nearest(name, curves, 'curves')}"
            elif other is curve:
                message = "both sides of a curve are sewn to each other without a word; name another curve"
            elif other.seam.sewn_to is not None:
                message = f"{name!r} says itself what it is sewn to; say it of one of both"
            elif curve.seam.notches and other.seam.notches:
                message = f"{name!r} has notches too; give them to one of both, they are carried to the other"
            elif curve.seam.notches and notched_by.setdefault(name, curve.name) != curve.name:
                message = f"{name!r} has the notches of {notched_by[name]!r} already; give {name!r} its own instead"
            met.add(name)
            if message and sewn:
                problems.append(Problem(sewn.mark, f"curve {curve.name!r}: sewn_to: {message}"))
    return problems
