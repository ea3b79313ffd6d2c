"""The spin-up manoeuvre in every engine beside published values and closed forms.

Nothing here shares code with an engine: what is expected comes from print (`literature.toml`), from the linear theory of the rotating
cantilever by power series (`rotating_cantilever`), or from the statics of a spinning rod.
"""

import dataclasses
import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.optimize import minimize_scalar

from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import FollowerAlone, SpinUp, base_motion
from tests.verification.literature.rotating_cantilever import cubic_frequency, frequencies, quasi_static_deflection, time_unit
from tests.verification.row import Row

CASE: Final = "spin-up"
LITERATURE: Final = tomllib.loads(Path(__file__).with_name("literature.toml").read_text("utf-8"))
PUBLISHED: Final = LITERATURE["rotating_cantilever"][0]

#: Runs at published rates: the spin-up ends at this instant and the vibration that it leaves is watched up to the other, s.
SPUN_UP, WATCHED = 4.0, 20.0

#: A mode's frequency in the plane of rotation is the root of a difference of squares, which magnifies a relative error of the engine in
#: the larger square: (frequency out of the plane / frequency in it)^2 is 2.8 at the rates here.
_MAGNIFIED: Final = 3.0
_BY_ESTIMATE: Final = "three times the engine's own error estimate: the frequency is the root of a difference of squares"


@dataclass(frozen=True)
class Vibration:
    """One sinusoid about a mean, fitted by least squares: frequency in Hz, amplitude and mean in the signal's unit."""

    frequency: float
    amplitude: float
    mean: float


def scene() -> FollowerAlone:
    """That of the manoeuvre."""
    found = load_case(CASE).scene
    assert isinstance(found, FollowerAlone)
    return found


def manoeuvre(name: str) -> Iterator[Row]:
    """The engine's largest lag, axial stretch and remaining vibration in the manoeuvre itself, at its default accuracy."""
    case, alone = load_case(CASE), scene()
    result = simulate(engine(name), alone, standard_start(alone), case.duration, case.output_step)
    trajectory, accuracy, unit = result.trajectory, _estimate(result), time_unit(alone.follower)
    time, deflection = trajectory["time"], trajectory["tip_deflection"]
    steady = time >= alone.spin_up.time
    row = partial(Row, scene=CASE, engine=name)

    lag, theory = -float(np.min(deflection)), linear_lag(alone)
    printed = _published("largest tip lag")
    yield row(
        quantity="largest tip lag, linear theory",
        value=lag,
        expected=theory,
        tolerance=(theory / alone.follower.length) ** 2 + accuracy,
        reason="linear theory leaves out the square of the lag over the length; the engine's error estimate",
    )
    yield row(
        quantity="largest tip lag, published",
        value=lag,
        expected=printed["value"],
        tolerance=printed["digits"] / printed["value"] + accuracy,
        reason="reading of a figure; the engine's error estimate",
    )

    rate = alone.spin_up.speed * unit
    frequency = float(frequencies(rate, 1)[0])
    found = fitted_vibration(time[steady], deflection[steady], frequency / unit / (2.0 * math.pi))
    of_engine, reason = _frequency_bound(name, accuracy, rate, frequency)
    yield row(
        quantity="frequency in steady spin",
        value=found.frequency,
        expected=frequency / unit / (2.0 * math.pi),
        tolerance=of_engine + (found.amplitude / alone.follower.length) ** 2,
        reason=f"{reason}; the square of amplitude over length",
    )
    yield row(
        quantity="mean tip deflection in steady spin",
        value=found.mean,
        expected=0.0,
        scale=theory,
        tolerance=1e-5,
        reason="what other modes leave in the fit of one sinusoid",
    )

    if "axial_stretch" in trajectory.columns:
        stretch, printed = float(np.mean(trajectory["axial_stretch"][steady])), _published("steady axial stretch")
        yield row(
            quantity="steady axial stretch, closed form",
            value=stretch,
            expected=spinning_rod_stretch(alone),
            tolerance=accuracy,
            reason="the engine's error estimate",
        )
        yield row(
            quantity="steady axial stretch, published",
            value=stretch,
            expected=printed["value"],
            tolerance=printed["digits"] / printed["value"] + accuracy,
            reason="the digits printed; the engine's error estimate",
        )


