"""What a maker should know about what was made: where a patch wrinkles or cuts into the surface, where a seam kinks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding, spoken
from flatnet.fitting.results import FittedPatch
from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import angles_between
from flatnet.geometry.wrinkles import WRINKLED
from flatnet.network.network import SampledStretch
from flatnet.report.summary import counted

Floats = NDArray[np.float64]

#: From this angle between the sheets on, beyond that of the given normals, a seam has a kink, rad.
KINK = np.radians(30.0)


def patch_warnings(
    fitted: FittedPatch, heights: Floats | None, clearance: float, of_original: Floats | None = None
) -> list[Finding]:
    """The warnings about a finished patch.

    Parameters
    ----------
    heights : (m,) float, mm: of its vertices over the reference surface; None where there is none.
    clearance : how far below it they may lie, mm.
    of_original : of a mirror image, the heights of its original.
    """
    warnings = []
    if fitted.mesh.wrinkles.wrinkled and not fitted.patch.wrinkles_expected:
        warnings.append(wrinkled(fitted))
    if len(fitted.mesh.self_intersections):
        warnings.append(_passes_through_itself(fitted))
    if heights is not None and heights.min() < -clearance:
        warnings.append(_inside_surface(fitted, heights, clearance))
    if heights is not None and fitted.patch.mirror_of is not None:
        rim = -np.arange(fitted.mesh.boundary_count)  # boundary vertex i is the image of vertex -i
        along = np.abs(heights[: len(rim)])
        drawn_off = 0.0 if of_original is None else np.abs(of_original[: len(rim)])[rim]
        if (along - drawn_off).max() > clearance:
            warnings.append(_off_surface(fitted, along - drawn_off))
    return warnings


def wrinkled(fitted: FittedPatch) -> Finding:
    """That a patch wrinkles: how much, and where most."""
    wrinkles = fitted.mesh.wrinkles
    where = _place(fitted, wrinkles.vertex)
    degrees = float(np.degrees(wrinkles.turning))
    folds = f"{counted(wrinkles.ridges, 'ridge')} and {counted(wrinkles.valleys, 'valley')}"
    return Finding(
        code="wrinkled",
        stage="report",
        where=where,
        amount=degrees,
        unit="deg",
        message=(
            f"it wrinkles: {folds}, {wrinkles.depth:.1f} mm from top to bottom, worst {where}, where the sheet turns "
            f"to and fro by {degrees:.0f} degrees within {wrinkles.reach:.0f} mm (a warning from "
            f"{np.degrees(WRINKLED):.0f} on)."
        ),
        remedy="Cut the patch there, lower normal_weight, or say `wrinkles: expected` if it is meant to.",
    )


def _passes_through_itself(fitted: FittedPatch) -> Finding:
    mesh = fitted.mesh
    where = _place(fitted, int(mesh.triangles[mesh.self_intersections[0, 0], 0]))
    count = len(mesh.self_intersections)
    return Finding(
        code="mesh_self_intersection",
        stage="report",
        where=where,
        amount=float(count),
        unit="pairs of triangles",
        message=f"it passes through itself in space: {counted(count, 'pair')} of triangles, the first {where}.",
        remedy="Cut the patch there, or move the curves on both sides of the place apart.",
    )


def _inside_surface(fitted: FittedPatch, heights: Floats, clearance: float) -> Finding:
    deepest = int(np.argmin(heights))
    where = _place(fitted, deepest)
    return Finding(
        code="inside_surface",
        stage="report",
        where=where,
        amount=float(-heights[deepest]),
        unit="mm",
        message=(
            f"it cuts into the surface by {-heights[deepest]:.1f} mm {where}; "
            f"{int((heights < -clearance).sum())} of its {len(heights)} vertices lie more "
            f"than {clearance:g} mm inside, the surface's `clearance`."
        ),
        remedy="Cut the patch there, raise its normal_weight, or allow it with a larger `clearance`.",
    )


def _off_surface(fitted: FittedPatch, along: Floats) -> Finding:
    worst = int(np.argmax(along))
    where = f"at {fitted.patch.boundary.place(worst)}, {spoken(fitted.mesh.vertices[worst])} mm"
    return Finding(
        code="off_surface",
        stage="report",
        where=where,
        amount=float(along[worst]),
        unit="mm",
        message=(
            f"as the mirror image of '{fitted.patch.mirror_of}' its boundary leaves the surface, which is "
            f"not the same on this side, by {along[worst]:.1f} mm more than that {where}."
        ),
        remedy="Draw this side by itself, or take a surface with two equal halves.",
    )


def _place(fitted: FittedPatch, vertex: int) -> str:
    """Words for a vertex of the mesh: the nearest place on the boundary, and where it is in space."""
    point = fitted.mesh.vertices[vertex]
    return f"near {fitted.patch.boundary.place_near(point)}, at {spoken(point)} mm"


def normal_gap(sampled: SampledStretch, patches: Sequence[str], gaps: Floats) -> Finding | None:
    """The warning where the sheets on both sides of a seam meet at an angle that nobody asked for.

    Parameters
    ----------
    gaps : (k,) float, rad: at every edge of the seam, the angle between the meshes beside it.
    """
    wanted = angles_between(sampled.left_normals, sampled.right_normals)
    excess = gaps - wanted
    worst = int(np.argmax(excess))
    if excess[worst] < KINK:
        return None
    middles = 0.5 * (sampled.vertices[:-1] + sampled.vertices[1:])
    along = polyline_length(sampled.vertices[: worst + 2])
    along -= 0.5 * float(np.linalg.norm(sampled.vertices[worst + 1] - sampled.vertices[worst]))
    where = f"'{sampled.name}' at {along:.1f} mm, at {spoken(middles[worst])} mm"
    degrees = float(np.degrees(gaps[worst]))
    meant = f" ({np.degrees(wanted[worst]):.0f} are given)" if wanted[worst] > 0.0 else ""
    return Finding(
        code="normal_gap",
        stage="report",
        where=where,
        amount=degrees,
        unit="deg",
        message=(
            f"{' and '.join(repr(name) for name in dict.fromkeys(patches))} meet at an angle along {where}: their "
            f"normals differ by {degrees:.0f} degrees{meant}, {int((excess >= KINK).sum())} of {len(gaps)} edges by "
            f"{np.degrees(KINK):.0f} or more."
        ),
        remedy="Raise normal_weight on both sides, cut across the patches there, or make the curve a crease.",
    )
