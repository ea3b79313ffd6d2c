"""Trajectories as xarray datasets; attributes give the meaning and the error estimate of each variable."""

import json
from importlib.metadata import version as installed_version
from typing import TYPE_CHECKING, Any

from quickreturn.cases.case import Case
from quickreturn.engines.accurate import Result
from quickreturn.reference_model.columns import COLUMNS

if TYPE_CHECKING:
    import xarray as xr


def dataset_of(case: Case, engine: str, version: str, result: Result) -> "xr.Dataset":
    """The trajectory of a result over its dimension `time`.

    Attributes are only texts and numbers, so that netCDF keeps them. Each variable has `units`, `long_name`, `comment` and, where it is
    known, `error_estimate`; the dataset has the case, the engine, its settings and its accuracy.

    Args:
        case: what was simulated.
        engine: name of the engine.
        version: version of the library behind it.
        result: trajectory, settings and error estimates.
    """
    import xarray as xr

    variables: dict[str, tuple[str, Any, dict[str, Any]]] = {}
    for name in result.trajectory.table().columns:
        about: dict[str, Any] = {"units": COLUMNS[name].unit, "long_name": name.replace("_", " "), "comment": COLUMNS[name].meaning}
        if (estimate := result.error_estimates.get(name)) is not None:
            about["error_estimate"] = float(estimate)
        variables[name] = ("time", result.trajectory[name], about)
    attributes: dict[str, str | float | None] = {
        "case": case.name,
        "title": case.title,
        "engine": engine,
        "version": version,
        "settings": json.dumps(result.settings),
        "accuracy": result.accuracy,
        "error_estimate": result.error_estimate,
        "error_estimate_of": result.estimate_of,
        "reached": "yes" if result.reached else "no",
        "remark": result.remark or None,
        "source": f"quickreturn {installed_version('quickreturn')}",
    }
    known = {name: value for name, value in attributes.items() if value is not None}
    return xr.Dataset(variables, {"time": variables.pop("time")}, known)
