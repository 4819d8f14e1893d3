"""The sections `patches` and `openings` of a project file -> patch and opening specs, and `around`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import yaml

from flatnet.parameters import FittingParameters
from flatnet.project.curve_specs import CurveSpec
from flatnet.project.marks import read_marks
from flatnet.project.parameters import read_fitting
from flatnet.project.patch_specs import AlsoSpec, GrainSpec, OpeningSpec, PatchSpec, SignedCurve
from flatnet.project.problems import Problem
from flatnet.project.section import Section
from flatnet.project.sewing import allowance_in
from flatnet.project.values import (
    NAME,
    WrongValueError,
    between,
    direction,
    flag,
    frozen,
    integer,
    length_in,
    name,
    nearest,
    number,
    one_of,
    scalar,
    wrong,
)
from flatnet.project.yaml_nodes import mark_of

_PATCH_KEYS = (
    "around",
    "material",
    "cut",
    "mirrored",
    "grain",
    "edge_length",
    "min_angle",
    "planar_boundary",
    "fitting",
    "allowance",
    "wrinkles",
    "also",
    "marks",
    "fold",
    "zone",
    "match",
)
_ALSO_KEYS = ("cut", "mirrored", "allowance")
_GRAIN_KEYS = ("along", "from", "to")
_SIGNED = re.compile(rf"(-?)({NAME})(?::({NAME})\.\.({NAME}))?")
_MOST_COPIES = 1000
Loops = tuple[tuple[SignedCurve, ...], ...]


@dataclass(frozen=True, eq=False)
class FaceSetting:
    """What the rest of the file means for its patches: unit, edge length (mm), curves, materials, fitting.

    Where crossings are joined, curves pass nodes that only the network knows.
    """

    mm_per_unit: float
    edge_length: float
    curves: Mapping[str, CurveSpec]
    materials: tuple[str, ...]
    fitting: FittingParameters
    joins_crossings: bool


def stretches(curve: CurveSpec) -> list[tuple[str, str]]:
    """The pairs of nodes between which a curve's stretches run; none where it has no node."""
    nodes = curve.nodes
    return list(pairwise(nodes + nodes[:1] if curve.closed and curve.start is None else nodes))


def _run(curve: CurveSpec, first: str, last: str) -> list[tuple[str, str]]:
    """The stretches from node `first` on to node `last` in the curve's direction; [] if there is no way."""
    pairs = stretches(curve)
    start = next((i for i, (node, _) in enumerate(pairs) if node == first), len(pairs))
    onward = pairs[start:] + (pairs[:start] if curve.closed else [])
    count = next((i for i, (_, node) in enumerate(onward, 1) if node == last), 0)
    return onward[:count] if start < len(pairs) else []


def read_patches(sections: Section, setting: FaceSetting) -> dict[str, PatchSpec]:
    """The section `patches` -> name -> patch, in file order."""
    patches = {}
    for key, mark, node in sections.named():
        section = Section(node, f"patch {key!r}", mark, _PATCH_KEYS, sections.problems)
        patches[key] = _patch(key, section, setting)
    return patches


def read_openings(
    sections: Section, curves: Mapping[str, CurveSpec], joins_crossings: bool
) -> dict[str, OpeningSpec]:
    """The section `openings` -> name -> opening, in file order."""
    openings = {}
    for key, mark, node in sections.named():
        section = Section(node, f"opening {key!r}", mark, ("around",), sections.problems)
        openings[key] = OpeningSpec(key, _around(section, curves, joins_crossings), mark)
    return openings


