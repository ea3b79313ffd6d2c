"""The mechanism's own time scale: its natural frequencies and modes as functions of the crank angle; and a half cycle on it.

A half cycle has 240 instants, the modes' phases by the mechanism, and the channel's templates.
"""

import functools
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.moving_mode import moving_mode, periodic
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import FrozenModes, deflections, frozen_crank_modes, turn_angles
from quickreturn.reference_model.scene_values import changed

CHANNELS = ("tip_acceleration", "strain_1", "strain_2", "strain_3")
MODES = 3
COUPLED = 4  # number of modes that a moving slider couples with the first one: higher ones add at most 0.01 rad to a phase
TEMPLATE_FLOOR = 0.15  # least magnitude of a template that keeps its sign, as a part of its RMS
COARSER = 3  # corrections for the motion are computed at each third angle, interpolated between: an error below 1e-4 of the frequency
ANGLES = 181  # number of crank angles in half a turn
TURN = np.linspace(0.0, 2.0 * np.pi, 2 * ANGLES - 1)  # rad
NOTHING = 1e-6  # as a part of the curvature at the slider: a gauge with no more sits at an end that carries no moment


@dataclass(frozen=True)
class TimeScale:
    """Periodic functions of the crank angle, the same for both directions of rotation."""

    frequencies: CubicSpline  # f1, f2, f3 in Hz of the crank held still, values of shape (..., 3)
    free_crank: CubicSpline  # relative change of f1 with a free, compliant crank, values of shape (...)
    motion: CubicSpline  # the same because the crank turns, per square of its speed, s^2/rad^2, values of shape (...)
    # per channel the response to each mode at constant action, unit mean modulus over a turn, values (..., 3)
    templates: dict[str, CubicSpline]
    # per channel the response to the first mode a quarter period late, per crank speed, in its template's unit, s/rad
    quadratures: dict[str, CubicSpline]
    # per channel its quasi-static response at constant crank speed, unit RMS over a turn, values of shape (...)
    slow_shapes: dict[str, CubicSpline]

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels with templates: those that show vibration."""
        return tuple(self.templates)

    def running_frequencies(self, crank_angle: Array, crank_speed: Array) -> Array:
        """f1, f2, f3 in Hz, the first as it is while the crank turns (`moving_mode`), shape (n, 3).

        Args:
            crank_angle: rad, shape (n,).
            crank_speed: rad/s, shape (n,).
        """
        frequencies = np.array(self.frequencies(crank_angle))
        frequencies[:, 0] *= 1.0 + self.free_crank(crank_angle) + self.motion(crank_angle) * crank_speed**2
        return frequencies


def time_scale(mechanism: Mechanism) -> TimeScale | None:
    """Tabulate the scale of a scene, with its own joint stiffness (rigid unless the scene says otherwise).

    With mass-normalised modes of shape phi and angular frequency omega, vibration of constant action has the modal coordinate
    omega^(-1/2): the tip acceleration then follows omega^(3/2) phi(L), the strain omega^(-1/2) phi''.

    Returns:
        None for a rigid follower, which has no frequencies.
    """
    if mechanism.follower.is_rigid:
        return None
    of_torque = {"crank.torque": 1.0, "crank.damping": 0.0, "crank.initial_speed": 1.0}
    return _tabulated(changed(mechanism, of_torque if mechanism.crank_is_free else {"crank.prescribed_speed": 1.0}))


@functools.lru_cache(maxsize=32)  # several recorded tables are measured in one scene, and so are their engines
def _tabulated(mechanism: Mechanism) -> TimeScale:
    """The scale of a scene with a flexible follower, whatever its speed."""
    angles = turn_angles(mechanism, ANGLES)
    modes = [frozen_crank_modes(mechanism, angle, COUPLED) for angle in angles]
    signs = _continuous_signs(modes, mechanism)
    frequencies = np.array([mode.frequencies[:MODES] for mode in modes])
    omega = 2.0 * np.pi * frequencies
    coarser = slice(None, None, COARSER)
    moving = moving_mode(mechanism, angles[coarser], modes[coarser], signs[coarser])
    dragged = CubicSpline(angles[coarser], moving.dragged)(angles)

    tip = np.array([mode.tip_displacement for mode in modes])
    of_tip = omega[:, 0] ** 1.5 * (
        2.0 * periodic(angles, signs[:, 0] * tip[:, 0])(angles, 1) / omega[:, 0] + np.einsum("aj,aj->a", dragged, signs * tip)
    )
    responses = {"tip_acceleration": (signs[:, :MODES] * omega**1.5 * tip[:, :MODES], of_tip)}
    slow_shapes = {"tip_acceleration": _slow_shape(quasi_static_tip_acceleration(mechanism, TURN))}
    gauges = mechanism.follower.strain_gauges
    curvatures = deflections(modes, np.array([[mode.slider_position, *gauges] for mode in modes]), 2)
    at_slider = curvatures[:, 0, 0]
    for number, (name, gauge) in enumerate(zip(CHANNELS[1:], gauges, strict=True), 1):
        curvature = curvatures[:, :, number]
        if not np.abs(curvature[:, :MODES]).max() > NOTHING * np.abs(at_slider).max():
            continue
        late = omega[:, 0] ** -0.5 * np.einsum("aj,aj->a", dragged, signs * curvature)
        responses[name] = (signs[:, :MODES] * omega**-0.5 * curvature[:, :MODES], late)
        slow_shapes[name] = _slow_shape(quasi_static_strain(mechanism, gauge, TURN))
    templates, quadratures = {}, {}
    for name, (in_phase, late) in responses.items():
        templates[name], unit = _template(angles, in_phase)
        quadratures[name] = periodic(angles, late / unit, -1.0)
    free_crank, motion = (periodic(angles[coarser], values) for values in (moving.free_crank, moving.motion))
    return TimeScale(periodic(angles, frequencies), free_crank, motion, templates, quadratures, slow_shapes)


def _continuous_signs(modes: list[FrozenModes], mechanism: Mechanism) -> Array:
    """Signs that make each mode resemble its neighbour at the next angle, shape (angles, modes)."""
    x = np.linspace(0.0, mechanism.follower.length, 41)
    weight = np.full(x.size, mechanism.follower.mass_per_length * x[1])
    weight[-1] += mechanism.tip_body.mass
    shapes = deflections(modes, x)
    overlaps = np.einsum("amx,amx,x->am", shapes[1:], shapes[:-1], weight)
    return np.cumprod(np.vstack([np.ones(shapes.shape[1]), np.where(overlaps < 0.0, -1.0, 1.0)]), axis=0)


def _template(angles: Array, response: Array) -> tuple[CubicSpline, float]:
    """The responses to the modes as a spline of unit mean modulus, and the divisor of the first mode's response."""
    keeps_sign = response.min(axis=0) * response.max(axis=0) > 0.0
    floor = TEMPLATE_FLOOR * np.sqrt(np.mean(response**2, axis=0))
    floored = np.where(keeps_sign, np.sign(response) * np.maximum(np.abs(response), floor), response)
    unit = np.mean(np.abs(floored), axis=0)
    return periodic(angles, floored / unit), float(unit[0])


