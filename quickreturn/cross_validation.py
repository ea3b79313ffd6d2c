"""Engines on cases in their steady state, measured, compared and held to what they claim; and the report on that."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.case import Case
from cases.errors import as_written, nearest_or_all
from cases.jobs.processes import PRELOAD, LocalProcesses
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from cases.library import CatalogueLine
from cases.runs.comparison import CaseResult, cross_validate
from cases.runs.request import Run
from engines.base import AnyEngine, Engine, Refusal
from engines.registry import MAIN, engine
from engines.settings import SettingError, as_texts
from engines.trajectory import Trajectory
from quickreturn.accuracy import checked
from quickreturn.catalogue import loaded
from quickreturn.solution import framed, known_column
from reference_model.columns import COLUMNS

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.curves import Drawing

AnyCase = str | Case | CatalogueLine

#: Of a measure, in the order of the table.
_NUMBERS = ("first_mode_frequency", "first_mode_amplitude", "minimum", "maximum")


class CrossValidation:
    """What came of some engines on some cases.

    Attributes:
        results: of each case: its runs by engine, the comparisons, and what became of the claims.
        notices: sentences on stored results that were damaged or could not be written.
    """

    def __init__(self, results: Sequence[CaseResult], notices: Sequence[str] = ()) -> None:
        self.results, self.notices = tuple(results), tuple(notices)

    @property
    def passed(self) -> bool | None:
        """Whether no engine departs from another by more than both claim, and all delivered; None if nothing could be judged."""
        judged = [result.passed for result in self.results if result.passed is not None]
        return all(judged) if judged else None

    def __getitem__(self, place: tuple[str, str]) -> Run:
        """All that is known of an engine on a case: `runs["thesis-24", "mujoco"]`. LookupError: there is none."""
        case, name = place
        results = {result.case.name: result for result in self.results}
        for given, known in ((case, results), (name, results[case].runs if case in results else {})):
            if given not in known:
                raise LookupError(f"{as_written(given)}: not among these results; {nearest_or_all(given, tuple(known))}")
        return results[case].runs[name]

    @property
    def frame(self) -> "pd.DataFrame":
        """A row for each case, engine, half and channel; each number with its error estimate, in the unit of the last column, or Hz."""
        import pandas as pd

        rows = [
            {"case": result.case.name, "engine": name, "half": measure.half, "channel": measure.channel}
            | {key: value for number in _NUMBERS for key, value in _with_estimate(measure, number)}
            | {"unit": COLUMNS[measure.channel].unit}
            for result in self.results
            for name, run in result.runs.items()
            for measure in run.measures
        ]
        table = pd.DataFrame(rows)
        table.attrs["units"] = {name: "Hz" if "frequency" in name else "see unit" for name in table.columns if name.startswith(_NUMBERS)}
        return table

    def cycle(self, case: str, engine: str) -> "pd.DataFrame":
        """The last cycle of an engine on a case, from the slider's farthest place to the next. LookupError: there is none."""
        columns = self[case, engine].cycle
        if not columns:
            raise LookupError(f"{engine} has no cycle of {case}: {self[case, engine].remark}")
        return framed(Trajectory(dict(columns), 0.0), case=case, engine=engine)

    def plot(self, *columns: str) -> "Drawing":
        """The last cycles of all engines over each other, a row of panels for each case; without columns the tip's acceleration.

        Raises:
            UnknownColumn: there is none of this name.
        """
        from quickreturn.curves import stacked

        chosen = [known_column(name, COLUMNS) for name in columns] or ["tip_acceleration"]
        cycles = {result.case.name: {name: run.cycle for name, run in result.runs.items() if run.cycle} for result in self.results}
        return stacked(cycles, chosen)

    def __repr__(self) -> str:
        from quickreturn.verdict_text import text_of

        return "\n".join(text_of(result) for result in self.results)


def _with_estimate(measure: Any, number: str) -> Iterable[tuple[str, float | None]]:
    yield number, measure.number(number)
    yield f"{number}_estimate", measure.estimate(number)