def _patch(key: str, section: Section, setting: FaceSetting) -> PatchSpec:
    problems_before = len(section.problems)
    loops = _around(section, setting.curves, setting.joins_crossings)
    complete = len(section.problems) == problems_before and not setting.joins_crossings
    cut, mirrored = _copies(section, 1, 0)
    fold = _fold(section, loops)
    material = _material(section, setting.materials)
    return PatchSpec(
        name=key,
        loops=loops,
        material=material,
        cut=cut,
        mirrored=mirrored,
        grain=_grain(section, setting, fold),
        edge_length=section.get(
            "edge_length", length_in(setting.mm_per_unit, positive=True), setting.edge_length
        ),
        min_angles=_min_angles(section, loops if complete else (), setting.curves),
        fitting=read_fitting(section, setting.fitting),
        wrinkles_expected=section.get("wrinkles", one_of("expected"), "") == "expected",
        simple_outline=section.get("planar_boundary", one_of("predicted", "simple"), "predicted") == "simple",
        mark=section.mark,
        allowance=section.get("allowance", allowance_in(setting.mm_per_unit), None),
        also=_also(section, setting, material, cut, mirrored),
        marks=read_marks(section, setting.mm_per_unit),
        fold=fold.curve if fold else None,
        zone=section.get("zone", name, ""),
        match=section.get("match", flag, False),
    )


def _fold(section: Section, loops: Loops) -> SignedCurve | None:
    """The entry of `around` along which the patch is one half of a piece."""
    node = section.values.get("fold")
    if node is None:
        return None
    text = section.read("fold", node, scalar("the name of a curve"), "")
    around = {entry.curve: entry for loop in loops for entry in loop}
    if text and around and text not in around:
        section.problem(node, f"fold: {text!r} is not around the patch; {nearest(text, around, 'curves around it')}")
    return around.get(text)


def _copies(section: Section, cut: int, mirrored: int) -> tuple[int, int]:
    """Plain and mirrored copies; `cut` and `mirrored` where nothing is said."""
    copies = between(integer, 0, _MOST_COPIES)
    cut, mirrored = section.get("cut", copies, cut), section.get("mirrored", copies, mirrored)
    if cut == mirrored == 0:
        where = section.values.get("cut", section.values.get("mirrored"))
        section.problem(where or section.mark, "nothing is cut: give 'mirrored' too, or make it an opening")
    return cut, mirrored


def _also(section: Section, setting: FaceSetting, material: str, cut: int, mirrored: int) -> tuple[AlsoSpec, ...]:
    """The further materials that a patch is cut from; copies are as many as of the first where nothing is said."""
    every = section.section("also", None)
    found = []
    for other, node in every.values.items():
        key = every.keys[other]
        if other not in setting.materials:
            hint = nearest(other, setting.materials, "materials")
            every.problem(key, f"there is no material {other!r}; {hint}")
        if other == material:
            every.problem(key, f"{other!r} is its `material` already")
        each = Section(node, f"{every.title}: {other}", mark_of(key), _ALSO_KEYS, section.problems)
        width = each.get("allowance", allowance_in(setting.mm_per_unit), None)
        found.append(AlsoSpec(other, *_copies(each, cut, mirrored), width))
    return tuple(found)


_UP = frozen(np.array([0.0, 0.0, 1.0]))


def _grain(section: Section, setting: FaceSetting, fold: SignedCurve | None) -> GrainSpec | None:
    node = section.values.get("grain")
    if node is None and fold is not None:
        return GrainSpec(curve=replace(fold, reversed=False, stretch=None), said=False)
    if node is None:
        return GrainSpec(_UP, said=False)
    if isinstance(node, yaml.SequenceNode):
        return GrainSpec(section.read("grain", node, direction, _UP))
    if isinstance(node, yaml.ScalarNode) and node.value in ("up", "none"):
        return GrainSpec(_UP) if node.value == "up" else None
    if isinstance(node, yaml.MappingNode):
        return _drawn_grain(section, node, setting)
    section.read("grain", node, _no_grain, None)
    return None


def _no_grain(node: yaml.Node) -> None:
    raise wrong(node, "'up', 'none', a direction [x, y, z], {along: curve} or {from: node, to: node}")


