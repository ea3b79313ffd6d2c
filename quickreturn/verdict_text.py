"""The results of engines on cases: as text for a terminal or a notebook, and as a JSON document."""

import math
from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult, agreement, not_judged
from quickreturn.cases.comparison.pair import WAVEFORM, Difference, Kind
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Cell, Rows, Units
from quickreturn.cases.motion.catalogue import IN_TABLES, MEASURES, numbers
from quickreturn.cases.motion.number import SAYS_NOTHING
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.resonance import resonance
from quickreturn.readings import readings
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.words import cost

#: Largest number of departures that the text shows for a pair of engines.
LISTED: Final = 5
#: Word -> kind of the differences that are shown for an engine that is not judged.
_OF_KIND: Final[dict[str, Kind]] = {"frequency": "channel frequency", "amplitude": "amplitude", "extremes": "extreme"}

#: Measures that the terminal shows.
_MEASURED: Final = tuple(name for name, place in IN_TABLES.items() if place.in_terminal)
#: Column whose peak the terminal shows -> its heading, and its format in SI.
_PEAKS: Final = {"tip_acceleration": ("peak accel.", ".2f"), "strain_2": ("peak strain 2", ".3e")}


def parts_of(result: CaseResult) -> list[Cell]:
    """Rows of the engines and recorded tables, their remarks, what plugins read off them, and the verdict."""
    whole = result.with_tables
    rows = [_row(result.case, run, whole.accuracy_class(name)) for name, run in whole.runs.items()]
    remarks = [f"  {run.engine}: {run.remark}" for run in whole.runs.values() if run.remark]
    verdict = [f"  {line}" for line in _verdict(whole)]
    read = [f"  {line}" for each in readings().values() for line in each.lines(result)]
    state = "" if result.turn is None else f"; turn {result.turn} from the standard start"
    return [f"{result.case.name}: {result.case.title}{state}", Rows(rows, _heads(result.case.units)), *remarks, *read, *verdict]


def _heads(units: Units) -> list[str]:
    """The headings of the rows of engines."""
    heads = {IN_TABLES[name].head.replace("₁", "1"): MEASURES[name].unit for name in _MEASURED}
    heads |= {head: COLUMNS[name].unit for name, (head, _) in _PEAKS.items()}
    measured = [f"{head} {units.of(si).name.replace('^', '')}".removesuffix(" 1") for head, si in heads.items()]
    return ["engine", "status", "start", "cycles", "solve s", "estimate", "class", *measured]


def _verdict(result: CaseResult) -> list[str]:
    """The verdict, and the differences from the reference of engines that are not judged."""
    lines = []
    for (engine, other), checks in result.departures.items():
        total = sum((check.engine, check.other) == (engine, other) for check in result.checks)
        lines.append(f"{engine} and {other} disagree by more than they claim, in {len(checks)} of {total} comparisons:")
        worst = sorted(checks, key=lambda check: -abs(check.difference) / check.tolerance if check.tolerance else -math.inf)
        units = result.case.units
        lines += [f"  {line}" for check in worst[:LISTED] for line in (_departure(check, units), *(f"  {part}" for part in check.why))]
        if len(checks) > LISTED:
            lines.append(f"  and {len(checks) - LISTED} more, which `departures` and --json list")
    if result.passed is None:
        lines.append(f"not judged: {result.reason}")
    departing = {check.engine for check in result.missed}
    within = [check for check in result.checks if check.engine not in departing]
    if within:
        names, others = (dict.fromkeys(getattr(check, side) for check in within) for side in ("engine", "other"))
        silent = agreement(within)["says_nothing"]
        lines.append(
            f"{', '.join(names)}: within what is claimed of {' and '.join(others)} in all {len(within)} comparisons"
            + (f"; {silent} of them say nothing, for more is claimed than {SAYS_NOTHING}" if silent else "")
        )
    reference = result.runs.get(REFERENCE)
    for name, run in result.runs.items():
        if reference is not None and reference.usable and run.usable and name != REFERENCE and (why := not_judged(run)):
            sizes = {word: [abs(each.relative) for each in result.differences(name, kind)] for word, kind in _OF_KIND.items()}
            largest = [f"{word} {100.0 * max(of_kind):.2g} %" for word, of_kind in sizes.items() if of_kind]
            lines.append(f"{name}, not judged ({why}): largest differences from {REFERENCE}: {', '.join(largest) or 'none'}")
    return lines