def run(
    cases: AnyCase | Iterable[AnyCase],
    engines: "str | AnyEngine | Iterable[str | AnyEngine]" = MAIN,
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    workshop: Workshop | None = None,
) -> CrossValidation:
    """Bring engines to their steady state on cases, each in a process of its own, measure and compare. Results are kept as they come.

    Args:
        cases: names, paths, patterns ("thesis-2*") or `Case`s, one or several.
        engines: names, or engines that are installed, one or several; default: the four main ones.
        accuracy: relative error of the tip deflection asked of every engine; None: each engine's default.
        settings: of an engine, by its name: {"mujoco": {"links": 16}}.
        workshop: where it is computed and kept; None: see `opened`.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: something cannot be; nothing has run then.
        StoreError: the folder of results cannot be used.
        KeyboardInterrupt: Ctrl-C; what was computed is kept.
    """
    chosen, names = loaded(cases), engine_names(engines)
    texts = {name: as_texts(values) for name, values in (settings or {}).items()}
    check_settings(chosen, names, texts)
    place = workshop or opened()
    results = cross_validate(chosen, place, names, checked(accuracy), texts)
    return CrossValidation(results, place.store.notices)


def report(
    cases: AnyCase | Iterable[AnyCase], folder: "str | os.PathLike[str]" = "reports/output", *, workshop: Workshop | None = None
) -> Path:
    """Write the report on cases: a page, and its tables as CSV beside it. Results are kept as they come.

    Args:
        cases: as of `run`.
        folder: is created where it is missing.
        workshop: as of `run`.

    Returns:
        The page.

    Raises:
        CaseError, StoreError, KeyboardInterrupt: as `run`.
        OutputError: the folder cannot be written to.
    """
    from reports.report import write_report

    return write_report(loaded(cases), Path(folder), workshop or opened(preload=DRAWING)).page


#: What workers need besides where pictures are drawn.
DRAWING = ("reports.pictures", "matplotlib.figure")


def opened(jobs: int | None = None, *, quiet: bool = False, preload: Sequence[str] = ()) -> Workshop:
    """The store of results and the processes of this machine.

    Args:
        jobs: how many processes at a time; None: one per core.
        quiet: whether nothing is shown on standard error meanwhile.
        preload: modules that workers need besides.

    Raises:
        StoreError: the folder of results, `.quickreturn` or what `QUICKRETURN_STORE` names, cannot be used.
    """
    return Workshop(Store(), LocalProcesses(jobs, preload=(*PRELOAD, *preload), quiet=quiet))


def engine_names(engines: "str | AnyEngine | Iterable[str | AnyEngine]") -> list[str]:
    """Names of engines that are installed, each once.

    Raises:
        UnknownEngine: there is none of this name; also of an engine that no other process could find.
    """
    each = [engines] if isinstance(engines, (str, Engine)) else engines
    names = list(dict.fromkeys(one.name if isinstance(one, Engine) else one for one in each))
    for name in names:
        engine(name)
    return names


def check_settings(cases: Sequence[Case], names: Sequence[str], settings: Mapping[str, Mapping[str, str]]) -> None:
    """Find out before anything runs whether settings can be.

    Raises:
        SettingError: an engine that is not among those that run, or a setting that it does not have or take.
    """
    for name, texts in settings.items():
        if name not in names:
            key = next(iter(texts), "")
            raise SettingError(f"{name}.{key}: engine {name} is not among those that run; these are {', '.join(names)}")
        for case in cases if texts else ():
            chosen = engine(name)
            try:
                chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(texts))
            except SettingError as error:  # several engines may share the settings, and one of them may lack one
                raise SettingError(f"{error} (engine {name})" if len(names) > 1 else str(error)) from error


def check_engines(names: Iterable[str]) -> None:
    """Find out before anything runs whether engines can be used here.

    Raises:
        UnknownEngine, Refusal: one cannot.
    """
    for name in names:
        if reason := engine(name).unavailable():
            raise Refusal(f"--engine {name}: {reason}")
