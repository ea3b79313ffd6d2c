"""Interpolates a number between the computed machines, with the error that it has at machines which it has not seen.

A Gaussian process with a polynomial trend (Rasmussen and Williams, "Gaussian Processes for Machine Learning", 2006, chapter 2): with the
covariance K = trend trend' T^2 + exp(-|x - x'|^2 / 2 l^2) + noise, the mean is k' K^-1 y, and the error at point i without that point is
(K^-1 y)_i / (K^-1)_ii (equation 5.12 there). Length and noise are those with the smallest such errors.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.plugins.thesis.inference.unknowns import NAMES, clearance_of, preload_of
from quickreturn.reference_model.arrays import Array

#: Standard deviation of the trend's weights: so large that they are free.
TREND: Final = 100.0
#: Lengths, in standard deviations of the features, and variances of the noise, in those of the process, that are tried.
LENGTHS: Final = (1.5, 3.0, 6.0)
NOISES: Final = (1e-3, 1e-2, 1e-1, 1.0)
#: Least number of machines to interpolate between.
FEWEST: Final = 20
#: Force of the slider, N, above which a preload lets a roller part: 0.6 of the peaks of 7 to 18 N in the runs.
FORCE: Final = 7.0
#: Stiffness (kN/m) of the arm against the slider: with `plus` 10 and 6 kN/m the first frequency of run 24 falls by 4 and 7 %.
ARM: Final = 0.85


def features(machines: Array, mass: Array | float = 0.0) -> Array:
    """What moves the readings, shape (n, features), from machines, shape (n, unknowns).

    `mass`: of the slider beyond the compliance, kg, which lowers the stiffness that the first mode meets by m omega^2.
    """
    of = dict(zip(NAMES, np.asarray(machines).T, strict=True))
    loaded, clearance = preload_of(of["joint"]), clearance_of(of["joint"])
    plus, minus = (of[side] - 1e-3 * mass * FIRST_MODE**2 for side in ("plus", "minus"))
    columns = [np.log(of["stiffness"])]
    for own, other in ((plus, minus), (minus, plus)):
        ratio = np.where(np.isinf(own), 1.0, own / np.where(np.isinf(other), 1.0, other))
        closed = 2.0 / np.pi * np.arcsin(np.minimum(1.0, loaded * (1.0 + ratio) / FORCE))
        compliance = closed / (own + other) + (1.0 - closed) / own
        columns.append(np.log1p(ARM * of["stiffness"] * compliance))
    columns += [1e3 * clearance, np.sqrt(loaded), of["tip"], np.log(of["damping"]), np.log(of["crank"]), np.log(of["loss"])]
    return np.column_stack(columns)


#: Angular frequency of the first mode, rad/s, with which a mass beyond the compliance swings.
FIRST_MODE: Final = 2.0 * np.pi * 18.0


@dataclass(frozen=True)
class Emulated:
    """A number at some machines."""

    mean: Array  # shape (n,)
    error: float  # standard deviation at machines that were not computed, robust: 1.48 times the median magnitude; inf if too few are known
    count: int  # number of computed machines that have the number


class Emulator:
    """Interpolation from the computed machines to others."""

    def __init__(self, computed: Array, wanted: Array) -> None:
        """`computed` and `wanted`: features of both, shape (m, features) and (n, features)."""
        centre, scale = computed.mean(axis=0), computed.std(axis=0)
        known, other = (computed - centre) / scale, (wanted - centre) / scale
        self._trends = TREND * _trend(known), TREND * _trend(other)
        squares = [np.sum(each**2, axis=1)[:, None] + np.sum(known**2, axis=1) - 2.0 * each @ known.T for each in (known, other)]
        self._kernels = {length: [np.exp(-0.5 * square / length**2) for square in squares] for length in LENGTHS}

    def __call__(self, values: Array, *, flat: bool = False) -> Emulated:
        """The number at the wanted machines.

        `values`: at the computed ones, shape (m,), NaN where it is not known; `flat`: with a constant in place of the trend.
        """
        has = np.isfinite(values)
        if has.sum() < FEWEST:
            return Emulated(np.zeros(len(self._trends[1])), np.inf, int(has.sum()))
        y, trends = values[has] - np.mean(values[has]), [self._trends[0][has], self._trends[1]]
        if flat:
            trends = [each[:, :1] for each in trends]
        size, best = max(float(np.std(y)), 1e-12), (np.inf, LENGTHS[0], y, y)
        for length in LENGTHS:
            for noise in NOISES:
                covariance = trends[0] @ trends[0].T + self._kernels[length][0][np.ix_(has, has)] + noise * np.eye(len(y))
                inverse = np.linalg.inv(covariance)
                weights = inverse @ (y / size)
                unseen = weights / np.diag(inverse)
                if (spread := 1.4826 * float(np.median(np.abs(unseen)))) < best[0]:
                    best = (spread, length, weights, unseen)
        spread, length, weights, _ = best
        mean = (trends[1] @ (trends[0].T @ weights)) + self._kernels[length][1][:, has] @ weights
        return Emulated(size * mean + float(np.mean(values[has])), size * spread, int(has.sum()))


def _trend(scaled: Array) -> Array:
    """A constant, the features, and the squares and products of the first three: stiffness and both compliances."""
    first = scaled[:, :3]
    products = [first[:, i] * first[:, j] for i in range(3) for j in range(i, 3)]
    return np.column_stack([np.ones(len(scaled)), scaled, *products])
