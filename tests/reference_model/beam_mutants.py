"""Mutants of the one beam's equations, each of which must miss the plain beam in some state.

The states are like those of `test_plain_beam`, where the compiled equations agree with differences of places to the tolerances used here.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.columns import ROW, columns_of
from quickreturn.reference_model.motion import equations, fields, inertia, loop, observe, plane
from quickreturn.reference_model.motion.layout import workspace
from quickreturn.reference_model.shapes import hermite_elements, no_shapes
from quickreturn.reference_model.slider_constraint import BASE, CHORDS, ELIMINATED
from tests.engines.scenes import run_24
from tests.reference_model.beam_states import (
    ALONE,
    APART,
    BY_FORCE,
    BY_LEVER,
    DAMPED,
    EVERYTHING,
    FREE,
    HEAVY,
    ON_CHORDS,
    ON_ELEMENTS,
    PRELOADED,
    RUBBING,
    State,
    alone,
    at_constant_speed,
    elements_of,
    following,
    modes_of,
    staying,
)
from tests.reference_model.mutation import Hunt, Source, plain

Array = NDArray[np.float64]
Functions = Mapping[str, Any]

#: Those of `test_plain_beam`: of what moves, and of what is recovered from the loads.
TOLERANCE: Final = 1e-6
RECOVERED: Final = 1e-4
#: Of a slider with shapes that follow it and its neighbourhood, where nothing but differences is left.
FOLLOWED: Final = 1e-6
#: By which the slider's place is off where the feedback shall show, m.
OFF: Final = 1e-3


def _store(array: Array, index: int, four: Array) -> None:
    array[index : index + 4] = four


LANES: Mapping[str, Callable[..., Any]] = {
    "load": lambda array, index: array[index : index + 4].copy(),
    "store": _store,
    "spread": lambda number: np.full(4, number),
    "plus": lambda sums, number, four: sums + number * four,
    "plus_product": lambda sums, one, other: sums + one * other,
    "total": lambda four: float(np.sum(four)),
}
SOURCE = Source(
    modules=(plane, fields, loop, inertia, observe, equations),
    no_equations=frozenset({"_factor", "_substitute", "kernel", "evaluate", "observe_states"}),
    stand_ins=dict.fromkeys(("compiled", "inlined", "stage", "cache", "parameters_at", "workspace_at"), plain)
    | {"numbers_at": lambda array, size: array}
    | LANES,
    entry=dict,
)

#: Flipped signs that change nothing, and why.
EQUIVALENT: Mapping[tuple[str, str], str] = {
    ("", "-(0.25 * math.pi)"): "the series of an eighth of the angle, doubled three times, is as good for small ones",
    ("directions", "-1 / 87178291200 - q / 20922789888000"): "the last term of the cosine is rounding, 1e-15 at the largest angle",
}


@dataclass(frozen=True)
class Check:
    """What must come out of the functions, and how far from it they are, in units of the tolerances."""

    ask: Callable[[Functions], Mapping[str, Any]]
    expected: Mapping[str, tuple[Any, float]]  # value, and the difference that is allowed

    def difference(self, functions: Functions) -> float:
        """Infinite where the state cannot be evaluated."""
        try:
            with np.errstate(all="ignore"):
                found = self.ask(functions)
        except (ValueError, ZeroDivisionError, OverflowError, IndexError):
            return math.inf
        ratios = [np.max(np.abs(found[name] - value)) / allowed for name, (value, allowed) in self.expected.items()]
        return max((float(ratio) if np.isfinite(ratio) else math.inf) for ratio in ratios)


def _asked(state: State, y: Array, functions: Functions) -> dict[str, Any]:
    """Rates, the observables, and what the slider's feedback adds."""
    rate, rows, w = np.empty_like(y), np.zeros(1, ROW), workspace(state.model.parameters)
    p = state.model.parameters
    if functions["_kernel"](p, w, y, rate, 1) != 1 or not functions["observe"](p, p.tables, w, y, rows[0]):
        raise ValueError("the state cannot be")
    found: dict[str, Any] = {name: values[0] for name, values in columns_of(rows, joint=True).items()}
    m = p.speeds
    found |= {"speeds": rate[:m], "accelerations": rate[m + 1 : 2 * m + 1], "powers": rate[2 * m + 1 :]}
    found |= {f"bias of {name}": getattr(w.facts, f"{name}_bias") for name in ("q2", "s", "gap")}
    return found | {"s_rate": rate[m], "feedback": rate[m] - w.facts.s_rate, "frequency": w.watched[1]}


