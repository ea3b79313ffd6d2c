"""One comparison of the ladder, and tables of them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

#: Columns of a table, in its order.
COLUMNS: Final = ("scene", "engine", "quantity", "value", "expected", "difference", "tolerance", "reason", "passed")


@dataclass(frozen=True, kw_only=True)
class Row:
    """A value of an engine beside the value expected.

    Attributes:
        scene: what is computed, in words.
        engine: name, with the settings that matter.
        quantity: in words, with its unit.
        value: the engine's.
        expected: from elsewhere.
        scale: size that differences are related to; None: the expected value.
        tolerance: largest difference over `scale` that the engine's discretization explains.
        reason: where the tolerance comes from.
    """

    scene: str
    engine: str
    quantity: str
    value: float
    expected: float
    tolerance: float
    reason: str
    scale: float | None = None

    @property
    def difference(self) -> float:
        """Value less expected, over the scale."""
        return (self.value - self.expected) / (abs(self.expected) if self.scale is None else self.scale)

    @property
    def passed(self) -> bool:
        """Whether the difference is within the tolerance; never if it is no number."""
        return abs(self.difference) <= self.tolerance


def smoothed(values: NDArray[np.float64], rows: int) -> NDArray[np.float64]:
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


def chapter(rows: Sequence[Row], title: str, text: str) -> dict[str, Any]:
    """A chapter of the stored verification (`reports.verification`): plain numbers and texts."""
    passed = sum(row.passed for row in rows)
    cells = [[_plain(getattr(row, name)) for name in COLUMNS] for row in rows]
    return {"title": title, "text": f"{text} {passed} of {len(rows)} comparisons passed.", "columns": list(COLUMNS), "rows": cells}


def _plain(value: Any) -> str | float | None:
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "yes" if value else "no"
    return float(value) if math.isfinite(value) else None
