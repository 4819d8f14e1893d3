"""The flattenability constraint theta_p = 2 pi of all interior vertices, its Jacobian and that one's Gram matrix."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from flatnet.geometry.derivatives import corner_angle_gradients
from flatnet.geometry.triangles import angle_sums

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class AngleSums:
    """c(x) = theta - 2 pi at the interior vertices of one triangulation (Property 1, constraint of Eq. 5).

    A boundary vertex with a least angle has a row too: c = min(theta - least, 0).

    Parameters
    ----------
    triangles : (t, 3) int.
    constrained : (c,) int; the vertices with a row, sorted.
    vertex_count : m; the Jacobian has 3 m columns.
    least : vertex -> least angle, rad, for those of `constrained` that are on the boundary.
    """

    def __init__(
        self, triangles: Ints, constrained: Ints, vertex_count: int, least: Mapping[int, float] | None = None
    ) -> None:
        self.triangles = triangles
        least = least or {}
        self._one_sided = np.isin(constrained, list(least))
        self._targets = np.array([least.get(int(vertex), 2.0 * np.pi) for vertex in constrained])
        self.constrained = constrained
        self._columns = 3 * vertex_count
        row_of = np.full(vertex_count, -1)
        row_of[constrained] = np.arange(len(constrained))
        rows = np.repeat(row_of[triangles], 3, axis=1).ravel()
        columns = np.tile(triangles, 3).ravel()
        self._used = rows >= 0
        self._row = rows[self._used]
        key, self._entry = np.unique(self._row * vertex_count + columns[self._used], return_inverse=True)
        self._star = key % vertex_count
        self._start = np.searchsorted(key // vertex_count, np.arange(len(constrained) + 1))

    def values(self, vertices: Floats) -> Floats:
        """c, (c,), rad."""
        c = angle_sums(vertices, self.triangles)[self.constrained] - self._targets
        return np.where(self._one_sided, np.minimum(c, 0.0), c)

    def jacobian(self, vertices: Floats) -> csr_matrix:
        """dc / dx, (c, 3 m); each row's entries are its star's vertices in turn, three columns each.

        A row whose least angle is exceeded is 0.
        """
        by_corner = corner_angle_gradients(vertices, self.triangles).reshape(-1, 3)[self._used]
        if self._one_sided.any():
            met = self._one_sided & (self.values(vertices) >= 0.0)
            by_corner[met[self._row]] = 0.0
        data = np.stack(
            [np.bincount(self._entry, weights=by_corner[:, axis], minlength=len(self._star)) for axis in range(3)],
            axis=1,
        )
        indices = (3 * self._star[:, None] + np.arange(3)).ravel()
        shape = (len(self.constrained), self._columns)
        return csr_matrix((data.ravel(), indices, 3 * self._start), shape=shape)

    def stars(self) -> list[tuple[Ints, Ints]]:
        """Rows grouped by the size s of their stars: (rows (r,), vertex ids (r, s))."""
        sizes = np.diff(self._start)
        groups = []
        for size in np.unique(sizes):
            rows = np.flatnonzero(sizes == size)
            groups.append((rows, self._star[self._start[rows][:, None] + np.arange(size)]))
        return groups

    def star_rows(self, jacobian: csr_matrix, rows: Ints, size: int) -> Floats:
        """The entries of some rows of equal star size as a dense (r, 3 s) array."""
        return jacobian.data[3 * self._start[rows][:, None] + np.arange(3 * size)]
