"""Fronts of the race: the runs of a combination that no other beats in both time and error, and its time at a level of the error."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from quickreturn.plugins.methods.row import Row, by_method

WORST, DEFLECTION = "worst of four", "deflection alone"
#: Name -> error of a row by which it is judged: the worst of deflection, acceleration, strains and slider force, or the deflection's.
CRITERIA: Final[Mapping[str, Callable[[Row], float | None]]] = {WORST: lambda row: row.worst, DEFLECTION: lambda row: row.error}


def paced(rows: Sequence[Row]) -> list[Row]:
    """The rows with times that other work of the machine affects less.

    The time of a run is the number of its calls times the least time of a call of the same size, plus that of the table. Runs of
    one combination with the same whole numbers and switches (modes, elements) have the same size. Rows without calls stay as they are.
    """
    counted, least = [row for row in rows if row.calls and row.call_seconds is not None], dict[Any, tuple[float, float]]()
    for row in counted:
        each, table = least.get(size_of(row), (math.inf, math.inf))
        least[size_of(row)] = min(each, row.call_seconds or 0.0), min(table, row.rows_seconds or 0.0)
    times = {id(row): least[size_of(row)] for row in counted}
    return [_at_pace(row, *times[id(row)]) if id(row) in times else row for row in rows]


def _at_pace(row: Row, each: float, table: float) -> Row:
    return replace(row, call_seconds=each, rows_seconds=table, solve_seconds=(row.calls or 0.0) * each + table)


def size_of(row: Row) -> tuple[Any, ...]:
    """What a call's time depends on, see `paced`."""
    return (row.scene, row.method, *(value for value in row.settings.values() if isinstance(value, int)))


def front(rows: Iterable[Row], by: str = WORST) -> list[Row]:
    """The rows that no other beats in both solve time and error, fastest first."""
    found: list[Row] = []
    known = [(row.seconds, error, row) for row in rows if row.completed and (error := CRITERIA[by](row)) is not None]
    least = math.inf
    for _, error, row in sorted(known, key=lambda each: each[:2]):
        if error < least:
            found.append(row)
            least = error
    return found


@dataclass(frozen=True)
class Standing:
    """A combination at a level of the error."""

    row: Row  # the first run below the level
    before: Row  # the one before it on the front, or itself
    seconds: float  # solve time at the level: interpolated in logarithms between the two
    calls: float | None  # likewise


def standings(rows: Iterable[Row], level: float, by: str = WORST) -> dict[str, Standing]:
    """Combination -> its standing at a level, the fastest first; without those of which no run is below it."""
    found = {method: at for method, of_method in by_method(rows).items() if (at := _standing(front(of_method, by), level, by))}
    return dict(sorted(found.items(), key=lambda item: item[1].seconds))


def _standing(on_front: Sequence[Row], level: float, by: str) -> Standing | None:
    errors = [max(CRITERIA[by](row) or 0.0, 1e-300) for row in on_front]
    number = next((number for number, error in enumerate(errors) if error <= level), None)
    if number is None:
        return None
    before, row = on_front[max(number - 1, 0)], on_front[number]
    share = math.log(level / errors[number - 1]) / math.log(errors[number] / errors[number - 1]) if number else 1.0
    calls = _between(before.calls, row.calls, share) if before.calls and row.calls else row.calls
    return Standing(row, before, _between(before.seconds, row.seconds, share), calls)


def _between(low: float, high: float, share: float) -> float:
    return low * (high / low) ** share
