"""Least squares of a slow part, a drifting first mode and a second mode: variable projection with quasi-Newton steps.

The signal is modelled as  slow part + (1 + rho sigma) [a (T cos phi + Q sin phi) + b (T sin phi - Q cos phi)] + second mode  with

    phi = alpha (theta + kappa drift) + beta (sigma^2 - 1),

theta (rad) the phase by the mechanism's own frequency, sigma this phase scaled to [-1, 1], T the channel's response to the first mode and Q
the same a quarter period late, the drift the part of theta by which the mechanism's frequency departs from its mean, and the second mode
T2 {1, sigma2} {cos, sin}(alpha2 theta2). beta and kappa do not change the mean frequency: their factors are zero at both ends. Linear
coefficients are eliminated by orthogonal projection (Golub and Pereyra, 1973), the projection's own change is neglected in the Jacobian
(Kaufman, 1975), steps are damped (Levenberg, Marquardt) and kept within bounds. Each half cycle has 240 instants (`half_cycle`).

What the Gauss-Newton method leaves out of the second derivatives is as large as what it keeps where a mode is weak: its steps overshoot,
and a third of the fits is not at its minimum after 25 of them. It is learned from step to step (Dennis, Gay and Welsch, ACM Trans. Math.
Softw. 7, 1981, section 3), which leaves one fit in 150 and takes half as many evaluations.

Several fits run side by side, which takes a third of the time: their arrays are small. They do not depend on each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.time_scale import ChannelHalf
from quickreturn.reference_model.arrays import Array

PRIOR_STRENGTH = 0.006  # residual, as a part of the signal's RMS, that weighs as much as a parameter that is one of its scales off zero
PRIOR_SCALES = np.array([np.inf, 1.5, 0.15, 0.6, np.inf])  # alpha, beta, kappa, rho, alpha2; inf: no prior
MAXIMUM_STEPS = 25
STEP_TOLERANCE = 1e-5  # least step of a parameter: a thousandth of the least uncertainty that is ever reported
TINY: Final = 1e-300  # in place of a divisor that is zero
RANK: Final = 1e-10  # part of the columns' largest singular value below which a direction is ignored


@dataclass(frozen=True)
class Bounds:
    """Least and greatest alpha, beta, kappa, rho, alpha2, each of shape (5,); equal bounds fix a parameter."""

    low: Array
    high: Array

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which parameters are not fixed."""
        return self.high > self.low


@dataclass(frozen=True)
class Fit:
    """A minimum of the fit, in units of the signal's RMS."""

    parameters: Array  # alpha, beta, kappa, rho, alpha2
    weights: Array  # coefficients of the oscillating columns: a, b, then the second mode's four
    residual: Array  # shape (240,)
    cost: float  # sum of squares of the residual and the priors
    jacobian: Array  # projected oscillating columns, then projected derivatives with respect to the five parameters, shape (240, 11)

    def covariance(self, variance: float, bounds: Bounds) -> Array:
        """Covariance of weights and parameters if every instant has noise of a variance, shape (11, 11); zero where a parameter is fixed.

        The priors reduce the response of the estimate to noise: with normal matrix N and priors P it is (N + P)^-1 N (N + P)^-1.
        """
        free = np.concatenate([np.ones(6, dtype=bool), bounds.free])
        jacobian = self.jacobian[:, free]
        normal = jacobian.T @ jacobian
        with_priors = normal + np.diag(np.concatenate([np.zeros(6), _prior_weights(self.residual.size) ** 2])[free])
        scale = np.sqrt(np.diag(with_priors))
        scale[scale == 0.0] = 1.0
        inverse = np.linalg.pinv(with_priors / np.outer(scale, scale), rcond=1e-12) / np.outer(scale, scale)
        covariance = np.zeros((free.size, free.size))
        covariance[np.ix_(free, free)] = variance * inverse @ normal @ inverse
        return covariance

    @property
    def residual_rms(self) -> float:
        """RMS of the residual, relative to the signal's."""
        return float(np.sqrt(np.mean(self.residual**2)))


