"""Make the curve network: a project and its surface go in, patches that share sampled curves come out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.forms.surface import ReferenceSurface
from flatnet.network.boundaries import make_patch
from flatnet.network.casting import cast_drawings
from flatnet.network.crossings import crossing_problems, join_crossings, name_ends
from flatnet.network.curves import CurveSamples, DrawnCurve, StretchSamples, sample_curve
from flatnet.network.drawing import draw_curve
from flatnet.network.faces import match_faces
from flatnet.network.graph import Dart, TracedFaces, dangling_ends, lone_slits, rotation_system, trace_faces
from flatnet.network.mirror import mirror_network
from flatnet.network.network import CurveNetwork, GeometryError, Loops, SampledStretch
from flatnet.network.normals import stretch_normals, surface_normals
from flatnet.network.patch import Patch
from flatnet.network.places import cut_at_fractions, place_nodes
from flatnet.network.tangents import normals_from_curves
from flatnet.network.thickness import to_middle
from flatnet.project.curve_specs import CurveSpec, NodeSpec
from flatnet.project.model import Project
from flatnet.project.nodes import drawing_order
from flatnet.project.problems import Problem, ProjectError

Floats = NDArray[np.float64]


def make_network(project: Project, surface: ReferenceSurface | None) -> CurveNetwork:
    """Sample a project's curves, trace the faces of their network and make those that are patches.

    Parameters
    ----------
    project : as its file gives it.
    surface : what curves are projected onto and normals taken from; None where the project has none.

    Raises
    ------
    ProjectError
        The geometry shows that the project is wrong: a projected curve jumps, a curve ends inside a face, a slit
        is joined to nothing, the order of curves around a node or the loops of a face are unsure
        (`ambiguous_faces`), an `around` is no face, a face is listed nowhere, normals change side along a patch.
        All problems that can be told at once are in it; a patch that is no disk is none of them, but a finding
        in `failed`.
    """

    places, stretches, traced = trace_network(project, surface)
    matched, problems = match_faces(project, stretches, traced)
    places, stretches, found = to_middle(project, matched.patches, places, stretches)
    problems += found

    patches: list[Patch] = []
    failed: list[Finding] = []
    for name, loops in matched.patches.items():
        made, found = make_patch(project.patches[name], loops, stretches, project.curves)
        problems += found
        if isinstance(made, Patch):
            patches.append(replace(made, strain=project.materials[made.material].strain))
        elif made is not None:
            failed.append(made)
    _refuse(project, list(dict.fromkeys(problems)))
    return CurveNetwork(
        nodes=places,
        stretches=stretches,
        patches=tuple(patches),
        failed=tuple(failed),
        rings={name: _names(loops) for name, loops in matched.patches.items() if len(loops) > 1},
        openings={name: _names(loops) for name, loops in matched.openings.items()},
        face_count=len(traced.faces),
        euler_characteristics=traced.euler_characteristics,
    )


def trace_network(
    project: Project, surface: ReferenceSurface | None
) -> tuple[dict[str, Floats], dict[str, SampledStretch], TracedFaces]:
    """The places of a project's nodes, its sampled stretches with normals, and all loops that they make.

    Raises
    ------
    ProjectError
        As `make_network`, but for what concerns patches.
    """
    project = cast_drawings(project, surface)
    places, stretches, new, problems = sample_stretches(project.as_drawn(), surface)
    places, stretches, found = mirror_network(project, places, stretches)
    _refuse(project, problems + found + dangling_ends(stretches, places, project.curves))
    nodes = {**project.nodes, **new}
    stretches, settled, problems = normals_from_curves(stretches, project.curves, nodes)
    _refuse(project, problems)
    rotation, problems = rotation_system(stretches, nodes, settled)
    _refuse(project, problems)
    traced = trace_faces(stretches, rotation)
    _refuse(project, lone_slits(traced, stretches, project.curves))
    return places, stretches, traced


def _refuse(project: Project, problems: list[Problem]) -> None:
    if problems:
        raise ProjectError(project.file, problems)


def _names(loops: tuple[tuple[Dart, ...], ...]) -> Loops:
    return tuple(tuple(map(str, loop)) for loop in loops)


def sample_stretches(
    project: Project, surface: ReferenceSurface | None
) -> tuple[dict[str, Floats], dict[str, SampledStretch], dict[str, NodeSpec], list[Problem]]:
    """All nodes in their places, all stretches of all curves in the order of the file, the nodes that crossings and
    free ends have got, and what is wrong with the other nodes and curves."""
    places, drawn, problems = draw_curves(project, surface)
    new: dict[str, NodeSpec] = {}
    if surface is not None and project.joins_crossings:
        drawn, new, unjoined = join_crossings(project.curves, project.nodes, drawn, surface)
        problems += unjoined
    elif surface is not None:
        problems += crossing_problems(project.curves, drawn, surface)
    drawn, ends = name_ends(project.curves, {*project.nodes, *new}, drawn)
    new |= ends
    places |= {name: node.position for name, node in new.items()}
    samples: dict[str, CurveSamples] = {}
    stretches: dict[str, SampledStretch] = {}
    for name, each in drawn.items():
        try:
            samples[name] = sample_curve(project.curves[name], each)
        except GeometryError as found:
            problems.append(found.problem)
    on_surface = [name for name in samples if project.curves[name].normals.source == "surface"]
    of_surface = surface_normals([part for name in on_surface for part in samples[name].stretches], surface)
    for name, sampled in samples.items():
        try:
            stretches |= _stretches_of(project.curves[name], sampled, of_surface)
        except GeometryError as found:
            problems.append(found.problem)
    return places, stretches, new, problems


def draw_curves(
    project: Project, surface: ReferenceSurface | None
) -> tuple[dict[str, Floats], dict[str, DrawnCurve], list[Problem]]:
    """All nodes in their places, mm, all curves drawn, and what is wrong with the others.

    What depends on a node or curve with a problem is left out without further word.
    """
    places, problems = place_nodes(project.nodes, project.curves, surface)
    drawn: dict[str, DrawnCurve] = {}
    for kind, name in drawing_order(project.nodes, project.curves):
        if kind == "curve" and all(node in places for node in project.curves[name].own_nodes):
            curve = project.curves[name]
            try:
                drawn[name] = draw_curve(curve, places, surface, project.chord_tolerance)
                drawn[name], on_it = cut_at_fractions(curve, drawn[name])
                places |= on_it
            except GeometryError as found:
                problems.append(found.problem)
    for position in places.values():
        position.setflags(write=False)
    return (
        {name: places[name] for name in project.nodes if name in places},
        {name: drawn[name] for name in project.curves if name in drawn},
        problems,
    )


def _stretches_of(
    curve: CurveSpec, samples: CurveSamples, of_surface: Mapping[StretchSamples, Floats]
) -> dict[str, SampledStretch]:
    """A curve's stretches with their normals, by name."""
    stretches = {}
    for part in samples.stretches:
        left, right = stretch_normals(curve, samples, part, of_surface)
        name = curve.name if len(samples.stretches) == 1 else f"{curve.name}:{part.start}..{part.end}"
        stretches[name] = SampledStretch(
            name, curve.name, part.start, part.end, part.vertices, left, right, curve.slit
        )
    return stretches
