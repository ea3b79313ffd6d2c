"""The search finds what a complete grid of settings finds, whatever an engine declares, and each combination has as many runs at most."""

import itertools
import math
from dataclasses import dataclass, replace

import pytest

from quickreturn.cases.library import load_case
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings, setting
from quickreturn.plugins.methods.fronts import standings
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.row import LEVELS, TIP, Row
from quickreturn.plugins.methods.search import SECONDS, STEPS, combinations, neighbours, search, seeds, variant_of


@dataclass(frozen=True, kw_only=True)
class MadeUp(Settings):
    """Settings of a made-up method: its error is shapes^-4 + 30 tolerance + what a spring leaves, and it is slow with a stiff one."""

    shapes: int = setting(10, "shapes", low=1, high=40)
    tolerance: float = setting(1e-9, "tolerance", low=1e-12, high=1e-2)
    stiffness: float = setting(1e6, "spring", low=1.0, high=1e12)
    quick: bool = setting(False, "half the time")
    other: float = setting(1.0, "no axis", low=0.0, high=10.0)


def made_up(settings: Settings, limit: float = math.inf) -> Row:
    assert isinstance(settings, MadeUp)
    error = settings.shapes**-4.0 + 30.0 * settings.tolerance + 100.0 / settings.stiffness
    seconds = (
        1e-6 * settings.shapes**2 * settings.tolerance**-0.12 * (1.0 + (settings.stiffness / 1e6) ** 0.5) * (0.5 if settings.quick else 1.0)
    )
    return Row(scene="s", engine="e", settings=settings.as_dict(), errors={TIP: error}, solve_seconds=seconds)


@pytest.mark.verify
def test_the_search_comes_near_the_best_of_a_whole_grid() -> None:
    tolerances, stiffnesses = ([10.0 ** (-0.25 * k) for k in range(8, 41)], [10.0 ** (0.25 * k) for k in range(8, 33)])
    grid = [made_up(MadeUp(shapes=n, tolerance=t, stiffness=k, quick=True)) for n in range(2, 16) for t in tolerances for k in stiffnesses]
    found = search([MadeUp(), MadeUp(shapes=20), MadeUp(shapes=40)], LEVELS, 100, made_up)
    assert len(found) <= 100
    for level in LEVELS:
        best = min(row.seconds for row in grid if (row.error or 1.0) <= level)
        (at,) = standings(found, level).values()
        assert at.row.seconds < 1.5 * best, (level, at.row.settings)
        assert at.row.settings["other"] == 1.0


@pytest.mark.parametrize("runs", [1, 2, 7, 32])
def test_no_combination_has_more_runs_than_another(runs: int) -> None:
    made: list[Settings] = []

    def counted(settings: Settings, limit: float) -> Row:
        made.append(settings)
        return made_up(settings)

    assert len(search([MadeUp(), MadeUp(shapes=20)], LEVELS, runs, counted)) == len(made) == len(set(made)) == runs


def test_the_sum_of_the_times_is_limited_and_each_run_by_what_is_left() -> None:
    limits: list[float] = []

    def slow(settings: Settings, limit: float) -> Row:
        limits.append(limit)
        return replace(made_up(settings), solve_seconds=0.1 * SECONDS)

    assert len(search([MadeUp()], LEVELS, 100, slow)) == 10
    assert limits == pytest.approx([0.5 * SECONDS * (1.0 - 0.1 * number) for number in range(10)])


def test_where_every_seed_is_too_slow_cheaper_settings_are_found() -> None:
    def limited(settings: Settings, limit: float) -> Row:
        row = made_up(settings)
        return row if row.seconds < 300e-6 else Row(scene="s", engine="e", settings=settings.as_dict(), status="too long")

    assert limited(MadeUp(shapes=40), 1.0).status == "too long"
    found = search([MadeUp(shapes=40)], (1e-2,), 32, limited)
    assert standings(found, 1e-2)


def test_a_step_stays_within_what_an_engine_accepts_and_moves_what_it_declares() -> None:
    corner = MadeUp(shapes=1, tolerance=1e-2)
    for step, finer in itertools.product(STEPS, (False, True)):
        assert all(each != corner for each in neighbours(corner, step, finer))
    cheaper = list(neighbours(MadeUp(), STEPS[0], False))
    assert {each.shapes for each in cheaper if isinstance(each, MadeUp)} == {5, 10, 15}
    assert MadeUp(tolerance=1e-8) in cheaper
    assert MadeUp(quick=True) in cheaper


def test_combinations_are_the_choices_that_an_engine_declares() -> None:
    def names(name: str, case: str = "thesis-24") -> list[str]:
        chosen, machine = engine(name), load_case(case).mechanism
        return [variant_of(chosen, chosen.settings_type().with_texts(each)) for each in combinations(chosen, machine)]

    assert names("multiplier") == ["", "explicit", "hermite"]
    assert {"", "consistent", "both linear"} <= set(names("nodal-load"))
    assert names("mujoco") == [""]
    assert names("reference") == ["", "implicit"]
    assert names("reference", "hard-ei-x0.1") == ["implicit", ""]


def test_every_engine_has_axes_and_other_seeds_for_other_levels() -> None:
    case = load_case("thesis-24", {"crank.prescribed_speed": "16.6 rad/s"})  # which all of them take
    for name in ("reference", "thesis", "exudyn", "mujoco", *RIVALS):
        first = seeds(engine(name), combinations(engine(name), case.mechanism)[0], LEVELS, case.mechanism)
        assert len(list(neighbours(first[0], STEPS[0], True))) >= 2, name
        assert len(first) > 1 or name in ("nodal-load", "thesis", "moving-boundaries"), name
