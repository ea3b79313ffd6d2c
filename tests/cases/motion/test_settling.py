"""Cutting cycles and judging when they have settled, on sequences whose limit is known."""

import itertools
import math
from collections.abc import Iterable

import numpy as np
import pytest

from quickreturn.cases.motion.settling import Cycle, Settling, cut_cycles

ANGLES = np.linspace(0.0, 2.0 * np.pi, 301)

PERIOD = 0.6  # s


def cycle(number: int, value: np.ndarray) -> Cycle:
    return Cycle(PERIOD * (number + ANGLES / (2.0 * np.pi)), np.pi + ANGLES, {"strain_1": value})


def approaching(ratio: complex, number: int, offset: float = 0.3) -> Cycle:
    """Cycle `number` of a sequence that approaches sin(q) + 1 with the multiplier `ratio`; the error's shape is exp(i q)."""
    error = offset * np.real(ratio**number * np.exp(1j * ANGLES))
    return cycle(number, np.sin(ANGLES) + 1.0 + error)


def true_error(ratio: float, number: int, offset: float = 0.3) -> float:
    return offset * ratio ** (number - 1) * np.sqrt(0.5) / np.sqrt(1.5)  # RMS of a cosine over the RMS of sin + 1


@pytest.mark.parametrize("ratio", [0.3, 0.77, 0.9])
def test_error_of_a_geometric_approach_is_known_exactly(ratio: float) -> None:
    settling = Settling()
    for number in range(8):
        settling.feed(approaching(ratio, number))
    # relative to the last cycle's RMS instead of the limit's: the error itself, at most 0.2 here at 0.9^7
    assert settling.error_estimate == pytest.approx(true_error(ratio, 8), rel=0.1)


@pytest.mark.parametrize("ratio", [0.3, 0.77])
def test_settles_when_the_remaining_error_is_small_not_when_the_change_is(ratio: float) -> None:
    settling = Settling()
    while not settling.feed(approaching(ratio, settling.cycles)):
        pass
    assert true_error(ratio, settling.cycles) < 1e-3 * 1.001  # the last cycle's RMS for the limit's: 1e-3 of it
    assert true_error(ratio, settling.cycles - 1) > 1e-3 * 0.999
    if ratio == 0.77:
        assert settling.changes[-1] < 1e-3 / 3.0  # the change alone would have been content two to four cycles earlier


def test_beating_modes_do_not_settle_early() -> None:
    ratio = 0.77 * np.exp(2.1j)
    settling = Settling()
    while not settling.feed(approaching(ratio, settling.cycles)):
        pass
    assert true_error(0.77, settling.cycles) < 2e-3  # the modulus is right, the ratio fluctuates with the phase


def test_fast_transient_does_not_hide_a_slow_one() -> None:
    settling = Settling()
    number = 0
    while not settling.settled:
        slow, fast = 0.02 * 0.8**number, 1.0 if number == 0 else 0.0
        settling.feed(cycle(number, np.sin(ANGLES) * (1.0 + slow) + fast))
        number += 1
    assert 0.02 * 0.8 ** (number - 1) < 1e-3


def test_endless_change_never_settles() -> None:
    settling = Settling()
    random = np.random.default_rng(3)
    for number in range(60):
        assert not settling.feed(cycle(number, np.sin(ANGLES + random.uniform(0.0, 6.0))))
    assert settling.error_estimate > 1e-3


