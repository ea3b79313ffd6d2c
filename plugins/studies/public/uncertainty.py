"""The scatter of measures due to uncertain quantities, which an argument, a study file or the tolerances of a case file describe."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Final

from quickreturn.arguments import AnyCase, check, given_settings, one_case
from quickreturn.cases.files.broken_toml import toml_of
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import in_library, load_case
from quickreturn.cases.files.errors import Argument, CaseError, as_written, attempted, nearest_or_all, texts_given, together
from quickreturn.cases.files.keys import SECTIONS
from quickreturn.cases.files.text_file import read_text
from quickreturn.cases.motion.catalogue import measure
from quickreturn.computing import HIGHEST, LOWEST, checked, workshop
from quickreturn.engines.registry import engine_names, is_engine, usable_engine
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.uncertainty.chaos import least_points
from quickreturn.plugins.studies.uncertainty.propagation import Points, check_samples, planned
from quickreturn.plugins.studies.uncertainty.scatter import Scatter

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
        indices), `surrogate(measure)`, and a picture by `plot()`.

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
