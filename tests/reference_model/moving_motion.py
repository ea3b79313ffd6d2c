"""Runs of the model whose shapes follow the slider, with its own tables or with finer ones."""

import numpy as np
from numpy.typing import NDArray

from reference_model.integrate import REACHED_END
from reference_model.mechanism import Mechanism
from reference_model.moving_model import MovingShapeModel
from reference_model.moving_modes import ModeFamily, mode_family
from reference_model.moving_parameters import moving_workspace, slider_range, span_tables

Array = NDArray[np.float64]


def places_of(mechanism: Mechanism) -> tuple[float, float]:
    """Nearest and farthest place of the rigid mechanism's slider, m."""
    return mechanism.pivot_distance - mechanism.crank.length, mechanism.pivot_distance + mechanism.crank.length


def fine_family(mechanism: Mechanism, modes: int) -> ModeFamily:
    """Shapes around the places that the slider visits: 120 terms leave 1e-9 of psi and 1e-6 of its second derivative in five modes."""
    nearest, farthest = places_of(mechanism)
    return mode_family(mechanism, modes, 0.98 * nearest, min(1.02 * farthest, slider_range(mechanism)[1]), 120)


def with_fine_tables(mechanism: Mechanism, modes: int, *, points: int = 11, intervals: int = 400) -> MovingShapeModel:
    """The same equations, with tables whose errors are 1e-8 and less: what is left is the equations' own."""
    model, family = MovingShapeModel(mechanism, modes), fine_family(mechanism, modes)
    tables = span_tables(family, points, intervals)
    parameters = model.parameters._replace(reach=family.high, tables=tables)
    for name, value in (
        ("parameters", parameters),
        ("_workspace", moving_workspace(tables, modes)),
        ("_output_workspace", moving_workspace(tables, modes)),
    ):
        object.__setattr__(model, name, value)
    return model


def run(
    model: MovingShapeModel, duration: float, intervals: int, tolerance: float, state: Array | None = None
) -> tuple[Array, dict[str, Array]]:
    """States and observables on a uniform grid, from the standard start or a given state."""
    crank = model.mechanism.crank
    y = model.straight_state(crank.initial_angle, crank.drive.initial_speed) if state is None else state
    result = model.integrate(y, duration / intervals, intervals, tolerance)
    assert result.status == REACHED_END
    return result.states, model.observe(result.states)
