"""The spin-up manoeuvre in every engine beside published values and closed forms.

Nothing here shares code with an engine: what is expected comes from print (`cases/data/literature.toml`), from the linear theory of the
rotating cantilever by power series (`rotating_cantilever`), or from the statics of a spinning rod.
"""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from cases.case import Case
from cases.case_file import load_case
from cases.data import read_toml
from engines.accurate import Result
from engines.base import EngineFailure, Refusal
from engines.registry import MAIN, engine
from engines.scene import simulate_scene
from engines.settings import SettingError
from reference_model.mechanism import FollowerAlone, SpinUp
from reference_model.spin_up import base_motion
from tests.verification.literature.comparison import Comparison
from tests.verification.literature.rotating_cantilever import cubic_frequency, frequencies, quasi_static_deflection, time_unit

Array = NDArray[np.float64]

CASE: Final = "spin-up"

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


def spin_up_table(engines: Sequence[str] = MAIN, rates: Sequence[float] = (2.0, 4.0, 6.0)) -> tuple[list[Comparison], dict[str, str]]:
    """All comparisons for engines by name, at their default accuracies.

    Args:
        engines: names.
        rates: those of the published frequencies to run as well, in units of 1 / `time_unit`; each costs a run.

    Returns:
        The rows, and for engines that have no such model or failed the sentence why.

    Raises:
        UnknownEngine: no engine has this name.
    """
    case, rows, failures = load_case(CASE), list[Comparison](), dict[str, str]()
    for name in engines:
        try:
            rows += manoeuvre(case, name)
            rows += [row for rate in rates for row in at_rate(case, name, rate)]
        except (Refusal, SettingError, EngineFailure) as trouble:
            failures[name] = str(trouble)
    return rows, failures


def manoeuvre(case: Case, name: str) -> list[Comparison]:
    """The engine's largest lag, axial stretch and remaining vibration in the manoeuvre itself."""
    scene = _follower_of(case)
    result = simulate_scene(engine(name), scene, case.duration, case.output_step)
    trajectory, accuracy = result.trajectory, _estimate(result)
    time, deflection = trajectory["time"], trajectory["tip_deflection"]
    steady = time >= scene.spin_up.time
    return [
        *_lag(case, name, -float(np.min(deflection)), accuracy),
        *_vibration(case, name, fitted_vibration(time[steady], deflection[steady], _expected_frequency(scene)), accuracy),
        *(
            _stretch(case, name, float(np.mean(trajectory["axial_stretch"][steady])), accuracy)
            if "axial_stretch" in trajectory.columns
            else ()
        ),
    ]


