"""Join edges that share vertices to chains: boundary loops, feature lines, sections."""

from __future__ import annotations

from collections.abc import Iterable

import networkx as nx
import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def boundary_edges(triangles: Ints) -> Ints:
    """The edges of one triangle only, (e, 2), in the direction that has the triangle on the left; sorted."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, counts = np.unique(np.sort(directed, axis=1), axis=0, return_index=True, return_counts=True)
    return directed[first[counts == 1]]


def chains(edges: Iterable[tuple[int, int]] | Ints) -> list[list[int]]:
    """The chains of edges between the vertices where other than two edges meet, then the loops without such.

    Each is the list of its vertices, of a loop the first again at the end; a loop runs in the direction in which
    its first edge is given. Every edge is in one chain.
    """
    graph = nx.Graph()
    graph.add_edges_from((int(a), int(b)) for a, b in edges)
    found = []
    left = {frozenset(edge): edge for edge in graph.edges}
    ends = [vertex for vertex in graph if graph.degree(vertex) != 2]
    for start in [*ends, *graph]:
        for following in graph[start]:
            if frozenset((start, following)) in left:
                chain = [start, following]
                del left[frozenset(chain)]
                while graph.degree(chain[-1]) == 2 and chain[-1] != start:
                    a, b = graph[chain[-1]]
                    chain.append(b if a == chain[-2] else a)
                    del left[frozenset(chain[-2:])]
                found.append(chain)
    return found
