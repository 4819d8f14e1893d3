"""The cotangent Laplacian of a triangle mesh, in the plane or in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix

from flatnet.geometry.triangles import corner_angles

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def cotangent_laplacian(vertices: Floats, triangles: Ints, count: int) -> csr_matrix:
    """Stiffness of linear elements, (count, count), symmetric, positive semi-definite."""
    cotangents = 1.0 / np.tan(corner_angles(vertices, triangles))
    rows, columns, values = [], [], []
    for corner in range(3):
        a, b = triangles[:, (corner + 1) % 3], triangles[:, (corner + 2) % 3]
        half = 0.5 * cotangents[:, corner]
        rows += [a, b, a, b]
        columns += [b, a, a, b]
        values += [-half, -half, half, half]
    return coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
    ).tocsr()
