"""A seam that was found, as a curve of the project: what the project file would say of it."""

from __future__ import annotations

from flatnet.network.network import SampledStretch
from flatnet.project.curve_specs import CurveSpec, NormalList, NormalSpec
from flatnet.project.patch_specs import PatchSpec


def seam_spec(seam: SampledStretch, patch: PatchSpec) -> CurveSpec:
    """The polyline through the seam's vertices, with a normal per segment, that divides a patch."""
    normals = NormalList(per="segment", values=seam.left_normals)
    return CurveSpec(
        name=seam.name,
        start=seam.start,
        end=seam.end,
        points=tuple(seam.vertices[1:-1]),
        closed=False,
        kind="polyline",
        on_surface=False,
        slit=False,
        edge_length=patch.edge_length,
        normals=NormalSpec("given", normals, normals),
        mark=patch.mark,
    )
