"""Hypotheses on how another program's machine was built, on tables of MuJoCo that `examples/as_built/` makes."""

import importlib
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.runs.column_differences import BUILT, QUANTITIES

SCRIPTS = Path(__file__).resolve().parents[2] / "examples" / "as_built"


@pytest.fixture(scope="module")
def mujoco_machines() -> Iterator[Any]:
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.syspath_prepend(str(SCRIPTS))
        yield importlib.import_module("mujoco_machines")
    for name in ("mujoco_machines", "run_24"):
        sys.modules.pop(name, None)


@pytest.fixture
def told(mujoco_machines: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The hypothesis on a construction's table, "" without one; or all explanations."""
    monkeypatch.setenv("QUICKRETURN_STORE", str(tmp_path))
    case = qr.case("thesis-24").with_({"follower.damping": "0 N*s/m^2", "follower.material_damping": "1e-4 s"})

    def tell(whole: bool = False, **changes: Any) -> Any:
        columns, _ = mujoco_machines.simulate(replace(mujoco_machines.STIFF, **changes))
        table = {name: np.asarray(values) for name, values in columns.items()}
        explanations = qr.compare(case, table, "reference", quiet=True).explanations
        return explanations if whole else explanations.get(BUILT, "")

    return tell


def test_a_soft_contact_shows_in_the_gap_and_a_low_frequency(told: Any) -> None:
    text = told(solref=3e-3)
    assert text.startswith("probably a soft contact: the slider is up to 0.")
    assert " mm off the centre line, and the first mode's frequency is " in text
    assert "give the contact a time constant of two steps" in text


@pytest.mark.verify
def test_friction_shows_in_a_slow_crank(told: Any) -> None:
    explanations = told(whole=True, friction=0.1)
    assert explanations[BUILT].startswith("probably friction, or another drive: a turn of the crank takes ")
    assert "crank.damping" in explanations[QUANTITIES]
    assert "would explain most of the difference" in explanations[QUANTITIES]


@pytest.mark.parametrize(("step", "added"), [pytest.param(1e-4, 0.0064, marks=pytest.mark.verify), (5e-4, 0.032)])
def test_an_integrator_that_damps_shows_in_the_damping_at_a_right_frequency(told: Any, step: float, added: float) -> None:
    """The added damping ratio is that of a pluck, within a third."""
    text = told(integrator="discrete", step=step, solref=2.0 * step)
    found = re.fullmatch(
        r"probably an integrator that damps: the first mode's damping ratio is ([\d.]+) larger, its frequency right; halve the step, .*",
        text,
    )
    assert found, text
    assert float(found[1]) == pytest.approx(added, rel=0.34)


@pytest.mark.verify
def test_a_polygon_shows_in_neither(told: Any) -> None:
    assert told().startswith("probably friction, the corners of a chain of links, or a long step: neither the first mode's frequency")


@pytest.mark.verify
def test_hinges_that_are_too_stiff_are_no_mistake_in_a_column(told: Any) -> None:
    found = told(stiffness=3.0, whole=True)
    assert list(found) == ["tip_deflection"]
    assert "no single mistake explains that" in found["tip_deflection"]


@pytest.mark.verify
def test_a_good_chain_gets_no_hypothesis(told: Any) -> None:
    assert told(links=26, step=2.5e-5, solref=5e-5) == ""