def _departure(check: Difference, units: Units) -> str:
    unit, where = units.of(check.unit), check.channel or "all channels"
    number, apart = check.number.value / unit.size, abs(check.difference) / unit.size
    values = "the signals" if check.quantity in WAVEFORM else f"{number:.5g} and {unit.text(check.other_number.value, '.5g')}"
    allowed = f"the claims of {check.engine} and {check.other} allow {check.tolerance / unit.size:.2g}"
    return f"{check.quantity}, {check.half}-return, {where}: {values} differ by {apart:.2g}, {allowed}"


def _row(case: Case, run: Run, accuracy_class: str | None) -> tuple[str, ...]:
    def number(value: float | None, form: str) -> str:
        return "-" if value is None or math.isnan(value) else format(value, form)

    def scaled(value: float | None, si: str, form: str) -> str:
        return number(None if value is None else value / case.units.of(si).size, case.units.form(si, form))

    measured = numbers(case.mechanism, run, _MEASURED)
    units = {name: COLUMNS[name].unit for name in _PEAKS}
    peaks = [scaled(run.peak(name) if run.usable and name in run.cycle else None, units[name], form) for name, (_, form) in _PEAKS.items()]
    return (
        run.engine,
        run.status,
        run.approach.start or "-",
        str(run.approach.cycles),
        "-" if run.computation.solve_seconds is None else cost(run.computation.solve_seconds),
        number(run.computation.error_estimate, ".1e"),
        accuracy_class or "-",
        *(scaled(measured[name].value if measured else None, MEASURES[name].unit, IN_TABLES[name].in_terminal) for name in _MEASURED),
        *peaks,
    )


def as_document(results: Sequence[CaseResult], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run` and `compare`: recorded tables follow the engines."""
    results = [result.with_tables for result in results]
    return {
        "cases": [
            {
                "case": result.case.name,
                "turn": result.turn,
                "passed": result.passed,
                "agreement": result.agreement,
                "reason": result.reason,
                "notes": list(result.case.notes),
                "engines": [
                    _as_document(run)
                    | {
                        "accuracy_class": result.accuracy_class(name),
                        **{name: each.document(each.of_run(result.case.mechanism, run)) for name, each in readings().items()},
                        "numbers": {
                            measure: {"value": found.value, "error": found.error, "unit": MEASURES[measure].unit}
                            for measure, found in numbers(result.case.mechanism, run).items()
                        },
                    }
                    for name, run in result.runs.items()
                ],
                "resonance": _resonance(result),
                "checks": [check.as_dict() for check in result.checks],
            }
            for result in results
        ],
        "failures": [
            {"case": result.case.name, "engine": run.engine, "status": run.status, "remark": run.remark}
            for result in results
            for run in result.failures
        ],
        "notices": list(notices),
    }


def _resonance(result: CaseResult) -> dict[str, Any] | None:
    """First mode (Hz, mean over the turn with the crank held), crank (Hz), their ratio and the nearest harmonic."""
    found = resonance(result.case.mechanism, result.settled_speed)
    return None if found is None else {**vars(found), "ratio": found.ratio, "harmonic": found.harmonic}


def _as_document(run: Run) -> dict[str, Any]:
    """Everything about a run except its cycle."""
    outlook = run.approach.settling
    return run.flat | {"settling": outlook and {**vars(outlook), "sentence": outlook.sentence()}}
