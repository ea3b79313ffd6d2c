"""A message about a wrong name shows what was typed, once, and where."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import quickreturn as qr
from quickreturn.cases.errors import Argument, CaseError
from quickreturn.cases.keys import PATHS
from quickreturn.plugins.studies.sweep.grid import scenes_of
from quickreturn.plugins.studies.sweep.rows import Impossible
from quickreturn.plugins.studies.uncertainty.calibration import frees_of
from tests.quickreturn.conftest import Call

SOLVED = {"time [s]": [0.0, 0.1], "crank_angle [rad]": [0.0, 1.0]}
WRONG = {"tip.mass": "uniform 0 g .. 1 g"}


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda name: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, measures=[name]), "measures"),
        (lambda name: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, measures=name), "measures"),
        (lambda name: qr.sweep("thesis-24", {name: "0 g; 1 g"}), "vary"),
        (lambda name: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, path=name), "path"),
        (lambda name: qr.resonance("thesis-24", range="60 rpm .. 90 rpm", measures=name), "measures"),
        (lambda name: qr.resonance("thesis-24", name, "60 rpm .. 90 rpm"), "range"),
        (lambda name: qr.uncertainty("thesis-24", WRONG, [name]), "measures"),
        (lambda name: qr.uncertainty("thesis-24", WRONG, name), "measures"),
        (lambda name: qr.uncertainty("thesis-24", {name: "uniform 0 g .. 1 g"}, ["multiplier"]), "uncertain"),
        (lambda name: qr.calibrate("thesis-24", SOLVED, name), "free"),
        (lambda name: qr.calibrate("thesis-24", SOLVED, [name]), "free"),
    ],
)
def test_python(ask: Callable[[str], Any], told: str) -> None:
    with pytest.raises(CaseError) as wrong:
        ask("wrong.name")
    assert str(wrong.value).startswith(f"{told}: ")
    assert str(wrong.value).count("wrong.name") == 1


@pytest.mark.parametrize(
    "ask",
    [
        lambda given: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, measures=given),
        lambda given: qr.resonance("thesis-24", range="60 rpm .. 90 rpm", measures=given),
        lambda given: qr.uncertainty("thesis-24", WRONG, given),
        lambda given: qr.calibrate("thesis-24", SOLVED, given),
    ],
)
@pytest.mark.parametrize("given", [[1], 1, [None], ["multiplier", 2.5]])
def test_what_is_no_text(ask: Callable[[Any], Any], given: Any) -> None:
    with pytest.raises(CaseError, match=r"(1|None|2\.5) is not a text; give one or several, such as "):
        ask(given)


@pytest.mark.parametrize(
    "typed",
    [
        ("sweep", "thesis-24", "--vary", "tip.mass = 0 g; 1 g", "--output", "x.csv", "--measure", "wrong.name"),
        ("sweep", "thesis-24", "--output", "x.csv", "--vary", "wrong.name"),
        ("resonance", "thesis-24", "--speed", "60 rpm .. 90 rpm", "--measure", "wrong.name"),
        ("calibrate", "thesis-24", "table.csv", "--free", "wrong.name"),
    ],
)
def test_the_command(call: Call, typed: tuple[str, ...]) -> None:
    Path("table.csv").write_text("time [s],crank_angle [rad]\n0,0\n0.1,1\n")
    answer = call(*typed)
    assert (answer.code, answer.output) == (2, "")
    assert f"{typed[-2]}: " in answer.errors
    assert answer.errors.count("wrong.name") == 1


def test_a_scene_of_a_study_that_cannot_be_names_no_option() -> None:
    """The sentence is stored with the point, whoever asked: `qr.sweep`, `qr.uncertainty` or the command."""
    (scene,) = scenes_of(qr.case("thesis-24"), [{"crank.length": "21 in"}])
    assert isinstance(scene, Impossible)
    assert scene.sentence.startswith('crank.length: "21 in"')


def test_a_mistake_in_an_argument_is_the_same_after_pickling() -> None:
    wrong = pickle.loads(pickle.dumps(Argument("free")))
    assert (type(wrong), wrong) == (Argument, "free")


def test_a_key_that_replaces_another_names_what_it_needs() -> None:
    held = qr.case("hard-prescribed-speed")
    with pytest.raises(CaseError) as wrong:
        held.with_({"crank.torque": "1 N*m"})
    told = 'overrides: crank.torque: "1 N*m" takes the place of crank.prescribed_speed and needs crank.damping as well'
    assert str(wrong.value).startswith(told)
    both = held.with_({"crank.torque": "1 N*m", "crank.damping": "1 N*m*s/rad"})
    assert both.mechanism.crank_is_free


def test_the_range_that_is_advised_is_accepted() -> None:
    """For every parameter that a fit may have: the example of a message is what the next call takes."""
    case, advised = qr.case("rigid"), 0
    for key, about in PATHS.items():
        if not about.is_number or not about.moves or key.startswith(("simulation.", "base.spin_up")):
            continue
        try:
            frees_of([key], case)
        except CaseError as wrong:
            text = wrong.accepted.partition('"')[2].partition('"')[0]
            (free,) = frees_of([text], case)
            assert free.parameter.key == key
            advised += 1
    assert advised > 5
