"""Engines in their steady state: measured and compared, and as a report."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from quickreturn.arguments import AnyCase, AnyEngineOrTable, Listing, given_settings, loaded, prepared
from quickreturn.cases.comparison.campaign import cross_validate
from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.files.errors import as_written, known_column, nearest_or_all
from quickreturn.cases.files.shown import Cell, Printable
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.cycle import EXTREMES, VIBRATION
from quickreturn.cases.motion.measure import Measure
from quickreturn.cases.motion.request import Run
from quickreturn.computing import checked, workshop
from quickreturn.engines.registry import MAIN
from quickreturn.engines.trajectory import Trajectory
from quickreturn.readings import readings
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.solution import framed
from quickreturn.verdict_text import parts_of

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.reports.drawing.style import Drawing
    from quickreturn.reports.report import Written

#: Numbers of a channel, as columns of `CrossValidation.frame`.
_NUMBERS = (*VIBRATION, *EXTREMES)


class CrossValidation(Printable):
    """Results of some engines on some cases.

    `passed` says whether all engines delivered and agree within their claims, `departures` where they disagree:

        assert results.passed, results.departures

    Attributes:
        results: for each case its runs by engine, the comparisons (`checks`), and the verdict.
        notices: sentences on damaged stored results, or on results that could not be stored.
    """

    def __init__(self, results: Sequence[CaseResult], notices: Sequence[str] = ()) -> None:
        self.results, self.notices = tuple(results), tuple(notices)

    @property
    def passed(self) -> bool | None:
        """Whether all engines delivered and none departs from another by more than both claim; None if nothing could be judged."""
        judged = [passed for result in self.results if (passed := result.with_tables.passed) is not None]
        return all(judged) if judged else None

    @property
    def departures(self) -> dict[tuple[str, str, str], list[Difference]]:
        """(case, engine, the engine or table that it departs from) -> the numbers that differ by more than both claim.

        Each has the measured quantity (`quantity`, `half`, `channel`), the `difference` and the `tolerance`, and both numbers: `number`
        and `other_number`, with `value`, `estimate` and `uncertainty`. Empty if no engine departs; `passed` is None if none could be
        judged.
        """
        by_case = {result.case.name: result.with_tables.departures for result in self.results}
        return {(case, *pair): checks for case, pairs in by_case.items() for pair, checks in pairs.items()}

    def __getitem__(self, place: tuple[str, str]) -> Run:
        """The run of an engine on a case: `runs["thesis-24", "mujoco"]`. LookupError: there is none."""
        if not (isinstance(place, tuple) and len(place) == 2):
            raise LookupError(f'{as_written(place)}: give case and engine, such as ["thesis-24", "mujoco"]')
        case, name = place
        results = {result.case.name: result for result in self.results}
        for given, available in ((case, results), (name, results[case].runs if case in results else {})):
            if given not in available:
                raise LookupError(f"{as_written(given)}: not among these results; {nearest_or_all(given, tuple(available))}")
        return results[case].runs[name]

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        """Completions that a notebook offers after `runs["`."""
        return [(result.case.name, engine) for result in self.results for engine in result.runs]

    @property
    def frame(self) -> "pd.DataFrame":
        """A row for each case, engine, half and channel; each number with its error estimate, in the unit of the last column, or Hz."""
        import pandas as pd

        rows = [
            {"case": result.case.name, "engine": name, "half": measure.half, "channel": measure.channel}
            | {f"{name}{of}": getattr(measure, f"{name}{of}") for name in _NUMBERS for of in ("", "_estimate")}
            | {"unit": COLUMNS[measure.channel].unit}
            for result in self.results
            for name, run in result.runs.items()
            for measure in run.measured.measures
        ]
        table = pd.DataFrame(rows)
        table.attrs["units"] = {name: "Hz" if "frequency" in name else "see unit" for name in table.columns if name.startswith(_NUMBERS)}
        return table

    @property
    def loads(self) -> "pd.DataFrame":
        """Loads on the parts: a row for each case, engine and quantity, in SI units, with its error, place and crank angle (rad)."""
        import pandas as pd

        return pd.DataFrame([{"case": result.case.name} | row for result in self.results for row in readings()["loads"].rows(result)])

    @property
    def numbers(self) -> "pd.DataFrame":
        """Every measure of the catalogue: a row for each case, engine and measure (`qr.measures()`), in SI units; nan where unavailable."""
        import pandas as pd

        rows = [
            {"case": result.case.name, "engine": engine, "measure": name}
            | {"value": found.value, "error": found.error, "unit": MEASURES[name].unit}
            for result in self.results
            for engine, run in result.runs.items()
            for name, found in numbers(result.case.mechanism, run).items()
        ]
        return pd.DataFrame(rows)

    def cycle(self, case: str, engine: str) -> "pd.DataFrame":
        """The last cycle of an engine on a case, from the slider's farthest place to the next. LookupError: there is none."""
        columns = self[case, engine].cycle
        if not columns:
            raise LookupError(f"{engine} has no cycle of {case}: {self[case, engine].remark}")
        return framed(Trajectory(dict(columns), 0.0), case=case, engine=engine)

    def plot(self, *columns: str) -> "Drawing":
        """Draw the last cycles of all engines over each other, a panel for each case and column; without columns the tip's acceleration.

        Raises:
            UnknownColumn: there is none of this name.
        """
        from quickreturn.reports.drawing.cycle import draw

        return draw(self.results, [known_column(name, COLUMNS) for name in columns] or ["tip_acceleration"])

    def _parts(self) -> Iterator[Cell]:
        for result in self.results:
            yield from parts_of(result)


