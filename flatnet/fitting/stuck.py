"""Free a mesh that is stuck: let the normals in slowly, then refine round the vertices that keep a high value.

Flattenability depends on the triangulation (paper 5.1): a vertex may have too little freedom to reach 2 pi, or reach
it by a fold alone. The triangles round it are divided in the manner of sqrt(3)-subdivision. Other meshes are stuck
because normals that contradict a flat sheet are held too hard from the start.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import PatchFailure
from flatnet.fitting.fair import fit_fair, refit_fair
from flatnet.fitting.planar_boundary import canonical_frame
from flatnet.fitting.remesh import carried_over, flat_boundary
from flatnet.fitting.results import FlattenableMesh, PlanarBoundary, PlanarMesh, SurfaceMesh, WarpedMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from flatnet.geometry.delaunay import delaunay_flips, insert
from flatnet.geometry.smoothing import shape_smoothing
from flatnet.geometry.triangles import angle_sums, hinge_angles, hinges_of
from flatnet.network.patch import BoundaryCurve, Patch
from flatnet.parameters import FairParameters
from flatnet.solvers.constrained_descent import CONVERGED

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A hinge sharper than this is a fold, rad. On a mesh that was refined nothing may be sharper than `SHARP`: a fold
#: that is divided into two hinges is still one.
FOLD, SHARP = np.radians(120.0), np.radians(90.0)
#: The normals are let in at this weight, and it grows by this factor.
LIGHT, RISE = 1.0, 10.0
#: Vertices with more than this part of the worst value are stuck with it, a quarter of the mesh at the most.
HIGH, MOST = 0.1, 0.25
#: Steps of shape smoothing round the vertices that are put in.
SMOOTHING_STEPS = 3
#: A boundary this near to a plane, over its extent, lies in it.
IN_PLANE = 1e-9

Meshes = tuple[FlattenableMesh, WarpedMesh, PlanarMesh]


def freed(
    mesh: FlattenableMesh,
    warped: WarpedMesh,
    planar: PlanarMesh,
    planar_boundary: PlanarBoundary,
    patch: Patch,
    parameters: FairParameters,
) -> Meshes:
    """M where it is neither stuck nor folded, with the M^0 and M^p that it came from; else as it was.

    - A boundary that lies in a plane has its flat piece there.
    - A light `normal_weight` has a smooth solution more often, and the heavier ones may be reached from it.
    - In each of `stuck_rounds` rounds the triangles of M^p round the stuck vertices are divided. The method goes on
      from where it was, carried over; where that does not do, it starts again from the M^0 of the finer M^p.
    - Where nothing reaches the weight that was asked for, M is that of the heaviest one that was reached; its
      `parameters` say which.

    Parameters
    ----------
    mesh : what the method came to, on M^p or on a later tessellation.
    warped, planar : M^0 and M^p.
    """
    boundary, tolerance = patch.boundary, parameters.tolerance
    stuck = stuck_vertices(mesh, boundary, tolerance)
    if parameters.stuck_rounds == 0 or not len(stuck):
        return mesh, warped, planar
    level = _in_its_plane(planar_boundary, patch, mesh)
    if level is not None and not len(stuck_vertices(level, boundary, tolerance)):
        return level, warped, planar
    found: Meshes = mesh, warped, planar
    lighter = _let_in(warped, planar, boundary, parameters)
    if lighter is not None:
        found = lighter, warped, planar
        if lighter.parameters["normal_weight"] == parameters.normal_weight:
            return found
    if not np.array_equal(mesh.triangles, planar.triangles):  # meshed anew: the folds may have come with that
        mesh = fit_fair(warped, boundary, planar, parameters)
        stuck = stuck_vertices(mesh, boundary, tolerance)
        if not len(stuck):
            return mesh, warped, planar
    for _ in range(parameters.stuck_rounds):
        finer = refined(planar, stuck)
        carried = carried_over(mesh, planar.positions, finer, parameters.normal_weight)
        try:
            planar, warped = finer, warp(finer, boundary)
        except PatchFailure:  # its edges differ too much in length
            break
        mesh = refit_fair(carried, boundary, planar, parameters)
        stuck = stuck_vertices(mesh, boundary, tolerance, SHARP)
        if len(stuck):
            again = fit_fair(warped, boundary, planar, parameters)
            mesh = min(mesh, again, key=_badness)
            stuck = stuck_vertices(mesh, boundary, tolerance, SHARP)
        if not len(stuck):
            return mesh, warped, planar
    return found


def _let_in(
    warped: WarpedMesh, planar: PlanarMesh, boundary: BoundaryCurve, parameters: FairParameters
) -> FlattenableMesh | None:
    """M with the heaviest weight of the normals up to that of `parameters` that was reached, from light to heavy."""
    weight = LIGHT
    mesh = None
    while weight < RISE * parameters.normal_weight and parameters.normal_weight > LIGHT:
        held = replace(parameters, normal_weight=min(weight, parameters.normal_weight))
        heavier = (
            fit_fair(warped, boundary, planar, held)
            if mesh is None
            else refit_fair(WarpedMesh(mesh.vertices, mesh.triangles, mesh.boundary_count), boundary, planar, held)
        )
        if len(stuck_vertices(heavier, boundary, parameters.tolerance)):
            break
        mesh = heavier
        weight *= RISE
    return mesh


def stuck_vertices(
    mesh: SurfaceMesh, boundary: BoundaryCurve, tolerance: float, sharpest: float = FOLD
) -> Ints:
    """The vertices to refine round, worst first: far from flattenable, else at folds; none where M can be made.

    Where a hinge is sharper than `sharpest`, rad, the ends of all that are sharper than `SHARP` are stuck.

    A boundary vertex is stuck where its flat angle is below the least one that was asked for.
    """
    values = mesh.flattenability.copy()
    rim = slice(0, mesh.boundary_count)
    values[rim] = np.maximum(boundary.min_angles - angle_sums(mesh.vertices, mesh.triangles)[rim], 0.0)
    most = max(1, int(MOST * len(values)))
    if not values.max() <= tolerance:
        high = np.flatnonzero(values > max(tolerance, HIGH * values.max()))
        return high[np.argsort(-values[high], kind="stable")][:most]
    hinges = hinges_of(mesh.triangles)
    angles = np.abs(hinge_angles(mesh.vertices, hinges))
    if angles.max(initial=0.0) <= sharpest:
        return np.empty(0, dtype=np.int64)
    sharp = np.flatnonzero(angles > SHARP)
    ends = hinges[sharp[np.argsort(-angles[sharp], kind="stable")], :2].ravel()
    return np.array(list(dict.fromkeys(ends.tolist())), dtype=np.int64)[:most]


def refined(planar: PlanarMesh, stuck: Ints) -> PlanarMesh:
    """M^p with the triangles round some vertices divided: their centroids put in, the edges between them flipped.

    In a regular mesh the Delaunay flips are those of sqrt(3)-subdivision; elsewhere they make the better triangles,
    and no edge between two boundary vertices.
    """
    count = planar.boundary_count
    at = np.flatnonzero(np.isin(planar.triangles, stuck).any(axis=1))
    centroids = planar.positions[planar.triangles[at]].mean(axis=1)
    positions, triangles = insert(planar.positions, planar.triangles, centroids, at)
    triangles = delaunay_flips(positions, triangles, count)
    free = np.zeros(len(positions), dtype=bool)
    free[triangles[np.isin(triangles, stuck).any(axis=1)]] = True
    free[:count] = False
    return PlanarMesh(shape_smoothing(positions, triangles, free, SMOOTHING_STEPS), triangles, count)


def _badness(mesh: FlattenableMesh) -> tuple[bool, float, float]:
    """Smaller is better: converged before not, then the sharpest hinge, then the worst value."""
    worst = mesh.max_flattenability
    sharpest = float(np.abs(hinge_angles(mesh.vertices, hinges_of(mesh.triangles))).max(initial=0.0))
    if mesh.status == CONVERGED:
        return False, sharpest, worst
    return True, worst if np.isfinite(worst) else np.inf, sharpest


def _in_its_plane(
    planar_boundary: PlanarBoundary, patch: Patch, stuck: FlattenableMesh
) -> FlattenableMesh | None:
    """The flat mesh of a boundary that lies in a plane; None where it does not, or crosses itself there.

    There every gradient of an angle sum vanishes in the limit and the method's last digits do not come: normals
    that lean away from the plane keep it from settling.
    """
    vertices = patch.boundary.vertices
    centre = vertices.mean(axis=0)
    _, extents, axes = np.linalg.svd(vertices - centre, full_matrices=False)
    if extents[2] > IN_PLANE * extents[0]:
        return None
    up = axes[2] if patch.boundary.normals.sum(axis=0) @ axes[2] >= 0.0 else -axes[2]
    frame = np.stack([axes[0], np.cross(up, axes[0])])
    outline = canonical_frame((vertices - centre) @ frame.T)
    try:
        planar = tessellate(flat_boundary(outline, planar_boundary), patch.edge_length)
    except PatchFailure:
        return None
    # canonical_frame turns and shifts: the rigid motion back to space is the one that fits the outline.
    middle = outline.mean(axis=0)
    back, _, _, _ = np.linalg.lstsq(outline - middle, vertices - centre, rcond=None)
    flat = (planar.positions - middle) @ back + centre
    flat[: len(vertices)] = vertices
    return replace(stuck, vertices=flat, triangles=planar.triangles, status=CONVERGED)
