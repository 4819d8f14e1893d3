"""Edges joined to chains."""

import numpy as np

from flatnet.geometry.chains import boundary_edges, chains


def test_an_open_chain_a_loop_and_a_fork():
    path, loop = [(3, 1), (1, 4), (4, 0)], [(7, 6), (6, 9), (9, 7)]
    assert chains(path + loop) == [[3, 1, 4, 0], [7, 6, 9, 7]]
    fork = chains([*path, (4, 5), (5, 2)])
    assert sorted(map(len, fork)) == [2, 3, 3]
    assert {chain[0] for chain in fork} | {chain[-1] for chain in fork} == {3, 4, 0, 2}


def test_a_figure_eight_is_two_loops_through_its_middle():
    eight = [(0, 1), (1, 2), (2, 0), (0, 3), (3, 4), (4, 0)]
    assert chains(eight) == [[0, 1, 2, 0], [0, 3, 4, 0]]


def test_the_boundary_runs_with_its_triangle_on_the_left():
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    [loop] = chains(boundary_edges(triangles))
    turns = [(0, 1, 2, 3, 0), (1, 2, 3, 0, 1), (2, 3, 0, 1, 2), (3, 0, 1, 2, 3)]
    assert tuple(loop) in turns
