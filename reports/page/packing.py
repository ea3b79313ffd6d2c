"""Packs signals for the page's script, which unpacks them in `templates/script/unpack.js`.

1. A value becomes a whole number of steps above its column's minimum. A column that is only drawn has 65,535 steps over its range and
   takes 2 bytes (`planes`) a value; a column whose values are shown has 16,777,215 steps and takes 3.
2. Third differences of these numbers, modulo 2^(8 planes), take their place, in zigzag: 0, -1, 1, -2 ... as 0, 1, 2, 3 ...
3. The lowest bytes of all values come first, then the next higher ones.
4. The bytes of all columns are compressed by deflate.
"""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Bytes a value in a column whose values are shown, and in one that is only drawn.
READ: Final = 3
DRAWN: Final = 2


def packed(tables: Mapping[str, Mapping[str, Array]], drawn: frozenset[str]) -> tuple[str, dict[str, Any]]:
    """Pack tables one after the other.

    Args:
        tables: name -> column -> values, shape (n,) in each table, finite.
        drawn: columns that are only drawn.

    Returns:
        The blob in base64, and name of a table -> its number of rows and, in the order of the blob, its columns as name, low, step, planes.
        A value is low + step * its whole number.
    """
    content, layouts = bytearray(), {}
    for name, columns in tables.items():
        layout = [_column(column, values, DRAWN if column in drawn else READ, content) for column, values in columns.items()]
        layouts[name] = {"rows": len(next(iter(columns.values()))), "columns": layout}
    return base64.b64encode(zlib.compress(bytes(content), 9)).decode("ascii"), layouts


def _column(name: str, values: Array, planes: int, content: bytearray) -> list[str | float]:
    low, levels = float(values.min()), 2 ** (8 * planes) - 1
    step = (float(values.max()) - low) / levels
    counts = np.rint((values - low) / step).astype(np.int64) if step > 0.0 else np.zeros(len(values), np.int64)
    for _ in range(3):
        counts = np.diff(counts, prepend=0)
    half = 2 ** (8 * planes - 1)
    signed = (counts + half) % (2 * half) - half
    zigzag = np.where(signed < 0, -2 * signed - 1, 2 * signed)
    for plane in range(planes):
        content += (zigzag >> (8 * plane)).astype(np.uint8).tobytes()
    return [name, low, step, planes]
