"""Reflect a fitted patch: the mirror image is not fitted again, and so an exact one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatnet.failure import Finding
from flatnet.fitting.results import (
    FailedPatch,
    FittedPatch,
    FlattenableMesh,
    Floats,
    Ints,
    PlanarBoundary,
    PlanarMesh,
    SurfaceMesh,
    WarpedMesh,
)
from flatnet.geometry.mirror import MirrorPlane
from flatnet.network.mirror import images_of_boundary
from flatnet.network.patch import Patch

#: What the flat image of (x, y) is: the grain stays along +x.
FLIP = np.array([1.0, -1.0])


def reflect_patch(
    original: FittedPatch | FailedPatch, patch: Patch, plane: MirrorPlane
) -> FittedPatch | FailedPatch:
    """The result for a patch that is the mirror image of another one.

    The boundary runs the other way round, so that it is anticlockwise again (`images_of_boundary`); the vertices
    inside keep their numbers, and every triangle turns round.

    Parameters
    ----------
    patch : the image, as the network has it.
    """
    if isinstance(original, FailedPatch):
        return replace(
            original,
            name=patch.name,
            failure=_as_image(original.failure, patch),
            warnings=tuple(_as_image(warning, patch) for warning in original.warnings),
            seconds={},
        )
    mesh, warped = original.mesh, original.warped
    rim = original.planar_boundary
    turn = _Turn(images_of_boundary(original.patch.boundary, patch.boundary, plane))
    return FittedPatch(
        patch=patch,
        planar_boundary=PlanarBoundary(
            positions=turn.values(rim.positions) * FLIP,
            inner_angles=turn.values(rim.inner_angles),
            predicted_angles=turn.values(rim.predicted_angles),
            lower_bounds=turn.values(rim.lower_bounds),
        ),
        planar=PlanarMesh(
            turn.values(original.planar.positions) * FLIP, turn.triangles(original.planar.triangles), turn.count
        ),
        warped=WarpedMesh(turn.vertices(warped, patch, plane), turn.triangles(warped.triangles), turn.count),
        mesh=FlattenableMesh(
            turn.vertices(mesh, patch, plane),
            turn.triangles(mesh.triangles),
            turn.count,
            method="mirror",
            parameters={},
            status=f"the mirror image of '{patch.mirror_of}'",
        ),
        flat=turn.values(original.flat) * FLIP,
        has_grain=original.has_grain,
        warnings=tuple(_as_image(warning, patch) for warning in original.warnings),
        seconds={},
    )


@dataclass(frozen=True, eq=False)
class _Turn:
    """What belongs to boundary vertices, put in the image's order.

    Attributes
    ----------
    images : (n,) int; vertex i of the original is `images[i]` of the image, and the other way round.
    """

    images: Ints

    @property
    def count(self) -> int:
        return len(self.images)

    def values(self, values: Floats) -> Floats:
        return np.concatenate([values[self.images], values[self.count :]])

    def triangles(self, triangles: Ints) -> Ints:
        numbers = np.where(triangles < self.count, self.images[np.minimum(triangles, self.count - 1)], triangles)
        return np.ascontiguousarray(numbers[:, ::-1])

    def vertices(self, mesh: SurfaceMesh, patch: Patch, plane: MirrorPlane) -> Floats:
        """The reflected vertices; those of the boundary are the network's, to the last bit."""
        vertices = self.values(plane.reflect(mesh.vertices))
        vertices[: self.count] = patch.boundary.vertices
        return vertices


def _as_image(finding: Finding, patch: Patch) -> Finding:
    said = f"as the mirror image of '{patch.mirror_of}', of which it was said: {finding.message}"
    return replace(finding, patch=patch.name, message=said)
