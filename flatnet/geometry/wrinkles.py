"""Wrinkles of a flattenable mesh: where it bends to and fro, how many ridges and valleys, how deep.

A sheet that bends one way only, however sharply, has none. Angles and lengths are those of the sheet itself:
the measure depends neither on its place and scale nor, within reason, on the size of the mesh
(docs/method.md has the figures behind the constants).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from flatnet.geometry.laplacian import cotangent_laplacian
from flatnet.geometry.triangles import area_vectors, edge_lengths, edges_of, hinge_angles, hinges_of, vertex_sums

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: From this turning on a patch is called wrinkled, rad. Slack waves stay below it, creases and dents exceed it.
WRINKLED = np.radians(20.0)
#: Bending to and fro within this many sqrt(area) is a wrinkle; what is wider is the shape of the patch.
REACH = 0.08
#: Bends narrower than this many sqrt(area), or so many mean edges if that is more, are noise of the mesh.
NOISE, NOISE_EDGES = 0.02, 1.0 / 3.0
#: Ridges and valleys are counted where the turning reaches this part of `WRINKLED` ...
ZONE = 0.5
#: ... and where they are so many reaches high.
LOWEST = 0.05


@dataclass(frozen=True)
class Wrinkles:
    """The wrinkles of one mesh.

    Attributes
    ----------
    turning : rad; how far the sheet turns to and fro, in vain, within `reach` of its worst place; 0 where all
        bending nearby has one sign.
    vertex : the worst place.
    reach : mm.
    ridges, valleys : how many, as seen from the normals' side.
    depth : from the top of the highest ridge to the bottom of the deepest valley, mm.
    """

    turning: float
    vertex: int
    reach: float
    ridges: int
    valleys: int
    depth: float

    @property
    def wrinkled(self) -> bool:
        return self.turning >= WRINKLED


def find_wrinkles(vertices: Floats, triangles: Ints, boundary_count: int) -> Wrinkles:
    """Measure the wrinkles of a mesh.

    With kappa the bending per mm, S the average over `reach` (a screened Poisson smoothing) and kappa_1 =
    kappa without the noise of the mesh, the turning at a point is reach (S|kappa_1| - |S kappa_1|): what is
    bent nearby, less what remains of it. The height of a fold is reach^2 (S kappa - S S kappa): that of the
    sheet over itself ironed within `reach`, exact for folds that are narrow against 2 pi reach.

    Parameters
    ----------
    vertices : (m, 3) float, mm.
    triangles : (t, 3) int; a disk.
    boundary_count : the first so many vertices are its boundary. There hinges are missing: the bending is carried
        on from inside; of a mesh with no vertex inside it is taken as it is.
    """
    edges = edges_of(triangles)
    areas = np.linalg.norm(area_vectors(vertices, triangles), axis=1)
    masses = vertex_sums(triangles, np.repeat(areas / 3.0, 3), len(vertices))
    laplacian = cotangent_laplacian(vertices, triangles, len(vertices))
    size = float(np.sqrt(areas.sum()))
    reach = REACH * size
    noise = max(NOISE * size, NOISE_EDGES * float(edge_lengths(vertices, edges).mean()))

    def average(width: float, weights: Floats) -> Callable[[Floats], Floats]:
        solver = splu((diags_array(weights) + width**2 * laplacian).tocsc(), permc_spec="MMD_AT_PLUS_A")
        return lambda values: solver.solve(weights * values)

    bend = bending_per_length(vertices, triangles)
    heard = np.where(np.arange(len(vertices)) < boundary_count, 0.0, masses)
    clean = average(noise, heard if heard.any() else masses)(bend)
    bend[:boundary_count] = clean[:boundary_count]
    nearby = average(reach, masses)
    turning = reach * (nearby(np.abs(clean)) - np.abs(nearby(clean)))
    mean = nearby(bend)
    height = reach**2 * (mean - nearby(mean))
    worst = int(np.argmax(turning))
    ridges, valleys, depth = _folds(height, LOWEST * reach, turning >= ZONE * WRINKLED, edges)
    return Wrinkles(max(float(turning[worst]), 0.0), worst, reach, ridges, valleys, depth)


def bending_per_length(vertices: Floats, triangles: Ints) -> Floats:
    """Twice the mean curvature at every vertex, (m,), 1/mm; positive where the mesh bulges to its normals' side.

    The mean over its hinges: a hinge turns by theta along l, which spreads over a third of its triangles. On the
    boundary, where those along it are missing, it means nothing.
    """
    hinges = hinges_of(triangles)
    i, j, k, l = hinges.T
    turn = edge_lengths(vertices, hinges[:, :2]) * hinge_angles(vertices, hinges)
    area = np.linalg.norm(area_vectors(vertices, np.stack([i, j, k], axis=1)), axis=1)
    area += np.linalg.norm(area_vectors(vertices, np.stack([j, i, l], axis=1)), axis=1)
    ends = np.concatenate([i, j])
    turns, spread = (np.bincount(ends, np.tile(w, 2), len(vertices)) for w in (turn, area / 3.0))
    return np.divide(turns, spread, out=np.zeros(len(vertices)), where=spread > 0.0)


def _folds(height: Floats, level: float, zone: Bools, edges: Ints) -> tuple[int, int, float]:
    """How many ridges and valleys above a level reach into a zone, and how deep they are, mm."""
    ridges, valleys = (
        [float(side[part].max()) for part in _parts(side > level, edges) if zone[part].any()]
        for side in (height, -height)
    )
    return len(ridges), len(valleys), max(ridges, default=0.0) + max(valleys, default=0.0)


def _parts(chosen: Bools, edges: Ints) -> list[Ints]:
    """The connected parts of the chosen vertices, in the order of their first vertex."""
    inner = edges[chosen[edges].all(axis=1)]
    graph = coo_array((np.ones(len(inner)), inner.T), shape=(len(chosen), len(chosen)))
    _, label = connected_components(graph, directed=False)
    return [np.flatnonzero(chosen & (label == each)) for each in dict.fromkeys(label[chosen].tolist())]
