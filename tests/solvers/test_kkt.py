"""The KKT step against a dense solve, and where the constraints depend on each other."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, random_array

from flatnet.solvers.kkt import KktStatus, kkt_step


def quadratic_program(n=40, m=12, seed=0):
    rng = np.random.default_rng(seed)
    # Diagonally dominant and not symmetric, as H of Eq. 10 is.
    hessian = csr_matrix(random_array((n, n), density=0.1, rng=rng)) + csr_matrix(np.diag(rng.uniform(5, 9, n)))
    jacobian = csr_matrix(random_array((m, n), density=0.3, rng=rng))
    return hessian.tocsr(), jacobian, rng.normal(size=n), rng.normal(size=m)


@pytest.mark.parametrize("seed", range(5))
def test_same_step_as_a_dense_solve(seed):
    hessian, jacobian, gradient, residual = quadratic_program(seed=seed)
    h, a, m = hessian.toarray(), jacobian.toarray(), len(residual)
    matrix = np.block([[h, a.T], [a, np.zeros((m, m))]])
    dense = np.linalg.solve(matrix, -np.concatenate([gradient, residual]))
    solved = kkt_step(hessian, jacobian, gradient, residual)
    assert solved.status is KktStatus.SOLVED
    tolerance = 1e-14 * np.linalg.cond(matrix) * np.abs(dense).max()
    assert np.concatenate([solved.step, solved.multipliers]) == pytest.approx(dense, abs=tolerance)


def test_a_vanishing_and_a_repeated_constraint_give_way():
    hessian, jacobian, gradient, residual = quadratic_program()
    rows = jacobian.toarray()
    rows[3] = 0.0
    rows[5], residual[5] = rows[4], residual[4]
    solved = kkt_step(hessian, csr_matrix(rows), gradient, residual)
    assert solved.status is KktStatus.REGULARISED
    left = rows @ solved.step + residual
    assert np.abs(np.delete(left, 3)).max() < 1e-4
    assert np.isfinite(solved.step).all()


def test_an_unsolvable_system_says_so():
    nothing = csr_matrix((3, 3))
    solved = kkt_step(nothing, csr_matrix(np.eye(3)[:1]), np.ones(3), np.ones(1))
    assert solved.status is KktStatus.SINGULAR
    assert not solved.step.any()
