"""The planar embedding of a network that has only one: the order of its curves around nodes without any normal."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import networkx as nx

from flatnet.network.graph import Dart
from flatnet.network.network import SampledStretch

#: The darts that leave every node.
Leaving = Mapping[str, list[Dart]]


def head(stretches: Mapping[str, SampledStretch], dart: Dart) -> str:
    """The node where a dart arrives."""
    stretch = stretches[dart.stretch]
    node = stretch.start if dart.reversed else stretch.end
    assert node is not None, "a closed curve without node has no darts at nodes"
    return node


def chains(
    stretches: Mapping[str, SampledStretch], leaving: Leaving, stations: Collection[str]
) -> list[tuple[Dart, ...]]:
    """The runs of darts from station to station, each in one direction; all other nodes have two darts at most.

    A run that meets no further station ends where no curve goes on.
    """
    runs: list[tuple[Dart, ...]] = []
    walked: set[Dart] = set()
    for node in (node for node in leaving if node in stations):
        for dart in leaving[node]:
            if dart in walked:
                continue
            run = [dart]
            while (end := head(stretches, run[-1])) not in stations:
                onward = [each for each in leaving[end] if each != run[-1].opposite]
                if not onward:
                    break
                run.append(onward[0])
            walked |= {dart, run[-1].opposite}
            runs.append(tuple(run))
    return runs


def unique_embedding(stretches: Mapping[str, SampledStretch], leaving: Leaving) -> dict[str, list[Dart]] | None:
    """The cyclic order of the darts at the junctions of one connected network, if its graph leaves no choice.

    Curves that end at a node by themselves are cut back first and nodes where only two curves meet are passed
    over. What remains has one embedding in the sphere, up to its mirror image, where it is planar, 3-connected and
    has no two curves between the same nodes (Whitney 1933).

    Returns
    -------
    junction -> its darts that belong to loops, all clockwise or all anticlockwise; None where there is a choice.
    """
    core = _without_dead_ends(stretches, leaving)
    junctions = {node for node, darts in core.items() if len(darts) > 2}
    first_dart: dict[tuple[str, str], Dart] = {}
    graph = nx.Graph()
    for run in chains(stretches, core, junctions):
        a, b = head(stretches, run[0].opposite), head(stretches, run[-1])
        if a == b or graph.has_edge(a, b):
            return None
        graph.add_edge(a, b)
        first_dart[a, b], first_dart[b, a] = run[0], run[-1].opposite
    if len(graph) < 4 or min(degree for _, degree in graph.degree) < 3:
        return None
    planar, embedding = nx.check_planarity(graph)
    if not planar or nx.node_connectivity(graph) < 3:
        return None
    return {node: [first_dart[node, other] for other in embedding.neighbors_cw_order(node)] for node in graph}


def _without_dead_ends(stretches: Mapping[str, SampledStretch], leaving: Leaving) -> dict[str, list[Dart]]:
    core = {node: list(darts) for node, darts in leaving.items()}
    ends = [node for node, darts in core.items() if len(darts) == 1]
    while ends:
        node = ends.pop()
        if not core[node]:  # both ends of a lone curve
            continue
        [dart] = core[node]
        other = head(stretches, dart)
        core[node] = []
        core[other].remove(dart.opposite)
        if len(core[other]) == 1:
            ends.append(other)
    return {node: darts for node, darts in core.items() if darts}
