"""Covariance of a least-squares fit with correlated residuals.

The residuals of a real table are not independent: noise is coloured, and errors of the model are smooth. So the covariance comes
from the residuals' own spectra (the sandwich estimate: W. K. Newey, K. D. West, Econometrica 55, 1987, 703; here in the frequency domain
and for all columns together).
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A direction counts as not determined if its standard error is larger than this part of the parameters or of their ranges ...
LOOSE: Final = 0.1
#: ... or if a change by that part changes the table by less than this part, which is about the simulation's accuracy.
LEAST_CHANGE: Final = 2e-4


def best_step(slopes: Array, residuals: Array, weights: Array) -> Array:
    """Change of the coordinates, (p,), that most reduces the residuals, (C, N), weighted by (C,); `slopes`: its effect, (C, N, p)."""
    matrix = (slopes * weights[:, None, None]).reshape(-1, slopes.shape[2])
    return np.asarray(np.linalg.lstsq(matrix, (residuals * weights[:, None]).ravel(), rcond=LEAST_CHANGE)[0])


def covariance(residuals: Array, slopes: Array) -> tuple[Array, Array]:
    """Covariance of a least-squares estimate with correlated residuals, and that with independent ones.

    Spectra and cross-spectra are averaged over 2 sqrt(N) + 1 of 2 N frequencies, so correlations over up to sqrt(N) rows count.

    Args:
        residuals: weighted, shape (C, N).
        slopes: their derivatives by the parameters, shape (C, N, p).

    Returns:
        Both of shape (p, p).
    """
    channels, rows, count = slopes.shape
    matrix = slopes.reshape(-1, count)
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    bread = np.linalg.pinv((matrix / sizes).T @ (matrix / sizes), rcond=1e-14, hermitian=True)
    spectra = np.fft.fft(residuals, 2 * rows, axis=1)
    of_slopes = np.fft.fft(slopes / sizes, 2 * rows, axis=1)
    width = 2 * math.isqrt(rows) + 1
    window = np.fft.fft(np.roll(np.pad(np.full(width, 1.0 / width), (0, 2 * rows - width)), -(width // 2)))
    filling = np.zeros((count, count), dtype=complex)
    for one in range(channels):
        for other in range(channels):
            smoothed = np.fft.ifft(np.fft.fft(spectra[one] * np.conj(spectra[other])) * window) / rows
            filling += np.einsum("fi,f,fj->ij", np.conj(of_slopes[one]), smoothed, of_slopes[other]) / (2 * rows)
    freedom = channels * rows / (channels * rows - count)
    scale = np.outer(sizes, sizes)
    independent = bread * float(np.mean(residuals**2)) * freedom / scale
    correlated = bread @ np.real(filling + filling.conj().T) @ bread * 0.5 * freedom / scale
    variances = np.diag(correlated)  # the scatter of the spectra must not make them smaller than for independent residuals
    wider = np.sqrt(np.maximum(1.0, np.diag(independent) / np.where(variances > 0.0, variances, math.inf)))
    return correlated * np.outer(wider, wider), independent


def reach(slopes: Array, levels: Array) -> Array:
    """Bound of what errors of known size do to a least-squares estimate, whatever their course in time, shape (p, p).

    Errors e_c of the columns with RMS up to t_c move the estimate by b = sum_c P_c e_c, where P is the pseudo-inverse of the slopes. With
    M = sqrt(C N) [t_1 P_1, ..., t_C P_C] this is b = M u with |u| <= 1, so that b lies in the ellipsoid of M M^T, which is returned. More
    rows do not make it smaller: such an error is no noise, and may look like the effect of a parameter throughout.

    Args:
        slopes: weighted, shape (C, N, p).
        levels: weighted RMS of the errors, shape (C,).
    """
    channels, rows, count = slopes.shape
    matrix = slopes.reshape(-1, count)
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    bread = np.linalg.pinv((matrix / sizes).T @ (matrix / sizes), rcond=1e-14, hermitian=True)
    moved = (slopes / sizes) @ bread / sizes * levels[:, None, None]  # of each coordinate by an error of `levels` in one row
    return np.asarray(channels * rows * np.einsum("cnk,cnl->kl", moved, moved))


def smooth_part(residuals: Array) -> float:
    """Part of the squared residuals, shape (C, N), that is smooth from row to row: 0 for independent noise.

    Third differences of independent numbers of variance v have the variance 20 v; those of a smooth course are small.
    """
    noise = float(np.mean(np.diff(residuals, 3, axis=1) ** 2)) / 20.0
    square = float(np.mean(residuals**2))
    return max(0.0, 1.0 - noise / square) if square > 0.0 else 0.0


def undetermined(sensitivities: Array, spread: Array) -> list[Array]:
    """Unit vectors of coordinates that a table does not determine, shape (p,) each.

    Args:
        sensitivities: relative change of each column by each coordinate, shape (C, N, p).
        spread: covariance of the coordinates, shape (p, p).
    """
    matrix = sensitivities.reshape(-1, len(spread))
    _, values, vectors = np.linalg.svd(matrix / math.sqrt(len(matrix)), full_matrices=False)
    errors = np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", vectors, spread, vectors), 0.0))
    return [vector for vector, value, error in zip(vectors, values, errors, strict=True) if LOOSE * value < LEAST_CHANGE or error > LOOSE]
