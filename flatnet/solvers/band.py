"""Symmetric positive definite band systems, summed from small element blocks.

Vertices are put in reverse Cuthill-McKee order of the graph that the elements make, three unknowns each; the
lower band is stored as LAPACK's dpbtrf wants it, in Fortran order (C order costs 2.4 times as much).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbtrf, dpbtrs
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class BandLayout:
    """Where each free unknown stands in the band.

    Parameters
    ----------
    free : (m,) bool; which vertices move.
    elements : (e, k) int arrays of vertex ids; the matrix couples all vertices of an element.

    Attributes
    ----------
    unknowns : (3 f,) int; full unknown (3 * vertex + axis) of every band row.
    row_of : (3 m,) int; band row of a full unknown, -1 where it is fixed.
    """

    def __init__(self, free: NDArray[np.bool_], elements: Iterable[Ints]) -> None:
        count = len(free)
        rows, columns = [], []
        for element in elements:
            rows.append(np.repeat(element, element.shape[1], axis=1).ravel())
            columns.append(np.tile(element, element.shape[1]).ravel())
        row, column = np.concatenate(rows), np.concatenate(columns)
        both = free[row] & free[column]
        graph = coo_matrix((np.ones(both.sum()), (row[both], column[both])), shape=(count, count)).tocsr()
        moving = np.flatnonzero(free)
        order = moving[reverse_cuthill_mckee(graph[moving][:, moving].tocsr(), symmetric_mode=True)]
        place = np.full(count, -1)
        place[order] = np.arange(len(order))
        reach = np.abs(place[row[both]] - place[column[both]]).max(initial=0)
        self.size = 3 * len(order)
        self.bandwidth = min(3 * int(reach) + 2, max(self.size - 1, 0))
        self.unknowns = (3 * order[:, None] + np.arange(3)).ravel()
        self.row_of = np.full(3 * count, -1)
        self.row_of[self.unknowns] = np.arange(self.size)

    def slots(self, rows: Ints, columns: Ints) -> Ints:
        """Flat band positions of entries given by full unknowns; pairs with a fixed one go past the end."""
        first, second = self.row_of[rows], self.row_of[columns]
        low, high = np.minimum(first, second), np.maximum(first, second)
        flat = (high - low) + low * (self.bandwidth + 1)
        flat[low < 0] = (self.bandwidth + 1) * self.size
        return flat

    def summed(self, slots: Ints, values: Floats) -> BandMatrix:
        """The matrix whose entries are the values summed at their slots."""
        size = (self.bandwidth + 1) * self.size
        sums = np.bincount(slots, weights=values, minlength=size + 1)
        return BandMatrix(self, np.asarray(sums[:size], dtype=np.float64))


class BlockSum:
    """Sums w J^T J over groups of elements, J one row per element, into the band.

    Parameters
    ----------
    groups : (e, k) full unknowns of the elements of every group.
    """

    def __init__(self, layout: BandLayout, groups: Iterable[Ints]) -> None:
        self._layout = layout
        slots, self._places, start = [], [], 0
        for unknowns in groups:
            rows, columns = np.tril_indices(unknowns.shape[1])
            block = layout.slots(unknowns.T[rows], unknowns.T[columns])
            slots.append(block.ravel())
            self._places.append((start, block.shape))
            start += block.size
        self._slots = np.concatenate(slots)
        self._values = np.empty(start)

    def __call__(self, jacobians: Iterable[Floats], weights: Iterable[Floats]) -> BandMatrix:
        """The sum for the rows `jacobians`, (e, k) of every group, and their weights, (e,)."""
        for jacobian, weight, (start, shape) in zip(jacobians, weights, self._places, strict=True):
            rows = np.ascontiguousarray(jacobian.T)
            weighted = rows * weight
            block = self._values[start : start + shape[0] * shape[1]].reshape(shape)
            for i in range(len(rows)):
                np.multiply(rows[: i + 1], weighted[i], out=block[i * (i + 1) // 2 : (i + 1) * (i + 2) // 2])
        return self._layout.summed(self._slots, self._values)


class BandMatrix:
    """A symmetric matrix in the lower band of `layout`; `values` is its flat Fortran-order storage."""

    def __init__(self, layout: BandLayout, values: Floats) -> None:
        self.layout = layout
        self.values = values

    def plus(self, other: BandMatrix, factor: float = 1.0) -> BandMatrix:
        return BandMatrix(self.layout, self.values + factor * other.values)

    def factor(self) -> BandFactor | None:
        """Cholesky factor; None where the matrix is not finite or not positive definite to round-off."""
        shape = (self.layout.bandwidth + 1, self.layout.size)
        factor, info = dpbtrf(self.values.reshape(shape, order="F"), lower=1)
        return BandFactor(self.layout, factor) if info == 0 and np.isfinite(factor[0]).all() else None


class BandFactor:
    """L of A = L L^T; solves with vectors over all unknowns, fixed ones 0."""

    def __init__(self, layout: BandLayout, factor: Floats) -> None:
        self.layout = layout
        self._factor = factor

    def solve(self, right_side: Floats) -> Floats:
        """A x = b for the free unknowns; (3 m,) in, (3 m,) out."""
        unknowns = self.layout.unknowns
        solution, _ = dpbtrs(self._factor, right_side[unknowns], lower=1)
        result = np.zeros_like(right_side)
        result[unknowns] = solution
        return result
