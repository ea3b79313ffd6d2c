"""Trajectories as xarray datasets, with the meaning and the error estimate of each variable; datasets and tables as files."""

import json
from collections.abc import Mapping
from importlib.metadata import version as installed_version
from typing import TYPE_CHECKING, Any

from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.output import require

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from quickreturn.cases.files.case import Case
    from quickreturn.engines.accurate import Result


def dataset_of(case: "Case", engine: str, version: str, result: "Result") -> "xr.Dataset":
    """The trajectory of a result over its dimension `time`.

    Attributes are only texts and numbers, so that netCDF keeps them. Each variable has `units`, `long_name`, `comment` and, where it is
    known, `error_estimate`; the dataset has the case, the engine, its settings and its accuracy.

    Args:
        case: what was simulated.
        engine: name of the engine.
        version: version of the library behind it.
        result: trajectory, settings and error estimates.

    Raises:
        MissingExtra: xarray is not installed.
    """
    require("tables", "a dataset")
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


def table_file(frame: "pd.DataFrame", units: Mapping[str, str], ending: str) -> bytes:
    """A table as .csv or .parquet, with units in the headings.

    Args:
        frame: columns with names, values in SI.
        units: unit of each column; "" for texts.
        ending: ".csv" or ".parquet".
    """
    headed = frame.set_axis([f"{name} [{unit}]" if (unit := units.get(str(name), "")) else str(name) for name in frame.columns], axis=1)
    if ending == ".parquet":
        require("tables", "a file .parquet")
        return headed.to_parquet(index=False)
    return str(headed.to_csv(index=False, lineterminator="\n")).encode()


def dataset_file(dataset: "xr.Dataset", ending: str) -> bytes:
    """A dataset as .nc (netCDF 4), or as a table (.csv, .parquet) with a row for each point."""
    if ending == ".nc":
        return bytes(dataset.to_netcdf(engine="h5netcdf"))
    frame = dataset.to_dataframe().reset_index()
    return table_file(frame, {name: dataset[name].attrs.get("units", "") for name in map(str, frame.columns)}, ending)
