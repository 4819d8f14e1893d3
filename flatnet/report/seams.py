"""What is measured along the seams: lengths and notches on both sides, the angle between their normals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from flatnet.fitting.results import FittedPatch
from flatnet.geometry.polygon import arclengths
from flatnet.geometry.triangles import angles_between, boundary_triangle_normals
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import Patch, Stretch
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.seams import Seam
from flatnet.report.warnings import normal_gap

Floats = NDArray[np.float64]


def seam_records(
    network: CurveNetwork, seams: Mapping[str, Seam], fitted: Mapping[str, FittedPatch]
) -> list[dict[str, object]]:
    """The `seams` of report.json: every stretch that at least one patch runs along."""
    sides: dict[str, list[tuple[Patch, Stretch]]] = {name: [] for name in network.stretches}
    for patch in network.patches:
        for stretch in patch.boundary.stretches:
            sides[stretch.seam].append((patch, stretch))
    return [_record(network.stretches[name], seams[name], used, fitted) for name, used in sides.items() if used]


def _record(
    sampled: SampledStretch,
    seam: Seam,
    sides: Iterable[tuple[Patch, Stretch]],
    fitted: Mapping[str, FittedPatch],
) -> dict[str, object]:
    vertices, normals = [], []
    along: list[Floats | None] = []  # flat arclengths of the vertices; None for a patch that could not be made
    for patch, stretch in sides:
        ids = side_vertices(stretch, len(patch.boundary.vertices))
        vertices.append({"patch": patch.name, "vertices": ids.tolist()})
        made = fitted.get(patch.name)
        along.append(arclengths(made.outline[ids]) if made else None)
        if made:
            normals.append(_mesh_normals(made, stretch))
    first, second = [*(None if side is None else float(side[-1]) for side in along), None][:2]
    gaps = angles_between(*normals) if len(normals) == 2 else None
    kink = normal_gap(sampled, [side["patch"] for side in vertices], gaps) if gaps is not None else None
    return {
        "curve": seam.name,
        "number": seam.number,
        "patches": [side["patch"] for side in vertices],
        "length_3d_mm": sampled.length,
        "length_a_mm": first,
        "length_b_mm": second,
        "difference_mm": abs(first - second) if first is not None and second is not None else None,
        "max_normal_gap_deg": float(np.degrees(gaps.max())) if gaps is not None else None,
        "warnings": [kink.as_dict()] if kink else [],
        "from": sampled.start,
        "to": sampled.end,
        "notches": [_walked(notch, *[*along, None][:2]) for notch in seam.notches],
        "sides": vertices,
    }


def _walked(notch: SeamNotch, *sides: Floats | None) -> dict[str, object]:
    """A notch and where it is met when both sew lines are walked from the seam's start."""
    first, second = (None if along is None else notch.met_at(along) for along in sides)
    return {"at_3d_mm": notch.arclength, "marks": notch.marks, "at_a_mm": first, "at_b_mm": second}


def side_vertices(stretch: Stretch, boundary_count: int) -> NDArray[np.int64]:
    """The boundary vertices along a stretch, in the seam's own direction, (count + 1,)."""
    ids = (stretch.first + np.arange(stretch.count + 1)) % boundary_count
    return ids[::-1] if stretch.reversed else ids


def _mesh_normals(fitted: FittedPatch, stretch: Stretch) -> Floats:
    mesh = fitted.mesh
    normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, mesh.boundary_count)
    along = normals[(stretch.first + np.arange(stretch.count)) % mesh.boundary_count]
    return along[::-1] if stretch.reversed else along
