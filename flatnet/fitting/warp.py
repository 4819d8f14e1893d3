"""Warp the planar mesh M^p onto the boundary curve (paper 3.3, Eq. 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.failure import PatchFailure
from flatnet.fitting.results import PlanarMesh, WarpedMesh
from flatnet.geometry.polygon import edge_vectors
from flatnet.geometry.triangles import unit
from flatnet.network.patch import BoundaryCurve
from flatnet.solvers.rbf import fit_mirrored, fit_triharmonic

Floats = NDArray[np.float64]

#: Constraint points nearer to each other than this part of tau are merged: at a right-angled corner the T_in of
#: both edges coincide, and the system would be singular.
MERGE_DISTANCE = 0.1
#: Boundary vertices nearer than this part of tau, in the plane and in space, are one point.
SAME_POINT = 1e-6
#: Below this reciprocal condition the solution has no digit left.
SINGULAR = 1e-15
#: More constraint points than this (about 500 boundary edges) are solved by what their symmetry leaves: the same map
#: to round-off, in a quarter of the time and a third of the memory.
MOST_WITHOUT_SYMMETRY = 2500
#: B must be interpolated to this part of its size, and M^0 must stay within this many sizes of it.
INTERPOLATION_TOLERANCE, FARTHEST = 1e-6, 3.0


def warp(planar: PlanarMesh, boundary: BoundaryCurve, cross_tangents: bool = True) -> WarpedMesh:
    """Carry M^p to M^0, which interpolates B and approximates its normals.

    A triharmonic RBF takes constraint points on and around the planar boundary to their partners on B: the
    vertices, mid-edge points lifted by tau / 2 along the normals and as far against them, and mid-edge points
    moved out and in by tau / 2 along the cross-tangents (T_out, T_in; their planar partners are moved across B^p
    as far, which the paper leaves out). tau is the mean edge length of M^p. The paper lifts to one side only;
    with both a patch and the same patch seen from the other side have one M^0.

    Parameters
    ----------
    planar : M^p; its first n vertices are the boundary, in the order of `boundary`.
    boundary : B, (n, 3) vertices in mm and (n, 3) unit edge normals.
    cross_tangents : False leaves out T_out and T_in (Fig. 6a).

    Raises
    ------
    PatchFailure
        `warp_singular` where the constraint points are degenerate, found by condition and by result.
    """
    tau = planar.mean_edge
    outline = planar.positions[: planar.boundary_count]
    sources, targets = constraint_points(outline, boundary, tau, cross_tangents)
    sources, targets = merge_near(sources, targets, tau, fixed=len(outline))
    # Lifted to both sides, the constraint points are mirrored by the plane, and M^p lies in it.
    fit = fit_triharmonic if len(sources) <= MOST_WITHOUT_SYMMETRY else fit_mirrored
    mapping = fit(sources, targets)
    flat = np.column_stack([planar.positions, np.zeros(len(planar.positions))])
    vertices = mapping(flat)
    _check(vertices, boundary, mapping.reciprocal_condition)
    vertices[: planar.boundary_count] = boundary.vertices
    return WarpedMesh(vertices, planar.triangles, planar.boundary_count)


def constraint_points(
    outline: Floats, boundary: BoundaryCurve, tau: float, cross_tangents: bool
) -> tuple[Floats, Floats]:
    """V^p and V of Eq. 3, (k, 3) each: vertices, points lifted to both sides, then T_out and T_in."""
    flat = np.column_stack([outline, np.zeros(len(outline))])
    flat_edge, edge = edge_vectors(flat), edge_vectors(boundary.vertices)
    flat_middle, middle = flat + 0.5 * flat_edge, boundary.vertices + 0.5 * edge
    up = np.array([0.0, 0.0, 1.0])
    reach = 0.5 * tau
    sources = [flat, flat_middle + reach * up, flat_middle - reach * up]
    targets = [boundary.vertices, middle + reach * boundary.normals, middle - reach * boundary.normals]
    if cross_tangents:
        flat_out = np.cross(unit(flat_edge), up)
        out = np.cross(unit(edge), boundary.normals)
        sources += [flat_middle + reach * flat_out, flat_middle - reach * flat_out]
        targets += [middle + reach * out, middle - reach * out]
    return np.concatenate(sources), np.concatenate(targets)


def merge_near(sources: Floats, targets: Floats, tau: float, fixed: int) -> tuple[Floats, Floats]:
    """One point for every cluster of sources nearer than `MERGE_DISTANCE` tau.

    The first `fixed`, boundary vertices, are not moved: a point near one is dropped for it, and of two vertices
    at one place with one partner (the sides of a closed slit) the first stays. Others become their average, and
    so do their partners.
    """
    pairs = cKDTree(sources).query_pairs(MERGE_DISTANCE * tau, output_type="ndarray")
    pairs = np.sort(pairs, axis=1)
    apart = np.maximum(
        *(np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) for points in (sources, targets))
    )
    pairs = pairs[(pairs[:, 1] >= fixed) | (apart <= SAME_POINT * tau)]
    leader = np.arange(len(sources))
    for a, b in pairs[np.lexsort(pairs.T[::-1])]:
        leader[b] = min(leader[b], leader[a])
    merged_sources, merged_targets = [], []
    for first in np.unique(leader):
        members = np.flatnonzero(leader == first) if first >= fixed else np.array([first])
        merged_sources.append(sources[members].mean(axis=0))
        merged_targets.append(targets[members].mean(axis=0))
    return np.array(merged_sources), np.array(merged_targets)


def _check(vertices: Floats, boundary: BoundaryCurve, reciprocal_condition: float) -> None:
    centre = boundary.vertices.mean(axis=0)
    size = float(np.linalg.norm(boundary.vertices - centre, axis=1).max())
    miss = float(np.linalg.norm(vertices[: len(boundary.vertices)] - boundary.vertices, axis=1).max())
    reach = float(np.linalg.norm(vertices - centre, axis=1).max())
    remedy = "Edges of very different length next to each other, or a boundary that touches itself, do this."
    if not (reciprocal_condition > SINGULAR and miss <= INTERPOLATION_TOLERANCE * size):
        raise PatchFailure.of(
            "warp_singular",
            "warp",
            f"the warp's equations are singular (reciprocal condition {reciprocal_condition:.1e}, "
            f"boundary missed by {miss:.3g} mm).",
            remedy,
            amount=miss,
            unit="mm",
        )
    if not reach <= FARTHEST * size:
        raise PatchFailure.of(
            "warp_singular",
            "warp",
            f"the warped mesh flies {reach:.3g} mm off a boundary of radius {size:.3g} mm.",
            remedy,
            amount=reach,
            unit="mm",
        )
