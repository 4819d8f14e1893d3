"""Divide the patches that failed or wrinkle by the best cut that was found, again and again up to a limit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from flatnet.failure import Finding
from flatnet.fitting.mirror import reflect_patch
from flatnet.fitting.results import FittedPatch
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.mirror import MirrorPlane
from flatnet.network.division import Cut
from flatnet.network.mirror import image_of_cut
from flatnet.network.network import CurveNetwork
from flatnet.network.patch import Patch
from flatnet.project.model import Project
from flatnet.remedies.diagnose import FitAll, Result, Trial, diagnose, divide_by, needs_cut, patch_of
from flatnet.remedies.seam_spec import seam_spec

T = TypeVar("T")

#: How often a patch and its parts are divided at most, one after the other: at most 2^3 pieces of one patch.
MAX_DEPTH = 3


def auto_split(
    project: Project,
    network: CurveNetwork,
    results: Mapping[str, Result],
    surface: ReferenceSurface | None,
    fit_all: Callable[[str], FitAll],
) -> tuple[Project, CurveNetwork, dict[str, Result]]:
    """Divide what can't be made, or wrinkles unexpectedly, where a cut was found that helps.

    Parameters
    ----------
    results : of every patch of the project, by its name.
    fit_all : how the parts of the patch of this name are fitted.

    Returns
    -------
    project, network, results : a divided patch is replaced by its parts, each with the warning `divided`; the cuts
        are seams of the network. What is the mirror image of a divided patch is divided by the images of its cuts.
    """
    curves = dict(project.curves)
    specs = {name: {name: spec} for name, spec in project.patches.items()}
    made = {name: {name: result} for name, result in results.items()}
    images = {patch.mirror_of: patch.name for patch in network.patches}
    originals = [patch.name for patch in network.patches if patch.mirror_of is None]
    for name in originals:
        if not needs_cut(results[name]):
            continue
        patch, spec = patch_of(network, name), project.patches[name]
        network, made[name], divisions = split(network, patch, results[name], surface, fit_all(name), MAX_DEPTH)
        specs[name] = {part: replace(spec, name=part) for part in made[name]}
        image = images.get(name)
        if divisions and image is not None and project.mirror is not None:
            network, parts = _divide_alike(network, patch_of(network, image), divisions, project.mirror)
            made[image] = {part.name: reflect_patch(made[name][of], part, project.mirror) for of, part in parts}
            spec = project.patches[image]
            specs[image] = {part.name: replace(spec, name=part.name, mirror_of=of) for of, part in parts}
        cuts = [seam for seam in network.stretches.values() if seam.curve not in curves]
        curves |= {cut.name: seam_spec(cut, spec) for cut in cuts}
    project = replace(project, curves=curves, patches=_in_one(specs.values()))
    return project, network, _in_one(made.values())


def _in_one(parts: Iterable[Mapping[str, T]]) -> dict[str, T]:
    return {name: part for of_patch in parts for name, part in of_patch.items()}


@dataclass(frozen=True, eq=False)
class Division:
    """A patch, the cut that divided it, and its parts on the left and on the right."""

    patch: Patch
    cut: Cut
    parts: tuple[Patch, Patch]


def _divide_alike(
    network: CurveNetwork, image: Patch, divisions: Sequence[Division], plane: MirrorPlane
) -> tuple[CurveNetwork, list[tuple[str, Patch]]]:
    """The network with a mirror image divided as its original was; the parts, each behind the name of its original."""
    assert image.mirror_of is not None, "an image is the image of something"
    image_of = {image.mirror_of: image.name}
    for division in divisions:
        patch = patch_of(network, image_of.pop(division.patch.name))
        cut = image_of_cut(division.cut, division.patch.boundary, patch.boundary, plane)
        network, (left, right) = divide_by(network, patch, cut)
        image_of |= {division.parts[0].name: left.name, division.parts[1].name: right.name}
    of = {name: original for original, name in image_of.items()}
    patches = tuple(replace(p, mirror_of=of[p.name]) if p.name in of else p for p in network.patches)
    return replace(network, patches=patches), [(of[p.name], p) for p in patches if p.name in of]


def split(
    network: CurveNetwork,
    patch: Patch,
    result: Result,
    surface: ReferenceSurface | None,
    fit_all: FitAll,
    depth: int,
) -> tuple[CurveNetwork, dict[str, Result], list[Division]]:
    """The parts of a patch that needs a cut, or the patch as it is where none was found; the cuts in their order."""
    cure = diagnose(network, patch, result, surface, fit_all).cure if needs_cut(result) and depth else None
    if cure is None:
        return network, {patch.name: result}, []
    network = cure.network
    made: dict[str, Result] = {}
    divisions = [Division(patch, cure.cut, cure.parts)]
    for part, came_out in zip(cure.parts, cure.results, strict=True):
        noted = replace(came_out, warnings=(*came_out.warnings, _note(patch, result, cure)))
        network, parts, further = split(network, part, noted, surface, fit_all, depth - 1)
        made |= parts
        divisions += further
    return network, made, divisions


def _note(patch: Patch, result: Result, cure: Trial) -> Finding:
    why = "wrinkles" if isinstance(result, FittedPatch) else result.failure.code
    ends = [patch.boundary.place(vertex) for vertex in (cure.cut.start, cure.cut.end)]
    return Finding(
        code="divided",
        stage="auto_split",
        message=(
            f"it is a part of '{patch.name}' ({why}), which was divided by the seam '{cure.seam}' from {ends[0]} to "
            f"{ends[1]}."
        ),
        remedy="Draw a seam where it suits the design; `flatnet diagnose` lists the other cuts that were tried.",
        where=f"{ends[0]} to {ends[1]}",
        amount=cure.cut.length,
        unit="mm",
    )
