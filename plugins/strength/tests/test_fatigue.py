"""Counted cycles against the standard's example and against brute force; Goodman's line and notches against numbers by hand."""

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quickreturn.plugins.strength.loads import loads_of
from quickreturn.plugins.strength.stress import COUNTED, counted_ranges, cycles_of, equivalent_amplitude
from quickreturn.plugins.strength.tests.test_loads import LOADED, rigid_cycle, stress_of_both
from quickreturn.reference_model.errors import ImpossibleMechanism

#: The history of ASTM E1049-85, figure 6: peaks and valleys A to I.
OF_THE_STANDARD = (-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0)


def ranges(history: Any) -> list[float]:
    return sorted(high - low for low, high in cycles_of(np.array(history, dtype=float)))


@pytest.mark.parametrize("first", range(len(OF_THE_STANDARD) - 1))
def test_cycles_are_those_of_the_standard(first: int) -> None:
    """ASTM E1049-85, section 5.4.5, figure 7: in a history that repeats one cycle each of the ranges 3, 4, 7 and 9, wherever it begins."""
    turned = OF_THE_STANDARD[first:-1] + OF_THE_STANDARD[: first + 1]
    assert ranges(turned) == [3.0, 4.0, 7.0, 9.0]
    assert sorted(cycles_of(np.array(turned))) == [(-4.0, 5.0), (-3.0, 4.0), (-2.0, 1.0), (-1.0, 3.0)]


def by_removing_inner_cycles(history: list[float]) -> list[float]:
    """The same by brute force on the circle: a pair of neighbours whose range is the smallest closes a cycle, again and again."""
    points = [value for value, _ in itertools.groupby(history)]
    if len(points) > 1 and points[0] == points[-1]:
        points.pop()
    found = list[float]()
    while True:
        n = len(points)
        points = [p for k, p in enumerate(points) if n < 3 or (p - points[k - 1]) * (points[(k + 1) % n] - p) < 0.0]
        if len(points) != n:
            continue
        if n <= 2:
            return sorted(found + ([abs(points[0] - points[1])] if n == 2 and points[0] != points[1] else []))
        k = min(range(n), key=lambda each: abs(points[each] - points[(each + 1) % n]))
        found.append(abs(points[k] - points[(k + 1) % n]))
        points = [p for each, p in enumerate(points) if each not in (k, (k + 1) % n)]


histories = st.lists(st.integers(-20, 20).map(float), min_size=2, max_size=40)


