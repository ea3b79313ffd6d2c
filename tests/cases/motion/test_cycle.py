"""Measures of whole cycles: what must not matter, what must not be found, what is refused."""

import functools
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.cycle import CycleMeasures, measure_cycle, signals_by_half
from quickreturn.cases.motion.extremes import extremes
from quickreturn.cases.motion.number import consensus
from quickreturn.cases.motion.time_scale import CHANNELS, TimeScale, time_scale
from quickreturn.reference_model.arrays import Array
from tests.verification.measures_accuracy import thesis_scene


@functools.cache
def scale_of_run(run: int) -> tuple[TimeScale, float]:
    """Time scale of a thesis run and its crank speed in rad/s."""
    mechanism, speed = thesis_scene(run)
    scale = time_scale(mechanism)
    assert scale is not None
    return scale, speed


def vibrating_cycle(
    scale: TimeScale, speed: float, factor: float, amplitude: float, second: tuple[float, float] = (1.0, 0.0), samples: int = 801
) -> tuple[Array, Array, dict[str, Array]]:
    """Time, crank angle and all channels: slow shape of unit RMS plus first and second mode, without noise.

    `factor` and `amplitude`: of the first mode, over its own frequency and times its template; `second`: the same of the second mode.
    """
    time = np.linspace(0.0, 2.0 * np.pi / speed, samples)
    crank_angle = np.pi + speed * time
    speeds = np.full(samples, speed)
    phases = cumulative_simpson(2.0 * np.pi * scale.running_frequencies(crank_angle, speeds).T, x=time, initial=0.0)
    channels = {}
    for name in scale.channels:
        templates = scale.templates[name](crank_angle).T
        late = scale.quadratures[name](crank_angle) * speeds
        channels[name] = (
            scale.slow_shapes[name](crank_angle)
            + amplitude * (templates[0] * np.cos(factor * phases[0]) + late * np.sin(factor * phases[0]))
            + second[1] * templates[1] * np.cos(second[0] * phases[1] + 0.7)
        )
    return time, crank_angle, channels


FACTOR = 0.95
AMPLITUDE = 4.0  # of the slow part's RMS over a turn: about as large as the slow part's peak


def numbers(measures: CycleMeasures) -> np.ndarray:
    """All numbers of the measures, NaN where not resolvable, shape (measures, 7)."""
    first = [f"first_mode_{name}" for name in ("frequency", "frequency_uncertainty", "amplitude", "amplitude_uncertainty")]
    names = (*first[:2], "second_mode_frequency", *first[2:], "minimum", "maximum")
    found = [[getattr(each, name) for name in names] for each in measures.measures]
    return np.array(found, dtype=float)  # of None it makes NaN


@pytest.fixture(scope="module")
def plain() -> CycleMeasures:
    scale, speed = scale_of_run(24)
    return measure_cycle(scale, *vibrating_cycle(scale, speed, FACTOR, AMPLITUDE))


def test_known_frequency_and_amplitude_are_found(plain: CycleMeasures) -> None:
    scale, speed = scale_of_run(24)
    angles = np.linspace(np.pi, 2.0 * np.pi, 2001)
    frequency = FACTOR * np.mean(scale.running_frequencies(angles, np.full(angles.size, speed))[:, 0])
    for measure in plain.measures:
        template = scale.templates[measure.channel](angles)[:, 0]
        assert measure.reason == ""
        # free of noise: what is left is the slow part beyond degree 5 that passes for vibration; 0.8 % and 2 spreads of the
        # amplitude in the accuracy table at this strength
        assert measure.first_mode_frequency == pytest.approx(frequency, rel=0.008)
        assert measure.first_mode_amplitude == pytest.approx(AMPLITUDE * math.sqrt(np.mean(template**2)), rel=0.04)
    for agreed in plain.consensus:
        assert agreed.first_mode_frequency == pytest.approx(frequency, rel=0.005)  # halved by averaging four channels


@pytest.mark.verify
def test_noise_moves_a_number_as_its_gain_says() -> None:
    """Noise of each of the 240 instants by itself moves a number by its gain over the root of 240: in 20 draws, whose scatter is 16 %."""
    scale, speed = scale_of_run(24)
    time, angle, channels = vibrating_cycle(scale, speed, FACTOR, AMPLITUDE)
    rows = np.linspace(time[0], time[-1], 479)  # 240 in each half
    angle, channels = CubicSpline(time, angle)(rows), {name: CubicSpline(time, values)(rows) for name, values in channels.items()}
    quiet = measure_cycle(scale, rows, angle, channels).measures
    halves = signals_by_half(rows, angle, channels)
    assert [each.variation for each in quiet] == pytest.approx([np.std(halves[each.half, each.channel]) for each in quiet], rel=1e-3)
    sizes = {name: 0.01 * min(each.variation for each in quiet if each.channel == name) for name in CHANNELS}
    random, noisy = np.random.default_rng(5), []
    for _ in range(20):
        noise = {name: values + sizes[name] * random.standard_normal(479) for name, values in channels.items()}
        noisy.append(measure_cycle(scale, rows, angle, noise).measures)
    for name in ("first_mode_frequency", "first_mode_amplitude"):
        for place, each in enumerate(quiet):
            scatter = np.std([getattr(measures[place], name) for measures in noisy], ddof=1)
            assert scatter == pytest.approx(each.response(name) * sizes[each.channel] / math.sqrt(240.0), rel=0.45), (name, each.channel)


