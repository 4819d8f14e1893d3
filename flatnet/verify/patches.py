"""Check the written meshes: a disk whose flat shape is its shape in space, on the curves of the network."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flatnet.verify.build import WrittenPatch
from flatnet.verify.measured import ANGLE_SUM, STRAIN, Measured
from flatnet.verify.mesh import covered_twice

#: Of the area of an outline: what its self-contact may cover twice by round-off.
TOUCH = 1e-12


def check_patch(patch: WrittenPatch) -> Iterator[Measured]:
    """Disk, angle sums, strain of the edges, orientation of the triangles, outline.

    Where the material gives, edges inside may be strained up to its limit, angle sums are free, and the boundary is
    as exact as ever.
    """
    mesh, file, name = patch.mesh, patch.file, patch.name
    yield Measured("a disk", file, name, float(len(mesh.faults)), 0.0, words="; ".join(mesh.faults))
    if mesh.faults:
        return
    if patch.strain_limit > 0.0:
        allowed = patch.strain_limit + STRAIN
        yield Measured("strain within what the material gives", file, name, _worst(mesh.strain), allowed)
    else:
        yield Measured("angle sums", file, name, _worst(mesh.defects), ANGLE_SUM, "rad")
        yield Measured("edge strain", file, name, _worst(mesh.strain), STRAIN)
    yield Measured("boundary strain", file, name, _worst(mesh.boundary_strain), STRAIN)
    flipped = int((~(mesh.flat_areas > 0.0)).sum())
    yield Measured("flipped triangles", file, name, float(flipped), 0.0, words=f"{flipped} of {len(mesh.triangles)}")
    area = abs(float(mesh.flat_areas.sum()))
    yield Measured("outline simple", file, name, covered_twice(mesh.outline), TOUCH * area, "mm^2", "it crosses itself")


def _worst(amounts: np.ndarray) -> float:
    """The largest, nan if there is one; 0 of none."""
    return float(amounts.max(initial=0.0))
