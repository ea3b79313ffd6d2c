"""Flipping the sign of any one term of the one beam's equations changes what `test_equations` and `test_supported_beam` verify.

There the compiled equations agree with definitions, virtual work and Lagrange's equations to 1e-5 and better, at states like these, in
accelerations, rates, powers, forces, energies and recovered observables. Here each mutant, as plain Python, must differ from them by
more in one of these.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference_model.model import BeamModel
from reference_model.motion import equations, fields, inertia, loop, observe
from reference_model.motion.layout import CHORDS, GAP_RATE, GAP_REMAINDER, LEVER, MULTIPLIER, Q2_REMAINDER, S_REMAINDER, SPRING, workspace
from reference_model.motion.observe import WIDTH
from reference_model.motion.parameters import Treatment
from reference_model.shapes import clamped_free_modes, hermite_elements, no_shapes
from tests.reference_model.lagrange import point
from tests.reference_model.mutation import Site, Source, mutant, original, plain, sites
from tests.reference_model.test_equations import ALONE, EVERYTHING, HELD, LENGTH, PLAIN

Array = NDArray[np.float64]
TOLERANCE = 2e-5


class _Place:
    """An array where compiled code has an address: never null."""

    def __init__(self, array: Array) -> None:
        self.array = array

    def __ne__(self, other: object) -> bool:
        return True

    __hash__ = None  # type: ignore[assignment]


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
    modules=(fields, loop, inertia, observe, equations),
    no_equations=frozenset(
        {"_factor", "_substitute", "kernel", "evaluate", "observe_states", "directions", "_curvature_at", "interpolate_row"}
    ),
    stand_ins=dict.fromkeys(("compiled", "inlined", "stage", "cache", "parameters_at", "workspace_at"), plain)
    | {"numbers_at": lambda place, size: place.array}
    | LANES,
    entry=lambda defined: defined["_kernel"],
)

#: Flipped signs that change nothing, and why.
EQUIVALENT: Mapping[tuple[str, str], str] = {
    ("", "-(0.25 * math.pi)"): "the series of an eighth of the angle, doubled three times, is as good for small ones",
}


@dataclass(frozen=True)
class Check:
    """A model, a state, and what the compiled equations say: rates and observables."""

    model: BeamModel
    state: Array
    expected: Array

    def difference(self, kernel: Callable[..., Any]) -> float:
        """Largest over rates and observables, relative to each; infinite where the state cannot be evaluated."""
        try:
            with np.errstate(all="ignore"):
                found = _asked(self.model, self.state, kernel)
        except (ValueError, ZeroDivisionError, OverflowError, IndexError):
            return np.inf
        return np.inf if found is None else float(np.max(np.abs(found - self.expected) / sizes(self.expected)))


def _asked(model: BeamModel, state: Array, kernel: Callable[..., Any]) -> Array | None:
    """Rates, observables, remainders of the loop and the highest frequency; None where the state cannot be evaluated."""
    rate, alone, row, w = np.empty_like(state), np.empty_like(state), np.zeros(WIDTH), workspace(model.parameters)
    if kernel(model.parameters, w, _Place(state), _Place(alone), 0) != 1:
        return None
    of_loop = w.facts[[GAP_RATE, GAP_REMAINDER, S_REMAINDER, Q2_REMAINDER]]
    if kernel(model.parameters, w, _Place(state), _Place(rate), _Place(row)) != 1:
        return None
    return np.concatenate([rate, alone, row, of_loop, w.slider])


def sizes(values: Array) -> Array:
    """Of each value its own, where it is not a difference that nearly vanishes: those of a loop that is closed."""
    return np.maximum(np.abs(values), 1e-6)


def _check(model: BeamModel, seed: int) -> Check:
    rng = np.random.default_rng(seed)
    p = model.parameters
    n, m = p.n, p.speeds
    y = model.state_at_rest() if p.LA == 0.0 else model.straight_state(2.2, 16.0)
    if p.LA == 0.0:
        y[0] = 0.7
    shapes = np.arange(1, n + 1) ** 2
    y[1 : n + 1] = 0.012 * rng.uniform(0.5, 1.0, n) * rng.choice([-1.0, 1.0], n) / shapes
    y[m + 2 : m + 2 + n] = 1.5 * rng.uniform(0.5, 1.0, n) * rng.choice([-1.0, 1.0], n) / shapes
    if m > n + 1:
        y[n + 1] += 0.01
        y[m + 2 + n] += 1.0
    at = point(model, y)
    # a slider that is not at the foot, as between two steps: the feedback has something to do
    at.y[m] += 0.0 if p.LA == 0.0 else 1e-5
    expected = _asked(model, at.y, original(SOURCE))
    assert expected is not None
    return Check(model, at.y, expected)


@cache
def checks() -> tuple[Check, ...]:
    """Shapes that follow, eliminated and sprung, crank free and held; shapes that stay; elements with each distribution; the base."""
    sprung = Treatment(kind=SPRING, stiffness=3e4, damping=20.0, inertia=0.05)
    force = Treatment(kind=MULTIPLIER, stabilization=80.0, bending_damping=1e-4)
    smooth, nodes = clamped_free_modes(LENGTH, 2), hermite_elements(LENGTH, 2)
    models = (
        BeamModel.following(EVERYTHING, 2),
        BeamModel.following(HELD, 2, sprung),
        BeamModel.staying(HELD, smooth, transverse_damping=True),
        BeamModel.staying(PLAIN, hermite_elements(LENGTH, 3), Treatment(kind=CHORDS, stabilization=80.0, bending_damping=1e-4)),
        BeamModel.staying(PLAIN, hermite_elements(LENGTH, 3), Treatment(kind=LEVER, stabilization=80.0, bending_damping=1e-4)),
        BeamModel.staying(PLAIN, nodes, force),
        BeamModel.staying(PLAIN, hermite_elements(LENGTH, 1), Treatment(kind=CHORDS, stabilization=80.0)),
        BeamModel.alone(ALONE, 2),
        BeamModel.following(EVERYTHING, 2, sprung),
        BeamModel.staying(EVERYTHING, no_shapes(LENGTH)),
    )
    return tuple(_check(model, seed) for seed, model in enumerate(models, 1))


def exercise(kernel: Callable[..., Any]) -> list[float]:
    return [check.difference(kernel) for check in checks()]


@cache
def found_sites() -> tuple[list[Site], list[Site]]:
    return sites(SOURCE, exercise)


def survivors(chosen: list[Site]) -> Iterator[str]:
    for site in chosen:
        if (site.function, site.flip) in EQUIVALENT:
            continue
        kernel = mutant(SOURCE, site)
        if all(check.difference(kernel) <= TOLERANCE for check in checks()):
            yield str(site)


def test_plain_python_agrees_with_the_compiled_equations() -> None:
    for check in checks():
        rate = np.empty_like(check.state)
        p, w = check.model._at
        assert equations.evaluate(equations.kernel(), p.address, w.address, check.state, rate)
        np.testing.assert_allclose(rate, check.expected[: len(rate)], rtol=1e-9, atol=1e-9 * np.max(np.abs(rate)))


def test_every_term_is_evaluated() -> None:
    """No branch of the equations escapes the states above."""
    refusals = "1"  # of a state that cannot be, in place of -1
    assert [str(site) for site in found_sites()[1] if site.flip != refusals] == []


def test_every_mutant_is_caught() -> None:
    every = found_sites()[0]
    assert len(every) > 200  # as many signs as the equations have, or the search for them is broken
    assert list(survivors(every)) == []


def test_every_equivalent_mutant_still_exists() -> None:
    assert set(EQUIVALENT) <= {(site.function, site.flip) for site in found_sites()[0]}
