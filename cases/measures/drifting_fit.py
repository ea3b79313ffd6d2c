"""Least squares of a slow part, a drifting first mode and a second mode: variable projection with Gauss-Newton steps.

The signal is modelled as  slow part + (1 + rho sigma) [a (T cos phi + Q sin phi) + b (T sin phi - Q cos phi)] + second mode  with

    phi = alpha (theta + kappa drift) + beta (sigma^2 - 1),

Q the channel's response a quarter period late, the drift the part of theta by which the mechanism's frequency departs from its mean,
and the second mode T2 {1, sigma2} {cos, sin}(alpha2 theta2). beta and kappa leave the mean frequency alone: what they multiply is zero at
both ends. Linear coefficients are eliminated by orthogonal projection (Golub and Pereyra, 1973), the projection's own change is neglected
in the Jacobian (Kaufman, 1975), steps are damped (Levenberg, Marquardt) and held within bounds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.measures.half_cycle import ChannelHalf

Array = NDArray[np.float64]

PRIOR_STRENGTH = 0.006  # of the signal's RMS, per scale below
PRIOR_SCALES = np.array([np.inf, 1.5, 0.15, 0.6, np.inf])  # alpha, beta, kappa, rho, alpha2
MAXIMUM_STEPS = 25
STEP_TOLERANCE = 1e-5  # in any parameter, a thousandth of the least uncertainty that is ever reported


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
        """Of weights and parameters, from noise of the given variance at every instant, shape (11, 11); zero where a parameter is fixed.

        The priors hold the estimate back: with normal matrix N and priors P it follows noise as (N + P)^-1 N (N + P)^-1.
        """
        counted = np.concatenate([np.ones(6, dtype=bool), bounds.free])
        jacobian = self.jacobian[:, counted]
        noise = jacobian.T @ jacobian
        held = noise + np.diag(np.concatenate([np.zeros(6), _prior_weights(self.residual.size) ** 2])[counted])
        scale = np.sqrt(np.diag(held))
        scale[scale == 0.0] = 1.0
        inverse = np.linalg.pinv(held / np.outer(scale, scale), rcond=1e-12) / np.outer(scale, scale)
        full = np.zeros((counted.size, counted.size))
        full[np.ix_(counted, counted)] = variance * inverse @ noise @ inverse
        return full

    @property
    def residual_rms(self) -> float:
        """RMS of the residual, relative to the signal's."""
        return float(np.sqrt(np.mean(self.residual**2)))


def orthonormal(columns: Array) -> Array:
    """Orthonormal basis of the columns' span, shape as given."""
    return np.linalg.qr(columns)[0]


def without(basis: Array, columns: Array) -> Array:
    """What of the columns is orthogonal to an orthonormal basis."""
    return columns - basis @ (basis.T @ columns)


def first_mode_columns(channel: ChannelHalf, alpha: float, beta: float, kappa: float, rho: float) -> Array:
    """The two columns of the drifting first mode, shape (240, 2)."""
    theta, sigma = channel.half.phases[0], channel.half.places[0]
    phase, growth = alpha * (theta + kappa * channel.half.drift) + beta * (sigma**2 - 1.0), 1.0 + rho * sigma
    in_phase, late = growth * channel.templates[0], growth * channel.quadrature
    cosine, sine = np.cos(phase), np.sin(phase)
    return np.column_stack([in_phase * cosine + late * sine, in_phase * sine - late * cosine])


def second_mode_columns(channel: ChannelHalf, alpha2: float) -> Array:
    """The four columns of the second mode, shape (240, 4)."""
    phase = alpha2 * channel.half.phases[1]
    cosine, sine = channel.templates[1] * np.cos(phase), channel.templates[1] * np.sin(phase)
    sigma2 = channel.half.places[1]
    return np.column_stack([cosine, sine, sigma2 * cosine, sigma2 * sine])


def refine(channel: ChannelHalf, slow: Array, start: Array, bounds: Bounds) -> Fit:
    """Descend from `start` (alpha, beta, kappa, rho, alpha2) to a minimum within the bounds.

    Args:
        channel: the signal with its templates.
        slow: orthonormal basis of the slow part, shape (240, k).
        start: shape (5,).
        bounds: for the five parameters.
    """
    signal = without(slow, channel.signal)
    fit = _evaluate(channel, slow, signal, np.clip(start, bounds.low, bounds.high))
    damping = 1e-3
    for _ in range(MAXIMUM_STEPS):
        step = _step(fit, bounds, damping)
        trial = np.clip(fit.parameters + step, bounds.low, bounds.high)
        moved = np.abs(trial - fit.parameters).max()
        if moved < STEP_TOLERANCE:
            break
        candidate = _evaluate(channel, slow, signal, trial)
        if candidate.cost < fit.cost:
            fit, damping = candidate, damping / 10.0
        else:
            damping *= 10.0
    return fit


def _step(fit: Fit, bounds: Bounds, damping: float) -> Array:
    """Damped Gauss-Newton step; parameters that would leave their bounds at once stay where they are."""
    derivatives = -fit.jacobian[:, 6:]
    prior = _prior_weights(fit.residual.size)
    normal = derivatives.T @ derivatives + np.diag(prior**2)
    gradient = derivatives.T @ fit.residual + prior**2 * fit.parameters
    blocked = ((fit.parameters <= bounds.low) & (gradient > 0.0)) | ((fit.parameters >= bounds.high) & (gradient < 0.0))
    moving = bounds.free & ~blocked
    step = np.zeros(5)
    if moving.any():
        block = normal[np.ix_(moving, moving)]
        scale = np.diag(np.diag(block) + 1e-12 * fit.residual.size)
        step[moving] = -np.linalg.solve(block + damping * scale, gradient[moving])
    return step


def _prior_weights(samples: int) -> Array:
    return PRIOR_STRENGTH * np.sqrt(samples) / PRIOR_SCALES


def _evaluate(channel: ChannelHalf, slow: Array, signal: Array, parameters: Array) -> Fit:
    alpha, beta, kappa, rho, alpha2 = parameters
    first, second = first_mode_columns(channel, alpha, beta, kappa, rho), second_mode_columns(channel, alpha2)
    columns = np.hstack([first, second])
    projected = without(slow, columns)
    basis, triangle = np.linalg.qr(projected)
    weights = np.linalg.lstsq(triangle, basis.T @ signal, rcond=1e-10)[0]
    residual = signal - projected @ weights

    theta, sigma = channel.half.phases[0], channel.half.places[0]
    quarter_turned = first[:, 0] * weights[1] - first[:, 1] * weights[0]
    envelope_change = first @ weights[:2] * sigma / (1.0 + rho * sigma)
    second_turned = second[:, 0] * weights[3] - second[:, 1] * weights[2]
    second_turned = second_turned + second[:, 2] * weights[5] - second[:, 3] * weights[4]
    derivatives = np.column_stack(
        [
            (theta + kappa * channel.half.drift) * quarter_turned,
            (sigma**2 - 1.0) * quarter_turned,
            alpha * channel.half.drift * quarter_turned,
            envelope_change,
            channel.half.phases[1] * second_turned,
        ]
    )
    derivatives = without(basis, without(slow, derivatives))
    prior = _prior_weights(signal.size) * parameters
    cost = float(residual @ residual + prior @ prior)
    return Fit(parameters, weights, residual, cost, np.hstack([projected, derivatives]))
