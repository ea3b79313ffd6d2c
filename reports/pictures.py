"""All pictures of the report: from the store where they are there, else drawn in processes of their own, one per case."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any, Final

import pandas as pd

from cases.benchmark import Benchmark
from cases.experiment import AxisLabels, MeasuredCurve, axis_labels
from cases.jobs.job import Job, Limits
from cases.jobs.workshop import Workshop
from cases.runs.comparison import CaseResult
from cases.studies import Studies
from reports.findings.runs import run_number
from reports.plots.picture import Picture

#: Pictures of one case, in the order of the page.
OF_CASE: Final = ("cycle", "mechanism", "forces", "spectrogram")
#: Pictures of all cases together.
OF_ALL: Final = ("overview", "heat_map")
#: Pictures of the studies.
OF_STUDIES: Final = ("convergence", "sensitivity")

_LIMITS: Final = Limits(seconds=600.0)  # drawing takes a few seconds
#: Everything in the project may leave its mark on a picture, and so may these libraries.
_CODE: Final = ("cases", "reports")
_LIBRARIES: Final = ("matplotlib", "pandas", "pillow")

Drawn = dict[str, Picture | None]


@dataclass(frozen=True)
class Pictures:
    """What was drawn; None for a picture that has nothing to show.

    Attributes:
        of_all: name of `OF_ALL` or `OF_STUDIES`, or "work precision CASE" and "freedom CASE" of a benchmark -> picture.
        of_case: case -> name of `OF_CASE` -> picture.
        failures: sentences on what could not be drawn.
    """

    of_all: Drawn = field(default_factory=dict)
    of_case: dict[str, Drawn] = field(default_factory=dict)
    failures: tuple[str, ...] = ()


def draw_pictures(
    results: Sequence[CaseResult],
    studies: Studies | None,
    benchmarks: Sequence[Benchmark],
    curves: Sequence[MeasuredCurve],
    workshop: Workshop,
) -> Pictures:
    """All pictures of the page.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was drawn is stored.
    """
    jobs: list[Job[Drawn]] = [_job("all cases", draw_all, (list(results),))]
    if studies is not None:
        tables = (studies.convergence, studies.sensitivity)
        jobs.append(_job("the studies", draw_studies, tables, [table.to_csv() for table in tables]))
    if benchmarks:
        jobs.append(_job("the methods", draw_methods, (list(benchmarks),), {table.case: table.points for table in benchmarks}))
    together = len(jobs)
    jobs += jobs_of_cases(results, curves)
    outcomes = workshop.outcomes(jobs, "pictures")
    failures = [f"pictures of {outcome.job.name}: drawing {outcome.explanation}" for outcome in outcomes if not outcome.completed]
    of_all: Drawn = {}
    for outcome in outcomes[:together]:
        of_all |= outcome.value or {}
    return Pictures(of_all, {outcome.job.name: outcome.value for outcome in outcomes[together:] if outcome.value}, tuple(failures))


def jobs_of_cases(results: Sequence[CaseResult], curves: Sequence[MeasuredCurve]) -> list[Job[Drawn]]:
    """Those of the pictures that show one case alone."""
    return [_job(result.case.name, draw_case, (result, *_of_run(result, curves))) for result in results]


def _job(name: str, function: Callable[..., Drawn], arguments: tuple[Any, ...], inputs: Any = None) -> Job[Drawn]:
    determined_by = [arguments if inputs is None else inputs, [metadata.version(library) for library in _LIBRARIES]]
    return Job(name, function, arguments, kind="pictures", code=_CODE, inputs=determined_by, limits=_LIMITS)


def draw_case(result: CaseResult, labels: Sequence[AxisLabels], curves: Sequence[MeasuredCurve]) -> Drawn:
    """The pictures `OF_CASE` of a case."""
    from cases.measures import time_scale
    from reports.plots.cycle import cycle_figure
    from reports.plots.forces import force_figure
    from reports.plots.mechanism import mechanism_figure
    from reports.plots.spectrogram import spectrogram_figure

    return {
        "cycle": cycle_figure(result, labels, curves),
        "mechanism": mechanism_figure(result),
        "forces": force_figure(result),
        "spectrogram": spectrogram_figure(result, time_scale(result.case.mechanism)),
    }


def draw_all(results: Sequence[CaseResult]) -> Drawn:
    """The pictures `OF_ALL`."""
    from reports.plots.heat_map import heat_map_figure
    from reports.plots.overview import overview_figure

    return {"overview": overview_figure(results), "heat_map": heat_map_figure(results)}


def draw_methods(benchmarks: Sequence[Benchmark]) -> Drawn:
    """Work precision and degrees of freedom of each scene."""
    from reports.plots.work_precision import work_freedom_figure, work_precision_figure

    drawn: Drawn = {}
    for table in benchmarks:
        drawn[f"work precision {table.case}"] = work_precision_figure(table)
        drawn[f"freedom {table.case}"] = work_freedom_figure(table)
    return drawn


def draw_studies(convergence: pd.DataFrame, sensitivity: pd.DataFrame) -> Drawn:
    """The pictures `OF_STUDIES`; the tables are those of `cases.studies.Studies`."""
    from reports.plots.convergence import convergence_figure
    from reports.plots.sensitivity import sensitivity_figure

    return {
        "convergence": convergence_figure(convergence),
        "sensitivity": sensitivity_figure(sensitivity),
    }


def _of_run(result: CaseResult, curves: Sequence[MeasuredCurve]) -> tuple[tuple[AxisLabels, ...], list[MeasuredCurve]]:
    number = run_number(result.case.name) if result.case.source == "library" else None
    if number is None:
        return (), []
    return axis_labels(number), [curve for curve in curves if curve.run == number]
