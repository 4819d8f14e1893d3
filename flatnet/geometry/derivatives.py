"""First derivatives of the quantities a mesh is fitted by: corner angles, hinge angles, edge lengths, areas.

Every function gives the derivative of one number per element with respect to the element's own vertices, so
that a Jacobian is a matter of scattering them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def corner_angle_gradients(vertices: Floats, triangles: Ints) -> Floats:
    """Derivative of each corner angle by the triangle's vertices, (t, 3 corners, 3 vertices, 3), rad per length.

    An angle at p falls when its first leg q turns towards the second one r, and grows when r turns away:
    both gradients are in the triangle's plane, across their leg, as long as one over the leg.
    """
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    gradients = np.zeros((len(triangles), 3, 3, 3))
    for p in range(3):
        q, r = (p + 1) % 3, (p + 2) % 3
        for leg, sign in ((q, -1.0), (r, 1.0)):
            along = corners[:, leg] - corners[:, p]
            across = np.cross(normal, along) / np.einsum("ij,ij->i", along, along)[:, None]
            gradients[:, p, leg] = sign * across
        gradients[:, p, p] = -gradients[:, p, q] - gradients[:, p, r]
    return gradients


def hinge_angle_gradients(vertices: Floats, hinges: Ints) -> Floats:
    """Derivative of each hinge angle by its vertices i, j, k, l, (h, 4, 3), rad per length."""
    i, j, k, l = (vertices[hinges[:, c]] for c in range(4))
    edge = j - i
    squared = np.einsum("ij,ij->i", edge, edge)
    left, right = np.cross(edge, k - i), np.cross(l - i, edge)
    length = np.sqrt(squared)
    by_k = -left * (length / np.einsum("ij,ij->i", left, left))[:, None]
    by_l = -right * (length / np.einsum("ij,ij->i", right, right))[:, None]
    along_k = (np.einsum("ij,ij->i", k - i, edge) / squared)[:, None]
    along_l = (np.einsum("ij,ij->i", l - i, edge) / squared)[:, None]
    by_i = -(1.0 - along_k) * by_k - (1.0 - along_l) * by_l
    by_j = -along_k * by_k - along_l * by_l
    return np.stack([by_i, by_j, by_k, by_l], axis=1)


def edge_length_gradients(vertices: Floats, edges: Ints) -> Floats:
    """Derivative of each edge's length by its two vertices, (e, 2, d); in the plane or in space."""
    along = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([-along, along], axis=1)


def area_gradients(vertices: Floats, triangles: Ints) -> Floats:
    """Derivative of each triangle's area by its vertices, (t, 3, 3): half the normal crossed with the far side."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    gradients = np.empty((len(triangles), 3, 3))
    for p in range(3):
        far_side = corners[:, (p + 2) % 3] - corners[:, (p + 1) % 3]
        gradients[:, p] = 0.5 * np.cross(normal, far_side)
    return gradients