@dataclass(frozen=True)
class Waves:
    """Data for the modes' columns: of one channel in a half cycle, shape (240,), or of several, shape (m, 240)."""

    theta: Array  # phase of the first mode, rad
    drift: Array  # part of theta by which the frequency departs from its mean, rad
    sigma: Array  # theta scaled to [-1, 1]
    in_phase: Array  # T, the channel's response to the first mode
    late: Array  # Q, the same a quarter period late
    theta2: Array  # phase, place and response of the second mode
    sigma2: Array  # phase, place and response of the second mode
    in_phase2: Array  # phase, place and response of the second mode

    @classmethod
    def of(cls, channel: ChannelHalf) -> "Waves":
        """The data of one channel."""
        half = channel.half
        first_mode = half.phases[0], half.drift, half.places[0], channel.templates[0], channel.quadrature
        return cls(*first_mode, half.phases[1], half.places[1], channel.templates[1])

    @classmethod
    def stacked(cls, channels: Sequence[ChannelHalf]) -> "Waves":
        """The data of several channels."""
        of_channels = [vars(cls.of(channel)) for channel in channels]
        return cls(**{name: np.array([waves[name] for waves in of_channels]) for name in of_channels[0]})

    def at(self, places: NDArray[np.intp]) -> "Waves":
        """The data of some of the channels."""
        return Waves(**{name: values[places] for name, values in vars(self).items()})

    def first_mode(self, alpha: Any, beta: Any = 0.0, kappa: Any = 0.0, rho: Any = 0.0) -> Array:
        """The two columns of the drifting first mode, shape (240, 2); (m, 240, 2) of m channels, or with m parameters."""
        alpha, beta, kappa, rho = (np.asarray(each)[..., None] for each in (alpha, beta, kappa, rho))
        phase, growth = alpha * (self.theta + kappa * self.drift) + beta * (self.sigma**2 - 1.0), 1.0 + rho * self.sigma
        in_phase, late = growth * self.in_phase, growth * self.late
        cosine, sine = np.cos(phase), np.sin(phase)
        return np.stack([in_phase * cosine + late * sine, in_phase * sine - late * cosine], axis=-1)

    def second_mode(self, alpha2: Any) -> Array:
        """The four columns of the second mode, shape (240, 4); (m, 240, 4) of m channels, or with m parameters."""
        phase = np.asarray(alpha2)[..., None] * self.theta2
        cosine, sine = self.in_phase2 * np.cos(phase), self.in_phase2 * np.sin(phase)
        return np.stack([cosine, sine, self.sigma2 * cosine, self.sigma2 * sine], axis=-1)


def orthonormal(columns: Array) -> Array:
    """Orthonormal basis of the columns' span, shape as given."""
    return np.linalg.qr(columns)[0]


def without(basis: Array, columns: Array) -> Array:
    """The part of the columns, shape (..., 240, k), that is orthogonal to an orthonormal basis."""
    return np.asarray(columns - basis @ (np.swapaxes(basis, -1, -2) @ columns))


def left_by(columns: Array, signal: Array) -> Array:
    """Sums of squares that fits of a signal (240,) by each of several sets of columns (m, 240, k) leave, shape (m,)."""
    gram, right = np.swapaxes(columns, 1, 2) @ columns, np.swapaxes(columns, 1, 2) @ signal
    return np.asarray(signal @ signal - np.sum(right * np.linalg.solve(gram, right[..., None])[..., 0], axis=1))


@dataclass(frozen=True)
class Problem:
    """The problem of one fit."""

    channel: ChannelHalf  # the signal with its templates
    slow: Array  # orthonormal basis of the slow part, shape (240, k)
    start: Array  # alpha, beta, kappa, rho, alpha2 from which the fit descends, shape (5,)
    bounds: Bounds  # least and greatest values of these parameters


def refined(problems: Sequence[Problem]) -> list[Fit]:
    """Descend to a minimum within the bounds, in each of the problems by itself."""
    waves = Waves.stacked([problem.channel for problem in problems])
    widest = max(problem.slow.shape[1] for problem in problems)
    slow = np.array([np.pad(problem.slow, ((0, 0), (0, widest - problem.slow.shape[1]))) for problem in problems])
    signals = without(slow, np.array([problem.channel.signal for problem in problems])[..., None])[..., 0]
    low, high = (np.array([getattr(problem.bounds, end) for problem in problems]) for end in ("low", "high"))
    fits = _evaluated(waves, slow, signals, np.clip([problem.start for problem in problems], low, high))
    damping, active = np.full(len(problems), 1e-3), np.arange(len(problems))
    left_out = np.zeros((len(problems), 5, 5))
    for _ in range(MAXIMUM_STEPS):
        here = fits.at(active)
        steps = _steps(here, left_out[active], low[active], high[active], damping[active])
        trial = np.clip(here.parameters + steps, low[active], high[active])
        moves = np.abs(trial - here.parameters).max(axis=1) >= STEP_TOLERANCE
        active, trial = active[moves], trial[moves]
        if not active.size:
            break
        candidates = _evaluated(waves.at(active), slow[active], signals[active], trial)
        left_out[active] = _learned(left_out[active], here.at(moves), candidates)
        better = candidates.cost < fits.cost[active]
        fits.put(active[better], candidates.at(better))
        damping[active] *= np.where(better, 0.1, 10.0)
    return [fits.one(at) for at in range(len(problems))]


@dataclass(frozen=True)
class _Fits:
    """The numbers of several fits as `Fit` has them, each with one more axis in front."""

    parameters: Array
    weights: Array
    residual: Array
    cost: Array
    jacobian: Array

    @property
    def derivatives(self) -> Array:
        """Of the fitted signal by the parameters, shape (m, 240, 5); those of the residual are their opposites."""
        return self.jacobian[:, :, 6:]

    @property
    def gradient(self) -> Array:
        """Of half the cost by the parameters, shape (m, 5)."""
        prior = _prior_weights(self.residual.shape[1])
        return prior**2 * self.parameters - _projected(self.derivatives, self.residual)

    def at(self, places: NDArray[Any]) -> "_Fits":
        return _Fits(**{name: values[places] for name, values in vars(self).items()})

    def put(self, places: NDArray[np.intp], others: "_Fits") -> None:
        for name, values in vars(self).items():
            values[places] = getattr(others, name)

    def one(self, place: int) -> Fit:
        return Fit(self.parameters[place], self.weights[place], self.residual[place], float(self.cost[place]), self.jacobian[place])


