"""One engine on one case: its trajectory from the standard start, with error estimates, and its natural frequencies."""

import math
import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from quickreturn.arguments import AnyCase, engine_given, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import known_column
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.motion.solving import Answer, TrajectoryRequest, frequencies_job
from quickreturn.cases.running.display import compilation_announced
from quickreturn.cases.running.job import Job, T, ThisProcess
from quickreturn.cases.running.store import Store, StoreError
from quickreturn.cases.running.workshop import outcomes_of
from quickreturn.computing import checked
from quickreturn.dataset import dataset_of
from quickreturn.engines.accurate import NOT_ESTIMATED, Result
from quickreturn.engines.base import AnyEngine, Engine, EngineFailure
from quickreturn.engines.error_parts import ESTIMATED, TIP, ErrorPart
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.settings import as_texts
from quickreturn.engines.trajectory import Trajectory, rms
from quickreturn.readings import readings
from quickreturn.reference_model.columns import AXIAL, BEARINGS, BENDING, COLUMNS
from quickreturn.reference_model.native import cache_folder
from quickreturn.reports.output import check_writable, write_file
from quickreturn.reports.words import ESTIMATE, settings_words

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from quickreturn.arguments import AnyEngineOrTable
    from quickreturn.reports.drawing.style import Drawing


