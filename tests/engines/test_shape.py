"""The deflection at the interior twelfths of the length: in every engine a line from the base to the tip, and the same line."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from quickreturn.engines.accurate import simulate
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.columns import SHAPE
from quickreturn.reference_model.mechanism import PrescribedSpeed
from tests.engines.scenes import run_24


def shape(trajectory: Trajectory) -> np.ndarray:
    """Thirteen places, base and tip included, shape (rows, 13)."""
    ends = [np.zeros(len(trajectory)), trajectory["tip_deflection"]]
    return np.column_stack([ends[0], *(trajectory[name] for name in SHAPE), ends[1]])


@pytest.mark.parametrize("name", [*MAIN, *(pytest.param(name, marks=pytest.mark.verify) for name in RIVALS)])
def test_thirteen_places_are_one_smooth_line_clamped_at_the_base(name: str) -> None:
    mechanism = run_24()
    if name == "moving-boundaries":  # which takes a crank of known speed alone
        mechanism = replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=16.6)))
    chosen = engine(name)
    settings = chosen.settings_for(chosen.default_accuracy, mechanism)
    trajectory = run_once(chosen, mechanism, standard_start(mechanism), 0.2, 1e-3, settings).trajectory
    x, lines = np.linspace(0.0, 1.0, 13), shape(trajectory)
    size = np.max(np.abs(lines))
    # leaving out every other place and taking it from a spline through the rest: smooth to 3e-3 of the largest, kink included
    spline = CubicSpline(x[::2], lines[:, ::2], axis=1, bc_type=((1, np.zeros(len(lines))), "not-a-knot"))
    assert np.max(np.abs(spline(x[1::2]) - lines[:, 1::2])) < 3e-3 * size


@pytest.mark.parametrize(("other", "accuracy"), [("mujoco", None), pytest.param("exudyn", 1e-2, marks=pytest.mark.verify)])
def test_engines_draw_the_same_line(other: str, accuracy: float | None) -> None:
    mechanism = run_24()
    lines = []
    for name, asked in (("reference", None), (other, accuracy)):
        result = simulate(engine(name), mechanism, standard_start(mechanism), 0.4, 1e-3, accuracy=asked)
        lines.append((shape(result.trajectory), result.error_estimates["tip_deflection"]))
    (ours, own), (line, estimate) = lines
    difference = np.sqrt(np.mean((line - ours) ** 2, axis=0))
    # the tip moves most; errors further in are no larger than its
    assert np.all(difference <= (estimate + own) * np.sqrt(np.mean(ours[:, -1] ** 2)))
