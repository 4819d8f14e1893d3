"""Nested dissection of a graph whose vertices have places in the plane: in which order to eliminate, and what fills.

A set of vertices is cut across at the median of one coordinate; those of the second half with a neighbour in the
first make the separator, which is eliminated after both. The halves are cut again, down to `LEAF` vertices. On a
planar mesh of n vertices the separators have O(sqrt n), the factor O(n log n) entries, made in O(n^1.5) operations
(George, 'Nested dissection of a regular finite element mesh', 1973).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Parts of at most so many vertices are not cut again: below, the calls cost more than the operations they save.
LEAF = 50


@dataclass(frozen=True, eq=False)
class Front:
    """A set of vertices eliminated together.

    Attributes
    ----------
    start, stop : its own vertices are `order[start:stop]`.
    later : (u,) places in the order, ascending, of the later vertices that the elimination couples.
    children : indices of the fronts whose updates it takes up.
    """

    start: int
    stop: int
    later: Ints
    children: tuple[int, ...]


def dissect(graph: csr_matrix, points: Floats) -> tuple[Ints, list[Front]]:
    """The order of elimination, (m,) vertex ids, and the fronts, each after its children.

    Parameters
    ----------
    graph : (m, m), symmetric pattern.
    points : (m, 2).
    """
    parts: list[tuple[Ints, tuple[int, ...]]] = []
    _cut(graph, points, np.arange(len(points)), parts)
    order = np.concatenate([own for own, _ in parts]) if parts else np.empty(0, dtype=np.int64)
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    fronts: list[Front] = []
    start = 0
    for own, children in parts:
        stop = start + len(own)
        coupled = [place[graph[own].indices], *(fronts[child].later for child in children)]
        later = np.unique(np.concatenate(coupled))
        fronts.append(Front(start, stop, later[np.searchsorted(later, stop) :], children))
        start = stop
    return order, fronts


def _cut(graph: csr_matrix, points: Floats, part: Ints, parts: list[tuple[Ints, tuple[int, ...]]]) -> tuple[int, ...]:
    """Append the fronts of `part`, the last its separator; the index of that one, or of what stands for it."""
    if len(part) <= LEAF:
        if not len(part):
            return ()
        parts.append((part, ()))
        return (len(parts) - 1,)
    inside = graph[part][:, part]
    cuts = [_halves(inside, points[part, axis]) for axis in (0, 1)]
    axis = int(cuts[1][1].sum() < cuts[0][1].sum())
    first, separator = cuts[axis]
    children = _cut(graph, points, part[first], parts) + _cut(graph, points, part[~first & ~separator], parts)
    if not separator.any():
        return children
    # In order along the cut, so that what a front couples of it lies side by side.
    along = np.argsort(points[part[separator], 1 - axis], kind="stable")
    parts.append((part[separator][along], children))
    return (len(parts) - 1,)


def _halves(graph: csr_matrix, coordinate: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which vertices lie in the first half, and which of the others have a neighbour there."""
    first = np.zeros(len(coordinate), dtype=bool)
    first[np.argsort(coordinate, kind="stable")[: len(coordinate) // 2]] = True
    return first, (graph @ first.astype(np.float64) > 0.0) & ~first