@dataclass(frozen=True, repr=False, eq=False)
class Solution(Printable):
    """A trajectory with its error estimates.

    Attributes:
        case: what was simulated.
        engine: name of the engine.
        version: version of the library behind it.
        result: trajectory, settings, error estimates and times as the engine gave them.
        request: what was asked of the engine.
        store: store from which the readings come and to which they go; None: they are computed.
        stored: whether it comes from the store; its times are then those of its computation.
    """

    case: Case
    engine: str
    version: str
    result: Result
    request: TrajectoryRequest
    store: Store | None = None
    stored: bool = False

    @classmethod
    def of(cls, case: Case, request: TrajectoryRequest, answer: Answer, store: Store | None, stored: bool) -> "Solution":
        """The solution of an answer. EngineFailure: the run failed."""
        version, result = answer
        if isinstance(result, EngineFailure):
            raise result
        return cls(case, engine_from(request.engine).name, version, result, request, store, stored)

    @property
    def trajectory(self) -> Trajectory:
        """The observables as plain arrays."""
        return self.result.trajectory

    @cached_property
    def frame(self) -> "pd.DataFrame":
        """The trajectory as a table, a row for each output step; `.attrs["units"]`: column -> unit."""
        return framed(self.trajectory, case=self.case.name, engine=self.engine, version=self.version)

    @property
    def estimates(self) -> "pd.Series[float]":
        """Estimated error of each column, RMS relative to its `scale`, for most the column's RMS; NaN where unknown."""
        import pandas as pd

        of = {"total": "error", "integration": "integration error", "unverified": "error, not verified"}[self.result.estimate_of]
        return pd.Series(self.result.error_estimates, dtype=float, name=of)

    @property
    def error_parts(self) -> tuple[ErrorPart, ...]:
        """The parts that add up to the error estimate of the tip deflection, each with the two runs that show it; empty if unknown.

        `result.error_parts` has those of every column, with the settings that differ from `settings`.
        """
        return tuple(part.complete(self.settings) for part in self.result.error_parts.get(TIP, ()))

    @cached_property
    def readings(self) -> dict[str, Any]:
        """What plugins read off the trajectory, by name."""
        return {name: value_here(each.job(self.request, self.result), self.store)[0] for name, each in readings().items()}

    @property
    def loads(self) -> Any:
        """Loads on the parts: stress along the arm, forces in joints and bearings; estimates are the columns' largest errors."""
        return self.readings["loads"]

    @property
    def settings(self) -> dict[str, Any]:
        """Settings of the engine in this run."""
        return self.result.settings

    @property
    def reached(self) -> bool:
        """Whether the estimate is within the accuracy; if not, `remark` says why."""
        return self.result.reached

    @property
    def remark(self) -> str:
        """A sentence if the run missed the accuracy or failed, or if a run for its estimate is missing; otherwise empty."""
        return self.result.remark

    def __getitem__(self, column: str) -> "pd.Series[float]":
        """A column. UnknownColumn: there is none of this name."""
        return self.frame[known_column(column, self.trajectory.columns)]

    def _ipython_key_completions_(self) -> list[str]:
        """Completions that a notebook offers after `solution["`."""
        return list(self.frame.columns)

    def to_xarray(self) -> "xr.Dataset":
        """The trajectory as an xarray dataset over `time`, with units and error estimates as attributes, which netCDF keeps."""
        return dataset_of(self.case, self.engine, self.version, self.result)

    def plot(self, *columns: str) -> "Drawing":
        """Draw columns over time; without any, the deflection and the acceleration of the tip, the middle strain and the slider force.

        Raises:
            UnknownColumn: there is none of this name.
        """
        from quickreturn.reports.drawing.curves import curves

        return curves({self.engine: self.trajectory.columns}, columns, title=f"{self.case.name}: {self.case.title}", units=self.case.units)

    def animate(self, path: "str | os.PathLike[str]", magnify: float | None = None) -> None:
        """Write a moving picture: a .webp, a .gif or, by ffmpeg, an .mp4 of the last turn, or a .html page.

        Args:
            path: of the file.
            magnify: factor of the deflection in a picture; None: a round factor that makes the deflection visible.

        Raises:
            OutputError: another ending, or it cannot be written.
            UnknownColumn: the engine does not give the follower's shape.
            CaseError: a page was asked for, and the case has no crank; or ffmpeg fails.
            MissingExtra: ffmpeg is not installed.
        """
        from quickreturn.reports.drawing.mechanism import moving
        from quickreturn.reports.output import MOVING

        check_writable(place := Path(path), "", *MOVING)
        write_file(place, moving(self.case, {self.engine: self.trajectory}, place.suffix.lower(), magnify))

    def rows(self, kept: str = "", notes: str = "its `notes`") -> Iterator[tuple[str, Cell]]:
        """The rows of its table: a name, and a text or rows.

        Args:
            kept: the file that has the trajectory's rows, if any.
            notes: words that say where the notes on the case are.
        """
        result = self.result
        times = {part: getattr(result, f"{part}_seconds") for part in ("compile", "setup", "solve", "estimate")}
        yield "case", self.case.name
        yield "engine", f"{self.engine} ({self.version})"
        if self.case.notes:
            yield "notes", f"{len(self.case.notes)} on this case: see {notes}"
        yield "rows", f"{len(self.trajectory)}{kept and ' in '}{kept}"
        if self.remark != NOT_ESTIMATED:
            yield self._estimates()
        if self.error_parts:
            yield "shown by", Rows([(f"{part}",) for part in self.error_parts])
        if doubtful := [name for name, estimate in result.error_estimates.items() if estimate is not None and estimate > 1.0]:
            yield "doubtful", f"{', '.join(doubtful)}: the error may be larger than the column itself"
        for name, each in readings().items():
            yield from each.of_simulation(self.case, result, self.readings[name])
        then = " (comes from the store; times of its computation)" if self.stored else ""
        yield "times", " + ".join(f"{seconds:.3g} s {part}" for part, seconds in times.items()) + then
        yield "settings", settings_words(self.settings)
        if result.further_run_skipped:
            yield "compared", "with one finer run; a second was skipped, for all columns converge alike"
        if self.remark:
            yield "remark", self.remark

    def _estimates(self) -> tuple[str, Rows]:
        """Error estimates, relative and in their units: those of `ESTIMATED`, and the largest of the moments and of the bearing forces.

        For a rigid follower the first is that of the tip's place.
        """
        result = self.result
        name, remark = ESTIMATE[result.estimate_of]
        wanted = "" if result.accuracy is None else f"asked: {result.accuracy:g}"
        rows = []
        for column in (each for each in ESTIMATED if each in self.trajectory.columns):
            relative, size = result.error_estimates[column], rms(self.trajectory[column])
            unit = self.case.units.of(COLUMNS[column].unit)
            words = column.removeprefix("tip_").removeprefix("slider_").replace("_", " ")
            if column == "tip_deflection" and relative is None and result.error_estimate is not None:
                relative, size, words = result.error_estimate, self.case.scene.follower.length, "tip's place"
            about = "; ".join(filter(None, (wanted, remark))) if column == "tip_deflection" else ""
            sizes = ("unknown", "") if relative is None else (f"{relative:.1e}", unit.text(relative * size, ".1e"))
            rows.append((words, *sizes, about))
        for words, columns in (("moments", BENDING), ("normal forces", AXIAL), ("bearings", BEARINGS)):
            if estimates := [estimate for column in columns if (estimate := result.error_estimates.get(column)) is not None]:
                rows.append((words, f"{max(estimates):.1e}", "", "at most"))
        return name, Rows(rows, ("of", "relative", "RMS", ""))

    def _parts(self) -> Iterator[Cell]:
        yield Rows(list(self.rows()))


def simulate(
    case: AnyCase,
    engine: "AnyEngineOrTable" = "reference",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Any] | None = None,
    estimate: bool = True,
    time_limit: float | None = None,
    store: bool = True,
    quiet: bool = False,
) -> Solution:
    """Simulate a case from its standard start, in this process; an earlier result comes from the store.

    Args:
        case: a name, a path or a `Case`.
        engine: a name, the path of a file that declares one, or an engine, for example one of your own.
        accuracy: relative error of the tip deflection asked for; None: the engine's default.
        settings: settings of the engine, by name; they are used as they are, and the error is still estimated.
        estimate: False: make one run without the runs for an error estimate; its error is then unknown.
        time_limit: wall time (s) within which to answer: runs for the error estimate that could take longer are not begun. None: no limit.
        store: False: compute it anew, and store nothing. Results of an engine that is not given by its name are not stored.
        quiet: whether messages on standard error are left out while code is compiled, which happens once on a machine.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument, or a scene that the engine cannot model.
        ValueError: `accuracy` is out of range, or is given without an estimate.
        EngineFailure: the run failed; `partial` holds the trajectory up to then.
    """
    engine = engine_given(engine)
    chosen, scene = engine_from(engine), one_case(case)
    if sentence := cache_folder.warning_if_not_kept():
        warnings.warn(sentence, stacklevel=2)
    request = request_of(scene, engine, as_texts(settings or {}), checked(accuracy), estimate, time_limit)
    kept = opened_store() if store else None
    with compilation_announced(quiet):
        answer, stored = value_here(request.job(chosen.name), kept)
    return Solution.of(scene, request, answer, kept, stored)


