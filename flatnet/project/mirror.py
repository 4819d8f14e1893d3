"""The section `mirror` of a project file, and nodes, curves and patches that are mirror images of others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import yaml
from numpy.typing import NDArray

from flatnet.geometry.mirror import MirrorPlane
from flatnet.project.curve_specs import CurveSpec, NodeSpec, OnLine
from flatnet.project.patch_specs import GrainSpec, PatchSpec, SignedCurve
from flatnet.project.problems import Mark, Problem
from flatnet.project.section import Section
from flatnet.project.values import direction, frozen, name, nearest, point_in, scalar
from flatnet.project.yaml_nodes import mark_of

_MIRROR_KEYS = ("point", "normal")
#: The key that makes a node, curve or patch the image of another.
IMAGE_KEY = "mirror_of"

Floats = NDArray[np.float64]
Spec = TypeVar("Spec", NodeSpec, CurveSpec, PatchSpec)


@dataclass(frozen=True)
class Images:
    """The images among the entries of a section, by name, and the names of all its entries in file order.

    Attributes
    ----------
    of : image -> what it is the image of.
    marks : image -> its place in the file.
    """

    section: Section
    of: Mapping[str, str]
    marks: Mapping[str, Mark]
    order: tuple[str, ...]

    def both_ways(self) -> dict[str, str]:
        """Original -> image and image -> original."""
        return {**self.of, **{original: image for image, original in self.of.items()}}

    def added(
        self,
        originals: Mapping[str, Spec],
        plane: MirrorPlane | None,
        reflected: Callable[[Spec, MirrorPlane], Spec],
    ) -> dict[str, Spec]:
        """All specs in file order; an image is the `reflected` original, under its own name."""
        images = {
            image: replace(reflected(originals[of], plane), name=image, mark=self.marks[image], mirror_of=of)
            for image, of in self.of.items()
            if plane is not None
        }
        specs = {**originals, **images}
        if not images:
            return specs
        elsewhere: list[str] = [each for each in specs if each not in self.order]  # imported ones
        return {each: specs[each] for each in (*elsewhere, *self.order) if each in specs}


def read_mirror(top: Section, mm_per_unit: float) -> MirrorPlane | None:
    """The plane of `mirror`; through the origin where the file gives no point."""
    if "mirror" not in top.values:
        return None
    section = top.section("mirror", _MIRROR_KEYS)
    placeholder = frozen(np.array([1.0, 0.0, 0.0]))
    return MirrorPlane(
        point=section.get("point", point_in(mm_per_unit), frozen(np.zeros(3))),
        normal=section.require("normal", direction, placeholder, "the direction across the plane, [x, y, z]"),
    )


def take_images(sections: Section, plane: MirrorPlane | None, what: str, imported: Iterable[str]) -> Images:
    """Take the entries with `mirror_of` out of a section, so that what is left are originals.

    `imported` : names of further originals, that do not stand in the section.
    """
    order = tuple(sections.keys)
    entries = {
        text: node
        for text, node in sections.values.items()
        if isinstance(node, yaml.MappingNode) and any(key.value == IMAGE_KEY for key, _ in node.value)
    }
    of: dict[str, str] = {}
    marks: dict[str, Mark] = {}
    for text, node in entries.items():
        del sections.values[text]
        key = sections.keys.pop(text)
        mark = mark_of(key)
        sections.read(repr(text), key, name, "")
        section = Section(node, f"{what} {text!r}", mark, (IMAGE_KEY,), sections.problems)
        original = section.require(IMAGE_KEY, scalar(f"the name of a {what}"), "")
        if plane is None:
            section.problem(mark, f"{IMAGE_KEY}, but the file has no mirror; add `mirror: {{normal: ...}}` at its top")
        elif original in entries:
            section.problem(mark, f"{IMAGE_KEY}: {original!r} is an image itself; name what that is the image of")
        elif original and original not in (known := [*sections.keys, *imported]):
            hint = nearest(original, known, f"{what}s")
            section.problem(mark, f"{IMAGE_KEY}: there is no {what} {original!r}; {hint}")
        elif original in of.values():
            other = next(image for image in of if of[image] == original)
            section.problem(mark, f"{IMAGE_KEY}: {original!r} has the image {other!r} already; keep one")
        elif original:
            of[text], marks[text] = original, mark
    return Images(sections, of, marks, order)


def node_image(spec: NodeSpec, plane: MirrorPlane) -> NodeSpec:
    """The node on the other side of the plane, in space alone: it is put where the original lands, reflected."""
    return replace(spec, position=frozen(plane.reflect(spec.position)), on_surface=False, place=None, cast=None)


def curve_image(
    spec: CurveSpec, plane: MirrorPlane, nodes: Mapping[str, str], curves: Mapping[str, str]
) -> CurveSpec:
    """The same curve on the other side, from the image of its start.

    `nodes`, `curves` : original -> image; those without an image are their own.
    """

    def of(node: str) -> str:
        return nodes.get(node, node)

    def of_point(point: str | Floats | OnLine) -> str | Floats | OnLine:
        if isinstance(point, OnLine):
            return point  # it guides the original
        return of(point) if isinstance(point, str) else frozen(plane.reflect(point))

    return replace(
        spec,
        start=spec.start and of(spec.start),
        end=spec.end and of(spec.end),
        points=tuple(of_point(point) for point in spec.points),
        cast=None,
        seam=spec.seam.image(curves, nodes),
        fractions=tuple(replace(each, node=of(each.node)) for each in spec.fractions),
    )


def image_problems(nodes: Mapping[str, NodeSpec], curves: Mapping[str, CurveSpec]) -> list[Problem]:
    """Curves that are drawn through images, and images whose normals would be found from the network's curves."""
    problems = []
    for curve in curves.values():
        for node in dict.fromkeys(curve.own_nodes if curve.mirror_of is None else ()):
            if node in nodes and nodes[node].mirror_of is not None:
                message = f"curve {curve.name!r}: is drawn through {node!r}, a mirror image; end it in the mirror plane"
                problems.append(Problem(curve.mark, f"{message} and give it an image too, for the rest of the way"))
        if curve.mirror_of is not None and curve.normals.source == "curves":
            message = f"curve {curve.name!r}: normals: curves has no place beside mirror images; give normals"
            problems.append(Problem(curve.mark, f"{message} to {curve.mirror_of!r}"))
    return problems


