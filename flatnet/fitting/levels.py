"""Run the default method coarse to fine, and on fresh tessellations of what it found.

On a fine mesh the method finds worse minima, and slowly: the long waves of the sheet take many of its steps. On a
coarse one it is quick to find the shape, which the finer ones keep. And M^p is not the final pattern: the outline
moves on the way to a flattenable mesh and the triangles of M^p with it. A mesh that is regular in its own flat shape
bends more freely, so the shape is meshed anew as long as it is far from the mesh it was found on.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatnet.failure import PatchFailure
from flatnet.fitting.fair import RoughFit, roughly_fit, roughly_refit
from flatnet.fitting.remesh import carried_over, flat_boundary, rest_strain
from flatnet.fitting.results import FlattenableMesh, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.unfold import unfold
from flatnet.fitting.warp import warp
from flatnet.geometry.triangles import corner_angles, vertex_sums
from flatnet.network.patch import Patch
from flatnet.parameters import MOST_NORMAL_WEIGHT, MOST_SHAPE_WEIGHT, FairParameters
from flatnet.solvers.constrained_descent import CONVERGED

#: A mesh whose edges have left those of M^p by more than this (root mean square) is meshed anew.
REMESH_STRAIN = 0.08
#: A fresh tessellation does not take the place of a mesh without thinner triangles than this, rad, if it ends with
#: some; triangles at boundary corners sharper than `SHARP` have no choice.
THIN, SHARP = np.radians(15.0), np.radians(30.0)
#: A fit that is still rough counts as thin below this, rad: the last steps take a degree off.
NEARLY_THIN = np.radians(16.0)
#: By how much the weights of strain, area and normals grow for the stiffer sheet that follows where triangles are thin.
STIFF_STRAIN, STIFF_AREA, STIFF_NORMALS = 10.0, 20.0, 2.0
#: The coarsest level has at the most about so many vertices, and each has a quarter of the next finer one's ...
COARSE_VERTICES = 900
#: ... but where the boundary's edges are short it may not get below this part of them: then there is one level.
WORTH_WHILE = 0.6


def fit_in_levels(
    warped: WarpedMesh,
    planar: PlanarMesh,
    planar_boundary: PlanarBoundary,
    patch: Patch,
    parameters: FairParameters,
) -> FlattenableMesh:
    """M, on a tessellation with the patch's edge length.

    Parameters
    ----------
    warped, planar : M^0 and M^p at the patch's edge length; where a coarser level can't be made flattenable,
        the method starts from them.
    """
    coarse = _coarse_start(planar, planar_boundary, patch)
    if coarse is not None:
        coarse_planar, coarse_warped, lengths = coarse
        fits = _rounds(coarse_warped, coarse_planar, lengths[0], planar_boundary, patch, parameters)
        finer: RoughFit | None = fits[-1]
        for length in lengths[1:]:
            # A finer mesh keeps what the coarser one has settled on; from a rough one it finds a worse minimum.
            finer = _on_fresh_mesh(finer.settled(), length, planar_boundary, patch) if finer is not None else None
        if finer is not None:
            mesh = _finished([finer], planar_boundary, patch)
            if mesh.status == CONVERGED:
                return mesh
    return _finished(
        _rounds(warped, planar, patch.edge_length, planar_boundary, patch, parameters), planar_boundary, patch
    )


def _coarse_start(
    planar: PlanarMesh, planar_boundary: PlanarBoundary, patch: Patch
) -> tuple[PlanarMesh, WarpedMesh, list[float]] | None:
    """M^p and M^0 of the coarsest level and the edge lengths of all levels; None where one level is enough."""
    count = len(planar.positions)
    halvings = int(np.ceil(np.log(count / COARSE_VERTICES) / np.log(4.0)))
    if halvings <= 0:
        return None
    lengths = [patch.edge_length * 2.0**level for level in range(halvings, -1, -1)]
    coarse = tessellate(planar_boundary, lengths[0])
    if len(coarse.positions) > WORTH_WHILE * count:
        return None
    return coarse, warp(coarse, patch.boundary), lengths


def _rounds(
    warped: WarpedMesh,
    planar: PlanarMesh,
    edge_length: float,
    planar_boundary: PlanarBoundary,
    patch: Patch,
    parameters: FairParameters,
) -> list[RoughFit]:
    """From M^0, meshed anew as long as M is far from the mesh it was found on; the last is the one to take."""
    fit = roughly_fit(warped, patch.boundary, planar, parameters)
    fits = [fit]
    for _ in range(parameters.remesh_rounds):
        if not fit.arrived or rest_strain(fit.planar, fit.mesh) <= REMESH_STRAIN:
            break
        again = _on_fresh_mesh(fit, edge_length, planar_boundary, patch)
        if again is None:
            break
        fit = again
        if _smallest_angle(fit.mesh) >= THIN or _smallest_angle(fits[-1].mesh) < THIN:
            fits.append(fit)
    return fits


def _finished(fits: list[RoughFit], planar_boundary: PlanarBoundary, patch: Patch) -> FlattenableMesh:
    """M of the last fit, on a stiffer sheet where its triangles are thin; the first fit's where that does not converge.

    Normals that contradict a flat sheet strain single triangles of it. Meshed anew and with more weight on lengths and
    areas the same shape keeps the triangles of its mesh; twice the weight of the normals holds it to them.
    """
    tried = [fits[0], fits[-1]] if len(fits) > 1 else [fits[0]]
    parameters = fits[0].parameters
    if parameters.remesh_rounds and fits[-1].arrived and _smallest_angle(fits[-1].mesh) < NEARLY_THIN:
        stiff = replace(
            parameters,
            strain_weight=min(STIFF_STRAIN * parameters.strain_weight, MOST_SHAPE_WEIGHT),
            area_weight=min(STIFF_AREA * parameters.area_weight, MOST_SHAPE_WEIGHT),
            normal_weight=min(STIFF_NORMALS * parameters.normal_weight, MOST_NORMAL_WEIGHT),
        )
        again = _on_fresh_mesh(fits[-1], patch.edge_length, planar_boundary, patch, stiff)
        if again is not None and _smallest_angle(again.mesh) > _smallest_angle(fits[-1].mesh):
            tried.append(again)
    for fit in reversed(tried):
        mesh = fit.finished()
        if mesh.status == CONVERGED:
            break
    return mesh


def _smallest_angle(mesh: FlattenableMesh) -> float:
    """Of the triangles' angles at vertices that are not sharp corners of the boundary, rad."""
    angles = corner_angles(mesh.vertices, mesh.triangles)
    sums = vertex_sums(mesh.triangles, angles.ravel(), len(mesh.vertices))
    return float(angles[sums[mesh.triangles] >= SHARP].min(initial=np.pi))


def _on_fresh_mesh(
    fit: RoughFit,
    edge_length: float,
    planar_boundary: PlanarBoundary,
    patch: Patch,
    stiff: FairParameters | None = None,
) -> RoughFit | None:
    """M on a new tessellation of its own flat outline; None where that can't be made flattenable.

    stiff : the parameters to fit with, where they are not those of the patch.
    """
    if not fit.arrived:
        return None
    mesh = fit.mesh
    try:
        flat = unfold(mesh)
        planar = tessellate(flat_boundary(flat, planar_boundary), edge_length)
    except PatchFailure:  # the flat outline crosses itself
        return None
    carried = carried_over(mesh, flat, planar, fit.parameters.normal_weight)
    again = roughly_refit(carried, patch.boundary, planar, stiff or fit.parameters)
    if not again.arrived:
        return None
    steps = mesh.steps + again.mesh.steps
    return replace(again, mesh=replace(again.mesh, steps=steps, parameters=mesh.parameters))
