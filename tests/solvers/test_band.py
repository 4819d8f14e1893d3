"""Band assembly and solution against dense linear algebra."""

import numpy as np

from flatnet.solvers.band import BandLayout, BlockSum


def chain(count):
    """Elements of three vertices along a strip, the first two vertices fixed."""
    elements = np.stack([np.arange(count - 2), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    free = np.ones(count, dtype=bool)
    free[:2] = False
    return elements, free


def test_sum_of_element_blocks_and_its_solution_equal_the_dense_ones():
    rng = np.random.default_rng(0)
    elements, free = chain(12)
    layout = BandLayout(free, [elements])
    unknowns = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 9)
    jacobian, weights = rng.normal(size=(len(elements), 9)), rng.uniform(0.5, 2.0, len(elements))
    unit = layout.summed(layout.slots(np.arange(36), np.arange(36)), np.ones(36))
    matrix = BlockSum(layout, [unknowns])([jacobian], [weights]).plus(unit)
    dense = np.eye(36)
    for ids, row, weight in zip(unknowns, jacobian, weights, strict=True):
        dense[np.ix_(ids, ids)] += weight * np.outer(row, row)
    moving = np.flatnonzero(np.repeat(free, 3))
    right_side = rng.normal(size=36)
    expected = np.zeros(36)
    expected[moving] = np.linalg.solve(dense[np.ix_(moving, moving)], right_side[moving])
    np.testing.assert_allclose(matrix.factor().solve(right_side), expected, rtol=1e-12, atol=1e-14)


def test_an_indefinite_matrix_has_no_factor():
    elements, free = chain(6)
    layout = BandLayout(free, [elements])
    diagonal = layout.slots(np.arange(18), np.arange(18))
    assert layout.summed(diagonal, -np.ones(18)).factor() is None