@given(histories)
@settings(max_examples=100, deadline=None)
def test_cycles_are_those_of_brute_force_wherever_the_history_begins(history: list[float]) -> None:
    closed = [*history, history[0]]
    right = by_removing_inner_cycles(history)
    assert ranges(closed) == pytest.approx(right)
    turned = history[len(history) // 2 :] + history[: len(history) // 2]
    assert ranges([*turned, turned[0]]) == pytest.approx(right)
    # up and down: what rises in a turn is the sum of the ranges
    assert sum(right) == pytest.approx(sum(max(after - before, 0.0) for before, after in itertools.pairwise(closed)))


@given(histories, st.floats(0.0, 1.0), st.floats(1.0, 4.0))
@settings(max_examples=100, deadline=None)
def test_no_inner_cycle_is_worse_than_the_largest(history: list[float], ratio: float, notch: float) -> None:
    """What lets the place be found by least and greatest stress alone, for a fatigue strength up to the tensile strength."""
    found = [
        float(equivalent_amplitude(notch * (high - low) / 2.0, (high + low) / 2.0, ratio)) for low, high in cycles_of(np.array(history))
    ]
    low, high = min(history), max(history)
    whole = float(equivalent_amplitude(notch * (high - low) / 2.0, (high + low) / 2.0, ratio))
    assert max(found, default=0.0) <= whole * (1.0 + 1e-12)


def test_cycles_too_small_to_harm_are_not_counted() -> None:
    turn = np.linspace(0.0, 2.0 * math.pi, 2001)
    slow, quick = np.cos(turn), np.cos(40.0 * turn)
    assert counted_ranges(slow) == pytest.approx((2.0,), abs=1e-5)
    assert len(counted_ranges(slow + 0.1 * COUNTED * quick)) == 1
    both = counted_ranges(slow + 0.5 * quick)
    assert both[0] == pytest.approx(3.0, abs=0.02)
    assert len(both) == 40
    assert counted_ranges(np.ones(5)) == ()


#: The rigid arm with a notch beside the place of the widest range, and strengths.
NOTCHED = dataclasses.replace(
    LOADED,
    follower=dataclasses.replace(
        LOADED.follower,
        fatigue_strength=160e6,
        tensile_strength=490e6,
        notch_places=(0.1, 0.42, 0.6),
        notch_factors=(1.2, 1.9, 3.0),
    ),
)


@pytest.mark.parametrize(("tensile", "notched"), [(490e6, True), (490e6, False), (None, True)])
def test_the_factor_is_that_of_goodmans_line(tensile: float | None, notched: bool) -> None:
    """Least and greatest stress in closed form on a grid, n = 1 / (K_f a / S_f + m / S_u) at each place, and the least of these."""
    changes: dict[str, Any] = {"tensile_strength": tensile} | ({} if notched else {"notch_places": None, "notch_factors": None})
    scene = dataclasses.replace(NOTCHED, follower=dataclasses.replace(NOTCHED.follower, **changes))
    follower = scene.follower
    grid, stress = stress_of_both(LOADED)  # strengths and notches do not change it
    notches = dict(zip(follower.notch_places or (), follower.notch_factors or (), strict=True))
    factors = np.array([max((k for at, k in notches.items() if abs(place - at) < 1e-9), default=1.0) for place in grid["places"]])
    for place, factor in notches.items():
        at = int(np.abs(grid["places"] - place).argmin())
        assert abs(grid["places"][at] - place) < 1e-3  # the grid has a place within a millimetre
        factors[at] = factor
    low, high = stress.min(axis=2), stress.max(axis=2)
    used = factors * (high - low) / 2.0 / follower.fatigue_strength + (
        0.0 if tensile is None else np.maximum(high + low, 0.0) / 2.0 / tensile
    )
    loads = loads_of(scene, rigid_cycle(scene), lambda column, angle: 0.0)
    assert loads.fatigue_factor is not None
    assert loads.stress is not None
    worst = loads.stress.fatigue
    assert loads.fatigue_factor.value == pytest.approx(1.0 / used.max(), rel=4e-3)  # a millimetre aside the stress is 2e-3 of itself less
    assert worst.notch_factor == factors[int(np.unravel_index(int(used.argmax()), used.shape)[1])] == (1.9 if notched else 1.0)
    ratio = 0.0 if tensile is None else follower.fatigue_strength / tensile
    assert worst.equivalent.value == pytest.approx(worst.notch_factor * worst.amplitude + ratio * max(worst.mean, 0.0), rel=1e-12)
    assert worst.ranges[0] == pytest.approx(2.0 * worst.amplitude, rel=1e-3)
    assert (
        worst.equivalent.uncertainty
        >= (1.9 if notched else 1.0) * 0.9 * loads.stress.amplitude.uncertainty - 0.02 * loads.stress.amplitude.value
    )
    # neither notch nor mean changes what is compared with the yield strength, and what the range alone says
    plain = loads_of(LOADED, rigid_cycle(LOADED), lambda column, angle: 0.0)
    assert plain.stress is not None
    assert loads.stress.largest == plain.stress.largest
    assert loads.stress.amplitude == plain.stress.amplitude == plain.stress.fatigue.equivalent


def test_a_mean_that_presses_does_not_count() -> None:
    assert equivalent_amplitude(50.0, -30.0, 0.4) == 50.0
    assert equivalent_amplitude(50.0, 30.0, 0.4) == 62.0


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (
            {"notch_places": (0.1, 0.2), "notch_factors": (1.5,)},
            "has 1 values, and follower.notch_places 2; give one factor for each place",
        ),
        ({"notch_places": (0.1,)}, "has 0 values, and follower.notch_places 1; give one factor for each place"),
        ({"notch_places": (0.1,), "notch_factors": (0.9,)}, "has 0.9 in it, and no notch makes the stress amplitude smaller; factors of 1"),
        ({"notch_places": (0.9,), "notch_factors": (1.9,)}, "leaves the notch at 0.9 m outside the follower; its length is 0.635 m"),
        ({"tensile_strength": 150e6}, r"cannot be: 1.6e\+08 Pa is more than follower.tensile_strength \(1.5e\+08 Pa\)"),
    ],
)
def test_notches_and_strengths_that_cannot_be_are_refused(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ImpossibleMechanism, match=sentence):
        dataclasses.replace(LOADED.follower, yield_strength=None, fatigue_strength=160e6, **values)
