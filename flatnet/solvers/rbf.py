"""Triharmonic radial basis functions with a linear polynomial (paper 3.3, Eq. 3)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve, qr, solve_triangular
from scipy.linalg.blas import dsymv, dsyr2
from scipy.linalg.lapack import dgecon, dpocon, dpotrf, dpotrs
from scipy.spatial.distance import cdist

Floats = NDArray[np.float64]

#: Kernels are evaluated in blocks of about so many entries, 16 MiB.
_BLOCK = 2**21


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
        step = max(1, _BLOCK // len(self.centres))
        blocks = [cdist(x[i : i + step], self.centres) ** 3 @ self.weights for i in range(0, len(x), step)]
        return np.concatenate(blocks) + self.polynomial[0] + x @ self.polynomial[1:]


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


@dataclass(frozen=True, eq=False)
class MirroredMap:
    """Psi of Eq. 3 on the plane z = 0, where the centres lie on it or in pairs mirrored by it.

    Psi(x) = p(x) + sum_i weight_i (|x - centre_i|^2 + height_i^2)^(3/2), a pair being one term with both weights.

    Attributes
    ----------
    centres : (k, 2), scaled and shifted as `scale` and `shift` say.
    heights : (k,), their distance from the plane, scaled; 0 on it.
    weights : (k, e).
    polynomial : (3, e).
    reciprocal_condition : of the linear system, in the 1-norm; 0 where the centres are degenerate.
    """

    centres: Floats
    heights: Floats
    weights: Floats
    polynomial: Floats
    scale: float
    shift: Floats
    reciprocal_condition: float

    def __call__(self, points: Floats) -> Floats:
        """Values (m, e) at points (m, 3) of the plane z = 0."""
        x = (points[:, :2] - self.shift) / self.scale
        return _mirrored_sum(x, np.zeros(len(x)), self.centres, self.heights, self.weights, self.polynomial)


def fit_mirrored(centres: Floats, values: Floats) -> MirroredMap:
    """What `fit_triharmonic` gives on the plane z = 0, to round-off, for centres that are mirrored by it.

    A function is the sum of its even and odd part in z, and so is its interpolant; on the plane the odd part is 0.
    The even part has one unknown for a pair of centres, and takes it to the mean of the pair's two values. On
    the weights that the side conditions leave free its symmetric matrix is positive definite (t^3 is conditionally
    positive definite of order 2), so Cholesky's factorisation does: for n pairs and m centres on the plane
    (n + m)^2 doubles, where the system of all has (2 n + m + 4)^2.

    Parameters
    ----------
    centres : (k, 3); those with z < 0 are the mirror images of those with z > 0, in the same order.
    values : (k, e).
    """
    z = centres[:, 2]
    above, below, level = (np.flatnonzero(side) for side in (z > 0.0, z < 0.0, z == 0.0))
    if not np.array_equal(centres[above], centres[below] * [1.0, 1.0, -1.0]):
        raise ValueError("centres must lie on the plane z = 0 or be mirrored by it")
    even = np.concatenate([level, above])
    wanted = np.concatenate([values[level], 0.5 * (values[above] + values[below])])
    shift = centres[even, :2].mean(axis=0)
    scale = float(np.abs(centres[even, :2] - shift).max()) or 1.0
    x, heights = (centres[even, :2] - shift) / scale, z[even] / scale
    system = _DefiniteSystem(_mirrored_matrix(x, heights), np.column_stack([np.ones(len(x)), x]))
    weights, polynomial = system.solve(wanted)
    # One step of iterative refinement: the factorisation loses a digit that the sum itself still has.
    left = wanted - _mirrored_sum(x, heights, x, heights, weights, polynomial)
    more, polynomial_more = system.solve(left)
    return MirroredMap(
        x, heights, weights + more, polynomial + polynomial_more, scale, shift, system.reciprocal_condition
    )


def _mirrored_kernel(x: Floats, heights: Floats, centres: Floats, of_centres: Floats) -> Floats:
    """Mean of |difference|^3 from each point to a centre and to its mirror image."""
    squares = cdist(x, centres, "sqeuclidean")
    both = np.ix_(heights > 0.0, of_centres > 0.0)  # elsewhere centre and image are equally far
    far = squares[both] + np.add.outer(heights[heights > 0.0], of_centres[of_centres > 0.0]) ** 2
    squares += np.subtract.outer(heights, of_centres) ** 2
    kernel = np.sqrt(squares)
    kernel *= squares
    kernel[both] = 0.5 * (kernel[both] + far * np.sqrt(far))
    return kernel


def _mirrored_sum(
    x: Floats, heights: Floats, centres: Floats, of_centres: Floats, weights: Floats, polynomial: Floats
) -> Floats:
    """Psi at points x (m, 2) of the given heights."""
    step = max(1, _BLOCK // len(centres))
    blocks = [
        _mirrored_kernel(x[i : i + step], heights[i : i + step], centres, of_centres) @ weights
        for i in range(0, len(x), step)
    ]
    return np.concatenate(blocks) + polynomial[0] + x @ polynomial[1:]


def _mirrored_matrix(x: Floats, heights: Floats) -> Floats:
    """The kernel between all centres, in Fortran order, its upper triangle at least."""
    matrix = np.zeros((len(x), len(x)), order="F")
    step = max(1, _BLOCK // len(x))
    for i in range(0, len(x), step):
        end = i + step
        matrix[:end, i:end] = _mirrored_kernel(x[i:end], heights[i:end], x[:end], heights[:end]).T
    return matrix


class _DefiniteSystem:
    """[A P; P^T 0] [weights; c] = [f; 0], A symmetric and positive definite where P^T weights = 0.

    With Q^T P = [R; 0], Q a product of Householder reflections, and B = Q^T A Q, the weights are Q [0; w]:
    B_22 w = (Q^T f)_2,    R c = (Q^T f)_1 - B_12 w.

    Attributes
    ----------
    reciprocal_condition : of B_22, in the 1-norm, or of R if that is less; 0 where B_22 is not definite or R
        singular, and then all solutions are nan.
    """

    def __init__(self, matrix: Floats, polynomials: Floats) -> None:
        """`matrix` : A, at least its upper triangle, in Fortran order, no entry below 0; overwritten."""
        self._count = count = polynomials.shape[1]
        norm = float(dsymv(1.0, matrix, np.ones(len(matrix))).max())
        (packed, scales), triangle = qr(polynomials, mode="raw")
        self._triangle = triangle[:count]
        self._reflections: list[tuple[Floats, float]] = []
        for column, scale in enumerate(scales):
            vector = packed[:, column].copy()
            vector[:column], vector[column] = 0.0, 1.0
            self._reflections.append((vector, scale))
            # H A H = A - v w^T - w v^T with H = 1 - scale v v^T
            image = scale * dsymv(1.0, matrix, vector)
            image -= 0.5 * scale * (vector @ image) * vector
            matrix = dsyr2(-1.0, vector, image, a=matrix, overwrite_a=1)
        self._coupling = matrix[:count, count:].copy()
        # A unit matrix in place of B_11, and nothing for B_12: to hand B_22 alone on would copy it.
        matrix[:count] = 0.0
        matrix[range(count), range(count)] = norm / len(matrix)
        self._factor, defect = dpotrf(matrix, clean=0, overwrite_a=1)
        of_polynomials = 1.0 / np.linalg.cond(self._triangle)
        self.reciprocal_condition = 0.0 if defect else min(float(dpocon(self._factor, norm)[0]), of_polynomials)

    def solve(self, right_side: Floats) -> tuple[Floats, Floats]:
        """Weights (k, e) and c (d, e) for f (k, e)."""
        if self.reciprocal_condition == 0.0:
            return np.full_like(right_side, np.nan), np.full((self._count, right_side.shape[1]), np.nan)
        turned = right_side.copy()
        for vector, scale in self._reflections:
            turned -= scale * np.outer(vector, vector @ turned)
        first = turned[: self._count].copy()
        turned[: self._count] = 0.0
        weights, _ = dpotrs(self._factor, turned)
        coefficients = solve_triangular(self._triangle, first - self._coupling @ weights[self._count :])
        for vector, scale in reversed(self._reflections):
            weights -= scale * np.outer(vector, vector @ weights)
        return weights, coefficients
