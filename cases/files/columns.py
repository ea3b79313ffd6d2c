"""Columns of a trajectory by their names, as a person gives them."""

from collections.abc import Mapping
from typing import Any

from quickreturn.cases.files.errors import as_written, nearest_or_all
from quickreturn.reference_model.errors import ToldError


class UnknownColumn(ToldError, LookupError):
    """No such column; the text is one sentence with the nearest known one."""


def known_column(name: str, columns: Mapping[str, Any]) -> str:
    """`name` itself. Raises UnknownColumn if it is the name of none of these columns."""
    if not isinstance(name, str):
        raise UnknownColumn(f'{as_written(name)}: no name of a column; give one after the other, such as "tip_deflection"')
    if name not in columns:
        raise UnknownColumn(f"{as_written(name)}: no such column; {nearest_or_all(name, tuple(columns))}")
    return name
