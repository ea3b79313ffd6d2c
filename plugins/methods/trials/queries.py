"""Queries on trials: the Pareto front, the fastest method for an accuracy, the orders of errors, the settings of a ladder."""

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np

from quickreturn.plugins.methods.trials.trial import Trial

#: Errors of the tip deflection at which methods are compared.
LEVELS: Final = (1e-2, 1e-3, 1e-4)


def pareto_front(trials: Iterable[Trial], column: str = "tip_deflection") -> list[Trial]:
    """The trials that no other one beats in both solve time and error of a column, fastest first."""
    front: list[Trial] = []
    least = np.inf
    done = [(trial.seconds, error, trial) for trial in trials if (error := trial.error_of(column)) is not None]
    for _, error, trial in sorted(done, key=lambda entry: entry[:2]):
        if error < least:
            front.append(trial)
            least = error
    return front


def fastest_at(trials: Iterable[Trial], level: float) -> dict[str, Trial]:
    """The fastest trial of each method with an error of the tip deflection of at most `level`; fastest method first."""
    best: dict[str, Trial] = {}
    for trial in sorted(trials, key=lambda each: each.seconds):
        if trial.error is not None and trial.error <= level:
            best.setdefault(trial.method, trial)
    return best


def soonest_at(trials: Iterable[Trial], level: float) -> list[tuple[str, float]]:
    """The methods of `fastest_at` whose error estimate was timed, with their waiting time (s); the least first."""
    waited = [(name, trial.waited_seconds) for name, trial in fastest_at(trials, level).items()]
    return sorted(((name, seconds) for name, seconds in waited if seconds is not None), key=lambda pair: pair[1])


def observed_order(trials: Iterable[Trial], method: str) -> float | None:
    """Slope of -log(error) of the tip deflection over log(degrees of freedom), by least squares over a method's trials.

    None if fewer than three numbers of degrees of freedom completed. Of several trials with the same number the one with the least error
    counts: the others differ in the time step.
    """
    least: dict[int, float] = {}
    for trial in trials:
        error, free = trial.error, trial.degrees_of_freedom
        if trial.method == method and error and free is not None:
            least[free] = min(error, least.get(free, np.inf))
    if len(least) < 3:
        return None
    free_log, error_log = np.log(list(least)), np.log(list(least.values()))
    return float(-np.polyfit(free_log, error_log, 1)[0])


def changing(trial: Trial, among: Sequence[Trial]) -> dict[str, Any]:
    """The settings of a trial that change along its method's ladder, which is among some trials; all settings of a ladder of one rung."""
    rungs = [each.settings for each in among if each.method == trial.method]
    return {name: value for name, value in trial.settings.items() if len(rungs) < 2 or any(rung[name] != rungs[0][name] for rung in rungs)}
