"""How `simulate`, `plot` and `animate` come by trajectories."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from quickreturn import questions
from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.solving import Answer, TrajectoryRequest
from quickreturn.commands import options
from quickreturn.solution import Solution

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.cases.jobs.store import Store
    from quickreturn.engines.trajectory import Trajectory


@dataclass(frozen=True)
class Attempt:
    """How an engine fared on a case."""

    case: "Case"
    engine: str
    request: TrajectoryRequest
    outcome: Outcome[Answer]
    store: "Store | None"

    def answer(self) -> Answer:
        """What came of it. Raises as `questions.value_of`."""
        return questions.value_of(self.outcome)

    def solution(self) -> Solution:
        """The trajectory and what is known of it. Raises as `answer`, and EngineFailure: the run broke down."""
        return Solution.of(self.case, self.request, self.answer(), self.store if self.outcome.job.lasts else None, self.outcome.stored)


def attempts(
    cases: "Sequence[Case]",
    engines: Sequence[str],
    settings: Mapping[str, Mapping[str, str]],
    accuracy: float | None,
    estimate: bool = True,
    meanwhile: Sequence[str] = (),
) -> list[Attempt]:
    """Each engine on each case, as far as that cannot be known beforehand; `meanwhile` as of `options.answered`.

    Raises as `questions.check`.
    """
    texts = questions.settings_of(settings, engines)
    pairs = list(itertools.product(cases, engines))
    for case, name in pairs:
        questions.check(name, case.scene, texts[name])
    options.tell_doubts(cases)
    requests = [
        TrajectoryRequest(
            scene=case.scene,
            duration=case.duration,
            output_step=case.output_step,
            engine=name,
            settings=texts[name],
            accuracy=accuracy,
            estimate=estimate,
            time_limit=options.limits().seconds,
        )
        for case, name in pairs
    ]
    jobs = [request.job(f"{case.name} {name}") for (case, name), request in zip(pairs, requests, strict=True)]
    outcomes, store = options.answered(jobs, "simulating", meanwhile)
    return [Attempt(*pair, request, outcome, store) for pair, request, outcome in zip(pairs, requests, outcomes, strict=True)]


def trajectories(
    cases: "Sequence[Case]", engines: Sequence[str], settings: Mapping[str, Mapping[str, str]], accuracy: float | None
) -> "dict[tuple[str, str], Trajectory]":
    """Trajectories by case and engine; what is missed of the accuracy is told.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure, EngineDied: one cannot, or failed.
    """
    found = {}
    for each in attempts(cases, engines, settings, accuracy):
        solution = each.solution()
        if not solution.reached:
            options.tell(f"{each.case.name}: engine {each.engine}: {solution.remark}")
        found[each.case.name, each.engine] = solution.trajectory
    return found
