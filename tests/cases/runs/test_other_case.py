"""A table of another case is told as that one's, and honest tables of the case itself never are: tables of known descent."""

import dataclasses
import functools

import numpy as np
import pytest

from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case
from quickreturn.cases.errors import CaseError
from quickreturn.cases.recorded import table_of
from quickreturn.cases.runs.column_differences import UNFIT, explanations
from quickreturn.cases.runs.other_case import TRAITS, other_cases
from quickreturn.cases.runs.recorded import recorded_run
from quickreturn.cases.runs.request import Run
from quickreturn.engines.registry import engine
from quickreturn.engines.scene import simulate_scene

ALL = ("thesis-15", "thesis-17", "thesis-22", "thesis-24", "hard-ei-x10", "hard-no-tip")


@functools.cache
def columns_of_case(name: str, by: str = "reference") -> dict[str, np.ndarray]:
    case = load_case(name)
    return simulate_scene(engine(by), case.scene, 2.2, 1e-3, estimate=False).trajectory.columns


@functools.cache
def right(case: Case) -> Run:
    """What stands for an engine on a case."""
    return recorded(case.name, case)


def recorded(name: str, case: Case, by: str = "reference", **changes: float) -> Run:
    """What a table of one case is, measured on another; `changes`: factors of columns."""
    columns = {column: changes.get(column, 1.0) * values for column, values in columns_of_case(name, by).items()}
    return recorded_run(table_of(columns), case)


@pytest.mark.parametrize(
    ("given", "name"),
    [
        *(("thesis-24", name) for name in ("thesis-17", "thesis-24")),
        *(pytest.param(given, name, marks=pytest.mark.verify) for given in ALL for name in ALL),
    ],
)
def test_the_case_is_found(given: str, name: str) -> None:
    case = load_case(given)
    found = other_cases(recorded(name, case), right(case), case)
    if name == given:
        assert (found.names, found.told) == ((), "")
    else:
        assert found.names[0] == name
        assert given in found.told


def test_cases_whose_crank_turns_at_another_pace_are_refused_with_the_case() -> None:
    with pytest.raises(CaseError, match=r"takes 0\.8.* s in it.*this looks like a table of thesis-07"):
        recorded("thesis-07", load_case("thesis-24"))


@pytest.mark.verify
def test_a_coarse_model_is_no_other_case() -> None:
    """One cubic has a first frequency that is 13 % too high: that of run 22, whose crank turns within 0.4 % as fast."""
    case = load_case("thesis-24")
    run, other = recorded("thesis-24", case, "thesis"), right(case)
    assert other_cases(run, other, case).names == ()
    told = explanations(run, other, case)
    assert list(told) == [UNFIT]
    assert "fits thesis-24" in told[UNFIT]
    assert "model coarse" in told[UNFIT]


@pytest.mark.parametrize(
    ("column", "factor"),
    [
        ("tip_deflection", 0.0254),
        ("tip_deflection", 1e3),
        ("slider_force", -1.0),
        ("slider_position", 1e3),
    ],
)
def test_one_wrong_column_makes_no_other_case(column: str, factor: float) -> None:
    """Least of all 0.0254 of the deflection: about what ten times the stiffness makes of it."""
    case = load_case("thesis-24")
    told = explanations(recorded("thesis-24", case, **{column: factor}), right(case), case)
    assert set(told) == {column}


def test_a_scene_with_another_value_is_told_as_that_and_no_column_is_explained() -> None:
    case = load_case("thesis-24")
    crank = dataclasses.replace(case.mechanism.crank, length=1.15 * case.mechanism.crank.length)
    mine = simulate_scene(engine("reference"), dataclasses.replace(case.mechanism, crank=crank), 2.2, 1e-3, estimate=False)
    told = explanations(recorded_run(table_of(mine.trajectory.columns), case), right(case), case)
    assert list(told) == [UNFIT]
    assert "the slider comes as near as 340.4 mm to P in it, 355.6 mm in thesis-24" in told[UNFIT]
    assert "is a quantity of the scene another one" in told[UNFIT]


def test_every_trait_is_told_with_both_values_and_the_case() -> None:
    for trait in TRAITS.values():
        assert trait.words.format(1.25, 2.5, "mine").count("mine") == 1
        assert trait.factor > 1.0


@pytest.mark.parametrize("size", [0.1, *(pytest.param(size, marks=pytest.mark.verify) for size in (0.03, 0.4))])
def test_noise_is_told_by_its_size(size: float) -> None:
    case, random = load_case("thesis-24"), np.random.default_rng(3)
    columns = dict(columns_of_case("thesis-24"))
    rms = float(np.sqrt(np.mean(columns["strain_2"][1500:] ** 2)))
    columns["strain_2"] = columns["strain_2"] + size * rms * random.standard_normal(len(columns["time"]))
    told = explanations(recorded_run(table_of(columns), case), right(case), case)
    assert set(told) == {"strain_2"}
    assert "look like noise of" in told["strain_2"]
    assert float(told["strain_2"].split("noise of ")[1].split(" %")[0]) == pytest.approx(100.0 * size, rel=0.25)


def test_a_sign_is_named_through_noise() -> None:
    case, random = load_case("thesis-24"), np.random.default_rng(4)
    columns = dict(columns_of_case("thesis-24"))
    rms = float(np.sqrt(np.mean(columns["strain_2"] ** 2)))
    columns["strain_2"] = -columns["strain_2"] + 0.05 * rms * random.standard_normal(len(columns["time"]))
    told = explanations(recorded_run(table_of(columns), case), right(case), case)
    assert set(told) == {"strain_2"}
    assert "sign" in told["strain_2"]