def _of_state(state: State, recovered: float = RECOVERED) -> Check:
    """All that the plain beam says of a state, to `recovered` what is recovered from the loads."""
    y, o, m = state.y, state.expected, state.beam.speeds
    powers = [o.dissipated_power, o.drive_power, *([o.joint_power] if m > state.beam.shapes.count + 1 else [])]
    values: dict[str, tuple[Any, float]] = {"speeds": (y[m + 1 : 2 * m + 1], 1.0), "accelerations": (o.acceleration, 0.0)}
    values["powers"] = np.array(powers), 0.0
    expected = {name: (value, TOLERANCE * max(float(np.max(np.abs(value))), size)) for name, (value, size) in values.items()}
    length = state.beam.scene.follower.length
    places = ("follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection")
    strains = max(abs(o.shown[f"strain_{gauge}"]) for gauge in (1, 2, 3))
    bending = max(abs(value) for name, value in o.shown.items() if name.startswith("moment_"))
    for name, value in o.shown.items():
        if name.startswith("moment_"):
            expected[name] = value, max(recovered, 1e-5) * max(bending, 1e-6)
        elif name.startswith("strain_") and name != "strain_energy":
            expected[name] = value, max(recovered, 1e-5) * max(strains, 1e-9)
        elif name in places or name.startswith("shape_"):
            expected[name] = value, recovered * length
        else:
            expected[name] = value, TOLERANCE * max(abs(value), 1e-2)
    if state.beam.kind == BASE:
        for name in ("slider_position", "constraint_gap", "gap_rate", "joint_power", "slider_force", "crank_angle", "crank_speed"):
            del expected[name]
        for name in ("moment_slider", "crank_force_x", "crank_force_y"):
            del expected[name]
    else:
        expected["s_rate"] = o.s_rate, TOLERANCE
        square = float(np.max(np.abs(y[m + 1 : 2 * m + 1]))) ** 2
        biases = {"s": o.s_remainder, "q2": o.q2_remainder} if state.model.closes_loop else {"s": o.s_remainder, "gap": o.gap_remainder}
        expected |= {f"bias of {name}": (value, TOLERANCE * max(abs(value), square)) for name, value in biases.items()}
        if state.model.closes_loop:
            for name in ("gap_rate", "joint_power"):
                del expected[name]
    if state.model.parameters.knows_frequency:
        expected["frequency"] = _bound(state), 1e-4 * _bound(state)
    return Check(lambda functions: _asked(state, y, functions), expected)


def _bound(state: State) -> float:
    """Of the highest frequency, by the plain beam's mass matrix."""
    M, highest = state.expected.mass_matrix, state.beam.shapes.stiffness(state.expected.configuration.s)[-1, -1]
    if state.model.parameters.first == 1:
        return math.sqrt(highest)
    return math.sqrt(highest / (1.0 - np.sum(M[0, 1:] ** 2 / np.diag(M)[1:]) / M[0, 0]))


def _of_feedback(state: State) -> Check:
    """How fast a slider that is not where it belongs goes there."""
    beam, m = state.beam, state.beam.speeds
    y = state.y.copy()
    y[m] += OFF
    here, c = state.expected.configuration, beam.at_place(y[m], y[1 : beam.shapes.count + 1])
    if beam.shapes.count == 0:
        missed = -OFF
    elif beam.kind == ELIMINATED:
        missed = abs(beam.crank_tip(y[0])) - abs(complex(c.z.at(y[m], beam.slider_piece)))
    else:
        tip, piece = beam.crank_tip(y[0]) / here.frame, beam.slider_piece
        tangent = complex(np.exp(1j * c.psi.at(y[m], piece)))
        foot = complex(c.z.at(y[m], piece))
        if beam.kind == CHORDS:
            (left, right), (x1, x2) = beam.node_places(c), beam.nodes()
            tangent, foot = (right - left) / abs(right - left), left + (y[m] - x1) / (x2 - x1) * (right - left)
        missed = (tangent.conjugate() * (tip - foot)).real
    return Check(
        lambda functions: _asked(state, y, functions), {"feedback": (equations.FEEDBACK * missed, 1e-3 * equations.FEEDBACK * OFF)}
    )


