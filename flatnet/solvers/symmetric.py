"""Factor a sparse symmetric positive definite matrix for a few solutions, by SuperLU in its symmetric mode."""

from __future__ import annotations

from scipy.sparse import csc_array, csc_matrix, csr_array, csr_matrix
from scipy.sparse.linalg import SuperLU, splu


def factored(matrix: csc_matrix | csr_matrix | csc_array | csr_array) -> SuperLU:
    """Factor of a symmetric or Hermitian positive definite matrix, pivots on its diagonal.

    Minimum degree on A + A^T in place of SuperLU's default, which orders A^T A: a third of the fill on a mesh.
    """
    return splu(
        csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
