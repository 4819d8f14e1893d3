"""First derivatives of the quantities a mesh is fitted by: corner angles, hinge angles, edge lengths, areas.

Every function gives the derivative of one number per element with respect to the element's own vertices, so
that a Jacobian is a matter of scattering them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import cross, dot

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def corner_angle_gradients(vertices: Floats, triangles: Ints) -> Floats:
    """Derivative of each corner angle by the triangle's vertices, (t, 3 corners, 3 vertices, 3), rad per length.

    An angle at p falls when its first leg q turns towards the second one r, and grows when r turns away:
    both gradients are in the triangle's plane, across their leg, as long as one over the leg.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    sides = c - b, a - c, b - a  # side k lies across from corner k
    normal = cross(sides[1], sides[2])
    normal /= np.sqrt(dot(normal, normal))[:, None]
    # Across side k into the triangle, as long as one over the side.
    inwards = [cross(normal, side) / dot(side, side)[:, None] for side in sides]
    gradients = np.empty((len(triangles), 3, 3, 3))
    for p in range(3):
        q, r = (p + 1) % 3, (p + 2) % 3
        gradients[:, p, q] = -inwards[r]
        gradients[:, p, r] = -inwards[q]
        gradients[:, p, p] = inwards[q] + inwards[r]
    return gradients


def hinge_angle_gradients(vertices: Floats, hinges: Ints) -> Floats:
    """Derivative of each hinge angle by its vertices i, j, k, l, (h, 4, 3), rad per length."""
    i, j, k, l = (vertices[hinges[:, c]] for c in range(4))
    edge = j - i
    squared = dot(edge, edge)
    length = np.sqrt(squared)
    left, right = cross(edge, k - i), cross(l - i, edge)
    gradients = np.empty((len(hinges), 4, 3))
    by_k = gradients[:, 2] = left * (-length / dot(left, left))[:, None]
    by_l = gradients[:, 3] = right * (-length / dot(right, right))[:, None]
    along_k = (dot(k - i, edge) / squared)[:, None]
    along_l = (dot(l - i, edge) / squared)[:, None]
    gradients[:, 1] = -along_k * by_k - along_l * by_l
    gradients[:, 0] = -by_k - by_l - gradients[:, 1]
    return gradients


def edge_length_gradients(vertices: Floats, edges: Ints) -> Floats:
    """Derivative of each edge's length by its two vertices, (e, 2, d); in the plane or in space."""
    along = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    along /= np.sqrt(dot(along, along))[:, None]
    return np.stack([-along, along], axis=1)


def area_gradients(vertices: Floats, triangles: Ints) -> Floats:
    """Derivative of each triangle's area by its vertices, (t, 3, 3): half the normal crossed with the far side."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    sides = c - b, a - c, b - a
    normal = cross(sides[1], sides[2])
    normal *= (0.5 / np.sqrt(dot(normal, normal)))[:, None]
    return np.stack([cross(normal, side) for side in sides], axis=1)