def _drawn_grain(section: Section, node: yaml.MappingNode, setting: FaceSetting) -> GrainSpec | None:
    """Along a curve, or from one node to another."""
    inner = Section(node, f"{section.title}: grain", mark_of(node), _GRAIN_KEYS, section.problems)
    if "along" in inner.values:
        for key in [key for key in ("from", "to") if key in inner.values]:
            inner.problem(inner.keys[key], f"'along' and '{key}' exclude each other; keep one")
        entry = _entry(inner, "along", inner.values["along"], setting.curves, setting.joins_crossings)
        return GrainSpec(curve=entry) if entry else None
    known = {name for curve in setting.curves.values() for name in curve.nodes}
    ends = []
    for key in ("from", "to"):
        end = inner.require(key, scalar("the name of a node"), "", "the grain runs along a curve or between two nodes")
        if end and end not in known and not setting.joins_crossings:
            hint = nearest(end, sorted(known), "nodes")
            inner.problem(inner.values[key], f"{key}: no curve passes a node {end!r}; {hint}")
        ends.append(end)
    if ends[0] == ends[1] != "":
        inner.problem(node, "'from' and 'to' are the same node")
    return GrainSpec(nodes=(ends[0], ends[1]))


def _material(section: Section, materials: tuple[str, ...]) -> str:
    if "material" not in section.values:
        if len(materials) > 1 and section.is_mapping:
            section.problem(section.mark, f"'material' is missing; say which of {', '.join(materials)}")
        return materials[0]
    node = section.values["material"]
    material = section.read("material", node, scalar("the name of a material"), materials[0])
    if material not in materials:
        hint = nearest(material, materials, "materials")
        section.problem(node, f"material: there is no material {material!r}; {hint}")
    return material


def _min_angles(section: Section, loops: Loops, curves: Mapping[str, CurveSpec]) -> dict[str, float]:
    on_patch = {node for loop in loops for entry in loop for node in _nodes_along(entry, curves)}
    angles = {}
    corners = section.section("min_angle", None)
    for node, value in corners.values.items():
        if node not in on_patch and loops:
            hint = nearest(node, sorted(on_patch), "nodes of this patch")
            corners.problem(corners.keys[node], f"node {node!r} is not on the boundary of the patch; {hint}")
        angle = corners.read(node, value, number, 1.0)
        if not 0.0 < angle < 360.0:
            corners.problem(value, f"{node}: must be between 0 and 360 degrees, got {angle:g}")
        angles[node] = float(np.radians(angle))
    return angles


def _nodes_along(entry: SignedCurve, curves: Mapping[str, CurveSpec]) -> set[str]:
    curve = curves[entry.curve]
    pairs = _run(curve, *entry.stretch) if entry.stretch else stretches(curve)
    return {node for pair in pairs for node in pair}


def _around(section: Section, curves: Mapping[str, CurveSpec], joins_crossings: bool) -> Loops:
    """The loops of a face; entries that are wrong are noted and left out."""
    if "around" not in section.values:
        if section.is_mapping:
            section.problem(section.mark, "'around' is missing; the signed curves around the face, in order")
        return ()
    node = section.values["around"]
    items = section.items("around", node, "a list of curves")
    if not items and isinstance(node, yaml.SequenceNode):
        section.problem(node, "around: names no curve")
    nested = [isinstance(item, yaml.SequenceNode) for _, item in items]
    if any(nested) and not all(nested):
        stray = items[nested.index(False)][1]
        section.problem(stray, "around: expected curves or a list of loops [[...], [...]], got both")
        return ()
    if not any(nested):
        lists = [items]
    else:
        lists = [section.items(label, item, "a list of curves") for label, item in items]
        for (label, item), entries in zip(items, lists):
            if not entries:
                section.problem(item, f"{label}: names no curve")
    loops = []
    for entries in lists:
        found = [_entry(section, label, item, curves, joins_crossings) for label, item in entries]
        loops.append(tuple(entry for entry in found if entry is not None))
    return tuple(loop for loop in loops if loop)


