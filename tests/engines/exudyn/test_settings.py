"""Which settings are compared, which ones cure what is too large (orders measured, and what they promise), and what steps keep."""

import dataclasses

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.balances import Balances
from quickreturn.engines import accurate
from quickreturn.engines.base import Comparison
from quickreturn.engines.error_parts import TIP, Compared, parts_of
from quickreturn.engines.exudyn import settings as ladder
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import SMALLEST_STEP, ExudynSettings
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import relative_error
from tests.engines.exudyn.runs import simulate
from tests.engines.scenes import run_24

ENGINE = ExudynEngine()


@pytest.mark.verify
def test_second_order_in_step_and_elements():
    fine = simulate(run_24(), 0.3, elements=32, step=1.25e-4)["tip_deflection"]
    errors = {
        (n, h): relative_error(simulate(run_24(), 0.3, elements=n, step=h)["tip_deflection"], fine)
        for n, h in ((32, 1e-3), (32, 5e-4), (8, 1.25e-4), (16, 1.25e-4))
    }
    # second order: 4.2 to 5 against a reference that is itself only a fourth of the step (third of the elements) finer
    assert 3.5 < errors[32, 1e-3] / errors[32, 5e-4] < 5.5
    in_time, in_space, in_stretch, in_passing = ENGINE.comparisons(ExudynSettings(elements=32, step=2.5e-4), run_24(), 1e-3)
    assert (in_time.other, in_time.factor) == (ExudynSettings(elements=32, step=5e-4), 2.0**ladder.CHECKED_IN_TIME)
    assert in_time.before == Comparison(in_time.other, ExudynSettings(elements=32, step=1e-3), in_time.factor, of="time")
    assert (in_space.run, in_space.other) == (in_time.before.other, ExudynSettings(elements=16, step=1e-3))
    assert in_space.factor == 2.0**ladder.SAFE_IN_SPACE
    assert (in_stretch.run, in_stretch.factor) == (in_space.other, 4.0)
    assert in_stretch.other == ExudynSettings(elements=16, step=1e-3, axial_factor=0.25)
    assert (in_passing.run, in_passing.other) == (in_space.run, ExudynSettings(elements=24, step=1e-3))
    assert errors[8, 1.25e-4] > 2.5 * errors[16, 1.25e-4]


@pytest.mark.verify
def test_stretch_is_estimated_and_cured_by_a_stiffer_cable():
    """A section three times as thick as run 24's at a tenth of its bending stiffness stretches; the scene's follower does not."""
    soft = load_case("hard-ei-x0.1").mechanism
    soft = dataclasses.replace(soft, follower=dataclasses.replace(soft.follower, thickness=3.0 * soft.follower.thickness))
    converged = ReferenceSettings(modes=9, tolerance=1e-8)
    truth = run_once(ReferenceEngine(), soft, standard_start(soft), 0.3, 1e-3, converged).trajectory["tip_deflection"]
    found = {}
    for factor in (1, 16):
        texts = {"elements": "32", "step": "2.5e-4", "axial_factor": str(factor)}
        result = accurate.simulate(ENGINE, soft, standard_start(soft), 0.3, 1e-3, texts)
        found[factor] = relative_error(result.trajectory["tip_deflection"], truth)
        assert found[factor] < result.error_estimate
    assert found[16] < 0.3 * found[1]  # measured 1.0e-4 and 4.7e-4; steps and elements leave 7e-5


@pytest.mark.verify
def test_few_elements_are_not_taken_for_a_cable_that_stretches():
    """Run 24's cable stretches little. A softer one shows it with half the elements; a stiffer one of few elements does not."""
    mechanism, rung = run_24(), ExudynSettings(elements=24, newton_tolerance=1e-5)

    def part(pair: Comparison) -> float:
        runs = (pair.run.as_dict(), pair.other.as_dict())
        run, other = (simulate(mechanism, 0.3, **settings) for settings in runs)
        parts, _ = parts_of(run, [Compared(run, other, pair.factor)], mechanism.follower.length)
        return parts[TIP][0].error

    _, _, stretch, _ = ENGINE.comparisons(rung, mechanism, 1e-3)
    half, whole = (part(Comparison(*(own.replaced(elements=n) for own in (stretch.run, stretch.other)), stretch.factor)) for n in (12, 24))
    few = stretch.run.replaced(elements=6)
    assert stretch.run.elements == 12
    assert half < 2e-5  # measured 7.2e-6
    assert 0.5 < half / whole < 2.0
    assert part(Comparison(few, few.replaced(axial_factor=4.0), 0.25)) > 1e-3  # measured 1.4e-3


