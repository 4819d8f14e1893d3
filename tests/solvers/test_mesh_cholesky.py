"""Assembly, order of elimination and solution against dense linear algebra."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix, eye_array
from scipy.spatial import Delaunay

from flatnet.solvers.mesh_cholesky import BlockSum, MeshLayout
from flatnet.solvers.nested_dissection import LEAF, dissect


def planar_mesh(count, seed=0):
    points = np.random.default_rng(seed).uniform(size=(count, 2)) * [2.0, 1.0]
    return points, Delaunay(points).simplices.astype(np.int64)


def unknowns_of(elements):
    return (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), -1)


def graph_of(elements, count):
    size = elements.shape[1]
    entries = np.repeat(elements, size, axis=1).ravel(), np.tile(elements, size).ravel()
    return coo_matrix((np.ones(entries[0].size), entries), shape=(count, count)).tocsr()


@pytest.mark.parametrize("count", [12, 700])
def test_sum_of_element_blocks_and_its_solution_equal_the_dense_ones(count):
    """At 700 vertices there are several levels of fronts; a tenth of the vertices is fixed."""
    rng = np.random.default_rng(1)
    points, triangles = planar_mesh(count)
    edges = np.unique(np.sort(triangles[:, :2], axis=1), axis=0)
    free = rng.uniform(size=count) > 0.1
    layout = MeshLayout(points, free, [triangles, edges])
    assert count < 100 or len(layout.blocks) > 7
    jacobians = [rng.normal(size=(len(group), 3 * group.shape[1])) for group in (triangles, edges)]
    weights = [rng.uniform(0.5, 2.0, len(group)) for group in (triangles, edges)]
    scalar = graph_of(triangles, count)
    scalar = (scalar + 2.0 * scalar.sum(axis=1).max() * eye_array(count)).tocsr()
    matrix = BlockSum(layout, [triangles, edges])(jacobians, weights).plus(layout.on_every_axis(scalar), 0.5)
    dense = 0.5 * np.kron(scalar.toarray(), np.eye(3))
    for group, jacobian, weight in zip((triangles, edges), jacobians, weights, strict=True):
        for ids, row, w in zip(unknowns_of(group), jacobian, weight, strict=True):
            dense[np.ix_(ids, ids)] += w * np.outer(row, row)
    moving = np.flatnonzero(np.repeat(free, 3))
    right_side = rng.normal(size=3 * count)
    expected = np.zeros(3 * count)
    expected[moving] = np.linalg.solve(dense[np.ix_(moving, moving)], right_side[moving])
    np.testing.assert_allclose(matrix.factor().solve(right_side), expected, rtol=1e-11, atol=1e-13)


def test_parts_that_do_not_hang_together_are_solved_too():
    points, triangles = planar_mesh(200)
    both = np.concatenate([points, points + [5.0, 0.0]])
    elements = np.concatenate([triangles, triangles + len(points)])
    layout = MeshLayout(both, np.ones(len(both), dtype=bool), [elements])
    scalar = (graph_of(elements, len(both)) + 50.0 * eye_array(len(both))).tocsr()
    right_side = np.random.default_rng(2).normal(size=3 * len(both))
    solution = layout.on_every_axis(scalar).factor().solve(right_side).reshape(-1, 3)
    np.testing.assert_allclose(scalar @ solution, right_side.reshape(-1, 3), rtol=1e-10, atol=1e-12)


def test_an_indefinite_matrix_has_no_factor():
    points, triangles = planar_mesh(30)
    layout = MeshLayout(points, np.ones(30, dtype=bool), [triangles])
    assert layout.on_every_axis(-eye_array(30).tocsr()).factor() is None
    assert layout.on_every_axis(np.nan * eye_array(30).tocsr()).factor() is None


def test_every_vertex_is_eliminated_once_and_only_couples_later_ones():
    """What a front couples are all later neighbours of what has been eliminated in it and below it."""
    points, triangles = planar_mesh(1500)
    graph = graph_of(triangles, len(points))
    order, fronts = dissect(graph, points)
    assert np.array_equal(np.sort(order), np.arange(len(points)))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    below = []
    for front in fronts:
        eliminated = set(range(front.start, front.stop)).union(*(below[child] for child in front.children))
        below.append(eliminated)
        neighbours = set(place[graph[order[list(eliminated)]].indices])
        assert set(front.later) == neighbours - eliminated
        assert front.later.size == 0 or front.later.min() >= front.stop
    assert max(front.stop - front.start for front in fronts) <= LEAF + 40  # no separator is longer than some rows
