"""How pieces are cut along a curve: the keys of a curve that say it."""

from __future__ import annotations

from typing import Literal, cast

import yaml

from flatnet.project.model import Ends, SeamSpec
from flatnet.project.section import Section
from flatnet.project.values import Parser, length_in, one_of
from flatnet.project.yaml_nodes import is_number, mark_of

SEAM_KEYS = ("allowance", "ends")


def read_seam(section: Section, mm_per_unit: float) -> SeamSpec:
    """What a curve says about its allowances."""
    left, right = _allowances(section, allowance_in(mm_per_unit))
    return SeamSpec(left, right, section.get("ends", _ends_in(mm_per_unit), Ends()))


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
