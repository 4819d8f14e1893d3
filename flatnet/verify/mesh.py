"""Formulas of the written meshes, from their edge lengths where that is possible; none is shared with the fitting."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class WrittenMesh:
    """A mesh as it stands in an OBJ.

    Attributes
    ----------
    vertices, flat : (m, 3) and (m, 2) float, mm.
    triangles : (t, 3) int, from 0.
    """

    vertices: Floats
    flat: Floats
    triangles: Ints

    @cached_property
    def half_edges(self) -> Ints:
        """(3 t, 2) int: tail and head, as the triangles run; edge k of triangle i at 3 i + k."""
        return np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=-1).reshape(-1, 2)

    @cached_property
    def twins(self) -> Ints:
        """(3 t,) int: the half-edge that runs the other way, -1 on the boundary."""
        tails, heads = self.half_edges.T
        key = tails * len(self.vertices) + heads
        order = np.argsort(key, kind="stable")
        reverse = heads * len(self.vertices) + tails
        at = np.minimum(np.searchsorted(key[order], reverse), len(key) - 1)
        return np.where(key[order][at] == reverse, order[at], -1)

    @cached_property
    def edges(self) -> Ints:
        """(e, 2) int: every edge once, the lower vertex first."""
        return np.unique(np.sort(self.half_edges, axis=1), axis=0)

    @cached_property
    def boundary(self) -> tuple[Ints, ...]:
        """The boundary's loops as the triangles run, each from its lowest vertex."""
        following = dict(self.half_edges[self.twins < 0].tolist())
        loops = []
        while following:
            start = min(following)
            loop = [start]
            while (after := following.pop(loop[-1], start)) != start:
                loop.append(after)
            loops.append(np.array(loop))
        return tuple(loops)

    @cached_property
    def faults(self) -> tuple[str, ...]:
        """Why it is no disk, in words; nothing where it is one."""
        faults = []
        doubled = len(self.half_edges) - len(np.unique(self.half_edges, axis=0))
        if doubled:
            faults.append(f"{doubled} edges run the same way in two triangles: flipped or doubled triangles")
        unused = len(self.vertices) - len(np.unique(self.triangles))
        if unused:
            faults.append(f"{unused} vertices are in no triangle")
        tails = self.half_edges[self.twins < 0][:, 0]
        if len(self.boundary) != 1 or len(np.unique(tails)) != len(tails):
            faults.append(f"its boundary is {len(self.boundary)} loops")
        euler = len(self.vertices) - len(self.edges) + len(self.triangles)
        if euler != 1:
            faults.append(f"V - E + F = {euler}, and a disk has 1")
        return tuple(faults)

    @property
    def outline(self) -> Floats:
        """The flat boundary, (n, 2)."""
        return self.flat[self.boundary[0]]

    @cached_property
    def on_boundary(self) -> NDArray[np.bool_]:
        """(m,) bool."""
        on = np.zeros(len(self.vertices), dtype=bool)
        on[self.half_edges[self.twins < 0].ravel()] = True
        return on

    @cached_property
    def defects(self) -> Floats:
        """abs(angle sum - 2 pi) of the interior vertices, (i,), rad."""
        angles = corner_angles(side_lengths(self.vertices, self.triangles))
        sums = np.zeros(len(self.vertices))
        np.add.at(sums, self.triangles, angles)
        return np.abs(sums - 2.0 * np.pi)[~self.on_boundary]

    @cached_property
    def strain(self) -> Floats:
        """abs(flat length / length in space - 1) of every edge, (e,)."""
        return np.abs(lengths(self.flat, self.edges) / lengths(self.vertices, self.edges) - 1.0)

    @cached_property
    def boundary_strain(self) -> Floats:
        """The same of the edges of the boundary, (n,)."""
        rim = self.half_edges[self.twins < 0]
        return np.abs(lengths(self.flat, rim) / lengths(self.vertices, rim) - 1.0)

    @cached_property
    def flat_areas(self) -> Floats:
        """Signed, (t,), mm^2; positive where anticlockwise."""
        a, b, c = (self.flat[self.triangles[:, k]] for k in range(3))
        return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])

    @cached_property
    def normals(self) -> Floats:
        """Unit, of every triangle in space, (t, 3)."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)

    @cached_property
    def hinges(self) -> Ints:
        """The half-edges of interior edges that run from the lower to the higher vertex, in the order of their ends."""
        tails, heads = self.half_edges.T
        inside = np.flatnonzero((self.twins >= 0) & (tails < heads))
        return inside[np.lexsort((heads[inside], tails[inside]))]

    @cached_property
    def dihedral_angles(self) -> Floats:
        """Of every hinge, rad: 0 where flat, positive where convex seen from the normals' side."""
        first, second = self.normals[self.hinges // 3], self.normals[self.twins[self.hinges] // 3]
        tails, heads = self.half_edges[self.hinges].T
        along = self.vertices[heads] - self.vertices[tails]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        size = 2.0 * np.arctan2(np.linalg.norm(first - second, axis=1), np.linalg.norm(first + second, axis=1))
        return np.where(np.einsum("ij,ij->i", np.cross(first, second), along) < 0.0, -size, size)


def lengths(points: Floats, pairs: Ints) -> Floats:
    """From one point of a pair to the other, (k,)."""
    return np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)


def side_lengths(points: Floats, triangles: Ints) -> Floats:
    """(t, 3): the side opposite each corner."""
    return np.stack([lengths(points, np.roll(triangles, -k - 1, axis=1)[:, :2]) for k in range(3)], axis=1)


def corner_angles(sides: Floats) -> Floats:
    """The angle opposite each side of triangles, (t, 3), rad; nan where there is no such triangle.

    Source: W. Kahan, Miscalculating Area and Angles of a Needle-like Triangle (2014), which loses no digits to thin
    triangles.
    """
    angles = []
    for k in range(3):
        c = sides[:, k]
        others = np.delete(sides, k, axis=1)
        a, b = others.max(axis=1), others.min(axis=1)
        mu = np.where(b >= c, c - (a - b), b - (a - c))
        with np.errstate(invalid="ignore", divide="ignore"):
            angles.append(2.0 * np.arctan(np.sqrt(((a - b) + c) * mu / ((a + (b + c)) * ((a - c) + b)))))
    return np.stack(angles, axis=1)


def covered_twice(outline: Floats) -> float:
    """How much an outline covers twice or the wrong way round, mm^2: 0 for a simple one, also if it touches itself."""
    polygon = shapely.Polygon(outline)
    if polygon.is_valid:
        return 0.0
    region = shapely.make_valid(polygon, method="structure", keep_collapsed=False)
    return abs(polygon.area - region.area)


def aligned(points: Floats, target: Floats, mirrored: bool = False) -> tuple[Floats, Floats]:
    """The turn L (mirroring where asked) and shift s for which points L^T + s is nearest to the target (Kabsch)."""
    centre, goal = points.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((target - goal).T @ (points - centre))
    keep = np.ones(points.shape[1])
    keep[-1] = np.sign(np.linalg.det(u @ vt)) * (-1.0 if mirrored else 1.0)
    linear = u @ np.diag(keep) @ vt
    return linear, goal - linear @ centre


def farthest(points: Floats, target: Floats) -> float:
    """The largest distance between partners, mm."""
    return float(np.linalg.norm(points - target, axis=1).max(initial=0.0))
