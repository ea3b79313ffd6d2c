"""The problems of the pack, each with its signals and its formulations; from these a table with bounds."""

import json
import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

import quickreturn as qr
from quickreturn.pack.check import PACK, interpolated
from quickreturn.plugins.pack import by_hand, cables, derived
from quickreturn.plugins.pack.values import Columns, times
from quickreturn.reference_model.arrays import Array

#: Columns of a formulation over a number of rows after the first.
Formulation = Callable[[int], Columns]
#: A bound is the largest difference of two formulations times this, with errors of interpolation and rounding added.
MARGIN: Final = 2.0
#: Least bound over the largest value of a signal: nobody asks for more, and the tables stay short.
LEAST: Final = 1e-6
#: Rounding of a table's numbers, at most this part of the bound.
ROUNDED: Final = 0.02


class Problem(NamedTuple):
    """A problem and its formulations: words that name each -> how it is computed. The first gives the table."""

    signals: Mapping[str, str]  # the main one first -> unit
    rows: int  # after the first
    formulations: Mapping[str, Formulation]
    finer: Formulation  # the first one with a finer resolution
    horizon: float | None = None  # s; None: the duration


def made(problem: Problem) -> tuple[str, dict[str, Any]]:
    """The text of results.csv, and the content of bounds.json but for names."""
    names, count = list(problem.formulations), problem.rows
    first, *others = (formulation(count) for formulation in problem.formulations.values())
    between = problem.finer(2 * count)
    fine = {name: values[::2] for name, values in between.items()}
    time = fine["time"]
    horizon = problem.horizon or float(time[-1])
    until = time <= horizon * (1 + 1e-9)

    def largest(differences: Array) -> float:
        return float(np.max(np.abs(differences[until])))

    columns, signals = [[f"{t:.10g}" for t in time]], {}
    for name, unit in problem.signals.items():
        values, scale = fine[name], float(np.max(np.abs(fine[name])))
        own = largest(first[name] - values)
        differences = {words: largest(other[name] - values) for words, other in zip(names[1:], others, strict=True) if name in other}
        halfway = [interpolated(time.tolist(), values.tolist(), t) for t in ((time[:-1] + time[1:]) / 2).tolist()]
        gap = float(np.max(np.abs(halfway - between[name][1::2])[until[1:]]))
        bound = _rounded_up(max((MARGIN * max(min(differences.values()), own) + gap) / (1 - ROUNDED), LEAST * scale))
        decimals = max(0, math.ceil(-math.log10(2 * ROUNDED * bound)))
        columns.append([f"{value:.{decimals}f}".replace("-0." + "0" * decimals, "0." + "0" * decimals) for value in values])
        relative = bound / float(np.sqrt(np.mean(values[until] ** 2)))
        signals[name] = {"bound": bound, "horizon": horizon, "scale": float(f"{scale:.6g}"), "unit": unit}
        signals[name] |= {"main": name == next(iter(problem.signals)), "relative": _digits(relative)}
        signals[name] |= {"differences": {words: _digits(each) for words, each in differences.items()}}
        signals[name] |= {"own": _digits(own), "interpolation": _digits(gap)}
    text = "\n".join(",".join(row) for row in [["time", *problem.signals], *zip(*columns, strict=True)]) + "\n"
    return text, {"formulation": names[0], "confirmed_by": names[1:], "signals": signals}


def _digits(value: float) -> float:
    return float(f"{value:.2g}")


def _rounded_up(bound: float) -> float:
    """With two digits."""
    size = 10.0 ** (math.floor(math.log10(bound)) - 1)
    return _digits(math.ceil(bound / size) * size)