def _entry(
    section: Section, label: str, node: yaml.Node, curves: Mapping[str, CurveSpec], joins_crossings: bool
) -> SignedCurve | None:
    def parse(node: yaml.Node) -> SignedCurve:
        expected = "a curve: hem, -hem, or a stretch of one, hem:a..b"
        match = _SIGNED.fullmatch(scalar(expected)(node))
        if match is None:
            raise wrong(node, expected)
        minus, curve, first, last = match.groups()
        if curve not in curves:
            raise WrongValueError(node, f"there is no curve {curve!r}; {nearest(curve, curves, 'curves')}")
        stretch = (first, last) if first else None
        if stretch and not (joins_crossings and set(stretch) - set(curves[curve].nodes)):
            _check_stretch(node, minus, curves[curve], stretch)
        return SignedCurve(curve, bool(minus), stretch, mark_of(node))

    return section.read(label, node, parse, None)


def _check_stretch(node: yaml.Node, minus: str, curve: CurveSpec, stretch: tuple[str, str]) -> None:
    first, last = stretch
    if _run(curve, first, last):
        return
    if _run(curve, last, first):
        right = f"{curve.name}:{last}..{first}"
        message = f"the curve runs from {last!r} to {first!r}; write {right}, backwards -{right}"
        raise WrongValueError(node, message)
    if not stretches(curve):
        raise WrongValueError(node, f"curve {curve.name!r} passes no node; write {minus}{curve.name}")
    written = ", ".join(f"{curve.name}:{a}..{b}" for a, b in stretches(curve))
    message = f"no stretch of {curve.name!r} runs from {first!r} to {last!r}; its stretches: {written}"
    raise WrongValueError(node, message)


def face_problems(
    patches: Mapping[str, PatchSpec],
    openings: Mapping[str, OpeningSpec],
    curves: Mapping[str, CurveSpec],
    joins_crossings: bool,
) -> list[Problem]:
    """Sides of a curve that two faces claim, and curves of patches without normals."""
    entries = [(f"patch {key!r}", entry) for key, patch in patches.items() for entry in _entries(patch)]
    bare: dict[str, Problem] = {}
    for title, entry in entries:
        curve = curves[entry.curve]
        if curve.normals.source == "none":
            message = f"has no normals, but {title} needs them; give 'normals' or a surface"
            bare.setdefault(curve.name, Problem(curve.mark, f"curve {curve.name!r}: {message}"))
    entries += [(f"opening {key!r}", entry) for key, face in openings.items() for entry in _entries(face)]
    # Where crossings are joined, any name may mean several stretches; which, the network tells.
    return [*bare.values(), *([] if joins_crossings else _side_problems(entries, curves))]


def _entries(face: PatchSpec | OpeningSpec) -> list[SignedCurve]:
    return [entry for loop in face.loops for entry in loop]


def _side_problems(
    entries: list[tuple[str, SignedCurve]], curves: Mapping[str, CurveSpec]
) -> list[Problem]:
    """No side of a stretch has two faces.

    The plain name of a curve with several stretches may mean any of them; only the network can tell which.
    """
    owners: dict[tuple[str, tuple[str, str] | None, bool], str] = {}
    problems = []
    for title, entry in entries:
        curve = curves[entry.curve]
        run = _run(curve, *entry.stretch) if entry.stretch else stretches(curve)
        if entry.stretch is None and len(run) > 1:
            continue
        covered: list[tuple[str, str] | None] = [*run] or [None]
        sides = [(curve.name, stretch, entry.reversed) for stretch in covered]
        owner = next((owners[side] for side in sides if side in owners), None)
        owners |= {side: title for side in sides if side not in owners}
        if owner is not None:
            other = replace(entry, reversed=not entry.reversed)
            taken = "stands there twice" if owner == title else f"already bounds {owner} on this side"
            message = f"{title}: around: '{entry}' {taken}; its other side is '{other}'"
            problems.append(Problem(entry.mark, message))
    return problems
