"""The array of numbers, as annotations name it, and the symmetric eigenproblem of two matrices."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def eigh(A: Array, B: Array) -> tuple[Array, Array]:
    """Solve A v = lambda B v (both symmetric, B positive definite) by Cholesky's factor of B, as LAPACK's `dsygvd` does.

    By numpy alone, for `scipy.linalg` takes longer to import than all solutions of a run.

    Returns:
        Eigenvalues, ascending, (n,), and vectors with v.T B v = 1 as columns, (n, n).

    Raises:
        numpy.linalg.LinAlgError: B is not positive definite.
    """
    inverse = np.linalg.inv(np.linalg.cholesky(B))
    values, vectors = np.linalg.eigh(inverse @ A @ inverse.T)
    return values, inverse.T @ vectors
