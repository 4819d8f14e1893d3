"""Fit one boundary with all stages and measure what comes out; how many edges give a wanted mesh size."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import FailedPatch, FittedPatch, PlanarMesh, WarpedMesh
from flatnet.fitting.run import run_patch
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from flatnet.geometry.triangles import corner_angles, hinge_angles, hinges_of, signed_areas, vertex_sums
from flatnet.network.patch import BoundaryCurve, Patch
from flatnet.parameters import FairParameters, FittingParameters
from flatnet.report.metrics import metrics
from tests.benchmark.boundaries import CASES, HOOKED, case

#: What every patch must reach: flattenability, rad; strain after unfolding; hinge, degrees; smallest angle, degrees.
EXACT, STRAIN, FOLD, SMALLEST_ANGLE = 1e-9, 1e-8, 120.0, 15.0
#: No hinge above this or that of M^0 and a little, degrees.
HINGE, HINGE_MORE = 90.0, 5.0
#: A boundary corner sharper than this may have smaller triangle angles, degrees.
SHARP = 30.0


@dataclass(frozen=True, eq=False)
class Fit:
    """One run: its figures, and the patch where there is one."""

    name: str
    record: dict[str, Any]
    fitted: FittedPatch | None

    @property
    def seconds(self) -> float:
        return sum(self.record["seconds"].values())


def fit(
    name: str, boundary: BoundaryCurve, edge_length: float, parameters: FittingParameters | None = None
) -> Fit:
    """All stages and their measures; a failure is named in the record."""
    result = run_patch(Patch(name, boundary, edge_length, "sheet"), parameters or FairParameters())
    seconds = dict(result.seconds or {})
    record = {"name": name, "boundary_edges": len(boundary.vertices), "seconds": seconds}
    if isinstance(result, FailedPatch):
        return Fit(name, record | {"status": result.failure.code, "message": result.failure.message}, None)
    return Fit(name, record | {"status": "ok"} | measures(result), result)


def initial_meshes(boundary: BoundaryCurve, edge_length: float) -> tuple[PlanarMesh, WarpedMesh]:
    """M^p and M^0 of a boundary."""
    planar = tessellate(fit_planar_boundary(boundary), edge_length)
    return planar, warp(planar, boundary)


def measures(fitted: FittedPatch) -> dict[str, Any]:
    """The figures of a patch, angles in degrees."""
    mesh, warped = fitted.mesh, fitted.warped
    all_of_it = metrics(fitted, None)
    angles = np.degrees(corner_angles(mesh.vertices, mesh.triangles))
    sums = vertex_sums(mesh.triangles, angles.ravel(), len(mesh.vertices))
    blunt = sums[mesh.triangles] >= SHARP
    before = hinge_angles(warped.vertices, hinges_of(warped.triangles))
    return {
        "vertices": len(mesh.vertices),
        "triangles": len(mesh.triangles),
        "steps": mesh.steps,
        "c": mesh.max_flattenability,
        "E": all_of_it["bending"],
        "dihedral": all_of_it["max_dihedral_deg"],
        "dihedral_m0": float(np.degrees(np.abs(before).max(initial=0.0))),
        "normals": all_of_it["mean_normal_deviation_deg"],
        "normals_max": all_of_it["max_normal_deviation_deg"],
        "angle": float(angles.min()),
        "angle_blunt": float(angles[blunt].min()),
        "self_intersections": all_of_it["self_intersections_3d"],
        "flipped": all_of_it["flipped_triangles"],
        "strain": fitted.max_edge_strain,
    }


def shortcomings(record: Mapping[str, Any], bending: float | None = None) -> list[str]:
    """Which of the demands on every patch it misses, in a few words; `bending` is the E to reach."""
    if record["status"] != "ok":
        return [record["status"]]
    limits = {
        "c": EXACT,
        "strain": STRAIN,
        "dihedral": min(FOLD, max(HINGE, record["dihedral_m0"] + HINGE_MORE)),
        "self_intersections": 0,
        "flipped": 0,
    }
    if bending is not None:
        limits["E"] = bending
    short = [key for key, limit in limits.items() if not record[key] <= limit]
    return short + ["angle"] * (record["angle_blunt"] < SMALLEST_ANGLE)


def edges_for(make: Callable[[int], BoundaryCurve], ratio: float, vertices: int) -> int:
    """How many boundary edges give a mesh of about so many vertices; within a few percent.

    A mesh of edge length l on an area A has A / (l^2 sqrt(3) / 2) vertices, half a boundary of n more.

    Parameters
    ----------
    make : the boundary of n edges.
    ratio : edge length of the mesh over that of the boundary.
    """
    planar = fit_planar_boundary(make(100)).positions
    following = np.roll(planar, -1, axis=0)
    perimeter = np.linalg.norm(following - planar, axis=1).sum()
    fan = np.stack([np.zeros(len(planar) - 2, int), np.arange(1, len(planar) - 1), np.arange(2, len(planar))], 1)
    area = signed_areas(planar, fan).sum()
    square = area / (np.sqrt(0.75) * ratio**2 * perimeter**2)
    n = (np.sqrt(0.25 + 4.0 * square * vertices) - 0.5) / (2.0 * square)
    return 4 * round(n / 4)


def sized_case(name: str, vertices: int) -> tuple[BoundaryCurve, float]:
    """One of the boundaries with its edge length, for a mesh of about so many vertices."""
    n = edges_for(lambda n: case(name, n)[0], (CASES | HOOKED)[name][1], vertices)
    return case(name, n)