def _slow_shape(response: Array) -> CubicSpline:
    """Periodic spline of unit RMS through a response at the angles `TURN`."""
    values = response / np.sqrt(np.mean(response[:-1] ** 2))
    values[-1] = values[0]
    return CubicSpline(TURN, values, bc_type="periodic")


def follower_acceleration(mechanism: Mechanism, crank_angle: Array) -> tuple[Array, Array]:
    """Angular acceleration of the rigid follower at unit crank speed, and the slider's arc length.

    Args:
        mechanism: the scene.
        crank_angle: rad, shape (n,).

    Returns:
        d^2 q2 / d q1^2 (1/rad, shape (n,)), and s in m, shape (n,).
    """
    z = mechanism.crank.length * np.exp(1j * crank_angle)
    u = z - mechanism.pivot_distance  # s e^(i q2): q2' = Re(z/u), derived once more
    return mechanism.pivot_distance * np.imag(z / u**2), np.abs(u)


def quasi_static_tip_acceleration(mechanism: Mechanism, crank_angle: Array) -> Array:
    """Tip acceleration of the rigid mechanism along the follower's normal at unit crank speed, m/rad^2, shape (n,)."""
    angular, _ = follower_acceleration(mechanism, crank_angle)
    return mechanism.follower.length * angular