def patch_image(
    spec: PatchSpec, plane: MirrorPlane, curves: Mapping[str, str], nodes: Mapping[str, str]
) -> PatchSpec:
    """The patch on the other side: the images of its curves, run the other way round."""

    def pair_of(pair: tuple[str, str] | None) -> tuple[str, str] | None:
        return pair and (nodes.get(pair[0], pair[0]), nodes.get(pair[1], pair[1]))

    def of(entry: SignedCurve) -> SignedCurve:
        curve = curves.get(entry.curve, entry.curve)
        return replace(entry, curve=curve, reversed=not entry.reversed, stretch=pair_of(entry.stretch))

    def grain_of(grain: GrainSpec) -> GrainSpec:
        return replace(
            grain,
            direction=None if grain.direction is None else frozen(plane.reflect_directions(grain.direction)),
            nodes=pair_of(grain.nodes),
            curve=grain.curve and replace(of(grain.curve), reversed=grain.curve.reversed),
        )

    return replace(
        spec,
        loops=tuple(tuple(of(entry) for entry in reversed(loop)) for loop in spec.loops),
        fold=spec.fold and curves.get(spec.fold, spec.fold),
        min_angles={nodes.get(node, node): angle for node, angle in spec.min_angles.items()},
        grain=spec.grain and grain_of(spec.grain),
        marks=tuple(
            replace(mark, points=tuple(frozen(plane.reflect(point)) for point in mark.points)) for mark in spec.marks
        ),
    )