def at_rate(name: str, rate: float) -> Row:
    """Frequency of the vibration about the steady spin at a rate (1 / `time_unit`) for which one is published."""
    out_of_plane = dict(zip(PUBLISHED["rates"], PUBLISHED["frequencies"], strict=True))[rate]
    alone = scene()
    unit = time_unit(alone.follower)
    spun = dataclasses.replace(alone, spin_up=SpinUp(speed=rate / unit, time=SPUN_UP))
    result = simulate(engine(name), spun, standard_start(spun), WATCHED, load_case(CASE).output_step)
    steady = result.trajectory["time"] >= SPUN_UP
    in_plane = math.sqrt(out_of_plane**2 - rate**2)
    expected = in_plane / unit / (2.0 * math.pi)
    found = fitted_vibration(result.trajectory["time"][steady], result.trajectory["tip_deflection"][steady], expected)
    # what the print leaves open, and what the finite amplitude adds to the frequency of infinitely small ones
    open_in_print = out_of_plane * PUBLISHED["digits"] / in_plane**2
    finite = (found.amplitude / alone.follower.length) ** 2
    of_engine, reason = _frequency_bound(name, _estimate(result), rate, in_plane)
    return Row(
        scene=CASE,
        engine=name,
        quantity=f"frequency in steady spin at {rate:g} / sqrt(rho A L^4 / EI)",
        value=found.frequency,
        expected=expected,
        tolerance=of_engine + open_in_print + finite,
        reason=f"{reason}; the digits printed; the square of amplitude over length",
    )


def fitted_vibration(time: Array, signal: Array, near: float) -> Vibration:
    """The sinusoid about a mean that fits best, its frequency within a tenth of `near` (Hz)."""

    def columns(frequency: float) -> Array:
        phase = 2.0 * np.pi * frequency * time
        return np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(time)])

    def misfit(frequency: float) -> float:
        A = columns(frequency)
        return float(np.sum((A @ np.linalg.lstsq(A, signal, rcond=None)[0] - signal) ** 2))

    # the misfit has a valley for every period more or less in the record: the deepest of a scan first
    scan = np.linspace(0.9 * near, 1.1 * near, 81)
    best = scan[int(np.argmin([misfit(frequency) for frequency in scan]))]
    step = scan[1] - scan[0]
    found = minimize_scalar(misfit, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-10 * near})
    a, b, mean = np.linalg.lstsq(columns(found.x), signal, rcond=None)[0]
    return Vibration(float(found.x), float(np.hypot(a, b)), float(mean))


def linear_lag(scene: FollowerAlone) -> float:
    """Largest lag of the tip by linear theory, m: the deflection in equilibrium with the base's motion, and the inertia of its change.

    Of the tip's deflection in equilibrium w_e(t) the first mode follows as w = w_e - w_e'' / omega^2, with its frequency at the rate of
    that instant; the next term is a tenth of that.
    """
    unit, length = time_unit(scene.follower), scene.follower.length
    time = np.linspace(0.0, scene.spin_up.time, 601)
    motion = np.array([base_motion(scene.spin_up.speed, scene.spin_up.time, t) for t in time])
    rest = length * quasi_static_deflection(motion[:, 1] * unit, motion[:, 2] * unit**2)
    some = time[::20]
    first = (
        np.interp(time, some, [frequencies(base_motion(scene.spin_up.speed, scene.spin_up.time, t)[1] * unit, 1)[0] for t in some]) / unit
    )
    change = np.gradient(np.gradient(rest, time), time)
    return float(np.max(-(rest - change / first**2)[2:-2]))


def spinning_rod_stretch(scene: FollowerAlone) -> float:
    """Lengthening of a rod that spins steadily, m: EA u'' + rho A W^2 (x + u) = 0 gives L (tan(aL)/(aL) - 1), a = W sqrt(rho A / EA)."""
    a = scene.spin_up.speed * math.sqrt(scene.follower.mass_per_length / scene.follower.axial_stiffness) * scene.follower.length
    return scene.follower.length * (math.tan(a) / a - 1.0)


def _frequency_bound(name: str, accuracy: float, rate: float, expected: float) -> tuple[float, str]:
    """Largest relative difference to be expected of an engine's frequency, and why; `expected` over 1 / `time_unit`."""
    if name == "thesis":
        return cubic_frequency(rate) / expected - 1.0 + accuracy, "a single cubic is stiffer by as much as Ritz's method says"
    return _MAGNIFIED * accuracy, _BY_ESTIMATE


def _estimate(result: Result) -> float:
    """Of the error of the tip deflection; that of the engine's default where none could be made."""
    return result.error_estimate if result.error_estimate is not None else result.accuracy or math.nan


def _published(quantity: str) -> dict[str, Any]:
    (found,) = (number for number in LITERATURE["number"] if number["quantity"] == quantity)
    return dict(found)
