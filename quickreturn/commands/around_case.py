"""The motion of a case over speeds around its own, for `show --resonance`."""

from collections.abc import Sequence

from quickreturn.cases.case import Case
from quickreturn.cases.resonance_curve.search import job_around
from quickreturn.cases.sweep.grid import job
from quickreturn.cases.sweep.rows import MeasureRequest, Row
from quickreturn.commands import options
from quickreturn.questions import value_of
from quickreturn.reports.results.around import Around


def resonances(cases: Sequence[Case]) -> list[dict[str, list[str]]]:
    """Lines on the motion of each case over speeds around its own."""
    workshop = options.opened_workshop()
    outcomes = workshop.outcomes([job_around(case) for case in cases], "resonance curves")
    asked = MeasureRequest(measures=("multiplier",))
    own = workshop.outcomes([job(case, [{}], asked) for case in cases], "motions at their own speeds")
    return [
        {"resonance_curve": [*Around(case, value_of(outcome)).lines, _stability(value_of(row))]}
        for case, outcome, row in zip(cases, outcomes, own, strict=True)
    ]


def _stability(row: Row) -> str:
    """A line on the motion of a machine with its own drive, from a row of one point and its multiplier."""
    value, error = row.values[0, 0], row.errors[0, 0]
    reason = f": {row.sentences[0]}" if row.sentences[0] else ""
    if row.statuses[0] == "settled":
        left = f"{100.0 * value:.3g} % of a disturbance is left after a turn (+- {100.0 * error:.1g} %)"
        return f"with its own drive the motion is stable: {left}"
    return f"with its own drive the motion is {row.statuses[0]}{reason}"
