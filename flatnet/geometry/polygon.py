"""Edges and angles of closed polygons: plain angles, and those predicted from edge normals (paper Fig. 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import dot

Floats = NDArray[np.float64]

#: Two unit normals whose sum is shorter than this are opposed: their mean plane would be noise.
OPPOSED = 1e-6


def edge_vectors(polygon: Floats) -> Floats:
    """From every vertex of a closed polygon to the next, (n, d); the last edge leads back to the first vertex."""
    return np.roll(polygon, -1, axis=0) - polygon


def arclengths(points: Floats) -> Floats:
    """Of every vertex of an open polyline, (k, d), from its first, (k,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def polyline_length(points: Floats) -> float:
    """Length of an open polyline, (k, d)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def side_lengths(polygon: Floats) -> Floats:
    """Length of every edge of a closed polygon, (n,)."""
    return np.linalg.norm(edge_vectors(polygon), axis=1)


def polygon_angles(vertices: Floats) -> Floats:
    """Angle v_{i-1} v_i v_{i+1} at every vertex of a closed polygon, (n,), rad in [0, pi] (Lemma 1)."""
    forward = edge_vectors(vertices)
    backward = -np.roll(forward, 1, axis=0)
    sine = np.linalg.norm(np.cross(forward, backward), axis=1)
    return np.arctan2(sine, dot(forward, backward))


def predicted_angles(vertices: Floats, normals: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Inner angle alpha of a surface at the vertices of its boundary, predicted from edge normals (Fig. 3).

    It is the angle turned, anticlockwise seen against the mean normal of the two edges that meet, from the
    edge that leaves to the edge that arrives, both projected onto the plane of that mean normal; a reflex
    corner comes out larger than pi. Where the boundary turns back on itself (the tip of a slit) it is 2 pi.
    Where the two normals are opposed no plane is defined and the plain angle in space is taken.

    Parameters
    ----------
    vertices : (n, 3) float; the closed polygon, anticlockwise seen against its normals.
    normals : (n, 3) float, unit; normals[i] belongs to the edge from vertex i to vertex i + 1.

    Returns
    -------
    alpha : (n,) float, rad in (0, 2 pi].
    opposed : (n,) bool; where the two normals are opposed.
    """
    following, previous = np.roll(vertices, -1, axis=0), np.roll(vertices, 1, axis=0)
    forward, backward = following - vertices, previous - vertices
    total = normals + np.roll(normals, 1, axis=0)
    length = np.linalg.norm(total, axis=1)
    opposed = length < OPPOSED
    mean = total / np.where(opposed, 1.0, length)[:, None]

    sine = dot(mean, np.cross(forward, backward))
    # The dot product of the projections; the cross product's part along `mean` needs no projecting.
    cosine = dot(forward, backward) - dot(forward, mean) * dot(backward, mean)
    alpha = np.arctan2(sine, cosine) % (2.0 * np.pi)
    alpha = np.where(opposed, polygon_angles(vertices), alpha)
    turns_back = (following == previous).all(axis=1)
    return np.where(turns_back | (alpha == 0.0), 2.0 * np.pi, alpha), opposed