def measures() -> "Listing[Measure]":
    """The measures of a settled motion: name, unit, meaning."""
    return Listing.of(MEASURES.values(), name=lambda each: each.name, unit=lambda each: each.unit, meaning=lambda each: each.meaning)


def run(
    cases: AnyCase | Iterable[AnyCase],
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]" = MAIN,
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> CrossValidation:
    """Bring engines to their steady state on cases, each in a process of its own, measure and compare. Each result is stored at once.

    Args:
        cases: names, paths, patterns ("thesis-2*") or `Case` objects, one or several.
        engines: names, or engines that are installed, one or several; default: the four main ones. Paths of recorded tables (.csv) may
            stand among them.
        accuracy: relative error of the tip deflection asked of every engine; None: each engine's default.
        settings: settings by engine: {"mujoco": {"links": 16}}.
        jobs: how many processes at a time; None: one per core.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument, or a scene that an engine cannot model; nothing has run.
        StoreError: the folder of results cannot be used.
        KeyboardInterrupt: Ctrl-C; finished results are kept.
    """
    chosen = loaded(cases)
    names, texts, tables = prepared(chosen, engines, given_settings(settings))
    with workshop(jobs, quiet, chosen, names) as opened:
        results = cross_validate(chosen, opened, names, checked(accuracy), texts, tables)
    return CrossValidation(results, opened.store.notices)


def report(
    cases: AnyCase | Iterable[AnyCase],
    folder: "str | os.PathLike[str]" = "reports/output",
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]" = MAIN,
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> Path:
    """Write the report on cases: a page, and its tables as CSV beside it. Each result is stored at once.

    `folder` is created if it is missing; the other arguments are those of `run`.

    Returns:
        The page.

    Raises:
        CaseError, SettingError, StoreError, KeyboardInterrupt: as `run`.
        OutputError: the folder cannot be written to.
    """
    return written_report(cases, folder, engines, accuracy=accuracy, settings=settings, jobs=jobs, quiet=quiet).page


def written_report(
    cases: AnyCase | Iterable[AnyCase],
    folder: "str | os.PathLike[str]",
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> "Written":
    """As `report`; what was written, with the runs that failed."""
    from quickreturn.reports.report import write_report

    chosen = loaded(cases)
    names, texts, tables = prepared(chosen, engines, given_settings(settings))
    with workshop(jobs, quiet, chosen, names) as opened:
        return write_report(chosen, Path(folder), opened, names, tables, checked(accuracy), texts)
