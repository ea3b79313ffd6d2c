"""Recordings of the thesis' experiment, which the report compares with the engines; the project has none."""

import os
from dataclasses import replace
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Final

from quickreturn.cases.files.errors import CaseError, path_shown
from quickreturn.cases.files.recorded import DECLARATIONS, RecordedTable, read_table

#: Environment variable with the folder of recordings, in place of the project's own.
FOLDER_VARIABLE: Final = "QUICKRETURN_CURVES"


def experiment_tables() -> list[RecordedTable]:
    """All tables in the folder of the experiment's recordings, by file name; each declares its case and its origin.

    The environment variable QUICKRETURN_CURVES names the folder; the default is the project's own.

    Raises:
        CaseError: no such folder, or a file is not such a table.
    """
    place = Path(os.environ.get(FOLDER_VARIABLE) or str(files(__package__) / "curves"))
    if not place.is_dir():
        raise CaseError(path_shown(str(place)), None, None, "is no folder", f"{FOLDER_VARIABLE} names a folder of CSV files")
    tables = [replace(read_table(str(path)), of_experiment=True) for path in sorted(place.glob("*.csv"))]
    for table, key in product(tables, ("case", "origin")):
        if key not in table.declared:
            accepted = f'write "# {key} = ..." above the heading, with {" or ".join(DECLARATIONS[key]) or "the name of a case"}'
            raise CaseError(table.shown, key, None, "this declaration is missing", accepted)
    return tables
