"""What the fitting stages hand on: planar boundary, planar mesh, warped mesh, flattenable mesh, fitted patch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.geometry.asked_curvature import asked_curvature
from flatnet.geometry.intersections import self_intersections
from flatnet.geometry.triangles import (
    angle_defects,
    angles_between,
    boundary_edges,
    boundary_triangle_normals,
    edge_lengths,
    edge_strain,
    edges_of,
)
from flatnet.geometry.wrinkles import Wrinkles, find_wrinkles
from flatnet.network.patch import Patch

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def _freeze(*arrays: NDArray[Any]) -> None:
    for array in arrays:
        array.setflags(write=False)


@dataclass(frozen=True, eq=False)
class PlanarBoundary:
    """B^p: the closed planar polygon with the edge lengths of B (paper 3.1).

    Attributes
    ----------
    positions : (n, 2) float, mm; anticlockwise, in the order of B.
    inner_angles : (n,) float, rad; theta of Eq. 2.
    predicted_angles : (n,) float, rad; alpha of Fig. 3.
    lower_bounds : (n,) float, rad; the bounds of Lemma 1 in force.
    """

    positions: Floats
    inner_angles: Floats
    predicted_angles: Floats
    lower_bounds: Floats
    warnings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        _freeze(self.positions, self.inner_angles, self.predicted_angles, self.lower_bounds)

    @property
    def angle_error(self) -> float:
        """epsilon_theta of Eq. 1, rad^2."""
        return float(np.mean((self.inner_angles - self.predicted_angles) ** 2))

    @property
    def asked_curvature(self) -> float:
        """Total curvature that the normals ask for, rad; positive: a dome, negative: a saddle."""
        return asked_curvature(self.predicted_angles)

    @property
    def lemma_2_margin(self) -> float:
        """(n - 2) pi less the sum of the lower bounds, rad (Lemma 2)."""
        return float((len(self.lower_bounds) - 2) * np.pi - self.lower_bounds.sum())


@dataclass(frozen=True, eq=False)
class PlanarMesh:
    """M^p: the triangulated region inside B^p (paper 3.2).

    Attributes
    ----------
    positions : (m, 2) float, mm; the first `boundary_count` are B^p in its order.
    triangles : (t, 3) int, anticlockwise.
    boundary_count : n.
    """

    positions: Floats
    triangles: Ints
    boundary_count: int

    def __post_init__(self) -> None:
        _freeze(self.positions, self.triangles)

    @cached_property
    def mean_edge(self) -> float:
        """Mean edge length, mm: tau of the paper's 3.3, and the unit of length of the solvers."""
        return float(edge_lengths(self.positions, edges_of(self.triangles)).mean())


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """A disk of triangles in space whose first `boundary_count` vertices are B in its order.

    Attributes
    ----------
    vertices : (m, 3) float, mm.
    triangles : (t, 3) int, anticlockwise seen against the patch's normals.
    """

    vertices: Floats
    triangles: Ints
    boundary_count: int

    def __post_init__(self) -> None:
        _freeze(self.vertices, self.triangles)

    @cached_property
    def flattenability(self) -> Floats:
        """|theta - 2 pi| at every vertex, 0 on the boundary; (m,) float, rad (Definition 2)."""
        defects = np.abs(angle_defects(self.vertices, self.triangles))
        defects[: self.boundary_count] = 0.0
        return defects

    @property
    def max_flattenability(self) -> float:
        return float(self.flattenability.max(initial=0.0))

    @property
    def mean_flattenability(self) -> float:
        """Over the interior vertices; 0 where there are none."""
        inside = self.flattenability[self.boundary_count :]
        return float(inside.mean()) if len(inside) else 0.0

    @cached_property
    def self_intersections(self) -> Ints:
        """Pairs of triangles that pass through each other, (k, 2)."""
        return self_intersections(self.vertices, self.triangles)

    @cached_property
    def wrinkles(self) -> Wrinkles:
        return find_wrinkles(self.vertices, self.triangles, self.boundary_count)

    def normal_deviations(self, normals: Floats) -> Floats:
        """Angle between `normals`, (n, 3), and the triangle at every boundary edge, (n,), rad."""
        own = boundary_triangle_normals(self.vertices, self.triangles, self.boundary_count)
        return angles_between(own, normals)


@dataclass(frozen=True, eq=False)
class WarpedMesh(SurfaceMesh):
    """M^0: M^p warped onto B (paper 3.3)."""


@dataclass(frozen=True, eq=False)
class FlattenableMesh(SurfaceMesh):
    """M: the mesh after flattenability has been reached as far as the method went (paper 4).

    Attributes
    ----------
    method, parameters : which method with what.
    status : `converged`, or why it stopped.
    steps : linear solves it took.
    """

    method: str = ""
    parameters: Mapping[str, float] = None  # type: ignore[assignment]
    status: str = ""
    steps: int = 0


@dataclass(frozen=True, eq=False)
class FittedPatch:
    """A patch that can be made: the mesh in space, the same mesh in the plane, and all that led there.

    Attributes
    ----------
    flat : (m, 2) float, mm; the place of every vertex of `mesh` in the plane, anticlockwise seen against the
        normals, the grain along +x where it has one, else the longest extent.
    has_grain : the patch has a grain direction, and it is somewhere along the mesh.
    seconds : stage -> time it took.
    """

    patch: Patch
    planar_boundary: PlanarBoundary
    planar: PlanarMesh
    warped: WarpedMesh
    mesh: FlattenableMesh
    flat: Floats
    has_grain: bool
    warnings: tuple[Finding, ...]
    seconds: Mapping[str, float]

    def __post_init__(self) -> None:
        _freeze(self.flat)

    @cached_property
    def edge_strain(self) -> Floats:
        """|flat length / length in space - 1| of every edge of `edges_of(mesh.triangles)`, (e,)."""
        return np.abs(edge_strain(self.mesh.vertices, self.flat, self.mesh.triangles))

    @property
    def max_edge_strain(self) -> float:
        """Over all edges."""
        return float(self.edge_strain.max())

    @property
    def mean_edge_strain(self) -> float:
        """Over all edges."""
        return float(self.edge_strain.mean())

    @property
    def max_boundary_strain(self) -> float:
        """Over the boundary edges: what the two sides of a seam can differ by."""
        on_rim = boundary_edges(edges_of(self.mesh.triangles), self.mesh.boundary_count)
        return float(self.edge_strain[on_rim].max())

    @property
    def outline(self) -> Floats:
        """(n, 2) float, mm: the flat boundary, the piece's sew line."""
        return self.flat[: self.mesh.boundary_count]


@dataclass(frozen=True, eq=False)
class FailedPatch:
    """A patch that could not be made, and why; `seconds` are those of the stages that ran."""

    name: str
    failure: Finding
    warnings: tuple[Finding, ...] = ()
    seconds: Mapping[str, float] | None = None
