"""What to do next: commands for the user's own machine."""

import shlex
from collections.abc import Sequence

from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.words import counted, listed


def next_steps(content: Content) -> Chapter | None:
    """The chapter; None where the report is not about the user's own machines."""
    if not content.is_own:
        return None
    case = content.results[0].case
    failures = [f"{result.case.name}, {run.engine}: {run.remark or run.status}" for result in content.results for run in result.failures]
    departing = [result.case.name for result in content.results if result.missed]
    facts = {
        "file": shlex.quote(case.source if case.source not in ("", "library") else case.name),
        "shorter": case.units.of("m").text(0.9 * case.mechanism.crank.length),
        "failures": failures,
        "departing": departing,
    }
    return Chapter("next", "What to do next", finding(len(failures), departing), facts)


def finding(failures: int, departing: Sequence[str]) -> str:
    """The number of simulations that failed, or the cases in which engines disagree, or what can be done."""
    if failures:
        return f"{counted(failures, 'simulation')} did not deliver"
    return f"Engines disagree in {listed(departing)}" if departing else "Change a value, measure the cost, take the data"
