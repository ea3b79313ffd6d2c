"""Tables as the content of files, with units in the headings."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def table_file(frame: "pd.DataFrame", units: Mapping[str, str], ending: str) -> bytes:
    """A table as .csv or .parquet.

    Args:
        frame: columns with names, values in SI.
        units: by name; "" of texts.
        ending: of the file.
    """
    headed = frame.set_axis([f"{name} [{unit}]" if (unit := units.get(str(name), "")) else str(name) for name in frame.columns], axis=1)
    if ending == ".parquet":
        return headed.to_parquet(index=False)
    return str(headed.to_csv(index=False, lineterminator="\n")).encode()
