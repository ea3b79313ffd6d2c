"""All pictures of the report: from the store where they are there, else drawn in processes of their own, one per case."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd

from cases.benchmark import Benchmark
from cases.comparison import CaseResult
from cases.experiment import AxisLabels, MeasuredCurve, axis_labels
from cases.store import Entry, Store
from cases.stored_jobs import Result, stored
from cases.studies import Studies
from cases.workers import PRELOAD, Job, Limits, Outcome
from reports.cache import content_of, content_of_curves, page_key
from reports.findings.runs import run_number
from reports.plots.picture import Picture

#: Pictures of one case, in the order of the page.
OF_CASE: Final = ("cycle", "mechanism", "forces", "spectrogram")
#: Pictures of all cases together.
OF_ALL: Final = ("overview", "heat_map")
#: Pictures of the studies.
OF_STUDIES: Final = ("convergence", "sensitivity")

_LIMITS: Final = Limits(seconds=600.0)  # drawing takes a few seconds
_PRELOAD: Final = (*PRELOAD, "matplotlib.figure", "reports.pictures")
_ALL: Final = "all cases"
_STUDIES: Final = "the studies"
_METHODS: Final = "the methods"

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
    store: Store,
    jobs: int | None = None,
) -> Pictures:
    """All pictures of the page.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was drawn is stored.
    """
    work: list[Job] = []
    inputs: dict[str, Any]
    everything = [content_of(result) for result in results]
    orders: list[tuple[str, Mapping[str, Any], Job]] = [(_ALL, {"results": everything}, Job(_ALL, draw_all, (list(results),)))]
    if studies is not None:
        tables = {name: getattr(studies, name) for name in ("convergence", "sensitivity")}
        texts: dict[str, Any] = {name: table.to_csv() for name, table in tables.items()}
        orders.append((_STUDIES, texts, Job(_STUDIES, draw_studies, tuple(tables.values()))))
    if benchmarks:
        points = {table.case: table.points for table in benchmarks}
        orders.append((_METHODS, points, Job(_METHODS, draw_methods, (list(benchmarks),))))
    for result, content in zip(results, everything, strict=True):
        labels, its_curves = _of_run(result, curves)
        inputs = {"result": content, "labels": labels, "curves": content_of_curves(its_curves)}
        orders.append((result.case.name, inputs, Job(result.case.name, draw_case, (result, labels, its_curves))))
    names = {}
    for name, determined_by, job in orders:
        key = page_key(f"pictures of {name if name in (_ALL, _STUDIES, _METHODS) else 'a case'}", determined_by)
        names[key] = name
        work.append(Job(key, job.function, job.arguments))
    entries, others = stored(work, store, "pictures", at_once=jobs, limits=_LIMITS, keep=_kept, preload=_PRELOAD)
    found = {names[key]: _unpacked(entry) for key, entry in entries.items()}
    failures = [f"pictures of {names[key]}: drawing {outcome.explanation}" for key, outcome in others.items()]
    of_all = found.pop(_ALL, {}) | found.pop(_STUDIES, {}) | found.pop(_METHODS, {})
    return Pictures(of_all, found, tuple(failures))


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


def _kept(outcome: Outcome) -> Result | None:
    return _packed(outcome.value) if outcome.completed else None


def _packed(drawn: Drawn) -> tuple[dict[str, Any], dict[str, Any]]:
    document: dict[str, Any] = {}
    arrays = {}
    for name, shown in drawn.items():
        document[name] = None
        if shown is not None:
            document[name] = {"mime": shown.mime, "width": shown.width, "height": shown.height, "alt": shown.alt}
            arrays[name] = np.frombuffer(shown.data, dtype=np.uint8)
    return document, arrays


def _unpacked(entry: Entry) -> Drawn:
    return {name: None if about is None else Picture(data=entry.arrays[name].tobytes(), **about) for name, about in entry.document.items()}