def test_growing_sequence_never_settles() -> None:
    settling = Settling()
    for number in range(20):
        assert not settling.feed(approaching(1.1, number, 1e-6))
    assert settling.error_estimate == np.inf


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_cycles_are_cut_where_the_slider_is_farthest(direction: float) -> None:
    time = np.linspace(3.0, 5.0, 1501)
    angle = 0.4 + 11.0 * time + 0.05 * np.sin(9.0 * time)
    cycles = cut_cycles(time, direction * angle, {"strain_1": np.cos(angle), "tip_acceleration": np.sin(3.0 * angle)})
    expected = np.arange(np.ceil((angle[0] - np.pi) / (2 * np.pi)), np.floor((angle[-1] - np.pi) / (2 * np.pi)) + 1)
    assert len(cycles) == len(expected) - 1 >= 2
    for turn, whole in zip(expected, cycles, strict=False):
        ends = np.pi + 2.0 * np.pi * np.array([turn, turn + 1])
        # cubic interpolation over steps of 0.015 rad: error of the order of 0.015^4 / 400
        assert direction * whole.crank_angle[[0, -1]] == pytest.approx(ends, abs=1e-8)
        assert whole.channels["strain_1"][[0, -1]] == pytest.approx([-1.0, -1.0], abs=1e-8)
        assert whole.channels["tip_acceleration"][[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-7)
        assert np.all(np.diff(whole.time) > 0.0)
    for before, after in itertools.pairwise(cycles):
        assert before.time[-1] == after.time[0]


def test_series_that_starts_and_ends_at_the_farthest_place_is_cut_whole() -> None:
    time = np.linspace(0.0, 4.0 * np.pi / 7.0, 801)
    cycles = cut_cycles(time, np.pi + 7.0 * time, {"strain_1": np.cos(7.0 * time)})
    assert [c.time.size for c in cycles] == [401, 401]
    assert cycles[0].time[0] == 0.0
    assert cycles[-1].time[-1] == pytest.approx(time[-1], abs=1e-12)


def fed(values: Iterable[float], settling: Settling) -> Settling:
    """Cycles that differ from sin + 1 by these multiples of a cosine."""
    for number, value in enumerate(values):
        settling.feed(cycle(number, np.sin(ANGLES) + 1.0 + value * np.cos(ANGLES)))
    return settling


@pytest.mark.parametrize(
    ("values", "multiplier", "is_noise"),
    [
        ([0.9**n for n in range(8)], 0.9, False),  # as the multiplier says
        ([0.3**n for n in range(8)], 0.9, False),
        ([(-1.0) ** n for n in range(8)], 0.9, True),
        ([(-1.0) ** n for n in range(8)], None, False),  # it may be slow
        ([(-1.0) ** n for n in range(8)], 1.1, False),  # no steady state that attracts
        ([1.0, -1.0, 1.0], 0.9, False),  # too few
    ],
)
def test_changes_that_do_not_follow_the_multiplier_are_noise(values: list[float], multiplier: float | None, is_noise: bool) -> None:
    assert fed(values, Settling(multiplier=multiplier)).is_noise is is_noise


def test_a_slow_approach_says_how_many_cycles_it_would_take() -> None:
    settling = fed((0.95**n for n in range(60)), Settling())
    assert not settling.settled
    outlook = settling.outlook
    assert outlook.ratio == pytest.approx(0.95, rel=1e-3)
    assert outlook.stalled_since is None
    assert outlook.remaining_error == pytest.approx(true_error(0.95, 60, 1.0), rel=0.02)
    # the distance falls below 1e-3 of the signals' RMS after as many cycles, counted from the first
    needed = 1 + math.log(1e-3 / true_error(0.95, 1, 1.0)) / math.log(0.95)
    assert outlook.cycles_needed == pytest.approx(needed, abs=1.5)
    assert "0.950-fold" in outlook.sentence()
    assert f"{outlook.cycles_needed} cycles" in outlook.sentence()


@pytest.mark.parametrize("seed", range(5))
def test_noise_that_does_not_die_away_is_told_with_the_cycle_since_which(seed: int) -> None:
    """An approach that ends in noise: 0.6^n falls below 0.01 in the tenth cycle, where the changes are noise."""
    random = np.random.default_rng(seed)
    settling = fed((0.6**n + 0.01 * random.standard_normal() for n in range(60)), Settling())
    assert not settling.settled
    outlook = settling.outlook
    assert outlook.ratio is None
    assert outlook.cycles_needed is None
    assert 6 <= outlook.stalled_since <= 14
    assert f"since cycle {outlook.stalled_since}" in outlook.sentence()
    assert "try finer settings" in outlook.sentence()


@pytest.mark.parametrize("multiplier", [1e-6, 0.7])
@pytest.mark.parametrize("seed", range(5))
def test_noise_is_what_is_left_where_the_multiplier_is_known(seed: int, multiplier: float) -> None:
    """Without it nobody knows what the noise hides. The error covers the last cycle's distance from the cycle without noise."""
    random = np.random.default_rng(seed)
    distances = [0.0]
    for _ in range(60):
        distances.append(multiplier * distances[-1] + 5e-5 * random.standard_normal())
    settling = Settling(multiplier=multiplier)
    assert settles(settling, distances)
    assert settling.cycles < 10
    assert settling.errors["strain_1"] > abs(distances[settling.cycles - 1])


@pytest.mark.parametrize("turn", [0.6, 0.9])
def test_changes_that_cancel_for_a_cycle_do_not_settle_a_march_from_afar(turn: float) -> None:
    """A complex multiplier: the change of a cycle passes through zero while the next ones are large."""

    def used(phase: float, far: bool) -> float:
        settling, left = Settling(multiplier=0.75, far=far), 0.3 * 0.75 ** np.arange(60) * np.cos(turn * np.arange(60) + phase)
        for number, value in enumerate(left):
            if settling.feed(cycle(number, np.sin(ANGLES) + 1.0 + value)):
                return abs(float(value)) / math.sqrt(1.5) / settling.error_estimate
        raise AssertionError("it does not settle")

    phases = np.linspace(0.0, 2.0 * np.pi, 25)
    assert max(used(phase, far=False) for phase in phases) > 10.0
    assert max(used(phase, far=True) for phase in phases) < 0.6


def test_a_known_multiplier_keeps_a_fast_part_from_hiding_the_slow_one() -> None:
    """Beside a steady state: of a disturbance of 4e-3 a twentieth is lost in a cycle, one of 5e-3 is gone in two."""
    values = [4e-3 * 0.95**n + 5e-3 * 0.05**n for n in range(60)]
    without, with_it = (next(s.cycles for s in [Settling(multiplier=m)] if settles(s, values)) for m in (None, 0.95))
    left = [values[cycles - 1] * np.sqrt(0.5) / np.sqrt(1.5) for cycles in (without, with_it)]
    assert left[0] > 1.5e-3
    assert left[1] < 1e-3


def settles(settling: Settling, values: list[float]) -> bool:
    return any(settling.feed(cycle(number, np.sin(ANGLES) + 1.0 + value * np.cos(ANGLES))) for number, value in enumerate(values))


def judged(values: list[float], *, rattles: bool = True) -> bool:
    """Whether the last 30 of these cycles count as ones that keep changing; `values`: their distances from a mean cycle."""
    cycles = [cycle(number, np.sin(ANGLES) + 1.0 + value * np.cos(ANGLES)) for number, value in enumerate(values)]
    settling = Settling()
    for each in cycles:
        settling.feed(each)
    return settling.keeps_changing(cycles[-30:], rattles)


def test_mild_rattling_may_come_and_go_and_wander_a_little() -> None:
    """Changes of about 0.01 that are three times as large in one half of the cycles, about a mean that moves by 0.01."""
    random = np.random.default_rng(3)
    wandering = [(0.01 if number < 45 else 0.0033) * random.standard_normal() + 0.01 * (number < 45) for number in range(60)]
    assert judged(wandering)
    assert not judged(wandering, rattles=False)


@pytest.mark.parametrize(
    "values",
    [
        [0.97**number for number in range(60)],
        [1e-4 * 1.15**number * (-1.0) ** number for number in range(60)],
        [0.002 * number for number in range(60)],
        [0.1 * (number < 45) + 0.02 * (-1.0) ** number for number in range(60)],
    ],
    ids=["approach", "growth", "drift", "jump"],
)
def test_what_has_not_come_to_rest_does_not_pass_for_rattling(values: list[float]) -> None:
    assert not judged(values)


def test_noise_of_parts_that_the_crank_moves_is_no_slow_approach() -> None:
    """Changes of 9e-11 that hardly shrink: by their ratio 1e-3 would be left after any number of cycles."""
    settling = Settling(multiplier=0.0)
    settled = [settling.feed(cycle(number, np.sin(ANGLES) + 1.0 + 9e-11 * number * np.cos(ANGLES))) for number in range(4)]
    assert settled == [False, False, False, True]
    assert settling.error_estimate < 9e-11


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_each_turn_of_a_follower_that_turns_fully_begins_half_a_turn_from_zero(sense: float) -> None:
    time = np.linspace(0.0, 3.4, 1701)
    q1 = sense * (0.2 + 2.0 * np.pi * time)
    cycles = cut_cycles(time, q1, {"follower_angle": q1 + 0.1 * np.sin(q1), "tip_x": q1})
    assert len(cycles) > 1
    for found in cycles:
        assert found.channels["follower_angle"][[0, -1]] == pytest.approx([np.pi, (1.0 + 2.0 * sense) * np.pi], abs=1e-9)
    assert cycles[1].channels["tip_x"][0] == pytest.approx(cycles[0].channels["tip_x"][-1])