def test_errors_that_channels_share_stay_in_the_consensus() -> None:
    """Four channels alike: their own part, 1 - 0.5 of the variance, is quartered, the common part stays."""
    agreed = consensus("pre", [20.0] * 4, [0.2] * 4)
    assert agreed.first_mode_frequency == pytest.approx(20.0)
    assert agreed.uncertainty == pytest.approx(0.2 * math.sqrt(0.5 / 4.0 + 0.5))
    alone = consensus("pre", [20.0], [0.2])
    assert alone.uncertainty == pytest.approx(0.2)
    scattered = consensus("pre", [19.0, 21.0], [0.1, 0.1])
    assert scattered.uncertainty == pytest.approx(1.0)  # the standard deviation of their mean
    assert consensus("pre", [], []).first_mode_frequency is None


def test_extremes_belong_to_their_half() -> None:
    scale, speed = scale_of_run(24)
    time, crank_angle, _ = vibrating_cycle(scale, speed, 1.0, 0.0)
    pre, post = measure_cycle(scale, time, crank_angle, {"strain_1": np.sin(crank_angle)}).measures
    assert (pre.minimum, pre.maximum) == pytest.approx((-1.0, 0.0), abs=1e-6)
    assert (post.minimum, post.maximum) == pytest.approx((0.0, 1.0), abs=1e-6)


@given(st.integers(60, 400), st.floats(0.1, 6.0), st.floats(0.0, 6.3))
def test_extremes_do_not_depend_on_where_the_samples_lie(samples: int, waves: float, phase: float) -> None:
    time = np.linspace(0.0, 1.0, samples)
    start, end = 0.2137, 0.7411  # between samples
    (found,) = extremes(time, np.sin(2.0 * np.pi * waves * time + phase), np.array([start, end]))
    dense = np.sin(2.0 * np.pi * waves * np.linspace(start, end, 20_001) + phase)
    # a cubic spline with ten samples in a wave is off by 5/384 (2 pi / 10)^4 = 2e-3, at the ends of the samples by some times that
    assert [each.value for each in found] == pytest.approx([dense.min(), dense.max()], abs=4e-3)


@example(0.0, -0.047, 0.28)
@given(st.floats(0.0, 1.0), st.floats(-0.9, 1.0), st.floats(0.0, 0.3))
def test_a_corner_between_samples_is_missed_by_no_more_than_is_said(place: float, other_side: float, bend: float) -> None:
    """A gauge's peak where the slider passes it. How steep its other side is, and what else bends there, makes no difference."""
    time = np.arange(40.0)
    corner, last = 20.0 + place, 30.0
    away = time - corner
    signal = np.where(away < 0.0, away, -other_side * away) - bend * (away / 10.0) ** 2
    ((_, highest),) = extremes(time, signal, np.array([10.0, last]))
    # on the other side the signal is a parabola in the distance from the corner: where it rises its peak is at the end or before it
    farthest = last - corner
    top = farthest if bend == 0.0 else min(max(-50.0 * other_side / bend, 0.0), farthest)
    true = max(0.0, -other_side * top - bend * (top / 10.0) ** 2)
    assert abs(highest.value - true) <= highest.uncertainty + 1e-9


def test_smooth_extremes_are_hardly_uncertain() -> None:
    """Twelve samples in a wave, as cycles of simulations have in one of the third mode; 16 times what the spline is off by."""
    time = np.linspace(0.0, 10.0, 121)
    for extreme, true in zip(extremes(time, np.sin(2.0 * np.pi * time), np.array([2.0, 8.0]))[0], (-1.0, 1.0), strict=True):
        assert abs(extreme.value - true) < extreme.uncertainty < 0.02


@pytest.mark.parametrize(
    ("later", "sense", "unit"), [(12.5, 1.0, 1.0), (0.0, 1.0, 1e-6), (0.0, -1.0, 1.0)], ids=["later", "unit", "other sense"]
)
def test_neither_the_time_nor_the_unit_nor_the_sense_of_rotation_matters(
    plain: CycleMeasures, later: float, sense: float, unit: float
) -> None:
    scale, speed = scale_of_run(24)
    time, crank_angle, channels = vibrating_cycle(scale, speed, FACTOR, AMPLITUDE)
    angle = sense * crank_angle + (40.0 * np.pi if later else 0.0)
    found = measure_cycle(scale, time + later, angle, {name: unit * values for name, values in channels.items()})
    # of amplitudes and extremes alone the unit is a factor; the fit stops at steps of 1e-5
    assert numbers(found) == pytest.approx(numbers(plain) * np.array([1.0] * 3 + [unit] * 4), rel=1e-5, nan_ok=True)


