"""The curve network: nodes, stretches of sampled curves with normals, and the patches that are its faces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import dot, unit
from flatnet.network.patch import Patch
from flatnet.project.problems import Mark, Problem

Floats = NDArray[np.float64]
#: Loops of one face, each as signed stretch names.
Loops = tuple[tuple[str, ...], ...]


class GeometryError(Exception):
    """One problem of the project that only its geometry tells; collected into a `ProjectError`."""

    def __init__(self, mark: Mark | None, message: str) -> None:
        self.problem = Problem(mark, message)
        super().__init__(message)


@dataclass(frozen=True, eq=False)
class SampledStretch:
    """A curve between two nodes that follow each other on it, sampled once for both patches along it: a seam.

    Attributes
    ----------
    name : the curve's name where it has one stretch only, else `curve:from..to`.
    start, end : its nodes; None for a closed curve without node.
    vertices : (k + 1, 3) float, mm; of a closed stretch the last is the first.
    left_normals, right_normals : (k, 3) float, unit, orthogonal to their edges: for the patch on the left and
        on the right of the curve's direction, seen against the normals. One array off creases. Zero where the
        project gives none.
    slit : the curve may end inside a face.
    """

    name: str
    curve: str
    start: str | None
    end: str | None
    vertices: Floats
    left_normals: Floats
    right_normals: Floats
    slit: bool = False

    def __post_init__(self) -> None:
        for array in (self.vertices, self.left_normals, self.right_normals):
            array.setflags(write=False)

    @property
    def length(self) -> float:
        return polyline_length(self.vertices)

    @property
    def crease(self) -> bool:
        return self.left_normals is not self.right_normals

    def moved(self, vertices: Floats) -> SampledStretch:
        """The same stretch with its vertices elsewhere; normals stay orthogonal to their edges."""
        edges = unit(np.diff(vertices, axis=0))

        def turned(normals: Floats) -> Floats:
            across = normals - dot(normals, edges)[:, None] * edges
            return across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)

        left = turned(self.left_normals)
        right = turned(self.right_normals) if self.crease else left
        return replace(self, vertices=vertices, left_normals=left, right_normals=right)


@dataclass(frozen=True, eq=False)
class CurveNetwork:
    """A project's curves, sampled, and its faces: to be made, impossible to make, and open.

    Attributes
    ----------
    nodes : name -> (3,) float, mm; the one position that all curves through the node share.
    stretches : name -> stretch, in the order of the project file.
    patches : faces ready to be fitted, in the order of the project file.
    failed : patches that are no disk or do not close (`Finding.patch` is the name).
    rings : patches among `failed` that have several loops -> those loops, as those of openings.
    openings : name -> its loops, each as signed stretch names (`-name`: run backwards).
    face_count : loops traced, over all components.
    euler_characteristics : V - E + F of every connected component, in the order of their first curve: 2 on a
        sphere or in the plane, 0 where the curves cut up a torus. Less is legal, and worth telling.
    """

    nodes: Mapping[str, Floats]
    stretches: Mapping[str, SampledStretch]
    patches: tuple[Patch, ...]
    failed: tuple[Finding, ...]
    rings: Mapping[str, Loops]
    openings: Mapping[str, Loops]
    face_count: int
    euler_characteristics: tuple[int, ...]
