"""A computed value beside one that comes from elsewhere, and tables as chapters of the verification's outcome."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd

from quickreturn.reference_model.arrays import Array

#: Columns of a table, in its order.
COLUMNS: Final = ("scene", "engine", "quantity", "value", "expected", "difference", "tolerance", "reason", "passed")


@dataclass(frozen=True, kw_only=True)
class Row:
    """A value of an engine beside the value expected."""

    scene: str  # what is computed, in words
    engine: str  # name, with the settings that matter
    quantity: str  # in words, with its unit
    value: float  # the engine's
    expected: float  # from elsewhere
    tolerance: float  # largest difference over `scale` that the engine's discretization explains
    reason: str  # where the tolerance comes from
    scale: float | None = None  # size that differences are related to; None: the expected value

    @property
    def difference(self) -> float:
        """Value less expected, over the scale."""
        return (self.value - self.expected) / (abs(self.expected) if self.scale is None else self.scale)

    @property
    def passed(self) -> bool:
        """Whether the difference is within the tolerance; never if it is no number."""
        return abs(self.difference) <= self.tolerance


def smoothed(values: Array, rows: int) -> Array:
    """Running mean weighted with sin^2 over `rows` rows, shape (n - rows + 1,): vibrations with four or more periods in it vanish."""
    weights = np.sin(np.pi * (np.arange(rows) + 0.5) / rows) ** 2
    return np.convolve(values, weights / weights.sum(), "valid")


def table(rows: Iterable[Row]) -> pd.DataFrame:
    """All rows, with `COLUMNS`."""
    return pd.DataFrame([[getattr(row, name) for name in COLUMNS] for row in rows], columns=list(COLUMNS))


def failures(rows: Iterable[Row]) -> str:
    """Every row that did not pass, a line each; empty if all did."""
    lines = [
        f"{row.scene}, {row.engine}, {row.quantity}: {row.value:.9g} instead of {row.expected:.9g},"
        f" difference {row.difference:.3g} beyond {row.tolerance:.3g} ({row.reason})"
        for row in rows
        if not row.passed
    ]
    return "\n".join(lines)


def chapter_of_rows(rows: Sequence[Row], title: str, text: str) -> dict[str, Any]:
    """A chapter that tells how many rows passed."""
    return chapter(table(rows), title, f"{text} {sum(row.passed for row in rows)} of {len(rows)} comparisons passed.")


def chapter(table: pd.DataFrame, title: str, text: str, digits: int = 17) -> dict[str, Any]:
    """A table as a chapter of the verification's outcome (`reports.page.content`), its numbers of so many digits."""
    rows = [[_plain(value, digits) for value in row] for row in table.itertuples(index=False)]
    return {"title": title, "text": text, "columns": [str(name).replace("_", " ") for name in table.columns], "rows": rows}


def _plain(value: Any, digits: int) -> str | float | int | None:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return None
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return float(f"{float(value):.{digits}g}")
    return int(value) if isinstance(value, np.integer) else value
