"""Studies over grids of machines, as datasets with the meaning and the error of each variable."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from quickreturn import computing
from quickreturn.arguments import AnyCase, given_settings, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError, texts_given
from quickreturn.cases.files.keys import si_text, unit_given
from quickreturn.cases.files.shown import Units
from quickreturn.cases.motion.catalogue import MEASURES, measure
from quickreturn.cases.running.workshop import Workshop
from quickreturn.computing import checked
from quickreturn.engines.registry import usable_engine
from quickreturn.plugins.studies.sweep.grid import ENGINE, Axis, Grid, axis, unit_of
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.sweep.study import Study, study
from quickreturn.reports.output import require

if TYPE_CHECKING:
    import xarray as xr

#: Default measures.
USUAL: Final = ("peak.tip_acceleration", "multiplier")
#: Suffix of a measure's name for the variable of its error.
ERROR: Final = ".error"
#: Attribute of a varied key: the unit in which its values were given. Its values are in SI.
GIVEN: Final = "given_in"


def sweep(
    case: AnyCase,
    vary: Mapping[str, str | Sequence[Any]],
    measures: str | Sequence[str] = USUAL,
    engine: str | os.PathLike[str] = "reference",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Any] | None = None,
    claims: bool = True,
    jobs: int | None = None,
    workshop: Workshop | None = None,
    quiet: bool = False,
) -> "xr.Dataset":
    """Measure the settled motion of every machine of a grid.

    Args:
        case: a name, a path or a `Case`, for all values that do not vary.
        vary: dotted key of a case file, or "engine" -> values: "60 rpm .. 300 rpm : 241", "log 1 N/m .. 1e6 N/m : 7", "0 g; 25 g; 50 g",
            a list of such texts, or numbers in SI.
        measures: one name or several, see `measures`.
        engine: name, or path of a file that declares one, unless engines vary.
        accuracy: error of the tip deflection to ask for; None: the engine's default.
        settings: settings of the engine, by name.
        claims: whether every number gets its error estimate, which takes about twice as long.
        jobs: processes at a time; None: one per core.
        workshop: processes and store; None: those of this machine.
        quiet: whether progress on standard error is left out.

    Returns:
        A dataset with a dimension for each key. Its variables are the measures, and "status" and "sentence" of each point. The error of
        the measure NAME, by the engine's estimate, is "NAME.error".

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError: an invalid argument; the sentence says what is accepted.
    """
    chosen = one_case(case)
    names = texts_given(measures, "measures", USUAL[0])
    axes = tuple(_axis(key, values) for key, values in vary.items())
    with nullcontext(workshop) if workshop is not None else computing.workshop(jobs, quiet) as opened:
        return dataset_of(computed(chosen, axes, names, os.fspath(engine), accuracy, settings, claims, opened))


def computed(
    case: Case,
    axes: Sequence[Axis],
    names: Sequence[str],
    engine: str,
    accuracy: float | None,
    settings: Mapping[str, Any] | None,
    claims: bool,
    workshop: Workshop,
) -> Study:
    """The study of a grid; arguments and errors as of `sweep`."""
    if not axes:
        raise CaseError(case.name, None, None, "nothing varies", 'give a key and values, such as "tip.mass = 0 g; 25 g"')
    for name in {engine, *(name for each in axes if each.key == ENGINE for name in each.texts)}:
        usable_engine(name)
    texts = given_settings({engine: settings or {}})[engine]
    request = MeasureRequest(
        measures=tuple(dict.fromkeys(measure(name).name for name in names)),
        engine=engine,
        claims=claims,
        accuracy=checked(accuracy),
        settings=texts,
        duration=case.duration,
    )
    return study(Grid(case, tuple(axes)), request, workshop)


def _axis(key: str, values: str | Sequence[Any]) -> Axis:
    if isinstance(values, str):
        return axis(f"{key} = {values}")
    if not all(isinstance(each, str) for each in values):
        unit_of(key)
    return axis(f"{key} = {'; '.join(each if isinstance(each, str) else si_text(key, float(each)) for each in values)}")


def dataset_of(study: Study) -> "xr.Dataset":
    """A study as a dataset. Its attributes are texts and numbers, which netCDF can store."""
    require("tables", "a dataset")
    import xarray as xr

    axes = study.grid.axes
    dimensions = tuple(each.key for each in axes)
    variables: dict[str, tuple[Any, ...]] = {}
    for place, name in enumerate(study.asked.measures):
        about = MEASURES[name]
        variables[name] = (dimensions, study.values[..., place], {"units": about.unit, "long_name": about.meaning})
        attributes_of_error = {"units": about.unit, "long_name": f"how far off {name} may be by the engine's own estimate"}
        if study.asked.claims:
            variables[f"{name}{ERROR}"] = (dimensions, study.errors[..., place], attributes_of_error)
    variables["status"] = (dimensions, study.statuses.astype(str), {"long_name": "how the point ended"})
    variables["sentence"] = (dimensions, study.sentences.astype(str), {"long_name": "why"})
    coordinates: dict[str, tuple[Any, ...]] = {
        each.key: (each.key, np.array(each.values), {"units": each.unit, GIVEN: each.given[0]} if each.unit else {}) for each in axes
    }
    case = study.grid.case
    attributes = {
        "case": case.name,
        "title": case.title,
        "case_file": case.to_toml(),
        "engine": study.asked.engine,
        "source": f"quickreturn {version('quickreturn')}",
    }
    return xr.Dataset(variables, coordinates, attributes)


def summary(dataset: "xr.Dataset", units: Units) -> list[str]:
    """Lines for a terminal: the number of points of each status, and the extremes of every measure with their places, in some units."""
    counts = Counter(map(str, dataset["status"].values.flat)).most_common()
    points = ", ".join(f"{count} {status}" for status, count in counts)
    lines = [f"{dataset['status'].size} points: {points}"]
    for name in (str(each) for each in dataset.data_vars if str(each) in MEASURES):
        unit = units.of(dataset[name].attrs["units"])
        values = dataset[name] / unit.size
        if not values.notnull().any():
            lines.append(f"{name}: no point has a value")
            continue
        ends = (("least", values.argmin(...)), ("greatest", values.argmax(...)))
        ends_text = [f"{which} {float(values[at]):.6g} at {_place(values[at], values)}" for which, at in ends]
        lines.append(f"{name} [{unit.name}]: {', '.join(ends_text)}")
    return lines


def _place(end: "xr.DataArray", values: "xr.DataArray") -> str:
    def text(key: str) -> str:
        value = end[key].item()
        if not isinstance(value, float):
            return f"{key} = {value}"
        unit, size = unit_given(key, [f"1 {values[key].attrs[GIVEN]}"])
        return f"{key} = {value / size:.6g} {unit}".removesuffix(" 1")

    return ", ".join(text(str(key)) for key in values.dims)