def written(folder: Path, name: str, made: tuple[str, dict[str, Any]]) -> None:
    """Write results.csv and bounds.json of a problem; each signal is on a line of its own, which the checkers rely on."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / "results.csv").write_text(made[0], "utf-8")
    content = {"problem": name, "version": (PACK / "VERSION").read_text("utf-8").strip()} | made[1]
    signals = ",\n".join(f"    {json.dumps(key)}: {json.dumps(value)}" for key, value in content.pop("signals").items())
    head = "".join(f"  {json.dumps(key)}: {json.dumps(value)},\n" for key, value in content.items())
    (folder / name / "bounds.json").write_text(f'{{\n{head}  "signals": {{\n{signals}\n  }}\n}}\n', "utf-8")


_TIP: Final = {"tip_x": "m", "tip_y": "m"}
_MECHANISM: Final = {"tip_deflection": "m", "tip_x": "m", "tip_y": "m", "crank_angle": "rad", "slider_position": "m"}
_DERIVED: Final = "quickreturn.derive"
_CABLE: Final = "Exudyn, ANCF cables, extrapolated in step and elements"


class Scene(NamedTuple):
    """A case of the library with changes, and settings of engine `exudyn`."""

    case: str
    duration: float
    exudyn: dict[str, Any]
    changes: dict[str, str]


_FINE: Final = {"elements": 64, "step": 1e-4, "extrapolated": True, "newton_tolerance": 1e-7, "axial_factor": 4.0}
_ALONE: Final = _FINE | {"step": 1e-3, "axial_factor": 64.0}
_ROLLERS: Final = _FINE | {"step": 2.5e-5, "extrapolated": False}  # rollers lift off: no order in the step to extrapolate by
SCENES: Final = {
    "spin-up": Scene("spin-up", 20.0, _ALONE, {}),
    "thesis-24": Scene("thesis-24", 0.8, _FINE, {}),
    "thesis-17": Scene("thesis-17", 0.8, _FINE, {}),
    "example": Scene("example", 0.5, _FINE, {"tip.force": '["3 N", "-2 N"]'}),
    "two-rollers": Scene("thesis-24", 0.6, _ROLLERS, {"slider.joint_stiffness_plus": "40 kN/m", "slider.joint_stiffness_minus": "20 kN/m"}),
}


def moved(name: str, engine: str, rows: int, fine: bool = False) -> Columns:
    """All columns of a scene by an engine: `reference` with 13 modes, or 16 if `fine`; `mujoco` to 1e-4."""
    scene = SCENES[name]
    case = qr.case(scene.case, scene.changes, duration=scene.duration, output_step=scene.duration / rows)
    settings = {"exudyn": scene.exudyn, "reference": {"modes": 16 if fine else 13, "tolerance": 1e-10 if fine else 1e-9}}.get(engine)
    accuracy = None if settings else 1e-4
    found = qr.simulate(case, engine, accuracy=accuracy, settings=settings, estimate=accuracy is not None, store=False, quiet=True)
    return {**found.trajectory.columns, "time": times(scene.duration, rows)}


def _scene(name: str, signals: dict[str, str], *others: str, **more: Formulation) -> Problem:
    formulations = {f"quickreturn, engine {engine}": partial(moved, name, engine) for engine in ("reference", *others)} | more
    return Problem(signals, 1000, formulations, partial(moved, name, "reference", fine=True))


PROBLEMS: Final = {
    "sag": Problem(
        {"tip_y": "m", "tip_x": "m", "tip_angle": "rad", "middle_y": "m"}, 100,
        {"elastica, boundary value problem (scipy)": by_hand.sag, _DERIVED: derived.sag}, by_hand.sag,
    ),
    "decay": Problem(
        {"tip_deflection": "m", "middle_deflection": "m"}, 1500,
        {"series of modes": partial(by_hand.decay, modes=80), _DERIVED: derived.decay}, partial(by_hand.decay, modes=160),
    ),
    "spin-up": _scene("spin-up", {"tip_deflection": "m", **_TIP}, "exudyn", **{_DERIVED: derived.spin_up}),
    "bending-pendulum": Problem(
        {"tip_y": "m", "tip_x": "m", "middle_x": "m", "middle_y": "m"}, 750,
        {_DERIVED: partial(derived.bending_pendulum, shapes=8), _CABLE: cables.bending_pendulum}, derived.bending_pendulum, horizon=2.0,
    ),
    "hub": Problem(
        {"tip_deflection": "m", **_TIP, "hub_angle": "rad"}, 500,
        {_DERIVED: partial(derived.hub, shapes=7), _CABLE: cables.hub}, partial(derived.hub, shapes=9),
    ),
    "moving-load": Problem(
        {"middle_y": "m", "quarter_y": "m", "load_y": "m"}, 600,
        {"sines, equations by hand (scipy)": by_hand.moving_load, f"{_DERIVED}, 20 sines": derived.moving_load},
        partial(by_hand.moving_load, modes=60),
    ),
    "bead": Problem(
        {"bead_place": "m", "rod_angle": "rad", "rod_speed": "rad/s"}, 1000,
        {_DERIVED: derived.bead, "MuJoCo, Runge and Kutta": by_hand.bead}, derived.bead,
    ),
    "slider-crank": Problem(
        {"bow": "m", "block_x": "m", "middle_x": "m", "middle_y": "m"}, 750,
        {_DERIVED: partial(derived.slider_crank, shapes=7), _CABLE: cables.slider_crank}, partial(derived.slider_crank, shapes=9),
    ),
    "double-four-bar": Problem(
        {**_TIP, "tip_vx": "m/s", "tip_vy": "m/s"}, 1000,
        {"equation of one angle (scipy)": by_hand.double_four_bar, _DERIVED: derived.double_four_bar}, by_hand.double_four_bar,
    ),
    "thesis-24": _scene("thesis-24", {**_MECHANISM, "slider_force": "N"}, "exudyn", "mujoco"),
    "thesis-17": _scene("thesis-17", {**_MECHANISM, "slider_force": "N"}, "exudyn", "mujoco"),
    "example": _scene("example", _MECHANISM, "exudyn", "mujoco"),
    "two-rollers": _scene("two-rollers", _MECHANISM, "exudyn", "mujoco"),
}  # fmt: skip
