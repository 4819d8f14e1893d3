"""Triharmonic radial basis functions with a linear polynomial (paper 3.3, Eq. 3)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve
from scipy.linalg.lapack import dgecon
from scipy.spatial.distance import cdist

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TriharmonicMap:
    """Psi(x) = p(x) + sum_i lambda_i |x - centre_i|^3.

    Attributes
    ----------
    centres : (k, d), scaled and shifted as `scale` and `shift` say.
    weights : (k, e), lambda.
    polynomial : (d + 1, e).
    reciprocal_condition : of the linear system, in the 1-norm; near 0 where the centres are degenerate.
    """

    centres: Floats
    weights: Floats
    polynomial: Floats
    scale: float
    shift: Floats
    reciprocal_condition: float

    def __call__(self, points: Floats) -> Floats:
        x = (points - self.shift) / self.scale
        return cdist(x, self.centres) ** 3 @ self.weights + self.polynomial[0] + x @ self.polynomial[1:]


def fit_triharmonic(centres: Floats, values: Floats) -> TriharmonicMap:
    """The map that takes every centre (k, d) to its value (k, e), with sum lambda = sum lambda centre = 0.

    Dense: (k + d + 1)^2 doubles. A singular system gives a map with a reciprocal condition of 0 or nan values,
    never an exception; the caller judges.
    """
    count, dimension = centres.shape
    shift = centres.mean(axis=0)
    scale = float(np.abs(centres - shift).max()) or 1.0
    x = (centres - shift) / scale
    system = np.zeros((count + dimension + 1, count + dimension + 1))
    system[:count, :count] = cdist(x, x) ** 3
    system[:count, count] = system[count, :count] = 1.0
    system[:count, count + 1 :] = x
    system[count + 1 :, :count] = x.T
    right_side = np.zeros((len(system), values.shape[1]))
    right_side[:count] = values
    norm = np.abs(system).sum(axis=0).max()
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)  # the condition says so
        factor, pivots = lu_factor(system, check_finite=False)
        reciprocal, _ = dgecon(factor, norm)
        solution = lu_solve((factor, pivots), right_side, check_finite=False)
    return TriharmonicMap(x, solution[:count], solution[count:], scale, shift, float(reciprocal))
