"""A changed scene in its steady cycles, measured.

If the loop stays closed and nothing rubs, `reference` finds the periodic state directly, and one cycle is measured. Every other scene is
marched from the periodic state of the scene as published: until 3 % of a disturbance remain by that state's largest Floquet multiplier, and
then through the measured cycles. Numbers are means over these, with their scatter; with a rattling joint no cycle repeats.

Friction and impacts slow the crank, and its speed changes the vibration more than they do. So a torque drive gets the torque that keeps the
published scene's mean speed; it follows from the loss of speed in the first cycles.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.consensus import consensus
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.first_mode import FirstMode, fit_first_modes
from quickreturn.cases.motion.half_cycle import channel_half, half_cycle
from quickreturn.cases.motion.marching import March, output_step, periodic_cycle
from quickreturn.cases.motion.orbit import PeriodicStart
from quickreturn.cases.motion.settling import Cycle
from quickreturn.cases.motion.time_scale import CHANNELS, TimeScale, time_scale
from quickreturn.engines.base import AnyEngine, EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.registry import engine as engine_of_name
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from quickreturn.reference_model.scene_values import changed

Array = NDArray[np.float64]

#: Number of recorded cycles of the steady motion. The vibration is fitted in each fourth of them, because this takes longest.
CYCLES: Final = 8
EVERY: Final = 4
#: Largest part of a disturbance that remains before these cycles.
LEFT: Final = 0.03
#: Number of cycles from which the final speed with a torque is predicted, allowed relative error of this speed, and largest number of
#: corrections of the torque.
TRIED: Final = 4
SPEED: Final = 2e-3
CORRECTIONS: Final = 3
#: Band, Hz, in which section 3.4 of the thesis saw a second mode, and a wider one in which its frequency is searched.
BAND: Final = (90.0, 180.0)
SOUGHT: Final = (60.0, 200.0)
#: Part of a cycle, counted from the farthest place, that counts as "at the return": crank angles from 360 to 420 degrees.
RETURN: Final = (0.5, 0.5 + 60.0 / 360.0)
#: Number of rows of a cycle at even instants, and length of a zero-padded transform over that of its signal.
ROWS: Final = 4096
PADDING: Final = 16


@dataclass(frozen=True)
class Half:
    """The first mode in a half, by channel, if all measured cycles resolve it."""

    frequencies: Mapping[str, float]  # Hz
    uncertainties: Mapping[str, float]  # of their measurement, Hz
    amplitudes: Mapping[str, float]  # RMS of the envelope, in the channel's unit
    scatter: float  # standard error of the mean frequency over the cycles, relative; 0 of one cycle


@dataclass(frozen=True)
class Ring:
    """The tip acceleration at the return, from 90 to 180 Hz."""

    rms: float  # m/s^2
    frequency: float  # Hz, the strongest between 60 and 200 Hz
    signs: tuple[float, float]  # correlation of strain 1 with 2, and with 3, from 60 to 200 Hz


@dataclass(frozen=True)
class Response:
    """Measurements of a scene; `reason` says why there are none."""

    halves: Mapping[str, Half] = field(default_factory=dict)
    peaks: Mapping[str, float] = field(default_factory=dict)  # largest magnitude in a cycle, by channel, mean over the cycles
    ring: Ring | None = None
    speed: float = 0.0  # mean crank speed, rad/s
    factor: float = 1.0  # error with the settings that computed it over that with the usual ones
    reason: str = ""


@dataclass(frozen=True)
class Request:
    """A scene to bring to its steady cycles."""

    scene: Mechanism  # changed from the published one
    start: PeriodicStart  # periodic state of the published scene
    multiplier: float  # its largest Floquet multiplier
    speed: float  # its mean crank speed, rad/s, which is kept
    engine: str = "reference"  # name
    settings: Mapping[str, str] = field(default_factory=dict)  # settings of the engine, as texts; others are those of its default accuracy
    finer: bool = False  # whether it uses the finer settings of the error estimate


def respond(requests: tuple[Request, ...]) -> tuple[Response, ...]:
    """The response of each scene in its steady cycles; a failure of an engine becomes its reason."""
    return tuple(_response(request) for request in requests)


def _response(request: Request) -> Response:
    engine, scene = engine_of_name(request.engine), request.scene
    try:
        settings, factor = engine.settings_for(engine.default_accuracy, scene).with_texts(dict(request.settings)), 1.0
        if request.finer:
            (pair,) = engine.comparisons(settings, scene, output_step(scene))  # `reference` and `thesis` have one
            settings, factor = pair.other, pair.factor
        return replace(_measured(scene, _at_speed(engine, settings, request)), factor=factor)
    except (EngineFailure, Refusal, ValueError) as failure:
        return Response(reason=str(failure))


def _at_speed(engine: AnyEngine, settings: Settings, request: Request) -> list[Cycle]:
    """The steady cycles with the torque that keeps the mean speed."""
    scene, corrections = request.scene, CORRECTIONS
    while True:
        cycles, reached = _steady_cycles(engine, settings, scene, request.start, request.multiplier)
        drive = scene.crank.drive
        if not corrections or not isinstance(drive, TorqueDrive) or abs(reached / request.speed - 1.0) < SPEED:
            return list(cycles)
        corrections -= 1
        scene = changed(scene, {"crank.torque": drive.torque + drive.damping * (request.speed - reached)})


def _steady_cycles(
    engine: AnyEngine, settings: Settings, scene: Mechanism, start: PeriodicStart, multiplier: float
) -> tuple[Iterator[Cycle], float]:
    """The cycles, which are simulated as they are taken, and the mean speed (rad/s) that they have or tend to."""
    step = output_step(scene)
    try:
        state = engine.steady_state(scene, standard_start(scene), settings)
    except NoSteadyState:
        state = None
    if state is not None and state.stable:
        return iter([periodic_cycle(state, step)[0]]), 2.0 * math.pi / state.period
    march = iter(March(engine.prepare(scene, start, settings), start.crank_speed, step))
    periods = [float(cycle.time[-1] - cycle.time[0]) for cycle in islice(march, TRIED)]
    before, last = (2.0 * math.pi / period for period in periods[-2:])
    # part of the speed's distance from its limit that remains after a cycle
    remaining = math.exp(-getattr(scene.crank.drive, "damping", math.inf) / scene.crank.inertia_about_pivot * periods[-1])
    waited = max(0, math.ceil(math.log(LEFT) / math.log(multiplier)) - TRIED)
    return islice(march, waited, waited + CYCLES), last + (last - before) * remaining / (1.0 - remaining)


def _measured(scene: Mechanism, cycles: list[Cycle]) -> Response:
    peaks = {name: float(np.mean([np.max(np.abs(cycle.channels[name])) for cycle in cycles])) for name in CHANNELS}
    rings = [_ring(cycle) for cycle in cycles]
    signs = np.mean([ring.signs for ring in rings], axis=0)
    return Response(
        halves=_first_modes(scene, cycles[::EVERY]),
        peaks=peaks,
        ring=Ring(
            float(np.sqrt(np.mean([ring.rms**2 for ring in rings]))),
            float(np.median([ring.frequency for ring in rings])),
            (float(signs[0]), float(signs[1])),
        ),
        speed=2.0 * math.pi * len(cycles) / float(cycles[-1].time[-1] - cycles[0].time[0]),
    )


def carrying(scene: Mechanism, half: str) -> Mechanism:
    """The scene for small vibrations in a half: with the roller that carries there, or with both if preload keeps both in contact."""
    plus, minus = scene.slider.sides
    if plus == minus:
        return scene
    without = dict.fromkeys(f"slider.{key}" for key in ("joint_stiffness_plus", "joint_stiffness_minus", "preload", "contact_damping"))
    return changed(scene, {"slider.joint_stiffness": plus if half == "post" else minus, **without})


def _first_modes(scene: Mechanism, cycles: list[Cycle]) -> dict[str, Half]:
    """Both halves, each on the time scale of the scene for small vibrations there."""
    scales = {carried: time_scale(carried) for carried in {carrying(scene, half) for half in HALVES}}
    return {half: _half(half, [_fitted(scales[carrying(scene, half)], half, cycle) for cycle in cycles]) for half in HALVES}


def _fitted(scale: TimeScale | None, half: str, cycle: Cycle) -> dict[str, FirstMode]:
    """The first mode in one half, by channel; `cases.motion.cycle.measure_cycle` would fit both on one scale, and a second mode."""
    if scale is None:
        return {}
    turned = np.abs(cycle.crank_angle - cycle.crank_angle[0])
    start, end = CubicSpline(turned, cycle.time)(np.pi * np.array((0.0, 1.0) if half == "pre" else (1.0, 2.0)))
    here = half_cycle(scale, float(start), float(end), CubicSpline(cycle.time, cycle.crank_angle))
    signals = {name: CubicSpline(cycle.time, cycle.channels[name]) for name in scale.channels}
    return fit_first_modes([{name: channel_half(scale, here, name, signal) for name, signal in signals.items()}])[0]


def _half(half: str, cycles: list[dict[str, FirstMode]]) -> Half:
    def mean(quantity: str) -> dict[str, float]:
        numbers = {name: [getattr(cycle[name], quantity) for cycle in cycles] for name in cycles[0]}
        return {name: float(np.mean(values)) for name, values in numbers.items() if None not in values}

    frequencies, uncertainties = mean("frequency"), mean("frequency_uncertainty")
    errors = list(uncertainties.values())
    means = [consensus(half, [cycle[name].frequency or 0.0 for name in frequencies], errors).first_mode_frequency for cycle in cycles]
    resolved = [frequency for frequency in means if frequency is not None]
    scatter = float(np.std(resolved, ddof=1) / np.mean(resolved) / math.sqrt(len(resolved))) if len(resolved) > 1 else 0.0
    return Half(frequencies, uncertainties, mean("amplitude"), scatter)


def _ring(cycle: Cycle) -> Ring:
    """The fast vibration at the return of one cycle; the cycle is taken as one of a periodic signal, whose ends lie far from there."""
    period = cycle.time[-1] - cycle.time[0]
    instants = cycle.time[0] + period / ROWS * np.arange(ROWS)
    progress = np.abs(CubicSpline(cycle.time, cycle.crank_angle)(instants) - cycle.crank_angle[0]) / (2.0 * np.pi)
    here = (progress >= RETURN[0]) & (progress < RETURN[1])

    def band(name: str, limits: tuple[float, float]) -> Array:
        spectrum = np.fft.rfft(CubicSpline(cycle.time, cycle.channels[name])(instants))
        frequencies = np.fft.rfftfreq(ROWS, period / ROWS)
        return np.asarray(np.fft.irfft(np.where((frequencies >= limits[0]) & (frequencies <= limits[1]), spectrum, 0.0), ROWS)[here])

    wide = band("tip_acceleration", SOUGHT)
    spectrum = np.abs(np.fft.rfft(wide * np.hanning(wide.size), PADDING * wide.size))
    strains = np.corrcoef([band(name, SOUGHT) for name in CHANNELS[1:]])
    return Ring(
        float(np.sqrt(np.mean(band("tip_acceleration", BAND) ** 2))),
        float(np.fft.rfftfreq(PADDING * wide.size, period / ROWS)[np.argmax(spectrum)]),
        (float(strains[0, 1]), float(strains[0, 2])),
    )
