"""Fit one patch: the stages of the paper in order, and what counts as made."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flatnet.failure import PatchFailure
from flatnet.fitting.levels import fit_in_levels
from flatnet.fitting.multi_loop import multi_loop
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import FittedPatch, FlattenableMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.unfold import unfold
from flatnet.fitting.warp import warp
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.triangles import hinge_angles, hinges_of
from flatnet.network.patch import BoundaryCurve, Patch
from flatnet.parameters import FairParameters, FittingParameters

#: A hinge sharper than this is a fold, rad.
FOLD = np.radians(120.0)


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
        From the stage that could not do its part; `not_converged`, `folded` or `self_intersection` where the
        result is no patch that can be cut.
    """
    boundary = patch.boundary
    with _timed("planar_boundary", seconds):
        planar_boundary = fit_planar_boundary(boundary)
    with _timed("tessellation", seconds):
        planar = tessellate(planar_boundary, patch.edge_length, boundary.slit_tips)
    with _timed("warp", seconds):
        warped = warp(planar, boundary)
    with _timed("flattenable_mesh", seconds):
        if isinstance(parameters, FairParameters):
            mesh = fit_in_levels(warped, planar, planar_boundary, patch, parameters)
        else:
            mesh = multi_loop(warped, boundary, planar, parameters)
        _check_converged(mesh, boundary, parameters.tolerance)
        _check_folds(mesh)
    with _timed("unfold", seconds):
        flat = unfold(mesh, patch.grain)
        _check_outline(flat[: mesh.boundary_count], boundary)
    return FittedPatch(
        patch, planar_boundary, planar, warped, mesh, flat, planar_boundary.warnings, dict(seconds)
    )


@contextmanager
def _timed(stage: str, seconds: dict[str, float]) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = time.perf_counter() - start


def _point(mesh: FlattenableMesh, vertex: int) -> str:
    x, y, z = mesh.vertices[vertex]
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


def _check_converged(mesh: FlattenableMesh, boundary: BoundaryCurve, tolerance: float) -> None:
    worst = int(np.argmax(mesh.flattenability))
    amount = mesh.max_flattenability
    if amount <= tolerance:
        return
    nearest = int(np.argmin(np.linalg.norm(boundary.vertices - mesh.vertices[worst], axis=1)))
    where = f"vertex {worst} at {_point(mesh, worst)}, next to {boundary.place(nearest)}"
    raise PatchFailure.of(
        "not_converged",
        "flattenable_mesh",
        f"{where} is {amount:.2e} rad from flattenable after {mesh.steps} steps of '{mesh.method}' "
        f"({mesh.status}); {tolerance:.0e} was asked for.",
        "Cut the patch in two there, or lower normal_weight if the normals contradict a flat sheet.",
        where=where,
        amount=amount,
        unit="rad",
    )


def _check_folds(mesh: FlattenableMesh) -> None:
    hinges = hinges_of(mesh.triangles)
    angles = np.abs(hinge_angles(mesh.vertices, hinges))
    worst = int(np.argmax(angles))
    if angles[worst] <= FOLD:
        return
    where = f"edge at {_point(mesh, int(hinges[worst, 0]))}"
    raise PatchFailure.of(
        "folded",
        "flattenable_mesh",
        f"the mesh folds by {np.degrees(angles[worst]):.0f} degrees at the {where}; "
        f"{int((angles > FOLD).sum())} edges fold by more than {np.degrees(FOLD):.0f}.",
        "Cut the patch in two there, lower normal_weight, or use a smaller edge_length.",
        where=where,
        amount=float(np.degrees(angles[worst])),
        unit="deg",
    )


def _check_outline(outline: np.ndarray, boundary: BoundaryCurve) -> None:
    crossings = polygon_crossings(outline, boundary.vertices)
    if not crossings:
        return
    i, s, j, t = crossings[0]
    where = f"{boundary.place(i + s)} and {boundary.place(j + t)}"
    raise PatchFailure.of(
        "self_intersection",
        "unfold",
        f"the flat piece overlaps itself at {len(crossings)} places, first between {where}.",
        "A cut that separates these two places solves it.",
        where=where,
        amount=float(len(crossings)),
        unit="crossings",
    )