def test_ladder_ends() -> None:
    assert ENGINE.settings_for(ENGINE.default_accuracy, run_24()) == ExudynSettings()
    settings, count = ExudynSettings(), 0
    while (finer := ENGINE.finer(settings, {}, 1e-3)) is not None:
        assert finer.step < settings.step
        settings, count = finer, count + 1
    assert count >= 1
    assert settings.step >= SMALLEST_STEP


def test_finer_settings_cure_what_is_too_large():
    settings = ExudynSettings(elements=24, step=2.5e-4)
    # of second order in time: 7 steps leave 2.0 (4/7)^2 = 0.65; 6 would leave 0.89, and with 0.1 in space too much
    assert ENGINE.finer(settings, {"time": 2.0, "space": 0.1}, 1e-3) == settings.replaced(step=1e-3 / 7)
    # of third order in space: 32 elements leave 0.42
    assert ENGINE.finer(settings, {"time": 0.5, "space": 1.0}, 1e-3) == settings.replaced(elements=32)
    # what passing shows is in space as well
    assert ENGINE.finer(settings, {"time": 0.5, "space": 0.4, "passing": 0.6}, 1e-3) == settings.replaced(elements=32)
    # smaller steps are cheaper than another cable, whose comparisons are all to be made again
    assert ENGINE.finer(settings, {"time": 0.7, "space": 0.3, "stretch": 0.1}, 1e-3) == settings.replaced(step=2e-4)
    assert ENGINE.finer(settings, {"time": 0.5, "space": 0.1, "stretch": 0.8}, 1e-3) == settings.replaced(axial_factor=4.0)


@example((0.0, 19.6, 0.0, 0.0), 92, 16.0, 9)  # all that is left to try are four elements more
@given(
    st.tuples(*[st.floats(0.0, 20.0)] * 4).filter(lambda excess: sum(excess) > 1.0),
    st.integers(6, 48).map(lambda half: 2 * half),
    st.sampled_from((1.0, 4.0, 16.0)),
    st.integers(1, 12),
)
def test_climbing_takes_what_the_orders_leave_to_within_reach(excess, elements, axial_factor, steps):
    own = ExudynSettings(elements=elements, axial_factor=axial_factor, step=1e-3 / steps)
    finer = ENGINE.finer(own, dict(zip(("time", "space", "stretch", "passing"), excess, strict=True)), 1e-3)
    if finer is None:
        return
    in_time, in_space, in_stretch, passing = excess

    def left(settings: ExudynSettings) -> float:
        in_elements = (in_space + passing) * (elements / settings.elements) ** 3
        return in_time * (settings.step / own.step) ** 2 + in_elements + in_stretch * axial_factor / settings.axial_factor

    most = own.replaced(
        elements=max(elements, min(2 * elements, ladder.MOST_ELEMENTS)), step=1e-3 / min(4 * steps, 50), axial_factor=max(ladder.STIFFER)
    )
    assert left(finer) <= max(1.0, 1.2 * left(most))
    assert left(finer) < sum(excess)
    assert (finer.step, finer.elements, finer.axial_factor) != (own.step, own.elements, own.axial_factor)


@pytest.mark.parametrize("output_step", [1e-2, 1e-3, 5e-4, 2.5e-4, 1e-5])
@pytest.mark.parametrize(("elements", "extrapolated"), [(8, False), (12, False), (12, True)])
def test_runs_compared_differ_on_any_output_grid(output_step, elements, extrapolated):
    """A step covers whole parts of an output step or whole output steps: settings that differ may be the same run."""
    for step in (5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4):
        own = ExudynSettings(elements=elements, step=step, extrapolated=extrapolated)
        in_time, *others = ENGINE.comparisons(own, run_24(), output_step)
        for pair in (in_time, in_time.before, *others):
            if pair is None:
                continue
            longer = pair.other.step_taken(output_step) / pair.run.step_taken(output_step)
            more, stiffer = pair.run.elements / pair.other.elements, pair.other.axial_factor / pair.run.axial_factor
            assert (longer, more, stiffer) != (1.0, 1.0, 1.0)
            order = ladder.FINER_IN_TIME if longer < 1.0 else ladder.CHECKED_IN_TIME if in_time.before else ladder.SAFE_IN_TIME
            in_space = more ** (ladder.SAFE_IN_SPACE if more > 1.0 else ladder.FINER_IN_SPACE)
            if pair.of == "passing":  # hardly any order
                in_space = 1.0 / ladder.PASSING[2]
            assert pair.factor == pytest.approx(longer**order * in_space / stiffer)


