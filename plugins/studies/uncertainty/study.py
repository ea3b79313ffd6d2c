"""The scatter of measures due to uncertain quantities, which an argument, a study file or the tolerances of a case file describe."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from quickreturn.arguments import AnyCase, check, given_settings, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import Argument, CaseError, as_written, attempted, nearest_or_all, texts_given, together
from quickreturn.cases.files.keys import SECTIONS
from quickreturn.cases.files.text_file import read_text, toml_of
from quickreturn.cases.library import in_library, load_case
from quickreturn.cases.motion.catalogue import measure
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.computing import HIGHEST, LOWEST, checked, workshop
from quickreturn.engines.registry import engine_names, is_engine, usable_engine
from quickreturn.plugins.studies.sweep.grid import OF_START, job
from quickreturn.plugins.studies.sweep.rows import MeasureRequest, Row
from quickreturn.plugins.studies.sweep.study import computed, joined
from quickreturn.plugins.studies.uncertainty.chaos import cube, least_points
from quickreturn.plugins.studies.uncertainty.parameters import Distribution, Parameter, changes, distribution
from quickreturn.plugins.studies.uncertainty.scatter import Scatter
from quickreturn.reference_model.arrays import Array

#: Least and largest number of points; a power of two keeps a Sobol' sequence balanced.
FEWEST: Final = 8
MOST: Final = 65536


@dataclass(frozen=True, eq=False)
class Points:
    """Points of a scrambled Sobol' sequence (A. B. Owen, Journal of Complexity 14, 1998, 466): twice as many contain the first ones."""

    case: Case
    distributions: Mapping[Parameter, Distribution]
    asked: MeasureRequest
    inputs: Array

    @cached_property
    def jobs(self) -> list[Job[Row]]:
        """A job for each point: neighbours in the sequence are none in the machine, so no point begins in the motion of another."""
        scene, name = self.case.mechanism, f"{self.asked.engine}, point {{}} of {len(self.inputs)}"
        points = (changes(scene, dict(zip(self.distributions, point, strict=True))) for point in self.inputs)
        return [replace(job(self.case, [point], self.asked), name=name.format(number)) for number, point in enumerate(points, 1)]

    def scatter(self, workshop: Workshop) -> Scatter:
        """Compute the points that are not stored. KeyboardInterrupt: Ctrl-C; finished points are stored."""
        asked, row = self.asked, joined(computed(self.jobs, workshop))
        numbers = row.values, row.errors, row.statuses, row.sentences
        return Scatter(self.case, self.distributions, asked.measures, self.inputs, *numbers, engine=asked.engine)


def check_samples(samples: int, source: str, key: str | None = "samples") -> None:
    """CaseError, which names `source`: it is no number of points."""
    if not FEWEST <= samples <= MOST or samples & (samples - 1):
        raise CaseError(source, key, str(samples), "is no power of two", f"from {FEWEST} to {MOST} are accepted, such as 256")


def planned(case: Case, uncertain: Mapping[str, Any], asked: MeasureRequest, samples: int, source: str) -> Points:
    """Quasi-random points, `samples` of them (a power of two), of distributions as texts by key (`uncertain`).

    CaseError, which names `source`: an unknown key, or an invalid distribution.
    """
    if not uncertain:
        raise CaseError(source, "uncertain", None, "names no parameter", 'write KEY = "uniform A .. B"')
    given = {Parameter.of_key(key, source): text for key, text in uncertain.items()}
    if of_start := next((parameter.key for parameter in given if parameter.key in OF_START), None):
        raise CaseError(source, of_start, None, "changes no steady motion", "leave its distribution or tolerance out")
    distributions = {parameter: distribution(text, parameter, source) for parameter, text in given.items()}
    points = cube(len(distributions), samples)
    inputs = np.column_stack([each.quantile(points[:, place]) for place, each in enumerate(distributions.values())])
    return Points(case, distributions, asked, inputs)


