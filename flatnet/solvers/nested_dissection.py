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
    links = np.stack([np.repeat(np.arange(len(points)), np.diff(graph.indptr)), graph.indices])
    _cut(links, points, np.arange(len(points)), parts)
    order = np.concatenate([own for own, _ in parts]) if parts else np.empty(0, dtype=np.int64)
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    fronts: list[Front] = []
    start = 0
    for own, children in parts:
        stop = start + len(own)
        neighbours = [graph.indices[graph.indptr[vertex] : graph.indptr[vertex + 1]] for vertex in own]
        coupled = [place[np.concatenate(neighbours)], *(fronts[child].later for child in children)]
        later = np.unique(np.concatenate(coupled))
        fronts.append(Front(start, stop, later[np.searchsorted(later, stop) :], children))
        start = stop
    return order, fronts


def _cut(links: Ints, points: Floats, part: Ints, parts: list[tuple[Ints, tuple[int, ...]]]) -> tuple[int, ...]:
    """Append the fronts of `part`, the last its separator; the index of that one, or of what stands for it.

    links : (2, e) the pairs of neighbours inside the part, both ways round.
    """
    if len(part) <= LEAF:
        if not len(part):
            return ()
        parts.append((part, ()))
        return (len(parts) - 1,)
    cuts = [_halves(links, points[:, axis], part) for axis in (0, 1)]
    axis = int(len(cuts[1][1]) < len(cuts[0][1]))
    first, separator = cuts[axis]
    # Which side each vertex lies on; what is not of this part counts as neither.
    side = np.zeros(len(points), dtype=np.int8)
    side[part], side[first], side[separator] = 2, 1, 0
    children: tuple[int, ...] = ()
    for half in (1, 2):
        inside = (side[links] == half).all(axis=0)
        children += _cut(links[:, inside], points, part[side[part] == half], parts)
    if not len(separator):
        return children
    # In order along the cut, so that what a front couples of it lies side by side.
    along = np.argsort(points[separator, 1 - axis], kind="stable")
    parts.append((separator[along], children))
    return (len(parts) - 1,)


def _halves(links: Ints, coordinate: Floats, part: Ints) -> tuple[Ints, Ints]:
    """The vertices in the first half of a part, and those of the others with a neighbour there."""
    lower = part[np.argsort(coordinate[part], kind="stable")[: len(part) // 2]]
    first = np.zeros(len(coordinate), dtype=bool)
    first[lower] = True
    touching = np.zeros(len(coordinate), dtype=bool)
    touching[links[1][first[links[0]]]] = True
    return lower, part[(touching & ~first)[part]]