def _of_row(state: State) -> Check:
    """A row of a table whose coefficients are all of one size."""
    t = state.model.parameters.tables
    rng = np.random.default_rng(0)
    t = t._replace(coefficients=rng.uniform(-1.0, 1.0, t.coefficients.shape) / t.step ** np.arange(3, -1, -1)[:, None])
    interval, part = 2, 0.37

    def ask(functions: Functions) -> Mapping[str, Any]:
        row = np.empty(t.coefficients.shape[2])
        functions["interpolate_row"](t, t.low + (interval + part) * t.step, row)
        return {"row": row}

    return Check(ask, {"row": (np.polyval(t.coefficients[interval], part * t.step), 1e-9)})


def _of_unobserved(state: State) -> Check:
    """The drive's power where nobody asks for observables, and its torque is given."""
    y, rate, m = state.y, np.empty_like(state.y), state.beam.speeds

    def ask(functions: Functions) -> Mapping[str, Any]:
        p = state.model.parameters
        functions["_kernel"](p, workspace(p), y, rate, 0)
        return {"power": rate[2 * m + 2]}

    return Check(ask, {"power": (state.expected.drive_power, TOLERANCE * abs(state.expected.drive_power))})


def _of_directions(largest: float) -> Check:
    """exp(i psi), of angles to either side of the one from which they are halved."""
    angles = np.linspace(-largest, largest, 16)

    def ask(functions: Functions) -> Mapping[str, Any]:
        e = np.empty(32)
        if not functions["directions"](angles, e):
            raise ValueError("too far")
        return {"e": e}

    return Check(ask, {"e": (np.concatenate([np.cos(angles), np.sin(angles)]), 1e-14)})


@cache
def checks() -> tuple[Check, ...]:
    """Shapes that follow, stay, and elements with each distribution; crank free and held; the base; a rigid follower."""
    held, held_elements = at_constant_speed(EVERYTHING), at_constant_speed(ON_ELEMENTS)
    damped = replace(BY_FORCE, bending_damping=1e-4)
    rubbing_held = at_constant_speed(RUBBING)
    # rotary inertia as large as shows where it acts beside the line
    turning = replace(held, slider=replace(held.slider, inertia=5e-3))
    rigid = run_24(follower={"bending_stiffness": math.inf}, slider=EVERYTHING.slider, gravity=EVERYTHING.gravity)
    states = (
        following(EVERYTHING, 1, 8, BY_FORCE),
        following(EVERYTHING, 2, 1),
        following(turning, 2, 2, HEAVY),
        staying(ON_ELEMENTS, elements_of(EVERYTHING, 2), 3, BY_LEVER),
        staying(ON_ELEMENTS, elements_of(EVERYTHING, 2), 4, ON_CHORDS),
        staying(held, modes_of(EVERYTHING, 2), 5, transverse_damping=True),
        alone(replace(ALONE, follower=replace(ALONE.follower, material_damping=2e-4)), hermite_elements(ALONE.follower.length, 2), 6),
        staying(held_elements, elements_of(EVERYTHING, 1), 7, damped),
        staying(rigid, no_shapes(rigid.follower.length), 9),
        following(DAMPED, 2, 34, APART),
        following(rubbing_held, 2, 30, APART),
        following(RUBBING, 2, 34, PRELOADED),
        following(RUBBING, 2, 35, FREE),
        staying(RUBBING, modes_of(EVERYTHING, 2), 34, BY_FORCE),
    )
    feedback = tuple(_of_feedback(states[k]) for k in (1, 2, 4, 8))
    of_states = (_of_state(state, FOLLOWED if state.model.parameters.tables.moves else RECOVERED) for state in states)
    return (*of_states, *feedback, _of_unobserved(states[0]), _of_row(states[0]), _of_directions(0.7), _of_directions(6.0))


HUNT: Final = Hunt(SOURCE, checks, 1.0, EQUIVALENT, least=200)