@pytest.mark.parametrize(("step", "steps"), [(5e-4, (5e-4, 1e-3, 2e-3)), (2.5e-4, (2.5e-4, 5e-4, 1e-3)), (1.6e-4, (1.25e-4, 2.5e-4, 5e-4))])
def test_longer_steps_pass_rows_of_the_output(step, steps):
    """By two where a step is one output step; where there are blows none is passed, and smaller steps are compared with."""
    own = ExudynSettings(elements=12, step=step)
    pair = ladder.in_time(own, 5e-4)
    assert [each.step_taken(5e-4) for each in (pair.run, pair.other, pair.before.other)] == pytest.approx(steps)
    assert ladder.in_time(own, 5e-4, blows=True).other.rows == 1
    assert own.step_taken(5e-4) <= step


@given(st.integers(1, 40), st.floats(1e-6, 4e-2), st.integers(1, ladder.MOST_ROWS))
def test_a_step_is_not_longer_than_it_may_be(parts, output_step, rows):
    """But for a single output step, which is what one step passes at most unless `rows` allows more."""
    for step in (output_step / parts, output_step * parts / 7.0):
        if ladder.LEAST_STEP <= step <= ladder.LARGEST_STEP:
            taken = ExudynSettings(step=step, rows=rows).step_taken(output_step)
            assert taken <= step * (1.0 + 1e-6)
            assert taken > 0.5 * min(step, rows * output_step) * (1.0 - 1e-6)


def test_what_both_pairs_with_more_elements_show_counts_once():
    """Half as many again and five quarters show the same error; with half and three quarters of many elements each counts."""
    few, many = (ENGINE.comparisons(ExudynSettings(elements=elements), run_24(), 1e-3) for elements in (12, 24))
    assert [pair.of for pair in few] == ["time", "space", "stretch"]
    assert [pair.of for pair in many] == ["time", "space", "stretch", "passing"]
    besides = few[1].besides
    assert (few[1].other.elements, besides.other.elements) == (18, 15)
    assert all(pair.besides is None for pair in (few[0], few[2], *many))


def test_an_arm_that_moves_much_begins_with_enough_elements_for_the_passing():
    assert [ladder.rung_for(accuracy, 0.28, moves_much=True).elements for accuracy in (1e-2, 3e-3, 1e-3)] == [8, 14, 16]
    assert ladder.rung_for(3e-3, 0.1, moves_much=False).elements == 9


@pytest.mark.parametrize("case", ["hard-shaper-steel", "hard-ei-x1000"])
def test_steps_keep_the_energy_balance_of_an_arm_that_hardly_bends(case: str) -> None:
    """The deflection alone is right with plain steps of 1 ms, which leave 9 and 340 % of the largest bending energy."""
    mechanism, accuracy = load_case(case).mechanism, 1e-2
    settings = ENGINE.settings_for(accuracy, mechanism)
    columns = run_once(ENGINE, mechanism, standard_start(mechanism), 0.3, 1e-3, settings).trajectory.columns
    assert Balances.of(columns, mechanism).violated(accuracy) == ""


@given(accuracy=st.floats(1e-4, 5e-2), frequency=st.floats(1.0, 1e5))
def test_only_steps_that_leave_too_much_energy_become_others(accuracy: float, frequency: float) -> None:
    """To within the rounding of steps to two digits, which is 5 % at most."""
    rung = ladder.rung_for(accuracy, 1.0, moves_much=True)
    found = ladder.balanced(rung, accuracy, frequency)
    left = ladder.LEFT_BY_STEPS[found.extrapolated] * (found.step * frequency) ** 2
    assert left <= 2.0 * accuracy * 1.05**2 or found.step <= ladder.SHORTEST_FOR_BALANCE
    assert found == rung or (found.extrapolated and found.step <= rung.step)
    assert found == rung or ladder.LEFT_BY_STEPS[rung.extrapolated] * (rung.step * frequency) ** 2 > 2.0 * accuracy
