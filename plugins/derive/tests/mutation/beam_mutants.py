"""Mutants of the one beam's equations, each of which must miss the computer's derivation in some state."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

import numpy as np

from quickreturn.plugins.derive.tests.mutation.mutation import Hunt, Source, plain
from quickreturn.plugins.derive.tests.reference.by_hand import by_hand, sizes
from quickreturn.plugins.derive.tests.reference.derived_beam import DerivedBeam, State
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import ROW, by_column, recorded_columns
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.motion import equations, fields, inertia, loop, observe, plane, spring
from quickreturn.reference_model.motion.layout import workspace
from quickreturn.reference_model.shapes import hermite_elements
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.state import State as Parts
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_states import (
    ALONE,
    APART,
    BY_FORCE,
    BY_LEVER,
    DAMPED,
    EVERYTHING,
    FREE,
    HEAVY,
    HELD_BY_SPRING,
    ON_CHORDS,
    ON_ELEMENTS,
    PRELOADED,
    RUBBING,
    at_constant_speed,
    elements_of,
    modes_of,
)

Functions = Mapping[str, Any]

#: Of what is solved for; found: 3e-13.
TOLERANCE: Final = 1e-10
following, staying = DerivedBeam.following, DerivedBeam.staying
#: By which the slider's place is off where the feedback shall show, m.
OFF: Final = 1e-3


def _store(array: Array, index: int, four: Array) -> None:
    array[index : index + 4] = four


FOURS: Mapping[str, Callable[..., Any]] = {
    "load": lambda array, index: array[index : index + 4].copy(),
    "store": _store,
    "spread": lambda number: np.full(4, number),
    "plus": lambda sums, one, other: sums + one * other,
    "total": lambda four: float(np.sum(four)),
}
SOURCE = Source(
    modules=(plane, fields, loop, spring, inertia, observe, equations),
    no_equations=frozenset({"_factor", "_substitute", "kernel", "observe_states"}),
    stand_ins=dict.fromkeys(("compiled", "inlined", "inner", "cache"), plain) | FOURS,
    entry=dict,
)

#: Changes without effect, and why.
_DOUBLED = "the series of an eighth of the angle, doubled three times, is as good for small ones"
_AT_REST: Final = "it only keeps a tip at rest from a division by zero"
EQUIVALENT: Mapping[tuple[str, str], str] = {
    ("motion", "p.LA / direction(q1)"): "the mirrored crank's tip is as far from P",
    ("_push_tip", "-math.sqrt(dot(velocity, velocity)) + STILL * p.slide_speed"): "the friction over the speed is even in the speed",
    ("_push_tip", "math.sqrt(dot(velocity, velocity)) - STILL * p.slide_speed"): _AT_REST,
    ("_push_tip", "STILL / p.slide_speed"): _AT_REST,
    ("_recover", "1.5"): "beyond any place before the follower's beginning is all of it",
    ("", "-(0.25 * math.pi)"): _DOUBLED,
    ("", "0.25 / math.pi"): _DOUBLED,
    ("", "0.375"): "the series is still good to 1e-14",
    ("", "3.0"): "the largest angle is chosen",
    ("highest_frequency", "1.5e-06"): "a floor that no sensible crank comes near",
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
    """All that the equations say, and what the slider's feedback adds."""
    p = state.model.parameters
    rate, rows, w = np.empty_like(y), np.zeros(1, ROW), workspace(p)
    if not functions["evaluate"](p, p.tables, w, Parts.of(y), Parts.of(rate)) or not functions["observe"](
        p, p.tables, w, Parts.of(y), rows[0]
    ):
        raise ValueError("the state cannot be")
    found = by_hand(
        state.model, w, rate, {name: values[0] for name, values in recorded_columns(by_column(rows), joint=True, spring=True).items()}
    )
    return found | {"feedback": rate[p.speeds] - w.facts.s_rate}


def _of_state(state: State) -> Check:
    """Every term and output."""
    size = sizes(state)
    return Check(
        lambda functions: _asked(state, state.y, functions),
        {name: (value, TOLERANCE * size[name]) for name, value in state.expected.items()},
    )


