"""Look at meshes from a direction: which direction shows them best, what lies in front, how it is lit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatnet.fitting.results import SurfaceMesh
from flatnet.geometry.triangles import area_vectors, edge_lengths, unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Length of the mean normal below which a surface is a body that one walks round; half a sphere's is 0.5.
BODY = 0.5
#: In the camera's frame (to the right, up, towards the viewer): from above left.
LIGHT = unit(np.array([-0.5, 0.6, 0.65]))
#: Part of the light that a face turned away from it still gets.
AMBIENT = 0.42


@dataclass(frozen=True)
class Camera:
    """A parallel projection, z upright, from an azimuth (+x towards +y) and an elevation, degrees."""

    azimuth: float
    elevation: float

    @property
    def axes(self) -> Floats:
        """To the right, up, towards the viewer: orthonormal and right-handed rows, (3, 3)."""
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        return np.array([right, np.cross(towards, right), towards])

    def project(self, points: Floats) -> Floats:
        """Points or directions (..., 3) in the camera's frame: to the right, up, nearness."""
        return points @ self.axes.T


#: Three quarters from the front (+y), a little from above.
FROM_THE_FRONT = Camera(50.0, 12.0)


@dataclass(frozen=True, eq=False)
class Surface:
    """Several meshes as one heap of triangles.

    Attributes
    ----------
    corners : (t, 3, 3) float, mm.
    boundaries : (b, 2, 3) float, mm; the edges of all boundaries.
    flattenability : (t,) float, rad; of every triangle's worst corner.
    strain : (t,) float; of every triangle's worst edge against the flat piece, 0 where there is none.
    """

    corners: Floats
    boundaries: Floats
    flattenability: Floats
    strain: Floats

    @classmethod
    def of(cls, meshes: Sequence[SurfaceMesh], flats: Sequence[Floats] = ()) -> Surface:
        """`flats` : the meshes' flat pieces, (m, 2) mm each."""
        return cls(
            np.concatenate([mesh.vertices[mesh.triangles] for mesh in meshes]),
            np.concatenate([_closed(mesh.vertices[: mesh.boundary_count]) for mesh in meshes]),
            np.concatenate([mesh.flattenability[mesh.triangles].max(axis=1) for mesh in meshes]),
            np.concatenate(
                [_strain(mesh, flat) for mesh, flat in zip(meshes, flats)]
                or [np.zeros(len(mesh.triangles)) for mesh in meshes]
            ),
        )

    @property
    def area_vectors(self) -> Floats:
        """Normal of every triangle times its area, (t, 3)."""
        return area_vectors(self.corners.reshape(-1, 3), np.arange(3 * len(self.corners)).reshape(-1, 3))

    def back_to_front(self, camera: Camera) -> tuple[Floats, Ints]:
        """The painter's order of triangles and boundary edges together.

        Returns
        -------
        corners : (t + b, 3, 2) float, mm, as the camera sees them, an edge as a triangle without width.
        order : (t + b,) int, the farthest first.
        """
        seen = camera.project(np.concatenate([self.corners, self.boundaries[:, [0, 1, 1]]]))
        nearness = seen[..., 2].mean(axis=1)
        # An edge belongs on top of the triangles beside it, whose centres are up to an edge length nearer.
        length = np.linalg.norm(self.boundaries[:, 1] - self.boundaries[:, 0], axis=1)
        nearness[len(self.corners) :] += length
        return seen[..., :2], np.argsort(nearness, kind="stable")

    def light(self, camera: Camera) -> tuple[Floats, NDArray[np.bool_]]:
        """Lambert's brightness of every triangle, in (0, 1], and whether its outside is seen; (t,) each.

        A triangle seen from inside is lit as if it faced the viewer.
        """
        normals = camera.project(unit(self.area_vectors))
        outside = normals[:, 2] >= 0.0
        facing = np.where(outside[:, None], normals, -normals)
        return AMBIENT + (1.0 - AMBIENT) * np.maximum(facing @ LIGHT, 0.0), outside


def cameras(surface: Surface) -> tuple[Camera, Camera]:
    """Two ways to look at a surface: the first at its outside, the second at what the first can't show.

    A sheet is seen along its mean normal, a little from above and from the side, then almost along itself,
    where folds show. A body is seen three quarters from the front, on the side where more of it is closed,
    then from behind.
    """
    vectors = surface.area_vectors
    x, y, z = vectors.sum(axis=0) / np.linalg.norm(vectors, axis=1).sum()
    if np.linalg.norm([x, y, z]) < BODY:
        front = FROM_THE_FRONT
        if x < -1e-6:  # of a symmetric body it is round-off
            front = replace(front, azimuth=180.0 - front.azimuth)
        return front, replace(front, azimuth=front.azimuth + 180.0)
    across = float(np.hypot(x, y))
    # What faces up or down is seen with x to the right, as on a plan.
    azimuth = float(np.degrees(np.arctan2(y, x))) if across > 0.3 else -90.0
    elevation = float(np.degrees(np.arctan2(z, across)))
    return (
        Camera(azimuth + 25.0, float(np.clip(elevation + 10.0, -50.0, 50.0))),
        Camera(azimuth - 40.0, float(np.clip(elevation, -20.0, 20.0))),
    )


def _strain(mesh: SurfaceMesh, flat: Floats) -> Floats:
    """|flat length / length in space - 1| of the worst edge of every triangle, (t,)."""
    ends = [np.stack([mesh.triangles[:, k], mesh.triangles[:, (k + 1) % 3]], axis=1) for k in range(3)]
    sides = [np.abs(edge_lengths(flat, end) / edge_lengths(mesh.vertices, end) - 1.0) for end in ends]
    return np.asarray(np.max(sides, axis=0))


def _closed(polygon: Floats) -> Floats:
    """The edges of a closed polygon, (n, 2, 3)."""
    return np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1)
