"""What an engine raises because a library, memory or a file is missing is no result: the next attempt begins anew."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.solving import TrajectoryRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.job import Job, ThisProcess
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from tests.engines.fake_package import FAKE_ENGINE, install

SCENE = load_case("thesis-24").mechanism
#: The fake engine, whose method `WHERE` raises `ERROR` in the first call.
LACKING = """
class Lacking(FakeEngine):
    name = "lacking"
    calls = 0

    def prepare(self, *arguments):
        type(self).calls += 1
        if WHERE == "prepare" and self.calls == 1:
            ERROR
        simulation = super().prepare(*arguments)
        advance = simulation.advance

        def first(*arguments):
            if WHERE == "advance" and self.calls == 1:
                ERROR
            return advance(*arguments)

        simulation.advance = first
        return simulation
"""


def trajectory() -> Job[Any]:
    return TrajectoryRequest(scene=SCENE, duration=0.1, output_step=0.01, engine="lacking", estimate=False).job("lacking")


def run() -> Job[Any]:
    request = RunRequest(mechanism=SCENE, duration=1.0, engine="lacking", settings={"step": "0.1"}, estimated=False, turn=1)
    return Job("lacking", steady_state, (request,), "steady state", ("lacking",))


@pytest.mark.parametrize("asked", [trajectory, run])
@pytest.mark.parametrize("where", ["prepare", "advance"])
@pytest.mark.parametrize("error", ["MemoryError", "OSError", "import no_such_library"])
def test_the_next_attempt_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked: Callable[[], Job[Any]], where: str, error: str
) -> None:
    statement = error if error.startswith("import") else f"raise {error}('libGL.so.1 is missing')"
    module = f"lacking_{where}_{asked.__name__}_{error.replace(' ', '_')}"
    source = FAKE_ENGINE + LACKING.replace("WHERE", repr(where)).replace("ERROR", statement)
    install(tmp_path / "packages", "lacking", {module: source}, {"lacking": f"{module}:Lacking"})
    monkeypatch.syspath_prepend(tmp_path / "packages")
    workshop = Workshop(Store(tmp_path), ThisProcess())
    (first,) = workshop.outcomes([asked()], "attempts")
    assert first.failure.startswith("raised ")
    assert workshop.store.written == 0
    (second,) = workshop.outcomes([asked()], "attempts")
    assert second.completed, second.explanation