def modes(
    case: AnyCase,
    engine: "AnyEngineOrTable" = "reference",
    crank_angle: float | Sequence[float] = 0.0,
    *,
    count: int = 4,
    settings: Mapping[str, Any] | None = None,
    store: bool = True,
    quiet: bool = False,
) -> "pd.DataFrame":
    """Natural frequencies in Hz, a row for each crank angle: follower straight, at rest, no gravity, undamped.

    Args:
        case: a name, a path or a `Case`.
        engine: a name, the path of a file that declares one, or an engine.
        crank_angle: angle at which the crank is held, degrees; one or several.
        count: largest number of frequencies; there are fewer columns if the model has fewer.
        settings: of the engine, by name; None: those for its default accuracy.
        store: False: compute them anew, and store nothing.
        quiet: whether messages on standard error are left out while code is compiled.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument, or a scene that the engine cannot model.
        EngineFailure: the engine failed, or returned something other than natural frequencies.
        ValueError: an invalid crank angle or count.
    """
    import pandas as pd

    given = np.atleast_1d(np.asarray(crank_angle))
    if given.dtype.kind not in "iuf" or not np.all(np.isfinite(given)):
        raise ValueError(f"crank_angle={crank_angle!r}: degrees are needed, a number or several")
    if not (isinstance(count, int) and count > 0):
        raise ValueError(f"count={count!r}: a whole number from 1 on is needed")
    angles = given.tolist()
    engine = engine_given(engine)
    scene, chosen, texts = one_case(case), engine_from(engine), as_texts(settings or {})
    job = frequencies_job(chosen.name, scene.mechanism, engine, [math.radians(angle) for angle in angles], count, texts)
    with compilation_announced(quiet):
        answer, _ = value_here(job, opened_store() if store else None)
    table = pd.DataFrame(answer.values, index=pd.Index(angles, name="crank angle [deg]"))
    table.columns = pd.Index([f"mode {number} [Hz]" for number in range(1, table.shape[1] + 1)])
    table.attrs.update(case=scene.name, engine=chosen.name, version=answer.version, settings=answer.settings)
    return table


def request_of(
    case: Case, engine: "str | AnyEngine", settings: dict[str, str], accuracy: float | None, estimate: bool, time_limit: float | None
) -> TrajectoryRequest:
    """The request for a case's trajectory from the standard start; arguments as of `simulate`."""
    how: dict[str, Any] = {"settings": settings, "accuracy": accuracy, "estimate": estimate, "time_limit": time_limit}
    return TrajectoryRequest(scene=case.scene, duration=case.duration, output_step=case.output_step, engine=engine, **how)


def value_here(job: Job[T], store: Store | None) -> tuple[T, bool]:
    """The value of a job in this process, and whether it was in the store. Raises as the job."""
    [outcome] = outcomes_of([job], "", ThisProcess(), store)
    if outcome.error is not None:
        raise outcome.error
    assert outcome.value is not None
    return outcome.value, outcome.stored


def opened_store(tell: Callable[[str], object] = warnings.warn) -> Store | None:
    """The store of results, or None with a message if it cannot be used."""
    try:
        return Store(tell=tell)
    except StoreError as error:
        tell(str(error))
        return None


def engine_from(engine: "str | AnyEngine") -> AnyEngine:
    """A usable engine by its name; an engine is returned as it is. UnknownEngine: there is none. Refusal: it cannot be used here."""
    given = engine_given(engine)
    return given if isinstance(given, Engine) else usable_engine(given)


def framed(trajectory: Trajectory, **about: str) -> "pd.DataFrame":
    """A trajectory as a table; its `attrs` hold the `units` and the keywords `about`."""
    table = trajectory.table()
    table.attrs.update(units={name: COLUMNS[name].unit for name in table.columns}, **about)
    return table


def as_csv(trajectory: Trajectory) -> bytes:
    """A trajectory as CSV: every number is the shortest text that reads back as the same number."""
    names = [name for name in COLUMNS if name in trajectory.columns]
    rows = zip(*(trajectory[name].tolist() for name in names), strict=True)
    return "".join(f"{','.join(line)}\n" for line in ([*names], *(map(repr, row) for row in rows))).encode("ascii")
