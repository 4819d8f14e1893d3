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

    def slots(self, unknowns: Ints) -> Ints:
        """Flat band positions of the lower half of element blocks, (e, k (k + 1) / 2).

        `unknowns` (e, k) are full unknowns; pairs with a fixed one go to a slot past the end.
        """
        a, b = np.tril_indices(unknowns.shape[1])
        rows = self.row_of[unknowns]
        first, second = rows[:, a], rows[:, b]
        low, high = np.minimum(first, second), np.maximum(first, second)
        flat = (high - low) + low * (self.bandwidth + 1)
        flat[low < 0] = (self.bandwidth + 1) * self.size
        return flat

    def assemble(self, parts: Iterable[tuple[Ints, Floats]]) -> BandMatrix:
        """Sum (slots, values) pairs into a matrix."""
        band = np.zeros((self.bandwidth + 1) * self.size + 1)
        for slots, values in parts:
            band += np.bincount(slots.ravel(), weights=values.ravel(), minlength=len(band))
        return BandMatrix(self, band[:-1])


class BandMatrix:
    """A symmetric matrix in the lower band of `layout`; `values` is its flat Fortran-order storage."""

    def __init__(self, layout: BandLayout, values: Floats) -> None:
        self.layout = layout
        self.values = values

    def plus(self, other: BandMatrix, factor: float = 1.0) -> BandMatrix:
        return BandMatrix(self.layout, self.values + factor * other.values)

    def factor(self) -> BandFactor | None:
        """Cholesky factor; None where the matrix is not positive definite to round-off."""
        shape = (self.layout.bandwidth + 1, self.layout.size)
        factor, info = dpbtrf(self.values.reshape(shape, order="F"), lower=1)
        return BandFactor(self.layout, factor) if info == 0 else None


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


def block_values(jacobian: Floats, weights: Floats) -> Floats:
    """Lower half of w J^T J for every element, in the order of `BandLayout.slots`; J is (e, k)."""
    a, b = np.tril_indices(jacobian.shape[1])
    return jacobian[:, a] * (jacobian[:, b] * weights[:, None])
