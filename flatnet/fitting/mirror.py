"""Reflect a fitted patch: the mirror image is not fitted again, and so an exact one."""

from __future__ import annotations

from dataclasses import replace

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
from flatnet.network.patch import Patch

#: What the flat image of (x, y) is: the grain stays along +x.
FLIP = np.array([1.0, -1.0])


def reflect_patch(
    original: FittedPatch | FailedPatch, patch: Patch, plane: MirrorPlane
) -> FittedPatch | FailedPatch:
    """The result for a patch that is the mirror image of another one.

    Boundary vertex i is the image of vertex -i, so that the boundary runs anticlockwise again; the vertices
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
    n = original.mesh.boundary_count
    mesh, warped = original.mesh, original.warped
    rim = original.planar_boundary
    return FittedPatch(
        patch=patch,
        planar_boundary=PlanarBoundary(
            positions=_turned(rim.positions, n) * FLIP,
            inner_angles=_turned(rim.inner_angles, n),
            predicted_angles=_turned(rim.predicted_angles, n),
            lower_bounds=_turned(rim.lower_bounds, n),
        ),
        planar=PlanarMesh(
            _turned(original.planar.positions, n) * FLIP, _triangles(original.planar.triangles, n), n
        ),
        warped=WarpedMesh(_vertices(warped, patch, plane), _triangles(warped.triangles, n), n),
        mesh=FlattenableMesh(
            _vertices(mesh, patch, plane),
            _triangles(mesh.triangles, n),
            n,
            method="mirror",
            parameters={},
            status=f"the mirror image of '{patch.mirror_of}'",
        ),
        flat=_turned(original.flat, n) * FLIP,
        has_grain=original.has_grain,
        warnings=tuple(_as_image(warning, patch) for warning in original.warnings),
        seconds={},
    )


def _turned(values: Floats, n: int) -> Floats:
    """Values per vertex, the first n run backwards from the same start."""
    return np.concatenate([values[:1], values[1:n][::-1], values[n:]])


def _triangles(triangles: Ints, n: int) -> Ints:
    numbers = np.where(triangles < n, -triangles % n, triangles)
    return np.ascontiguousarray(numbers[:, ::-1])


def _vertices(mesh: SurfaceMesh, patch: Patch, plane: MirrorPlane) -> Floats:
    """The reflected vertices; those of the boundary are the network's, to the last bit."""
    vertices = _turned(plane.reflect(mesh.vertices), mesh.boundary_count)
    rim = vertices[: mesh.boundary_count]
    assert np.allclose(rim, patch.boundary.vertices, atol=1e-9 * np.abs(rim).max()), "the boundaries are images"
    rim[:] = patch.boundary.vertices
    return vertices


def _as_image(finding: Finding, patch: Patch) -> Finding:
    said = f"as the mirror image of '{patch.mirror_of}', of which it was said: {finding.message}"
    return replace(finding, patch=patch.name, message=said)
