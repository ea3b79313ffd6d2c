"""A machine in its steady cycles, read in the two ways in which the thesis may have read its curves.

A machine marches from the periodic state of the run as published, for `WAITED` turns; then the frequencies are read in `CYCLES` turns. If
its joint stays closed, `reference` finds the periodic state directly, and so does `thesis`.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.first_mode import FirstMode, fit_first_modes
from quickreturn.cases.motion.marching import March, output_step, periodic_cycle
from quickreturn.cases.motion.number import consensus
from quickreturn.cases.motion.orbit import PeriodicStart
from quickreturn.cases.motion.settling import Cycle
from quickreturn.cases.motion.time_scale import CHANNELS, TimeScale, channel_half, half_cycle, time_scale
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.registry import engine as engine_of_name
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed

#: Turns that are not read, and turns that are: after eight turns the frequencies of runs 10, 18 and 24 change by less than 0.1 % a turn.
WAITED: Final = 8
CYCLES: Final = 2
#: Largest standard deviation of a half's frequency over its channels, relative: beyond it the fits follow different vibrations.
DISAGREEMENT: Final = 0.02
#: Band, Hz, in which the vibration after the return is sought; section 3.4 of the thesis prints 132 Hz. Band below which extremes count.
SOUGHT: Final = (60.0, 200.0)
COUNTED: Final = (0.0, 40.0)
#: Part of a cycle, from the farthest place, that counts as "at the return": crank angles from 360 to 420 degrees.
RETURN: Final = (0.5, 0.5 + 60.0 / 360.0)
#: Least swing between two extremes that an eye counts, as a part of the half's range, and least number of extremes for a frequency.
SWING: Final = 0.05
EXTREMES: Final = 5
#: Number of rows of a cycle at even instants, and length of a zero-padded transform over that of its signal.
ROWS: Final = 4096
PADDING: Final = 16


@dataclass(frozen=True)
class Half:
    """The first mode in a half; None where no turn resolves it."""

    fitted: float | None = None  # Hz, consensus of the channels' fits
    counted: float | None = None  # Hz, from the extremes below 40 Hz, median over the channels
    amplitudes: Mapping[str, float] = field(default_factory=dict)  # RMS of the envelope, in the channel's unit


@dataclass(frozen=True)
class Ring:
    """The fast vibration of the tip acceleration at the return, from 60 to 200 Hz."""

    rms: float  # m/s^2
    frequency: float  # Hz, the strongest
    signs: tuple[float, float]  # correlation of strain 1 with 2, and with 3, in that band


@dataclass(frozen=True)
class Response:
    """A machine's steady cycles, read; `reason` says why there are none."""

    halves: Mapping[str, Half] = field(default_factory=dict)
    ring: Ring | None = None
    peaks: Mapping[str, float] = field(default_factory=dict)  # largest magnitude in a turn, by channel
    speed: float = 0.0  # mean crank speed, rad/s
    reason: str = ""


@dataclass(frozen=True)
class Request:
    """A machine to bring to its steady cycles."""

    scene: Mechanism
    start: PeriodicStart  # periodic state of the run as published
    engine: str = "reference"  # name; its settings are those of its default accuracy


def respond(requests: tuple[Request, ...]) -> tuple[Response, ...]:
    """The response of each machine; a failure of the engine becomes its reason."""
    return tuple(_response(request) for request in requests)


def _response(request: Request) -> Response:
    try:
        return _read(request.scene, list(_steady_cycles(request)))
    except (EngineFailure, Refusal, ValueError) as failure:
        return Response(reason=str(failure))


def _steady_cycles(request: Request) -> Iterator[Cycle]:
    engine, scene = engine_of_name(request.engine), request.scene
    settings, step = engine.settings_for(engine.default_accuracy, scene), output_step(scene)
    try:
        state = engine.steady_state(scene, standard_start(scene), settings)
    except NoSteadyState:
        state = None
    if state is not None and state.stable:
        return iter([periodic_cycle(state, step)[0]])
    march = March(engine.prepare(scene, request.start, settings), request.start.crank_speed, step)
    return islice(march, WAITED, WAITED + CYCLES)


def _read(scene: Mechanism, cycles: Sequence[Cycle]) -> Response:
    scales = {half: time_scale(carrying(scene, half)) for half in HALVES}
    fits = {half: [_fits(scales[half], half, cycle) for cycle in cycles] for half in HALVES}
    rings = [_ring(cycle) for cycle in cycles]
    return Response(
        halves={half: _half(half, fits[half], [_count(half, cycle) for cycle in cycles]) for half in HALVES},
        ring=Ring(
            float(np.mean([ring.rms for ring in rings])),
            float(np.mean([ring.frequency for ring in rings])),
            (float(np.mean([ring.signs[0] for ring in rings])), float(np.mean([ring.signs[1] for ring in rings]))),
        ),
        peaks={name: float(np.mean([np.max(np.abs(cycle.channels[name])) for cycle in cycles])) for name in CHANNELS},
        speed=2.0 * math.pi * len(cycles) / float(cycles[-1].time[-1] - cycles[0].time[0]),
    )


