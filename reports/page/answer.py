"""The answer on the first screen: the numbers behind its three sentences and its figures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.comparison.pair import Kind
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.engines.registry import MODEL
from quickreturn.reports.engine_differences import Spread, differences, engines_of, spread
from quickreturn.reports.page.content import Content
from quickreturn.reports.words import percent, size

#: Largest part of an engine's numbers that may differ by more than claimed if it is to count as agreeing.
FEW: Final = 0.05


@dataclass(frozen=True)
class Cubic:
    """The thesis' model compared with the converged one."""

    frequency: Spread  # relative differences of its first-mode frequency
    strain: float | None  # its peak of the strain at mid-arm over the converged one, median over the cases


@dataclass(frozen=True)
class Answer:
    """The content of the first screen."""

    cases: int  # number of cases; in `compared` of them something could be judged
    compared: int
    engines: Sequence[str]  # names of all
    simulations: int  # number of simulations; `settled` of them are in their steady state at the accuracy asked
    settled: int
    missed: Sequence[str]  # a clause for each simulation that misses its accuracy
    alike: Sequence[str]  # engines whose numbers agree within their claims, the reference first; empty if nothing could be judged
    departing: Sequence[str]  # engines that were judged and are not alike
    frequency: Spread | None  # differences of these engines from the reference in the consensus first-mode frequency
    amplitude: Spread | None  # likewise in the first-mode amplitudes
    extreme: Spread | None  # likewise in the extremes
    cubic: Cubic | None  # None if the thesis' model or the reference is missing


def answer_of(content: Content) -> Answer:
    """The answer of a report."""
    results = content.results
    runs = [run for result in results for run in result.runs.values()]
    checks = [check for result in results for check in result.checks if check.verdict != "says nothing"]
    judged = list(dict.fromkeys(check.engine for check in checks))
    beyond = {name: [not check.passed for check in checks if check.engine == name] for name in judged}
    alike = [name for name in judged if sum(beyond[name]) <= FEW * len(beyond[name])]
    others = list(dict.fromkeys(check.other for check in checks)) if alike else []
    against = others[0] if others else REFERENCE
    kinds: tuple[Kind, ...] = ("frequency", "amplitude", "extreme")
    spreads = {kind: spread([difference for name in alike for difference in differences(results, name, kind, against)]) for kind in kinds}
    return Answer(
        cases=len(results),
        compared=sum(result.passed is not None for result in results),
        engines=engines_of(results),
        simulations=len(runs),
        settled=sum(run.status == Ending.SETTLED for run in runs),
        missed=[f"{result.case.name}: {clause}" for result in results for clause in accuracies_missed(result)],
        alike=[*others, *alike],
        departing=[name for name in judged if name not in alike],
        **spreads,
        cubic=_cubic(results),
    )


def accuracies_missed(result: CaseResult) -> tuple[str, ...]:
    """A clause for each engine whose estimate misses the accuracy asked, with both."""
    return tuple(_missed(run) for run in result.runs.values() if run.status == Ending.INACCURATE)


def _missed(run: Run) -> str:
    error, accuracy = run.computation.error_estimate, run.computation.accuracy
    estimate = "an unknown error" if error is None else f"an error of {size(error)} of the tip’s deflection"
    asked = "" if accuracy is None else f" where {percent(accuracy, 'g')} was asked"
    return f"{run.engine} estimates {estimate}{asked}"


def _cubic(results: Sequence[CaseResult]) -> Cubic | None:
    frequency = spread(differences(results, MODEL, "frequency"))
    if frequency is None:
        return None
    pairs = [(result.runs[MODEL], result.runs[REFERENCE]) for result in results if {MODEL, REFERENCE} <= set(result.runs)]
    ratios = [
        run.peak("strain_2") / other.peak("strain_2") for run, other in pairs if run.usable and other.usable and other.peak("strain_2")
    ]
    return Cubic(frequency, float(np.median(ratios)) if ratios else None)
