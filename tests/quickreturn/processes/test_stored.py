"""What was simulated before comes from the store: the same to the last bit, in the same files, told as such; unless nobody wants it."""

import json
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.motion.solving import TrajectoryRequest
from quickreturn.cases.running.job import ThisProcess
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import outcomes_of
from tests.engines.fake_engine import FakeEngine
from tests.quickreturn.conftest import Call
from tests.quickreturn.scene_file import SCENE

#: An engine that the commands know the code of; its loads need moments, which it does not give.
QUICK = ("small.toml", "--engine", "thesis", "--duration", "0.02")


@pytest.fixture(autouse=True)
def small(call: Call) -> None:
    """A case in the folder where the program is called, with the fake engine installed."""
    Path("small.toml").write_text(SCENE)


def results() -> list[Path]:
    return sorted(Path(".quickreturn").glob("*.result"))


def test_the_second_simulation_is_the_first_one() -> None:
    first, second = (qr.simulate("small.toml", "fake", accuracy=1e-2) for _ in range(2))
    assert (first.stored, second.stored) == (False, True)
    assert first.frame.equals(second.frame)
    assert vars(first.result) | {"trajectory": 0} == vars(second.result) | {"trajectory": 0}
    assert (first.version, first.settings, first.loads) == (second.version, second.settings, second.loads)
    assert "comes from the store" in repr(second)
    assert "comes from the store" not in repr(first)


def test_what_is_asked_otherwise_is_computed() -> None:
    qr.simulate("small.toml", "fake")
    for more in ({"accuracy": 1e-2}, {"settings": {"step": 0.05}}, {"estimate": False}, {"store": False}):
        assert not qr.simulate("small.toml", "fake", **more).stored  # type: ignore[arg-type]
    assert not qr.simulate(qr.case("small.toml", {"crank.length": "4.1 in"}), "fake").stored
    assert not qr.simulate(qr.case("small.toml", duration=0.05), "fake").stored
    assert qr.simulate("small.toml", "fake", time_limit=1e6).stored, "a limit that leaves nothing out changes nothing"


def test_nothing_is_kept_where_nobody_wants_it_or_the_engine_is_ones_own() -> None:
    qr.simulate("small.toml", "fake", store=False)
    qr.modes("small.toml", "fake", store=False)
    assert not qr.simulate("small.toml", FakeEngine()).stored
    assert not qr.simulate("small.toml", FakeEngine()).stored
    assert results() == []


def test_a_failure_comes_again_with_what_was_computed() -> None:
    for _ in range(2):
        with pytest.raises(qr.EngineFailure, match="the beam snapped; try another beam") as failure:
            qr.simulate("small.toml", "fake", settings={"behaviour": "fails"})
        assert failure.value.partial is not None
        assert len(failure.value.partial) == 3
    assert len(results()) == 1


def test_what_a_time_limit_leaves_out_is_computed_the_next_time() -> None:
    scene = qr.case("small.toml")
    asked = {"scene": scene.scene, "duration": scene.duration, "output_step": scene.output_step, "engine": "fake"}
    hurried = TrajectoryRequest(**asked, time_limit=1e-9)  # type: ignore[arg-type]
    [outcome] = outcomes_of([hurried.job("hurried")], "", ThisProcess(), Store())
    assert outcome.value is not None
    _, result = outcome.value
    assert not isinstance(result, qr.EngineFailure)
    assert result.hurried
    assert result.error_estimate is None
    assert not qr.simulate("small.toml", "fake").stored


def test_a_command_says_where_its_answer_comes_from(call: Call) -> None:
    first, second = (json.loads(call("simulate", *QUICK, "--json", "--output", f"{name}.csv").output) for name in ("one", "two"))
    assert (first.pop("stored"), second.pop("stored")) == (False, True)
    assert first | {"output": "two.csv"} == second
    assert Path("one.csv").read_bytes() == Path("two.csv").read_bytes()
    files = results()
    assert not json.loads(call("simulate", *QUICK, "--json", "--no-store").output)["stored"]
    assert call("plot", *QUICK, "--output", "a.png").code == 0
    assert results() == files, "plot draws what simulate has computed"


def test_a_command_keeps_nothing_of_an_engine_whose_library_it_would_have_to_load(call: Call) -> None:
    for _ in range(2):
        assert not json.loads(call("simulate", "small.toml", "--engine", "fake", "--json").output)["stored"]
    assert results() == []


def test_python_and_the_command_share_what_is_kept(call: Call) -> None:
    told = json.loads(call("simulate", *QUICK, "--json", "--output", "one.csv").output)
    solution = qr.simulate(qr.case("small.toml", duration=0.02), "thesis")
    assert solution.stored
    assert solution.result.error_estimates == told["error_estimates"]
    assert np.array_equal(solution["tip_deflection"], np.genfromtxt("one.csv", delimiter=",", names=True)["tip_deflection"])
