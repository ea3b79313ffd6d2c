"""How far `moving-boundaries` is from exact geometry, and whether its motion is stable.

The tables of `docs/methods.md` come from here; the commands stand in `reference_model/RIVALS.md`, section 4.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
import pandas as pd

from quickreturn.engines.base import NoSteadyState
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import relative_error
from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel
from quickreturn.plugins.methods.rivals.moving_boundaries import MovingBoundariesEngine, MovingBoundariesSettings
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.rigid import crank_pace
from tests.reference_model.multipliers import linear_multipliers

COLUMNS = ("tip_deflection", "tip_acceleration", "strain_2", "slider_force")


def at_speed(mechanism: Mechanism, speed: float) -> Mechanism:
    """The scene with its crank at a speed, rad/s."""
    return dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=speed)))


def error_table(
    mechanism: Mechanism,
    parts: Sequence[float] = (0.5, 1.0, 1.5),
    modes: Sequence[int] = (1, 2, 3, 4),
    duration: float = 2.0,
    output_step: float = 1e-3,
) -> pd.DataFrame:
    """Errors of some columns (RMS of the difference over RMS) against `reference` with 9 modes at the same prescribed speed.

    One row for each part of the speed, with and without foreshortening, and number of modes; duration and output step in s.
    """
    rows = []
    for part in parts:
        scene = at_speed(mechanism, part * crank_pace(mechanism))
        reference = ReferenceEngine().prepare(scene, standard_start(scene), ReferenceSettings(modes=9, tolerance=1e-9))
        truth = reference.advance(duration, output_step)
        for foreshortening in (False, True):
            for n in modes:
                settings = MovingBoundariesSettings(modes=n, foreshortening=foreshortening, tolerance=1e-9)
                found = MovingBoundariesEngine().prepare(scene, standard_start(scene), settings).advance(duration, output_step)
                errors = {name: relative_error(found[name], truth[name]) for name in COLUMNS}
                rows.append({"part of speed": part, "foreshortening": foreshortening, "modes": n, **errors})
    return pd.DataFrame(rows)


def stability_table(mechanism: Mechanism, speeds: Sequence[float], modes: int = 2, *, exact: bool = True) -> pd.DataFrame:
    """Largest modulus of a multiplier at prescribed speeds (rad/s): undamped, damped, and damped by `reference` with 4 modes.

    NaN where `reference` finds no periodic motion; not asked for unless `exact`.
    """
    calm = dataclasses.replace(
        mechanism,
        base=dataclasses.replace(mechanism.base, damping=0.0),
        follower=dataclasses.replace(mechanism.follower, damping=0.0),
    )
    models = {
        f"{name}, {'foreshortening' if short else 'linear'}": MovingBoundariesModel(at_speed(scene, speeds[0]), modes, short)
        for name, scene in (("undamped", calm), ("damped", mechanism))
        for short in (False, True)
    }
    rows = []
    for speed in speeds:
        row = {"speed": speed} | {name: float(np.abs(linear_multipliers(model, speed, 1e-8)[0])) for name, model in models.items()}
        rows.append(row | ({"reference": _exact(at_speed(mechanism, speed))} if exact else {}))
    return pd.DataFrame(rows)


def _exact(scene: Mechanism) -> float:
    try:
        found = ReferenceEngine().steady_state(scene, standard_start(scene), ReferenceSettings(modes=4, tolerance=1e-8))
    except NoSteadyState:
        return float("nan")
    assert found is not None
    return abs(found.multipliers[0])
