"""What is measured on a fitted patch; docs/report.md says what every figure means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.fitting.results import FittedPatch
from flatnet.geometry.asked_curvature import least_normal_deviation
from flatnet.geometry.boundary_triangulation import triangulate_boundary
from flatnet.geometry.triangles import (
    angles_between,
    bending,
    boundary_triangle_normals,
    corner_angles,
    hinge_angles,
    hinges_of,
    signed_areas,
)
from flatnet.geometry.wrinkles import Wrinkles
from flatnet.network.patch import BoundaryCurve

Floats = NDArray[np.float64]

#: The triangulation of the boundary alone is looked for up to so many edges: it takes 0.4 s there, n^3.
MOST_ALONE = 200


def normal_deviations(fitted: FittedPatch) -> Floats:
    """Angle between the given normal and that of the mesh at every boundary edge, (n,), rad."""
    return fitted.mesh.normal_deviations(fitted.patch.boundary.normals)


def boundary_error(fitted: FittedPatch) -> float:
    """Largest distance of a boundary vertex of the mesh from its place on B, mm."""
    boundary: BoundaryCurve = fitted.patch.boundary
    on_mesh = fitted.mesh.vertices[: fitted.mesh.boundary_count]
    return float(np.linalg.norm(on_mesh - boundary.vertices, axis=1).max())


def surface_distance(heights: Floats) -> dict[str, float]:
    """The `surface_distance_mm` of a patch whose vertices lie so far outside (positive) or inside the surface."""
    return {
        "mean": float(np.abs(heights).mean()),
        "max": float(np.abs(heights).max()),
        "max_outside": float(heights.max(initial=0.0)),
        "max_inside": float((-heights).max(initial=0.0)),
    }


def wrinkle_record(wrinkles: Wrinkles) -> dict[str, float]:
    """The `wrinkles` of a patch in report.json."""
    return {
        "turning_deg": float(np.degrees(wrinkles.turning)),
        "reach_mm": wrinkles.reach,
        "ridges": wrinkles.ridges,
        "valleys": wrinkles.valleys,
        "depth_mm": wrinkles.depth,
    }


def boundary_alone(boundary: BoundaryCurve) -> dict[str, float] | None:
    """The baseline: what a triangulation of the boundary without a vertex inside bends, and leaves of the normals.

    It is always exactly flattenable. None for more than `MOST_ALONE` edges, where finding it takes too long.
    """
    vertices = boundary.vertices
    if len(vertices) > MOST_ALONE:
        return None
    triangles = triangulate_boundary(vertices, boundary.normals)
    if not len(triangles):
        return None
    normals = boundary_triangle_normals(vertices, triangles, len(vertices))
    return {
        "bending": bending(vertices, triangles),
        "max_dihedral_deg": float(np.degrees(np.abs(hinge_angles(vertices, hinges_of(triangles))).max(initial=0.0))),
        "mean_normal_deviation_deg": float(np.degrees(angles_between(normals, boundary.normals)).mean()),
    }


def metrics(fitted: FittedPatch, heights: Floats | None) -> dict[str, object]:
    """The `metrics` of a patch in report.json.

    Parameters
    ----------
    heights : (m,) float, mm: of its vertices over the reference surface; None where there is none.
    """
    mesh = fitted.mesh
    deviations = np.degrees(normal_deviations(fitted))
    hinges = hinges_of(mesh.triangles)
    areas = signed_areas(fitted.flat, mesh.triangles)
    return {
        "vertices": len(mesh.vertices),
        "triangles": len(mesh.triangles),
        "max_flattenability_rad": mesh.max_flattenability,
        "mean_flattenability_rad": mesh.mean_flattenability,
        "initial_max_flattenability_rad": fitted.warped.max_flattenability,
        "max_edge_strain": fitted.max_edge_strain,
        "strain_limit": fitted.patch.strain,
        "mean_edge_strain": fitted.mean_edge_strain,
        "max_boundary_strain": fitted.max_boundary_strain,
        "boundary_error_mm": boundary_error(fitted),
        "asked_curvature_rad": fitted.planar_boundary.asked_curvature,
        "least_normal_deviation_deg": float(
            np.degrees(least_normal_deviation(fitted.patch.boundary.vertices, fitted.planar_boundary.predicted_angles))
        ),
        "angle_error": fitted.planar_boundary.angle_error,
        "max_normal_deviation_deg": float(deviations.max()),
        "mean_normal_deviation_deg": float(deviations.mean()),
        "wrinkles": wrinkle_record(mesh.wrinkles),
        "surface_distance_mm": surface_distance(heights) if heights is not None else None,
        "lemma_2_margin_rad": fitted.planar_boundary.lemma_2_margin,
        "max_dihedral_deg": float(np.degrees(np.abs(hinge_angles(mesh.vertices, hinges)).max(initial=0.0))),
        "bending": bending(mesh.vertices, mesh.triangles),
        "boundary_alone": boundary_alone(fitted.patch.boundary),
        "min_triangle_angle_deg": float(np.degrees(corner_angles(fitted.flat, mesh.triangles).min())),
        "flipped_triangles": int((areas <= 0.0).sum()),
        "self_intersections_3d": len(mesh.self_intersections),
        "area_mm2": float(areas.sum()),
    }
