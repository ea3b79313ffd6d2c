"""Signals as numbers that a browser unpacks: whole numbers over a column's range, third differences, bytes apart, deflate.

A column of n values becomes `planes` bytes a value: 2 for columns that are only drawn (their range in 65,535 steps), 3 for columns whose
values are shown (16,777,215). Differences are taken modulo 2^(8 planes), zigzag (0, -1, 1, -2 ... as 0, 1, 2, 3 ...), and the low bytes of
all values precede the next higher ones. `templates/script/unpack.js` undoes it.
"""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Bytes for a value that is shown, and for one that is only drawn.
READ: Final = 3
DRAWN: Final = 2


def packed(tables: Mapping[str, Mapping[str, Array]], drawn: frozenset[str]) -> tuple[str, dict[str, Any]]:
    """Pack tables one after the other.

    Args:
        tables: name -> column -> values, shape (n,) in each table, finite.
        drawn: columns that are only drawn.

    Returns:
        The blob in base64, and for each table its number of rows and its columns in the order of the blob: name, low, step, planes; values
        are low + step * whole number.
    """
    content, layouts = bytearray(), {}
    for name, columns in tables.items():
        found = [_column(column, values, DRAWN if column in drawn else READ, content) for column, values in columns.items()]
        layouts[name] = {"rows": len(next(iter(columns.values()))), "columns": found}
    return base64.b64encode(zlib.compress(bytes(content), 9)).decode("ascii"), layouts


def _column(name: str, values: Array, planes: int, content: bytearray) -> list[str | float]:
    low, levels = float(values.min()), 2 ** (8 * planes) - 1
    step = (float(values.max()) - low) / levels
    whole = np.rint((values - low) / step).astype(np.int64) if step > 0.0 else np.zeros(len(values), np.int64)
    for _ in range(3):
        whole = np.diff(whole, prepend=0)
    half = 2 ** (8 * planes - 1)
    signed = (whole + half) % (2 * half) - half
    zigzag = np.where(signed < 0, -2 * signed - 1, 2 * signed)
    for plane in range(planes):
        content += (zigzag >> (8 * plane)).astype(np.uint8).tobytes()
    return [name, low, step, planes]
