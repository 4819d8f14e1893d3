"""What is measured along the seams: lengths on both sides and in space, and the angle between their normals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from flatnet.fitting.results import FittedPatch
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import Patch, Stretch
from flatnet.report.metrics import angles_between, boundary_triangle_normals

Floats = NDArray[np.float64]


def seam_records(network: CurveNetwork, fitted: Mapping[str, FittedPatch]) -> list[dict[str, object]]:
    """The `seams` of report.json: every stretch that at least one patch runs along."""
    sides: dict[str, list[tuple[Patch, Stretch]]] = {name: [] for name in network.stretches}
    for patch in network.patches:
        for stretch in patch.boundary.stretches:
            sides[stretch.seam].append((patch, stretch))
    return [_record(network.stretches[name], used, fitted) for name, used in sides.items() if used]


def _record(
    seam: SampledStretch, sides: Iterable[tuple[Patch, Stretch]], fitted: Mapping[str, FittedPatch]
) -> dict[str, object]:
    vertices, normals = [], []
    flat_lengths: list[float | None] = []  # None for a patch that could not be made
    for patch, stretch in sides:
        ids = side_vertices(stretch, len(patch.boundary.vertices))
        vertices.append({"patch": patch.name, "vertices": ids.tolist()})
        made = fitted.get(patch.name)
        flat_lengths.append(_length(made.outline[ids]) if made else None)
        if made:
            normals.append(_mesh_normals(made, stretch))
    first, second = [*flat_lengths, None][:2]
    gap = float(np.degrees(angles_between(*normals).max())) if len(normals) == 2 else None
    return {
        "curve": seam.name,
        "patches": [side["patch"] for side in vertices],
        "length_3d_mm": seam.length,
        "length_a_mm": first,
        "length_b_mm": second,
        "difference_mm": abs(first - second) if first is not None and second is not None else None,
        "max_normal_gap_deg": gap,
        "from": seam.start,
        "to": seam.end,
        "sides": vertices,
    }


def side_vertices(stretch: Stretch, boundary_count: int) -> NDArray[np.int64]:
    """The boundary vertices along a stretch, in the seam's own direction, (count + 1,)."""
    ids = (stretch.first + np.arange(stretch.count + 1)) % boundary_count
    return ids[::-1] if stretch.reversed else ids


def _mesh_normals(fitted: FittedPatch, stretch: Stretch) -> Floats:
    mesh = fitted.mesh
    normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, mesh.boundary_count)
    along = normals[(stretch.first + np.arange(stretch.count)) % mesh.boundary_count]
    return along[::-1] if stretch.reversed else along


def _length(points: Floats) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
