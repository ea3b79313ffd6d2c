"""Trajectories as xarray datasets; attributes give the meaning and the error estimate of each variable."""

import json
from typing import TYPE_CHECKING, Any

from quickreturn.reference_model.columns import COLUMNS

if TYPE_CHECKING:
    import xarray as xr

    from quickreturn.solution import Solution


def dataset_of(solution: "Solution") -> "xr.Dataset":
    """The trajectory over its dimension `time`.

    Attributes are only texts and numbers, so that netCDF keeps them. Each variable has `units`, `long_name`, `comment` and, where it is
    known, `error_estimate`; the dataset has the case, the engine, its settings and its accuracy.
    """
    import xarray as xr

    estimates = solution.result.error_estimates
    variables: dict[str, tuple[str, Any, dict[str, Any]]] = {}
    for name in solution.frame.columns:
        about: dict[str, Any] = {"units": COLUMNS[name].unit, "long_name": name.replace("_", " "), "comment": COLUMNS[name].meaning}
        if (estimate := estimates.get(name)) is not None:
            about["error_estimate"] = float(estimate)
        variables[name] = ("time", solution.trajectory[name], about)
    return xr.Dataset(variables, {"time": variables.pop("time")}, _attributes(solution))


def _attributes(solution: "Solution") -> dict[str, str | float]:
    """Attributes of the dataset, without unknown ones."""
    from importlib.metadata import version

    result = solution.result
    attributes: dict[str, str | float | None] = {
        "case": solution.case.name,
        "title": solution.case.title,
        "engine": solution.engine,
        "version": solution.version,
        "settings": json.dumps(solution.settings),
        "accuracy": result.accuracy,
        "error_estimate": result.error_estimate,
        "error_estimate_of": result.estimate_of,
        "reached": "yes" if result.reached else "no",
        "remark": result.remark or None,
        "source": f"quickreturn {version('quickreturn')}",
    }
    return {name: value for name, value in attributes.items() if value is not None}
