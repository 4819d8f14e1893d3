"""Divide the patches that failed or wrinkle by the best cut that was found, again and again up to a limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from flatnet.failure import Finding
from flatnet.fitting.results import FittedPatch
from flatnet.forms.surface import ReferenceSurface
from flatnet.network.network import CurveNetwork
from flatnet.network.patch import Patch
from flatnet.project.model import Project
from flatnet.project.patch_specs import PatchSpec
from flatnet.remedies.diagnose import FitAll, Result, Trial, diagnose, needs_cut
from flatnet.remedies.seam_spec import seam_spec

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
        are seams of the network.
    """
    curves = dict(project.curves)
    specs: dict[str, PatchSpec] = {}
    made: dict[str, Result] = {}
    for name, result in results.items():
        patch = next((patch for patch in network.patches if patch.name == name), None)
        parts = {name: result}
        if patch is not None and needs_cut(result):
            network, parts = split(network, patch, result, surface, fit_all(name), MAX_DEPTH)
        made |= parts
        cuts = [seam for seam in network.stretches.values() if seam.curve not in curves]
        curves |= {cut.name: seam_spec(cut, project.patches[name]) for cut in cuts}
        specs |= {part: replace(project.patches[name], name=part) for part in parts}
    return replace(project, curves=curves, patches=specs), network, made


def split(
    network: CurveNetwork,
    patch: Patch,
    result: Result,
    surface: ReferenceSurface | None,
    fit_all: FitAll,
    depth: int,
) -> tuple[CurveNetwork, dict[str, Result]]:
    """The parts of a patch that needs a cut, or the patch as it is where none was found."""
    cure = diagnose(network, patch, result, surface, fit_all).cure if needs_cut(result) and depth else None
    if cure is None:
        return network, {patch.name: result}
    network = cure.network
    made: dict[str, Result] = {}
    for part, came_out in zip(cure.parts, cure.results, strict=True):
        noted = replace(came_out, warnings=(*came_out.warnings, _note(patch, result, cure)))
        network, parts = split(network, part, noted, surface, fit_all, depth - 1)
        made |= parts
    return network, made


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