def _of_feedback(state: State) -> Check:
    """How fast a slider that is not where it belongs goes there."""
    y = state.y.copy()
    y[state.model.parameters.speeds] += OFF
    expected = state.model.parameters.feedback * state.witness.missed(state, OFF)
    return Check(lambda functions: _asked(state, y, functions), {"feedback": (expected, TOLERANCE * abs(expected))})


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
    p, rate, expected = state.model.parameters, np.empty_like(state.y), state.expected["powers"][1]

    def ask(functions: Functions) -> Mapping[str, Any]:
        functions["evaluate"](p, p.tables, workspace(p), Parts.of(state.y), Parts.of(rate))
        return {"power": rate[2 * p.speeds + 2]}

    return Check(ask, {"power": (expected, TOLERANCE * abs(expected))})


def _of_directions(largest: float) -> Check:
    """exp(i psi), of angles to either side of the one from which they are halved."""
    angles = np.linspace(-largest, largest, 16)

    def ask(functions: Functions) -> Mapping[str, Any]:
        e = np.empty(32)
        if not functions["directions"](angles, e):
            raise ValueError("too far")
        return {"e": e}

    return Check(ask, {"e": (np.concatenate([np.cos(angles), np.sin(angles)]), 1e-14)})


def _exchanged(mechanism: Mechanism) -> Mechanism:
    """The mechanism whose crank is as long as the pivots are apart, and the other way round: the follower turns fully."""
    crank = replace(mechanism.crank, length=mechanism.pivot_distance)
    return replace(mechanism, pivot_distance=mechanism.crank.length, crank=crank)


@cache
def checks() -> tuple[Check, ...]:
    """Shapes that follow, stay, and elements with each distribution; crank free and held; the base; a rigid follower."""
    damped = replace(BY_FORCE, bending_damping=1e-4)
    # rotary inertia as large as shows where it acts beside the line
    turning = at_constant_speed(replace(EVERYTHING, slider=replace(EVERYTHING.slider, inertia=5e-3)))
    rigid = run_24(follower={"bending_stiffness": math.inf}, slider=EVERYTHING.slider, gravity=EVERYTHING.gravity)
    alone = replace(ALONE, follower=replace(ALONE.follower, material_damping=2e-4))
    models = (
        following(EVERYTHING, 1, BY_FORCE),
        following(EVERYTHING, 4, slowed_to=3),  # with more points a cell
        following(turning, 2, HEAVY),
        staying(ON_ELEMENTS, elements_of(EVERYTHING, 2), BY_LEVER),
        staying(ON_ELEMENTS, elements_of(EVERYTHING, 2), ON_CHORDS),
        staying(at_constant_speed(EVERYTHING), modes_of(EVERYTHING, 2)),
        DerivedBeam.of_follower_alone(alone, hermite_elements(ALONE.follower.length, 2)),
        staying(at_constant_speed(ON_ELEMENTS), elements_of(EVERYTHING, 1), damped),
        following(rigid, 0),
        following(DAMPED, 2, APART),
        following(at_constant_speed(RUBBING), 2, APART),
        following(RUBBING, 2, PRELOADED),
        following(RUBBING, 2, FREE),
        staying(RUBBING, modes_of(EVERYTHING, 2), BY_FORCE),
        following(replace(HELD_BY_SPRING, slider=Slider()), 2),
        staying(at_constant_speed(HELD_BY_SPRING), modes_of(EVERYTHING, 2), BY_FORCE),
        following(_exchanged(EVERYTHING), 2, BY_FORCE),
        following(replace(EVERYTHING, spring=Spring(stiffness=50.0, anchor=(-0.1, -0.4), free_length=0.2, damping=2.0)), 1),
    )
    states = [model.random_state(seed) for seed, model in enumerate(models)]
    feedback = (_of_feedback(states[k]) for k in (1, 2, 4, 8))
    return (*map(_of_state, states), *feedback, _of_unobserved(states[0]), _of_row(states[0]), _of_directions(0.7), _of_directions(6.0))


HUNT: Final = Hunt(SOURCE, checks, 1.0, EQUIVALENT, least=700)
