"""Fronts of the race: the runs of a combination that no other beats in both time and error, and its time at a level of the error."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from quickreturn.plugins.methods.row import LEVELS, Row

WORST, DEFLECTION = "worst of four", "deflection alone"
#: Name -> error of a row by which it is judged: the worst of deflection, acceleration, strains and slider force, or the deflection's.
CRITERIA: Final[Mapping[str, Callable[[Row], float | None]]] = {WORST: lambda row: row.worst, DEFLECTION: lambda row: row.error}


def paced(rows: Sequence[Row]) -> list[Row]:
    """The rows with times that other work of the machine affects less.

    The time of a run is the number of its calls times the least time of a call of the same size, plus that of the table. Runs of
    one combination with the same whole numbers and switches (modes, elements) have the same size. Rows without calls stay as they are.
    """
    least: dict[Any, tuple[float, float]] = {}
    for row in rows:
        if row.calls and row.call_seconds is not None:
            pair, known = (row.call_seconds, row.rows_seconds or 0.0), least.get(_size(row), (math.inf, math.inf))
            least[_size(row)] = min(pair[0], known[0]), min(pair[1], known[1])
    return [_at_pace(row, *least[_size(row)]) if row.calls and row.call_seconds is not None else row for row in rows]


def _at_pace(row: Row, each: float, table: float) -> Row:
    of_rows = None if row.rows_seconds is None else table
    return replace(row, call_seconds=each, rows_seconds=of_rows, solve_seconds=(row.calls or 0.0) * each + (of_rows or 0.0))


def _size(row: Row) -> tuple[Any, ...]:
    return (row.scene, row.method, *(value for value in row.settings.values() if isinstance(value, int)))


def front(rows: Iterable[Row], by: str = WORST) -> list[Row]:
    """The rows that no other beats in both solve time and error, fastest first."""
    found: list[Row] = []
    least = math.inf
    known = [(row.seconds, error, row) for row in rows if row.completed and (error := CRITERIA[by](row)) is not None]
    for _, error, row in sorted(known, key=lambda each: each[:2]):
        if error < least:
            found.append(row)
            least = error
    return found


@dataclass(frozen=True)
class Standing:
    """A combination at a level of the error."""

    row: Row  # the first run below the level
    seconds: float  # solve time at the level: interpolated in logarithms between that run and the one before it on the front
    calls: float | None  # likewise


def around_levels(on_front: Sequence[Row], by: str) -> list[Row]:
    """The rows of a front that give the times at `LEVELS`, and its most accurate one."""
    first = [next((number for number, row in enumerate(on_front) if (CRITERIA[by](row) or 0.0) <= level), None) for level in LEVELS]
    kept = {max(number - before, 0) for number in first if number is not None for before in (0, 1)} | {len(on_front) - 1}
    return [row for number, row in enumerate(on_front) if number in kept]


def standing(rows: Iterable[Row], level: float, by: str = WORST) -> Standing | None:
    """The time of one combination at a level; None if no run is below it."""
    on_front = front(rows, by)
    number = next((number for number, row in enumerate(on_front) if (CRITERIA[by](row) or 0.0) <= level), None)
    if number is None:
        return None
    row, before = on_front[number], on_front[max(number - 1, 0)]
    errors = [max(CRITERIA[by](each) or 0.0, 1e-300) for each in (before, row)]
    share = math.log(level / errors[0]) / math.log(errors[1] / errors[0]) if number else 1.0
    calls = _between(before.calls, row.calls, share) if before.calls and row.calls else row.calls
    return Standing(row, _between(before.seconds, row.seconds, share), calls)


def _between(low: float, high: float, share: float) -> float:
    return low * (high / low) ** share


def standings(rows: Iterable[Row], level: float, by: str = WORST) -> dict[str, Standing]:
    """Combination -> its standing at a level, the fastest first."""
    methods: dict[str, list[Row]] = {}
    for row in rows:
        methods.setdefault(row.method, []).append(row)
    found = {method: at for method, of_method in methods.items() if (at := standing(of_method, level, by)) is not None}
    return dict(sorted(found.items(), key=lambda item: item[1].seconds))
