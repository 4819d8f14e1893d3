"""Fit one patch: the stages of the paper in order, and what counts as made."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding, PatchFailure, spoken
from flatnet.fitting.boundary_alone import boundary_alone, made_of_it_alone, stages_before
from flatnet.fitting.contradiction import Asked, contradiction, gave_way
from flatnet.fitting.levels import fit_in_levels
from flatnet.fitting.multi_loop import multi_loop
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import FittedPatch, FlattenableMesh, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.fitting.strained import strained
from flatnet.fitting.stuck import FOLD, freed
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.unfold import along_chord, along_grain, unfold
from flatnet.fitting.warp import warp
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.triangles import angle_sums, hinge_angles, hinges_of
from flatnet.network.patch import BoundaryCurve, Grain, Patch
from flatnet.parameters import BoundaryAloneParameters, FairParameters, FittingParameters

Floats = NDArray[np.float64]

#: What to do about a fold of a patch that is made of its boundary alone.
OTHERWISE = "Method 'fair' bends smoothly where it finds a way; else cut the patch in two there."


def fit_patch(
    patch: Patch, parameters: FittingParameters, seconds: dict[str, float]
) -> FittedPatch:
    """B -> B^p -> M^p -> M^0 -> M -> flat.

    Parameters
    ----------
    seconds : filled with the time of each stage as it ends, so that a failure leaves what was measured.

    Raises
    ------
    PatchFailure
        From the stage that could not do its part; `not_converged`, `stuck_vertex`, `folded` or
        `self_intersection` where the result is no patch that can be cut.
    """
    if isinstance(parameters, BoundaryAloneParameters):
        return _fit_boundary_alone(patch, parameters, seconds)
    boundary = patch.boundary
    with _timed("planar_boundary", seconds):
        planar_boundary = fit_planar_boundary(boundary, patch.simple_outline)
    with _timed("tessellation", seconds):
        planar = tessellate(planar_boundary, patch.edge_length)
    with _timed("warp", seconds):
        warped = warp(planar, boundary)
    with _timed("flattenable_mesh", seconds):
        if isinstance(parameters, FairParameters):
            mesh = fit_in_levels(warped, planar, planar_boundary, patch, parameters)
            mesh, warped, planar = freed(mesh, warped, planar, planar_boundary, patch, parameters)
        else:
            mesh = multi_loop(warped, boundary, planar, parameters)
        asked = Asked.by(planar_boundary, boundary)
        check_converged(mesh, boundary, parameters, asked)
        fold = _fold(mesh, asked)
        if fold is not None:
            raise PatchFailure(fold)
    with _timed("unfold", seconds):
        flat = unfold(mesh)
        _check_outline(flat[: mesh.boundary_count], boundary)
    if patch.strain > 0.0:
        with _timed("strained", seconds):
            fair = parameters if isinstance(parameters, FairParameters) else FairParameters()
            mesh, flat = strained(mesh, flat, boundary, fair, patch.strain)
    warnings = planar_boundary.warnings + contradiction(asked, mesh, boundary)
    if isinstance(parameters, FairParameters):
        warnings += gave_way(asked, mesh, parameters.normal_weight)
    return _fitted(patch, planar_boundary, planar, warped, mesh, flat, warnings, seconds)


def _fit_boundary_alone(
    patch: Patch, parameters: BoundaryAloneParameters, seconds: dict[str, float]
) -> FittedPatch:
    """B -> M -> flat. What was chosen as the last resort may fold, which is said; it may not cover itself when flat."""
    boundary = patch.boundary
    with _timed("flattenable_mesh", seconds):
        mesh = boundary_alone(boundary)
    with _timed("unfold", seconds):
        flat = unfold(mesh)
        planar_boundary, planar, warped = stages_before(mesh, flat, boundary)
        asked = Asked.by(planar_boundary, boundary)
        check_converged(mesh, boundary, parameters, asked)
        _check_outline(flat, boundary)
    fold = _fold(mesh, asked)
    warnings = (
        *planar_boundary.warnings,
        made_of_it_alone(mesh, boundary),
        *contradiction(asked, mesh, boundary),
        *([replace(fold, remedy=OTHERWISE)] if fold else []),
    )
    return _fitted(patch, planar_boundary, planar, warped, mesh, flat, warnings, seconds)


def _fitted(
    patch: Patch,
    planar_boundary: PlanarBoundary,
    planar: PlanarMesh,
    warped: WarpedMesh,
    mesh: FlattenableMesh,
    flat: Floats,
    warnings: tuple[Finding, ...],
    seconds: dict[str, float],
) -> FittedPatch:
    """The finished patch, laid along its grain."""
    with _timed("unfold", seconds):
        laid = _laid(flat, mesh, patch.grain)
    if patch.grain is not None and laid is None:
        warnings += (_no_grain(patch.grain),)
    return FittedPatch(
        patch=patch,
        planar_boundary=planar_boundary,
        planar=planar,
        warped=warped,
        mesh=mesh,
        flat=flat if laid is None else laid,
        has_grain=laid is not None,
        warnings=warnings,
        seconds=dict(seconds),
    )


def _laid(flat: Floats, mesh: FlattenableMesh, grain: Grain | None) -> Floats | None:
    """The flat mesh with its grain along +x; None where it has none."""
    if grain is None:
        return None
    if grain.chord is not None:
        return along_chord(flat, *grain.chord)
    laid = along_grain(flat, mesh, np.asarray(grain.direction))
    return flat if laid is None and not grain.said else laid


def _no_grain(grain: Grain) -> Finding:
    x, y, z = np.asarray(grain.direction)
    return Finding(
        code="no_grain",
        stage="unfold",
        message=f"its grain direction ({x:g}, {y:g}, {z:g}) is nowhere along the patch: it is laid by its extent.",
        remedy="Give `grain` a direction along the patch, a curve, two nodes, or `none`.",
    )


@contextmanager
def _timed(stage: str, seconds: dict[str, float]) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - start


def check_converged(
    mesh: FlattenableMesh, boundary: BoundaryCurve, parameters: FittingParameters, asked: Asked
) -> None:
    """Raise `stuck_vertex` or `not_converged` where a vertex is far from flattenable or a corner too sharp."""
    tolerance = parameters.tolerance
    angles = angle_sums(mesh.vertices, mesh.triangles)[: mesh.boundary_count]
    short = boundary.min_angles - angles
    corner = int(np.argmax(short))
    if short[corner] > tolerance:
        raise PatchFailure.of(
            "not_converged",
            "flattenable_mesh",
            f"the corner at {boundary.place(corner)} has {np.degrees(angles[corner]):.2f} degrees when flat; "
            f"min_angle asks for {np.degrees(boundary.min_angles[corner]):.2f}.",
            "Lower min_angle there, or give the patch more room: a curve that is less straight at this corner.",
            where=boundary.place(corner),
            amount=float(short[corner]),
            unit="rad",
        )
    worst = int(np.argmax(mesh.flattenability))
    amount = mesh.max_flattenability
    if amount <= tolerance:
        return
    where = f"vertex {worst} at {spoken(mesh.vertices[worst])} mm, {_next_to(boundary, mesh.vertices[worst])}"
    rounds = parameters.stuck_rounds if isinstance(parameters, FairParameters) else 0
    # Out of steps it was still on its way; refined round in vain it is stuck.
    stuck = rounds > 0 and mesh.status != "step_limit"
    tried = f" and {rounds} rounds of refinement" if stuck else ""
    raise PatchFailure.of(
        "stuck_vertex" if stuck else "not_converged",
        "flattenable_mesh",
        f"{where}, is {amount:.2e} rad from flattenable after {mesh.steps} steps of '{mesh.method}'{tried} "
        f"({mesh.status}); {tolerance:.0e} was asked for. {asked.statement}",
        _way_out(asked, "a smaller edge_length" if stuck else "more steps (max_steps), a smaller edge_length"),
        where=where,
        amount=amount,
        unit="rad",
    )


def _next_to(boundary: BoundaryCurve, point: Floats) -> str:
    """Words for how far a point is from the two nearest of the curves round the patch."""
    distances = np.linalg.norm(boundary.vertices - point, axis=1)
    n = len(distances)
    nearest = []
    for stretch in boundary.stretches:
        ids = (stretch.first + np.arange(stretch.count)) % n
        vertex = int(ids[np.argmin(distances[ids])])
        nearest.append((float(distances[vertex]), boundary.place(vertex)))
    return " and ".join(f"{distance:.1f} mm from {place}" for distance, place in sorted(nearest)[:2])


def _way_out(asked: Asked, otherwise: str) -> str:
    """What to do about a patch that was not found, by whether its normals stand in the way."""
    if asked.contradicts:
        return f"{asked.remedy('there')} Or lower normal_weight, so that they may give way."
    return f"The method did not find the way: try {otherwise}, a lower normal_weight, or cut the patch in two there."


def _fold(mesh: FlattenableMesh, asked: Asked) -> Finding | None:
    """The finding `folded` where a hinge is sharper than `FOLD`."""
    hinges = hinges_of(mesh.triangles)
    angles = np.abs(hinge_angles(mesh.vertices, hinges))
    if angles.max(initial=0.0) <= FOLD:
        return None
    worst = int(np.argmax(angles))
    where = f"edge at {spoken(mesh.vertices[hinges[worst, 0]])} mm"
    return Finding(
        "folded",
        "flattenable_mesh",
        f"the mesh folds by {np.degrees(angles[worst]):.0f} degrees at the {where}; "
        f"{int((angles > FOLD).sum())} edges fold by more than {np.degrees(FOLD):.0f}. {asked.statement}",
        _way_out(asked, "a smaller edge_length"),
        where=where,
        amount=float(np.degrees(angles[worst])),
        unit="deg",
    )


def _check_outline(outline: Floats, boundary: BoundaryCurve) -> None:
    crossings = polygon_crossings(outline, boundary.vertices)
    if not crossings:
        return
    i, s, j, t = crossings[0]
    where = f"{boundary.place(i + s)} and {boundary.place(j + t)}"
    places = "one place" if len(crossings) == 1 else f"{len(crossings)} places, first"
    raise PatchFailure.of(
        "self_intersection",
        "unfold",
        f"the flat piece overlaps itself at {places} between {where}.",
        "A cut that separates these two places solves it.",
        where=where,
        amount=float(len(crossings)),
        unit="crossings",
    )