def _steps(fits: _Fits, left_out: Array, low: Array, high: Array, damping: Array) -> Array:
    """Damped steps, shape (m, 5); parameters at a bound that they would leave stay there.

    `left_out`, shape (m, 5, 5): see `_learned`.
    """
    derivatives, gradient = fits.derivatives, fits.gradient
    normal = np.swapaxes(derivatives, 1, 2) @ derivatives + np.diag(_prior_weights(fits.residual.shape[1]) ** 2)
    blocked = ((fits.parameters <= low) & (gradient > 0.0)) | ((fits.parameters >= high) & (gradient < 0.0))
    moving = (high > low) & ~blocked
    block = np.where(moving[:, :, None] & moving[:, None, :], normal + left_out, 0.0)
    scale = np.einsum("mkk->mk", normal) + 1e-12 * fits.residual.shape[1]
    diagonal = np.where(moving, damping[:, None] * scale, 1.0)  # one for a parameter that stays
    damped = block + diagonal[:, :, None] * np.eye(5)
    return np.asarray(-np.linalg.solve(damped, np.where(moving, gradient, 0.0)[..., None])[..., 0])


def _learned(left_out: Array, here: _Fits, there: _Fits) -> Array:
    """What Gauss-Newton leaves out of the second derivatives of half the cost, shape (m, 5, 5), after a trial of the step from `here`.

    Along the step it becomes what the residual's derivatives show there. Before that it is made smaller if it was larger than they show.
    """

    def along(one: Array, other: Array) -> Array:
        return np.asarray(np.einsum("mk,mk->m", one, other))

    step, change = there.parameters - here.parameters, there.gradient - here.gradient
    shown, known = _projected(here.derivatives - there.derivatives, there.residual), _projected(left_out, step)
    sizing = np.minimum(1.0, np.abs(along(step, shown)) / np.maximum(np.abs(along(step, known)), TINY))
    missing, curvature = shown - sizing[:, None] * known, along(change, step)
    convex = curvature > 0.0  # otherwise the step shows nothing of a minimum
    change = change / np.where(convex, curvature, 1.0)[:, None]
    product = missing[:, :, None] * change[:, None, :]
    update = product + np.swapaxes(product, 1, 2) - along(missing, step)[:, None, None] * change[:, :, None] * change[:, None, :]
    return np.where(convex[:, None, None], sizing[:, None, None] * left_out + update, left_out)


def _projected(columns: Array, signals: Array) -> Array:
    """Products of columns, shape (m, n, k), with signals, shape (m, n): shape (m, k)."""
    return np.asarray((signals[:, None, :] @ columns)[:, 0])


def _prior_weights(samples: int) -> Array:
    return PRIOR_STRENGTH * np.sqrt(samples) / PRIOR_SCALES


def _evaluated(waves: Waves, slow: Array, signals: Array, parameters: Array) -> _Fits:
    """The fits with parameters of shape (m, 5); `slow` (m, 240, k) is orthonormal or zero, the signals (m, 240) are without it."""
    alpha, beta, kappa, rho, alpha2 = parameters.T
    first, second = waves.first_mode(alpha, beta, kappa, rho), waves.second_mode(alpha2)
    projected = without(slow, np.concatenate([first, second], axis=-1))
    basis, triangle = np.linalg.qr(projected)
    along = np.swapaxes(basis, 1, 2) @ signals[..., None]
    weights = (np.linalg.pinv(triangle, rcond=RANK) @ along)[..., 0]
    residual = signals - (projected @ weights[..., None])[..., 0]

    a, b, *of_second = weights.T[..., None]
    quarter_turned = first[..., 0] * b - first[..., 1] * a
    envelope_change = (first[..., 0] * a + first[..., 1] * b) * waves.sigma / (1.0 + rho[:, None] * waves.sigma)
    second_turned = second[..., 0] * of_second[1] - second[..., 1] * of_second[0]
    second_turned = second_turned + second[..., 2] * of_second[3] - second[..., 3] * of_second[2]
    derivatives = np.stack(
        [
            (waves.theta + kappa[:, None] * waves.drift) * quarter_turned,
            (waves.sigma**2 - 1.0) * quarter_turned,
            alpha[:, None] * waves.drift * quarter_turned,
            envelope_change,
            waves.theta2 * second_turned,
        ],
        axis=-1,
    )
    derivatives = without(basis, without(slow, derivatives))
    prior = _prior_weights(signals.shape[1]) * parameters
    cost = np.sum(residual**2, axis=1) + np.sum(prior**2, axis=1)
    return _Fits(parameters, weights, residual, cost, np.concatenate([projected, derivatives], axis=-1))
