"""One step of sequential quadratic programming: the sparse KKT system of a quadratic program with equalities."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csc_array, csr_matrix, identity
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]

#: Largest residual of the linear system, relative to its right-hand side, that counts as solved.
SOLVED = 1e-8
#: What a dependent constraint gives way, relative to the mean diagonal of A A^T.
GIVE = 1e-8


class KktStatus(Enum):
    """How the system was solved."""

    SOLVED = "solved"
    REGULARISED = "regularised"
    SINGULAR = "singular"


@dataclass(frozen=True, eq=False)
class KktStep:
    """Attributes: step (n,) delta; multipliers (m,) lambda; status, of which `SINGULAR` leaves both zero."""

    step: Floats
    multipliers: Floats
    status: KktStatus


def kkt_step(hessian: csr_matrix, jacobian: csr_matrix, gradient: Floats, residual: Floats) -> KktStep:
    """Solve Eq. 10,

        [ H   A^T ] [ delta  ]     [ g ]
        [ A    0  ] [ lambda ] = - [ c ],

    by SuperLU with its default ordering. Where rows of A vanish or depend on each other the system is singular;
    then -epsilon I in place of the zero block lets those rows give way.

    Parameters
    ----------
    hessian : (n, n) sparse H, symmetric or not.
    jacobian : (m, n) sparse A.
    gradient : (n,) g.
    residual : (m,) c.
    """
    n, m = len(gradient), len(residual)
    right = -np.concatenate([gradient, residual])
    give = GIVE * (jacobian.data @ jacobian.data) / max(m, 1)
    for epsilon, status in ((0.0, KktStatus.SOLVED), (give, KktStatus.REGULARISED)):
        corner = -epsilon * identity(m) if epsilon else None
        matrix = csc_array(block_array([[hessian, jacobian.T], [jacobian, corner]]))
        try:
            solution = splu(matrix).solve(right)
        except RuntimeError:  # SuperLU: a pivot is exactly zero
            continue
        wrong = np.linalg.norm(matrix @ solution - right)
        if np.isfinite(solution).all() and wrong <= SOLVED * np.linalg.norm(right):
            return KktStep(solution[:n], solution[n:], status)
    return KktStep(np.zeros(n), np.zeros(m), KktStatus.SINGULAR)
