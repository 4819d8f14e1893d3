"""Geodesics on a triangle mesh: the straightest ways from point to point, each as a polyline on the mesh."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import potpourri3d
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A point whose barycentric coordinate in a triangle is less than this lies on the opposite edge.
ON_EDGE = 1e-6


class NoWayError(Exception):
    """There is no way on the surface between two points."""


def geodesics(mesh: trimesh.Trimesh, points: Floats) -> list[Floats]:
    """From every point to the next the geodesic that shortening the shortest way along edges comes to.

    By flips of intrinsic edges: N. Sharp, K. Crane, You can find geodesic paths in triangle meshes by just
    flipping edges, ACM TOG 39 (2020), as geometry-central has them.

    Parameters
    ----------
    points : (m + 1, 3) float, mm; taken to the nearest points of the mesh.

    Returns
    -------
    m polylines, each (k, 3): their points are where they cross edges of the mesh.

    Raises
    ------
    NoWayError
        The mesh is not manifold, or two points lie on parts of it that do not hang together.
    """
    vertices, triangles, index = _with_points(mesh, points)
    try:
        solver = potpourri3d.EdgeFlipGeodesicSolver(vertices, triangles)
    except RuntimeError as error:
        raise NoWayError(
            "the surface's mesh is not manifold (somewhere more than two faces meet along an edge, or two parts "
            f"touch in a vertex): no geodesic can be found on it; repair the mesh ({error})"
        ) from error
    part = trimesh.graph.connected_component_labels(trimesh.graph.face_adjacency(triangles), len(triangles))
    part_of = np.zeros(len(vertices), dtype=int)
    part_of[triangles] = part[:, None]
    legs = []
    for i, (a, b) in enumerate(pairwise(index)):
        if a == b:
            raise NoWayError(f"points {i + 1} and {i + 2} are the same point of the surface")
        if part_of[a] != part_of[b]:
            raise NoWayError(f"points {i + 1} and {i + 2} lie on two parts of the surface that do not hang together")
        legs.append(np.array(solver.find_geodesic_path(a, b), dtype=float))
    return legs


def _with_points(mesh: trimesh.Trimesh, points: Floats) -> tuple[Floats, Ints, list[int]]:
    """The mesh with the nearest points of `points` among its vertices, and their indices."""
    vertices, triangles = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    feet, _, homes = trimesh.proximity.closest_point(mesh, points)
    home_of = np.arange(len(triangles))  # the triangle of the mesh that each was cut from
    index = []
    for foot, home in zip(feet, homes):
        inside = np.flatnonzero(home_of == home)
        weights = trimesh.triangles.points_to_barycentric(
            vertices[triangles[inside]], np.broadcast_to(foot, (len(inside), 3))
        )
        best = int(weights.min(axis=1).argmax())
        corners, weight = triangles[inside[best]], weights[best]
        if weight.max() > 1.0 - ON_EDGE:
            index.append(int(corners[weight.argmax()]))
            continue
        new = len(vertices)
        vertices = np.vstack([vertices, foot])
        index.append(new)
        opposite = corners[weight < ON_EDGE]
        split = inside[[best]]
        if len(opposite):  # on an edge: the triangle across it is cut too
            a, b = corners[corners != opposite[0]]
            split = np.flatnonzero((triangles == a).any(axis=1) & (triangles == b).any(axis=1))
        children, of = [], []
        for t in split:
            for k in range(3):
                child = triangles[t].copy()
                child[k] = new
                if not len(opposite) or triangles[t, k] in (a, b):
                    children.append(child)
                    of.append(home_of[t])
        triangles = np.vstack([np.delete(triangles, split, axis=0), children])
        home_of = np.concatenate([np.delete(home_of, split), of])
    return vertices, triangles, index