def quasi_static_strain(mechanism: Mechanism, arc_length: float, crank_angle: Array) -> Array:
    """Surface strain under the inertia loads of the rigid motion at unit crank speed, s^2, shape (n,).

    EI W'' is the moment of the outboard inertia forces (beam, tip body) and of the slider force where the slider is outboard.

    Args:
        mechanism: the scene, with a flexible follower.
        arc_length: m, the gauge's place.
        crank_angle: rad, shape (n,).
    """
    follower, tip, x = mechanism.follower, mechanism.tip_body, arc_length
    angular, s = follower_acceleration(mechanism, crank_angle)
    L, rho_a = follower.length, follower.mass_per_length
    moment_of_inertia = mechanism.base.inertia + rho_a * L**3 / 3.0
    outboard = rho_a * (L**3 / 3.0 - x * L**2 / 2.0 + x**3 / 6.0)  # integral of rho A xi (xi - x) from x to L
    center = L + tip.center_of_mass
    moment_of_inertia += tip.inertia + tip.mass * center**2
    outboard += tip.inertia + tip.mass * center * (center - x)
    slider_force = moment_of_inertia * angular / s
    moment = -outboard * angular + slider_force * np.maximum(s - x, 0.0)
    return moment / follower.bending_stiffness * follower.extreme_fibre


SAMPLES = 240
PROGRESS = np.linspace(-1.0, 1.0, SAMPLES)  # time scaled to [-1, 1]
ROUND_OFF = 1e-12  # a signal that varies less than this, relative to its size, is constant


@dataclass(frozen=True)
class HalfCycle:
    """One half of a cycle, shared by its channels; arrays of shape (240,) unless stated."""

    time: Array  # s, uniform
    crank_angle: Array  # rad
    crank_speed: Array  # rad/s
    mean_frequencies: Array  # time means of f1, f2, f3 over the half, Hz, shape (3,)
    phases: Array  # theta_i = 2 pi times the integral of f_i, zero at the middle of their ranges, rad, shape (3, 240)
    drift: Array  # theta_1 less a phase of constant rate, zero at both ends, rad
    places: Array  # sigma_i = theta_i scaled to [-1, 1], shape (3, 240)


@dataclass(frozen=True)
class ChannelHalf:
    """One channel in a half cycle."""

    half: HalfCycle  # the half cycle
    signal: Array  # the channel minus its mean, in units of `unit`, shape (240,)
    unit: float  # RMS of the channel's deviation from its mean, in its own unit; 0 if it does not vary
    templates: Array  # response to the modes at constant action, shape (3, 240)
    quadrature: Array  # response to the first mode a quarter period late, in the template's unit, shape (240,)
    slow_shape: Array  # quasi-static response to the crank's motion, shape (240,)


@cache
def polynomials(degree: int) -> Array:
    """Legendre polynomials of `PROGRESS`, degrees 0 to `degree`, shape (240, degree + 1)."""
    return np.asarray(legendre.legvander(PROGRESS, degree), dtype=np.float64)


def half_cycle(scale: TimeScale, start: float, end: float, crank_angle: CubicSpline) -> HalfCycle:
    """The half cycle from `start` to `end` (s); `crank_angle` gives rad over time."""
    instants = np.linspace(start, end, SAMPLES)
    angles = crank_angle(instants)
    speeds = crank_angle(instants, 1)
    phases = 2.0 * np.pi * cumulative_simpson(scale.running_frequencies(angles, speeds).T, x=instants, initial=0.0)
    span = phases[:, -1:]
    phases = phases - span / 2.0
    return HalfCycle(
        time=instants,
        crank_angle=angles,
        crank_speed=speeds,
        mean_frequencies=span[:, 0] / (2.0 * np.pi * (end - start)),
        phases=phases,
        drift=phases[0] - span[0] / 2.0 * PROGRESS,
        places=phases / (span / 2.0),
    )


def channel_half(scale: TimeScale, half: HalfCycle, channel: str, signal: CubicSpline) -> ChannelHalf:
    """One channel in the half cycle; `signal` gives it over time."""
    values = signal(half.time)
    deviation = values - values.mean()
    unit = float(np.sqrt(np.mean(deviation**2)))
    constant = unit <= ROUND_OFF * np.abs(values).max()
    return ChannelHalf(
        half=half,
        signal=np.zeros(SAMPLES) if constant else deviation / unit,
        unit=0.0 if constant else unit,
        templates=scale.templates[channel](half.crank_angle).T,
        quadrature=scale.quadratures[channel](half.crank_angle) * half.crank_speed,
        slow_shape=scale.slow_shapes[channel](half.crank_angle),
    )
