"""One scene: error and solve time of every method over its ladder of settings, against a solution that a second engine confirms.

One process, pinned to one processor; the repetitions of all trials are interleaved, so that a drift of the machine's speed affects all of
them alike. Trials that failed or were not tried stay in the table. An engine that crashes ends this process:
`cases.benchmark.scenes.measure` finds out which engine it was.
"""

import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from quickreturn.cases.files.case import Case
from quickreturn.engines.registry import engine
from quickreturn.plugins.methods.trials.methods import Plan, methods
from quickreturn.plugins.methods.trials.queries import LEVELS, fastest_at
from quickreturn.plugins.methods.trials.trial import Trial, estimate_seconds, repeated, trial_of, warm_up, worth_repeating
from quickreturn.plugins.methods.trials.truth import Truth, confirmation_of, truth_of
from quickreturn.reference_model.natural_modes import frozen_crank_modes

#: Largest number of repetitions of a trial.
REPETITIONS: Final = 5
#: Solve time (s) beyond which the finer settings of a method are not tried.
LONG: Final = 10.0
NOT_TRIED: Final = "not tried"
_AT_WORK: Final = "at work: "


@dataclass(frozen=True)
class Benchmark:
    """The table of one scene."""

    case: str  # its name
    title: str  # its title
    duration: float  # s
    truth: Truth  # the solution that defines errors
    confirmation: Trial  # a second solution
    trials: tuple[Trial, ...]  # one for each method and settings
    repetitions: int  # largest number of repetitions of a trial
    longest: float  # solve time (s) beyond which the finer settings of a method were not tried
    machine: dict[str, str]  # processor, system and versions
    # engine -> why it was left out: it died, was stopped at a limit or cannot be used on this machine
    failures: dict[str, str] = field(default_factory=dict)


def benchmark(
    case: Case,
    names: Sequence[str],
    repetitions: int = REPETITIONS,
    longest: float = LONG,
    announce: Callable[[str], None] = lambda name: None,
) -> Benchmark:
    """Measure engines on a case, in this process.

    Args:
        case: the scene; from its standard start, over its duration and output step.
        names: of engines.
        repetitions: of each trial, at most.
        longest: solve time (s) beyond which the finer settings of a method are not tried.
        announce: called with the name of each engine before it runs.

    Raises:
        UnknownEngine: no engine has this name.
        EngineFailure: the solution that defines errors cannot be computed.
        Refusal: the engine of that solution cannot model the scene.
    """
    plans = [plan for method in methods(names, case) for plan in method.plans(case)]
    truth = truth_of(case)
    confirmation = confirmation_of(case, truth)
    for plan in {plan.method.name: plan for plan in plans}.values():
        announce(plan.method.engine.name)
        warm_up(plan)
    rounds, untried = list[list[Trial]](), f"{NOT_TRIED}: coarser settings took longer than {longest:g} s"
    slow: set[str] = set()
    for plan in plans:
        announce(plan.method.engine.name)
        rounds.append([Trial(**plan.about, status=untried) if plan.method.name in slow else trial_of(plan, truth)])
        if rounds[-1][0].completed and rounds[-1][0].seconds > longest:
            slow.add(plan.method.name)
    for _ in range(1, repetitions):
        for plan, trials in zip(plans, rounds, strict=True):
            if worth_repeating(trials):
                announce(plan.method.engine.name)
                trials.append(trial_of(plan, truth))
    return Benchmark(
        case.name,
        case.title,
        case.duration,
        Truth.of(case, truth),
        confirmation,
        tuple(_detailed(plans, [repeated(trials) for trials in rounds], announce)),
        repetitions,
        longest,
        _machine(names),
    )


def _detailed(plans: Sequence[Plan], trials: Sequence[Trial], announce: Callable[[str], None]) -> list[Trial]:
    """The trials; each method's fastest one within an error of `LEVELS` also has the time of its error estimate."""
    chosen = {id(trial) for level in LEVELS for trial in fastest_at(trials, level).values()}
    detailed = []
    for plan, trial in zip(plans, trials, strict=True):
        timed = None
        if id(trial) in chosen:
            announce(trial.engine)
            timed = estimate_seconds(plan)
        detailed.append(replace(trial, estimate_seconds=timed, statistics=trial.statistics | _calls_per_period(plan.case, trial)))
    return detailed


def _calls_per_period(case: Case, trial: Trial) -> dict[str, float]:
    """Right-hand sides per period of the highest mode that `reference` keeps, at the start's crank angle; nothing for other methods."""
    modes, calls = trial.settings.get("modes"), trial.statistics.get("right_hand_side_calls")
    if trial.engine != "reference" or modes is None or calls is None or case.mechanism.follower.is_rigid:
        return {}
    highest = frozen_crank_modes(case.mechanism, case.mechanism.crank.initial_angle, modes).frequencies[-1]
    return {"calls_per_period": calls / (case.duration * float(highest))}


def pinned(case: Case, names: Sequence[str], repetitions: int) -> Benchmark:
    """As `benchmark`, with the process pinned to one processor; its output names the engine at work, see `last_at_work`."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    began = time.monotonic()

    def announce(name: str) -> None:
        print(f"\n{_AT_WORK}{time.monotonic() - began:.3f} {name}", flush=True)

    return benchmark(case, names, repetitions, announce=announce)


def last_at_work(output: str) -> tuple[str | None, float]:
    """The engine at work when a process in `pinned` ended, by the process' output, and the time (s) when it began; (None, 0): none yet."""
    announced = [line.removeprefix(_AT_WORK).split(" ", 1) for line in output.splitlines() if line.startswith(_AT_WORK)]
    return (announced[-1][1], float(announced[-1][0])) if announced else (None, 0.0)


def _machine(names: Sequence[str]) -> dict[str, str]:
    return {
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
        "processor": platform.processor() or platform.machine(),
        "system": platform.platform(),
        "python": platform.python_version(),
        **{name: engine(name).version() for name in names if not engine(name).unavailable()},
    }