def test_uneven_samples_give_the_same(plain: CycleMeasures) -> None:
    scale, speed = scale_of_run(24)
    time, crank_angle, channels = vibrating_cycle(scale, speed, FACTOR, AMPLITUDE, samples=1601)
    kept = np.flatnonzero(np.random.default_rng(1).random(time.size) < 0.6)
    kept = np.union1d(kept, [0, time.size - 1])
    uneven = measure_cycle(scale, time[kept], crank_angle[kept], {name: values[kept] for name, values in channels.items()})
    # interpolation over up to about 2 ms of a 20 Hz vibration on a slow part
    assert numbers(uneven)[:, [0, 3]] == pytest.approx(numbers(plain)[:, [0, 3]], rel=2e-3)
    assert numbers(uneven)[:, 5:] == pytest.approx(numbers(plain)[:, 5:], rel=0.01, abs=0.02)


def test_any_subset_of_channels_is_measured_alike(plain: CycleMeasures) -> None:
    scale, speed = scale_of_run(24)
    time, crank_angle, channels = vibrating_cycle(scale, speed, FACTOR, AMPLITUDE)
    alone = measure_cycle(scale, time, crank_angle, {"strain_2": channels["strain_2"]})
    kept = [0, 2, 3, 4, 5, 6]  # all but the frequency's uncertainty, into which goes what other channels say of the drift they share
    assert numbers(alone)[:, kept] == pytest.approx(numbers(plain)[np.ix_([2, 6], kept)], rel=1e-12, nan_ok=True)


@pytest.mark.parametrize("run", [10, 24, *(pytest.param(run, marks=pytest.mark.verify) for run in (6, 17))])
def test_pure_slow_signal_is_not_resolvable(run: int) -> None:
    scale, speed = scale_of_run(run)
    measures = measure_cycle(scale, *vibrating_cycle(scale, speed, 1.0, 0.0))
    for measure in measures.measures:
        assert measure.first_mode_frequency is None
        assert measure.first_mode_amplitude is None
        assert measure.second_mode_frequency is None
        assert measure.reason
    assert [c.first_mode_frequency for c in measures.consensus] == [None, None]


@pytest.mark.parametrize("factor", [0.93, 1.1])
def test_strong_second_mode_is_found_where_channels_agree(factor: float) -> None:
    scale, speed = scale_of_run(24)
    cycle = vibrating_cycle(scale, speed, 1.0, 0.5, second=(factor, 0.4))
    frequency = factor * np.mean(scale.frequencies(np.linspace(np.pi, 2.0 * np.pi, 2001))[:, 1])
    measures = measure_cycle(scale, *cycle).measures
    for half in ("pre", "post"):
        found = [m.second_mode_frequency for m in measures if m.half == half and m.second_mode_frequency is not None]
        assert len(found) >= 2
        assert found == pytest.approx([frequency] * len(found), rel=0.01)  # one step of the scan
    alone = measure_cycle(scale, *cycle[:2], {"strain_1": cycle[2]["strain_1"]}).measures
    assert all(measure.second_mode_frequency is None for measure in alone)


def test_measured_extremes_are_those_below_200_hz() -> None:
    scale, speed = scale_of_run(24)
    period = 2.0 * np.pi / speed
    time = np.linspace(0.0, period, 2001)
    slow = 2.0 * np.sin(2.0 * np.pi * 5.0 * time / period)  # 13 Hz, with its peaks in both halves
    rattle = 0.5 * np.sin(2.0 * np.pi * 300.0 * time / period)  # 790 Hz
    cycle = {"tip_acceleration": slow + rattle}
    raw = measure_cycle(scale, time, np.pi + speed * time, cycle).measures
    passed = measure_cycle(scale, time, np.pi + speed * time, cycle, measured=True).measures
    for before, after in zip(raw, passed, strict=True):
        assert before.maximum > 2.4
        # gain at 13 Hz: 1 - 3e-10; at 790 Hz: 1.7e-5
        assert (after.minimum, after.maximum) == pytest.approx((-2.0, 2.0), abs=1e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, q, y: (t, q, y[:-1]), "samples"),
        (lambda t, q, y: (t, q + 0.5 * np.sin(12.0 * q), y), "turns back"),
        (lambda t, q, y: (t, q + 1.0, y), "farthest place"),
    ],
)
def test_what_is_no_cycle_is_refused(change, message: str) -> None:  # type: ignore[no-untyped-def]
    scale, speed = scale_of_run(24)
    time, crank_angle, channels = vibrating_cycle(scale, speed, 1.0, 0.5)
    time, crank_angle, values = change(time, crank_angle, channels["strain_1"])
    with pytest.raises(ValueError, match=message):
        measure_cycle(scale, time, crank_angle, {"strain_1": values})