#: Key of a study file -> its types, and an example.
KEYS: Final[Mapping[str, tuple[tuple[type, ...], str]]] = {
    "case": ((str,), '"thesis-24"'),
    "measures": ((list,), '["post.frequency"]'),
    "uncertain": ((dict,), '{ "tip.mass" = "uniform 0 g .. 25 g" }'),
    "samples": ((int,), "256"),
    "engine": ((str,), '"reference"'),
    "accuracy": ((float,), "0.003"),
}
#: Number of points if none is given.
SAMPLES: Final = 256


def uncertainty(
    case: AnyCase | None,
    uncertain: Mapping[str, str] | str | os.PathLike[str] | None = None,
    measures: str | Sequence[str] = (),
    samples: int | None = None,
    *,
    engine: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
    claims: bool = True,
    accuracy: float | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> Scatter:
    """Measure the settled motion at quasi-random values of uncertain quantities.

    Args:
        case: a name, a path or a `Case`; None: that of the study file.
        uncertain: key of a case file -> distribution: "uniform 0 kg .. 0.3 kg", "log-uniform 1 N/m .. 1e3 N/m",
            "normal 2128 lbf*in^2 +- 4 %", or a tolerance, "6 mm +- 0.1 mm", within which every value is equally likely; or the path of a
            study file; None: the tolerances of the case file.
        measures: one name or several, see `qr.measures`.
        samples: number of points, a power of two; None: that of the study file, or 256.
        engine: name, or path of a file that declares one; None: that of the study file, or "reference".
        settings: of the engine, by name.
        claims: whether every number gets the simulation's error estimate, which takes about twice as long.
        accuracy: error of the tip deflection to ask for; None: that of the study file, or the engine's default.
        jobs: processes at a time; None: one per core.
        quiet: whether progress on standard error is left out.

    Returns:
        Points, which print as a summary, with `mean(measure)`, `deviation(measure)`, `quantiles(measure)`, `shares(measure)` (Sobol'
        indices), and `surrogate(measure)`.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument; the sentence says what is accepted.
    """
    if uncertain is None or isinstance(uncertain, Mapping):
        if case is None:
            raise CaseError("case", None, None, "none is given", 'give one, such as "thesis-24"')
        study: dict[str, Any] = {"case": one_case(case), **({} if uncertain is None else {"uncertain": uncertain})}
        source = "uncertain"
    else:
        source = os.fspath(uncertain)
        study = study_of(source)
        study |= {} if case is None else {"case": one_case(case)}
    points = points_of(study, source, measures, samples, None if engine is None else os.fspath(engine), settings, claims, accuracy)
    with workshop(jobs, quiet) as opened:
        return points.scatter(opened)


def points_of(
    study: Mapping[str, Any],
    source: str,
    measures: str | Sequence[str],
    samples: int | None,
    engine: str | None,
    settings: Mapping[str, Any] | None,
    claims: bool,
    accuracy: float | None,
) -> Points:
    """The points of a study, as `study_of` gives it, with arguments of `uncertainty` in place of its values; errors as there."""
    case, name = study["case"], engine or study.get("engine", "reference")
    names = texts_given(measures or study.get("measures", ()), "measures", "post.frequency")
    if not names:
        raise CaseError(Argument("measures"), None, None, "none is given", 'give one, such as "post.frequency"')
    usable_engine(name)
    texts, file = given_settings({name: settings or {}})[name], case.name if case.source == "library" else case.source or case.name
    check(name, case.mechanism, texts)
    if samples is not None:
        check_samples(samples, Argument("samples"), None)
    request = MeasureRequest(
        measures=tuple(dict.fromkeys(measure(each).name for each in names)),
        engine=name,
        claims=claims,
        accuracy=checked(accuracy or study.get("accuracy")),
        settings=texts,
        duration=case.duration,
    )
    uncertain = study.get("uncertain", case.tolerances)
    if not uncertain and "uncertain" not in study:
        accepted = 'give a value of it a tolerance, such as thickness = "6 mm +- 0.1 mm", or write a study with a table [uncertain]'
        raise CaseError(file, None, None, "has no tolerances", accepted)
    count = samples or study.get("samples", SAMPLES)
    points = planned(case, uncertain, request, count, source if "uncertain" in study else file)
    if count < (least := least_points(len(points.distributions))):
        given, key = (Argument("samples"), None) if samples is not None else (source, "samples")
        problem = f"points are too few for {len(points.distributions)} uncertain quantities"
        raise CaseError(given, key, str(count), problem, f"at least {least} are needed, or fewer uncertain quantities")
    return points


def is_study(path: str) -> bool:
    """Whether a path is that of a study file; False for a case file, a name of the library, and what cannot be read."""
    if in_library(path) or not os.path.isfile(path):
        return False
    try:
        keys = toml_of(read_text(path), path).keys()
    except CaseError:
        return False
    return not keys & SECTIONS.keys()


def study_of(path: str, overrides: Mapping[str, str] | None = None) -> dict[str, Any]:
    """The content of a study file, its case loaded with overrides, keys of `uncertain` with dots.

    CaseError: all mistakes in the file, or those in the case.
    """
    content, mistakes = toml_of(read_text(path, "a study file"), path), list[CaseError]()
    for key, value in content.items():
        attempted(mistakes, _check, path, key, value)
    if "case" not in content:
        mistakes.append(CaseError(path, "case", None, "this key is missing", f"write case = {KEYS['case'][1]}"))
    if mistakes:
        raise together(mistakes)
    if "uncertain" in content:
        flat: dict[str, Any] = {}
        for section, value in content["uncertain"].items():
            flat |= {f"{section}.{key}": text for key, text in value.items()} if isinstance(value, dict) else {section: value}
        content["uncertain"] = flat
    if content.get("engine", "reference") not in engine_names():  # a file, whose path is that from the study's folder
        content["engine"] = os.path.join(os.path.dirname(path), content["engine"])
    return {**content, "case": _case(path, content["case"], overrides or {})}


def _case(study: str, name: str, overrides: Mapping[str, str]) -> Case:
    """The case of a study; a path is that from the study's folder."""
    is_path = not in_library(name) and (os.sep in name or name.endswith(".toml"))
    where = os.path.join(os.path.dirname(study), name) if is_path else name
    try:
        return load_case(where, overrides)
    except CaseError as wrong:
        if wrong.key is None and not wrong.further:  # there is no such case
            raise CaseError(study, "case", as_written(name), wrong.problem, wrong.accepted) from None
        raise


def _check(path: str, key: str, value: Any) -> None:
    """CaseError: an unknown key of a study file, or a wrong value."""
    if key not in KEYS:
        raise CaseError(path, key, as_written(value), "belongs to an unknown key", nearest_or_all(key, tuple(KEYS)))
    kinds, example = KEYS[key]
    wrong = not isinstance(value, kinds) or isinstance(value, bool)
    if wrong or (key == "measures" and not (value and all(isinstance(each, str) for each in value))):
        raise CaseError(path, key, as_written(value), "is not accepted", f"write such as {key} = {example}")
    if key == "engine" and not is_engine(value):
        raise CaseError(path, key, as_written(value), "is unknown", nearest_or_all(value, engine_names()))
    if key == "accuracy" and not LOWEST <= value <= HIGHEST:
        raise CaseError(path, key, as_written(value), "cannot be asked for", f"numbers from {LOWEST:g} to {HIGHEST:g} are accepted")
    if key == "samples":
        check_samples(value, path)
    for name in value if key == "measures" else ():
        try:
            measure(name)
        except CaseError as unknown:
            raise CaseError(path, key, unknown.value, unknown.problem, unknown.accepted) from None
