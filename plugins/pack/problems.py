"""The problems of the pack, each with its signals and its formulations."""

from functools import partial
from typing import Any, Final, NamedTuple

import quickreturn as qr
from quickreturn.plugins.pack import by_hand, cables, derived
from quickreturn.plugins.pack.bounds import Formulation, Problem
from quickreturn.plugins.pack.values import Columns, times

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