def at_rate(case: Case, name: str, rate: float) -> Iterator[Comparison]:
    """Frequency of the vibration about the steady spin at a rate (1 / `time_unit`) for which one is published."""
    published = _published_frequencies()
    out_of_plane = dict(zip(published["rates"], published["frequencies"], strict=True))[rate]
    scene = _follower_of(case)
    unit = time_unit(scene.follower)
    spun = dataclasses.replace(scene, spin_up=SpinUp(speed=rate / unit, time=SPUN_UP))
    result = simulate_scene(engine(name), spun, WATCHED, case.output_step)
    steady = result.trajectory["time"] >= SPUN_UP
    expected = math.sqrt(out_of_plane**2 - rate**2) / unit / (2.0 * math.pi)
    found = fitted_vibration(result.trajectory["time"][steady], result.trajectory["tip_deflection"][steady], expected)
    # what the print leaves open, and what the finite amplitude adds to the frequency of infinitely small ones
    open_in_print = out_of_plane * published["digits"] / (out_of_plane**2 - rate**2)
    finite = (found.amplitude / scene.follower.length) ** 2
    of_engine, reason = _frequency_bound(name, result, rate, expected * unit * 2.0 * math.pi)
    yield Comparison(
        case=case.name,
        engine=name,
        quantity=f"frequency in steady spin at {rate:g} / sqrt(rho A L^4 / EI)",
        unit="Hz",
        computed=found.frequency,
        expected=expected,
        scale=expected,
        bound=of_engine + open_in_print + finite,
        reason=f"{reason}; the digits printed; the square of amplitude over length",
        kind="published",
        source=published["source"],
        seen=published["seen"],
        note=f"square of the printed frequency out of the plane less square of the rate; {published['note']}",
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


def _lag(case: Case, name: str, lag: float, accuracy: float) -> Iterator[Comparison]:
    scene = _follower_of(case)
    expected = linear_lag(scene)
    common: dict[str, Any] = {"case": case.name, "engine": name, "quantity": "largest tip lag", "unit": "m", "computed": lag}
    yield Comparison(
        **common,
        expected=expected,
        scale=expected,
        bound=(expected / scene.follower.length) ** 2 + accuracy,
        reason="linear theory leaves out the square of the lag over the length; the engine's error estimate",
        kind="closed form",
        source="linear theory of the rotating cantilever by power series: equilibrium and its inertia",
    )
    yield _against_print(common, accuracy, "reading of a figure")


def _stretch(case: Case, name: str, stretch: float, accuracy: float) -> Iterator[Comparison]:
    closed = spinning_rod_stretch(_follower_of(case))
    common: dict[str, Any] = {"case": case.name, "engine": name, "quantity": "steady axial stretch", "unit": "m", "computed": stretch}
    yield Comparison(
        **common,
        expected=closed,
        scale=closed,
        bound=accuracy,
        reason="the engine's error estimate",
        kind="closed form",
        source="rod that spins steadily, L (tan(aL)/(aL) - 1)",
    )
    yield _against_print(common, accuracy, "the digits printed")


def _against_print(common: dict[str, Any], accuracy: float, uncertain: str) -> Comparison:
    """A quantity beside its published value; `uncertain` is what the value's digits stand for."""
    published = _published(common["quantity"])
    return Comparison(
        **common,
        expected=published["value"],
        scale=published["value"],
        bound=published["digits"] / published["value"] + accuracy,
        reason=f"{uncertain}; the engine's error estimate",
        kind="published",
        source=published["source"],
        seen=published["seen"],
        note=published["note"],
    )


def _vibration(case: Case, name: str, found: Vibration, result_accuracy: float) -> Iterator[Comparison]:
    scene = _follower_of(case)
    rate = scene.spin_up.speed * time_unit(scene.follower)
    expected = _expected_frequency(scene)
    of_engine, reason = _frequency_bound_for(name, result_accuracy, rate, expected * time_unit(scene.follower) * 2.0 * math.pi)
    yield Comparison(
        case=case.name,
        engine=name,
        quantity="frequency in steady spin",
        unit="Hz",
        computed=found.frequency,
        expected=expected,
        scale=expected,
        bound=of_engine + (found.amplitude / scene.follower.length) ** 2,
        reason=f"{reason}; the square of amplitude over length",
        kind="closed form",
        source="linear theory of the rotating cantilever by power series",
    )
    yield Comparison(
        case=case.name,
        engine=name,
        quantity="mean tip deflection in steady spin",
        unit="m",
        computed=found.mean,
        expected=0.0,
        scale=linear_lag(scene),
        bound=1e-5,
        reason="what other modes leave in the fit of one sinusoid",
        kind="closed form",
        source="in steady spin nothing bends the follower",
    )


def _frequency_bound(name: str, result: Result, rate: float, expected: float) -> tuple[float, str]:
    return _frequency_bound_for(name, _estimate(result), rate, expected)


def _frequency_bound_for(name: str, accuracy: float, rate: float, expected: float) -> tuple[float, str]:
    """Largest relative difference to be expected of an engine's frequency, and why; `expected` over 1 / `time_unit`."""
    if name == "thesis":
        return cubic_frequency(rate) / expected - 1.0 + accuracy, "a single cubic is stiffer by as much as Ritz's method says"
    return _MAGNIFIED * accuracy, _BY_ESTIMATE


def _estimate(result: Result) -> float:
    """Of the error of the tip deflection; that of the engine's default where none could be made."""
    return result.error_estimate if result.error_estimate is not None else result.accuracy or math.nan


def _expected_frequency(scene: FollowerAlone) -> float:
    unit = time_unit(scene.follower)
    return float(frequencies(scene.spin_up.speed * unit, 1)[0]) / unit / (2.0 * math.pi)


def _follower_of(case: Case) -> FollowerAlone:
    assert isinstance(case.scene, FollowerAlone)
    return case.scene


@cache
def _published(quantity: str) -> dict[str, Any]:
    (found,) = (number for number in read_toml("literature.toml")["number"] if number["quantity"] == quantity)
    return dict(found)


@cache
def _published_frequencies() -> dict[str, Any]:
    (found,) = read_toml("literature.toml")["rotating_cantilever"]
    return dict(found)
