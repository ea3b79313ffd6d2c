"""The problems of the pack, each with its signals and its formulations."""

from functools import partial
from typing import Final

from quickreturn.plugins.pack import by_hand, cables, derived, scenes
from quickreturn.plugins.pack.bounds import Formulation, Problem

_TIP: Final = {"tip_x": "m", "tip_y": "m"}
_MECHANISM: Final = {"tip_deflection": "m", "tip_x": "m", "tip_y": "m", "crank_angle": "rad", "slider_position": "m"}
_DERIVED: Final = "quickreturn.derive"
_CABLE: Final = "Exudyn, ANCF cables, extrapolated in step and elements"


def _scene(name: str, signals: dict[str, str], *others: str, **more: Formulation) -> Problem:
    formulations = {f"quickreturn, engine {engine}": partial(scenes.moved, name, engine) for engine in ("reference", *others)} | more
    return Problem(signals, 1000, formulations, partial(scenes.moved, name, "reference", fine=True))


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
