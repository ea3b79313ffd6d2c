"""Tables and datasets as the content of files."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def table_file(frame: "pd.DataFrame", units: Mapping[str, str], ending: str) -> bytes:
    """A table as .csv or .parquet, with units in the headings.

    Args:
        frame: columns with names, values in SI.
        units: unit of each column; "" for texts.
        ending: ".csv" or ".parquet".
    """
    headed = frame.set_axis([f"{name} [{unit}]" if (unit := units.get(str(name), "")) else str(name) for name in frame.columns], axis=1)
    if ending == ".parquet":
        return headed.to_parquet(index=False)
    return str(headed.to_csv(index=False, lineterminator="\n")).encode()


def dataset_file(dataset: "xr.Dataset", ending: str) -> bytes:
    """A dataset as .nc (netCDF 4), or as a table (.csv, .parquet) with a row for each point."""
    if ending == ".nc":
        return bytes(dataset.to_netcdf(engine="h5netcdf"))
    frame = dataset.to_dataframe().reset_index()
    return table_file(frame, {name: dataset[name].attrs.get("units", "") for name in map(str, frame.columns)}, ending)
