"""Symmetric positive definite systems with three unknowns a vertex, summed from small element blocks.

The factor is multifrontal: every front of a nested dissection is a dense matrix over its own vertices and the later
ones that they couple; its own part is factored by LAPACK, the rest is handed up to the next front (Duff and Reid,
'The multifrontal solution of indefinite sparse symmetric linear equations', 1983). A front is kept in three blocks,
own x own, later x own and later x later, lower triangles in Fortran order, so that no call copies.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm, dtrsv
from scipy.linalg.lapack import dpotrf
from scipy.sparse import coo_matrix, csr_matrix

from flatnet.solvers.nested_dissection import Front, dissect

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

AXES = np.arange(3)


@dataclass(frozen=True, eq=False)
class _Block:
    """A front in unknowns, and how it is filled and handed up.

    Attributes
    ----------
    own : slice of the unknowns that are eliminated here.
    later : (u,) the unknowns that they couple.
    entries, places : where the matrix's own entries stand in its values, and in the front's first columns.
    parent : index of the front that takes up the update, -1 at a root.
    runs : (from, to, to where) of the runs of `later` that lie side by side in the parent's front too.
    """

    own: slice
    later: Ints
    entries: Ints
    places: Ints
    parent: int
    runs: list[tuple[int, int, int]]


class MeshLayout:
    """Where the entries of a matrix over the free vertices are kept, and how it is factored.

    The values are blocks of 3 x 3 over pairs of vertices, the later vertex first, sorted by the earlier one.

    Parameters
    ----------
    points : (m, 2) places of the vertices in the plane; only the order of elimination depends on them.
    free : (m,) bool; which vertices move.
    elements : (e, k) int arrays of vertex ids; the matrix couples all vertices of an element.

    Attributes
    ----------
    unknowns : (3 f,) int; full unknown (3 * vertex + axis) of every row, in the order of elimination.
    """

    def __init__(self, points: Floats, free: NDArray[np.bool_], elements: Iterable[Ints]) -> None:
        moving = np.flatnonzero(free)
        self.count = len(moving)
        self._place = np.full(len(free), -1)
        self._place[moving] = np.arange(self.count)
        pairs = np.unique(np.concatenate([self._pairs(element).ravel() for element in elements]))
        late, early = self._pair_of(pairs[pairs >= 0])
        graph = coo_matrix((np.ones(len(late)), (late, early)), shape=(self.count, self.count)).tocsr()
        order, fronts = dissect((graph + graph.T).tocsr(), points[moving])
        place = np.empty_like(order)
        place[order] = np.arange(self.count)
        self._place[moving] = place
        late, early = np.maximum(place[late], place[early]), np.minimum(place[late], place[early])
        self._keys = np.sort(early * self.count + late)
        self.size = 9 * len(self._keys)
        self.unknowns = (3 * moving[order][:, None] + AXES).ravel()
        self.blocks = self._blocks(fronts)

    def _pairs(self, elements: Ints) -> Ints:
        """Keys of the pairs of vertices of every element, (k (k + 1) / 2, e); -1 where one is fixed."""
        rows, columns = np.tril_indices(elements.shape[1])
        place = self._place[elements.T]
        first, second = place[rows], place[columns]
        low = np.minimum(first, second)
        return np.where(low < 0, -1, low * self.count + np.maximum(first, second))

    def _pair_of(self, keys: Ints) -> tuple[Ints, Ints]:
        """The later and the earlier vertex of a pair."""
        early, late = np.divmod(keys, max(self.count, 1))
        return late, early

    def slots(self, elements: Ints) -> Ints:
        """Places among the values of the lower triangle of every element's matrix, (3 k (3 k + 1) / 2, e).

        Entries with a fixed vertex go past the end.
        """
        size = elements.shape[1]
        keys = self._pairs(elements)
        pair = np.where(keys < 0, -1, np.searchsorted(self._keys, keys))
        place = self._place[elements.T]
        rows, columns = np.tril_indices(size)
        swapped = place[rows] < place[columns]
        # The rows of the element's matrix, three for each vertex, and which pair of vertices each entry is of.
        row, column = np.tril_indices(3 * size)
        (i, a), (j, b) = np.divmod(row, 3), np.divmod(column, 3)
        at = i * (i + 1) // 2 + j
        inside = np.where(swapped[at], (3 * b + a)[:, None], (3 * a + b)[:, None])
        return np.where(pair[at] < 0, self.size, 9 * pair[at] + inside)

    def _blocks(self, fronts: list[Front]) -> list[_Block]:
        parents = np.full(len(fronts), -1)
        for index, front in enumerate(fronts):
            parents[list(front.children)] = index
        late, early = self._pair_of(self._keys)
        starts = np.searchsorted(early, np.arange(self.count + 1))
        blocks = []
        for front, parent in zip(fronts, parents, strict=True):
            own = front.stop - front.start
            pairs = np.arange(starts[front.start], starts[front.stop])
            below = np.searchsorted(front.later, late[pairs]) + own
            row = np.where(late[pairs] < front.stop, late[pairs] - front.start, below)
            column = early[pairs] - front.start
            height = 3 * (own + len(front.later))
            places = (3 * row[:, None, None] + AXES[:, None]) + height * (3 * column[:, None, None] + AXES)
            entries = 9 * pairs[:, None, None] + 3 * AXES[:, None] + AXES
            runs = _runs(front, fronts[parent]) if len(front.later) else []
            blocks.append(
                _Block(
                    slice(3 * front.start, 3 * front.stop),
                    _thrice(front.later),
                    entries.ravel(),
                    places.ravel(),
                    int(parent),
                    runs,
                )
            )
        return blocks

    def on_every_axis(self, matrix: csr_matrix) -> MeshMatrix:
        """A symmetric matrix over the vertices, (m, m), the same for every axis."""
        entries = matrix.tocoo()
        row, column = self._place[entries.row], self._place[entries.col]
        lower = (column >= 0) & (row >= column)
        pair = np.searchsorted(self._keys, column[lower] * self.count + row[lower])
        slots = 9 * pair + 4 * AXES[:, None]
        return self.summed(slots.ravel(), np.tile(entries.data[lower], 3))

    def summed(self, slots: Ints, values: Floats) -> MeshMatrix:
        """The matrix whose entries are the values summed at their slots."""
        sums = np.bincount(slots, weights=values, minlength=self.size + 1)
        return MeshMatrix(self, np.asarray(sums[: self.size], dtype=np.float64))


def _runs(front: Front, parent: Front) -> list[tuple[int, int, int]]:
    """Runs of the front's later unknowns that stay side by side in its parent's; none crosses own and later."""
    own = parent.stop - parent.start
    place = np.searchsorted(parent.later, front.later) + own
    place = np.where(front.later < parent.stop, front.later - parent.start, place)
    ends = np.flatnonzero((np.diff(place) != 1) | (place[1:] == own)) + 1
    starts = [0, *ends.tolist()]
    return [(3 * i, 3 * j, 3 * int(place[i])) for i, j in zip(starts, [*ends.tolist(), len(place)], strict=True)]


def _thrice(vertices: Ints) -> Ints:
    return (3 * vertices[:, None] + AXES).ravel()


class BlockSum:
    """Sums w J^T J over groups of elements, J one row per element, into a matrix.

    Parameters
    ----------
    groups : (e, k) vertex ids of the elements of every group.
    """

    def __init__(self, layout: MeshLayout, groups: Iterable[Ints]) -> None:
        self._layout = layout
        slots, self._places, start = [], [], 0
        for elements in groups:
            block = layout.slots(elements)
            slots.append(block.ravel())
            self._places.append((start, block.shape))
            start += block.size
        self._slots = np.concatenate(slots)
        self._values = np.empty(start)

    def __call__(self, jacobians: Iterable[Floats], weights: Iterable[Floats]) -> MeshMatrix:
        """The sum for the rows `jacobians`, (e, 3 k) of every group, and their weights, (e,)."""
        for jacobian, weight, (start, shape) in zip(jacobians, weights, self._places, strict=True):
            rows = np.ascontiguousarray(jacobian.T)
            weighted = rows * weight
            block = self._values[start : start + shape[0] * shape[1]].reshape(shape)
            for i in range(len(rows)):
                np.multiply(rows[: i + 1], weighted[i], out=block[i * (i + 1) // 2 : (i + 1) * (i + 2) // 2])
        return self._layout.summed(self._slots, self._values)


class MeshMatrix:
    """A symmetric matrix in the blocks of `layout`; of a block on the diagonal only the lower triangle counts."""

    def __init__(self, layout: MeshLayout, values: Floats) -> None:
        self.layout = layout
        self.values = values

    def plus(self, other: MeshMatrix, factor: float = 1.0) -> MeshMatrix:
        return MeshMatrix(self.layout, self.values + factor * other.values)

    def factor(self) -> MeshFactor | None:
        """Cholesky factor; None where the matrix is not finite or not positive definite to round-off."""
        blocks = self.layout.blocks
        updates: dict[int, Floats] = {}
        children: list[list[int]] = [[] for _ in blocks]
        diagonals, lowers = [], []
        for index, block in enumerate(blocks):
            own, later = block.own.stop - block.own.start, len(block.later)
            front = np.zeros((own + later) * own)
            front[block.places] = self.values[block.entries]
            front = front.reshape((own + later, own), order="F")
            update = np.zeros((later, later), order="F")
            for child in children[index]:
                _take_up(front, update, own, blocks[child].runs, updates.pop(child))
            diagonal, info = dpotrf(front[:own], lower=1, clean=0)
            if info != 0 or not np.isfinite(np.diagonal(diagonal)).all():
                return None
            lower = dtrsm(1.0, diagonal, front[own:], side=1, lower=1, trans_a=1)
            if later:
                updates[index] = dsyrk(-1.0, lower, beta=1.0, c=update, lower=1, overwrite_c=1)
                children[block.parent].append(index)
            diagonals.append(diagonal)
            lowers.append(lower)
        return MeshFactor(self.layout, diagonals, lowers)


def _take_up(front: Floats, update: Floats, own: int, runs: list[tuple[int, int, int]], handed: Floats) -> None:
    """Add the lower triangle of a child's update to its parent's columns and update."""
    for j, (left, right, column) in enumerate(runs):
        target, place, above = (front, column, 0) if column < own else (update, column - own, own)
        for top, bottom, row in runs[j:]:
            at = row - above
            target[at : at + bottom - top, place : place + right - left] += handed[top:bottom, left:right]


class MeshFactor:
    """L of A = L L^T; solves with vectors over all unknowns, fixed ones 0."""

    def __init__(self, layout: MeshLayout, diagonals: list[Floats], lowers: list[Floats]) -> None:
        self.layout = layout
        self._fronts = list(zip(layout.blocks, diagonals, lowers, strict=True))

    def solve(self, right_side: Floats) -> Floats:
        """A x = b for the free unknowns; (3 m,) in, (3 m,) out."""
        x = right_side[self.layout.unknowns]
        for block, diagonal, lower in self._fronts:
            x[block.own] = dtrsv(diagonal, x[block.own], lower=1)
            x[block.later] -= lower @ x[block.own]
        for block, diagonal, lower in reversed(self._fronts):
            right = x[block.own] - x[block.later] @ lower
            x[block.own] = dtrsv(diagonal, right, lower=1, trans=1)
        result = np.zeros_like(right_side)
        result[self.layout.unknowns] = x
        return result