def carrying(scene: Mechanism, half: str) -> Mechanism:
    """The scene for small vibrations in a half: with the roller that carries there, or with both if a preload keeps both in contact."""
    plus, minus = scene.slider.sides
    if plus == minus:
        return scene
    without = dict.fromkeys(f"slider.{key}" for key in ("joint_stiffness_plus", "joint_stiffness_minus", "preload", "contact_damping"))
    return changed(scene, {"slider.joint_stiffness": plus if half == "post" else minus, **without})


def _fits(scale: TimeScale | None, half: str, cycle: Cycle) -> dict[str, FirstMode]:
    """The first mode in one half, by channel; `cases.motion.cycle.measure_cycle` would fit both halves on one scale."""
    if scale is None:
        return {}
    turned = np.abs(cycle.crank_angle - cycle.crank_angle[0])
    start, end = CubicSpline(turned, cycle.time)(np.pi * np.array((0.0, 1.0) if half == "pre" else (1.0, 2.0)))
    here = half_cycle(scale, float(start), float(end), CubicSpline(cycle.time, cycle.crank_angle))
    signals = {name: CubicSpline(cycle.time, cycle.channels[name]) for name in scale.channels}
    return fit_first_modes([{name: channel_half(scale, here, name, signal) for name, signal in signals.items()}])[0]


def _half(half: str, cycles: Sequence[Mapping[str, FirstMode]], counts: Sequence[float | None]) -> Half:
    fitted = []
    for fits in cycles:
        pairs = [(fit.frequency, fit.frequency_uncertainty) for fit in fits.values() if fit.frequency and fit.frequency_uncertainty]
        frequencies = [frequency for frequency, _ in pairs]
        if len(pairs) == 1 or (pairs and np.std(frequencies, ddof=1) <= DISAGREEMENT * np.mean(frequencies)):
            fitted.append(consensus(half, frequencies, [error for _, error in pairs]).first_mode_frequency or 0.0)
    counted = [count for count in counts if count is not None]
    amplitudes = {name: [fits[name].amplitude or 0.0 for fits in cycles] for name in cycles[0]}
    return Half(
        fitted=float(np.mean(fitted)) if fitted else None,
        counted=float(np.mean(counted)) if counted else None,
        amplitudes={name: float(np.mean(values)) for name, values in amplitudes.items() if all(values)},
    )


def _even(cycle: Cycle) -> tuple[Array, Array]:
    """`ROWS` even instants of a cycle, s, and the part of the turn that the crank has made at each."""
    instants = cycle.time[0] + (cycle.time[-1] - cycle.time[0]) / ROWS * np.arange(ROWS)
    turned = np.abs(CubicSpline(cycle.time, cycle.crank_angle)(instants) - cycle.crank_angle[0])
    return instants, turned / (2.0 * np.pi)


def _band(cycle: Cycle, instants: Array, name: str, limits: tuple[float, float]) -> Array:
    """A channel between two frequencies, Hz, as a periodic signal."""
    spectrum = np.fft.rfft(CubicSpline(cycle.time, cycle.channels[name])(instants))
    frequencies = np.fft.rfftfreq(ROWS, instants[1] - instants[0])
    return np.asarray(np.fft.irfft(np.where((frequencies >= limits[0]) & (frequencies <= limits[1]), spectrum, 0.0), ROWS))


def _count(half: str, cycle: Cycle) -> float | None:
    """The frequency that an eye counts in a half, Hz: half the number of swings between extremes, over the time between the outer ones."""
    instants, progress = _even(cycle)
    here = (progress >= 0.5) == (half == "post")
    counts = [counted_frequency(instants[here], _band(cycle, instants, name, COUNTED)[here]) for name in CHANNELS]
    found = [count for count in counts if count is not None]
    return float(np.median(found)) if found else None


def counted_frequency(time: Array, signal: Array) -> float | None:
    """The frequency, Hz, by the extremes of a signal that differ from their neighbours by a visible swing; None with too few."""
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(signal))))
    visible, least = list[int](), SWING * float(np.ptp(signal))
    for at in turns:
        while len(visible) > 1 and (signal[visible[-1]] - signal[visible[-2]]) * (signal[at] - signal[visible[-1]]) > 0.0:
            visible.pop()
        if not visible or abs(signal[at] - signal[visible[-1]]) >= least:
            visible.append(int(at))
    return (len(visible) - 1) / (2.0 * float(time[visible[-1]] - time[visible[0]])) if len(visible) >= EXTREMES else None


def _ring(cycle: Cycle) -> Ring:
    instants, progress = _even(cycle)
    wide = _band(cycle, instants, "tip_acceleration", SOUGHT)
    here = (progress >= RETURN[0]) & (progress < RETURN[1])
    at_return = wide[here]
    strains = np.corrcoef([_band(cycle, instants, name, SOUGHT)[here] for name in CHANNELS[1:]])
    spectrum = np.abs(np.fft.rfft(at_return * np.hanning(at_return.size), PADDING * at_return.size))
    return Ring(
        rms=float(np.sqrt(np.mean(at_return**2))),
        frequency=float(np.fft.rfftfreq(PADDING * at_return.size, instants[1] - instants[0])[np.argmax(spectrum)]),
        signs=(float(strains[0, 1]), float(strains[0, 2])),
    )
