"""Judges a table by the reference results of a problem; needs Python alone: python3 check.py PROBLEM FILE [SHARE].

PROBLEM is the name of a folder beside this file; FILE a CSV table with `time` and names of signals in its first line. SHARE, a part of a
signal's largest value such as 0.01, is added to each bound. Exit code 0: no signal is outside its bound; 1: one is; 2: bad input.
"""

import bisect
import itertools
import json
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

PACK = Path(__file__).resolve().parent
NEIGHBOURS = 6  # rows of the reference results through which a polynomial gives the value at a time of the table
LARGEST = 0.5  # share: a larger one is a per cent, or allows a table of zeros
FEWEST = 50  # the longest gap between rows of the table is the time up to the horizon over this


class BadInput(Exception):
    """The text says what is wrong with the table, or that there is no such problem."""


class Verdict(NamedTuple):
    """`status` is within, outside, beyond the horizon, or missing."""

    signal: str
    status: str
    told: str


def judged(problem: str, file: Path, share: float | str = 0.0) -> list[Verdict]:
    """The verdicts on the signals of a table; `share` may be a number's text. Raises BadInput."""
    folder = PACK / problem
    if not (folder / "bounds.json").is_file():
        known = ", ".join(sorted(each.parent.name for each in PACK.glob("*/bounds.json")))
        raise BadInput(f"{problem}: no such problem; there are {known}")
    try:
        allowed = float(share)
    except ValueError:
        allowed = math.nan
    if not 0.0 <= allowed <= LARGEST:
        raise BadInput(f"{share}: the share is a number from 0 to {LARGEST}, such as 0.01 for one per cent")
    signals = json.loads((folder / "bounds.json").read_text("utf-8"))["signals"]
    right, table = read_table(folder / "results.csv"), read_table(file)
    if not any(name in table for name in signals):
        raise BadInput(f"{file}: has none of the signals {', '.join(signals)}")
    return [judged_signal(name, each, right, table, allowed) for name, each in signals.items()]


def read_table(file: Path) -> dict[str, list[float]]:
    """The columns of a CSV table. Raises BadInput."""
    try:
        lines = [line for line in file.read_text("utf-8-sig").splitlines() if line.strip()]
    except (OSError, UnicodeError) as error:
        raise BadInput(f"{file}: cannot be read as a text in UTF-8 ({error})") from error
    names = [name.strip().strip('"') for name in lines[0].split(",")] if lines else []
    if names.count("time") != 1 or any(name and names.count(name) > 1 for name in names):
        raise BadInput(f"{file}: the first line must have `time` and each name once, separated by commas, without units")
    rows: list[list[float]] = []
    for number, line in enumerate(lines[1:], 2):
        fields = line.split(",")
        try:
            rows.append([float(field) if field.strip() else math.nan for field in fields])
        except ValueError:
            raise BadInput(f"{file}, row {number}: not numbers: {line.strip()[:60]}") from None
        if len(fields) != len(names):
            raise BadInput(f"{file}, row {number}: {len(fields)} fields, {len(names)} names")
    table = {name: [row[k] for row in rows] for k, name in enumerate(names)}
    time = table["time"]
    if len(time) < 2 or not all(a < b for a, b in itertools.pairwise(time)):
        raise BadInput(f"{file}: the times do not increase, or are fewer than two")
    return table


def judged_signal(name: str, signal: dict[str, Any], right: dict[str, list[float]], table: dict[str, list[float]], share: float) -> Verdict:
    """The verdict on a signal of the table, whose entry in bounds.json is `signal`."""
    if name not in table:
        return Verdict(name, "missing", "")
    times, horizon, unit = right["time"], signal["horizon"], signal["unit"]
    begin, end = times[0], times[-1]
    bound, slack = signal["bound"] + share * signal["scale"], 1e-9 * (end - begin)
    near = [(t, y) for t, y in zip(table["time"], table[name], strict=True) if begin - slack <= t <= end + slack]
    rows = [(t, abs(y - interpolated(times, right[name], t)) if math.isfinite(y) else math.inf) for t, y in near]
    now = [(t, error) for t, error in rows if t <= horizon + slack]
    if not now:
        return Verdict(name, "beyond the horizon", f"no row from {begin:g} to {horizon:g} s")
    for a, b in itertools.pairwise([begin, *(t for t, _ in now), horizon]):
        if b - a > (horizon - begin) / FEWEST + slack:
            return Verdict(name, "outside", f"no row between {a:g} and {b:g} s; the horizon is {horizon:g} s")
    at, worst = max(now, key=lambda row: row[1])
    if worst > bound:
        return Verdict(name, "outside", f"off by {worst:.2g} {unit} at {at:g} s, bound {bound:.2g}")
    if later := [t for t, error in rows if t > horizon + slack and error > bound]:
        return Verdict(name, "beyond the horizon", f"within up to {horizon:g} s; off from {later[0]:g} s")
    return Verdict(name, "within", f"off by {worst:.2g} {unit}, bound {bound:.2g}")


def interpolated(times: list[float], values: list[float], t: float) -> float:
    """The value at t of the polynomial through the nearest six rows, by Lagrange's formula."""
    first = min(max(bisect.bisect_right(times, t) - NEIGHBOURS // 2, 0), len(times) - NEIGHBOURS)
    rows, value = range(first, first + NEIGHBOURS), 0.0
    for i in rows:
        value += values[i] * math.prod((t - times[j]) / (times[i] - times[j]) for j in rows if j != i)
    return value


def main(arguments: list[str]) -> int:
    """Print the verdicts; the exit code."""
    if len(arguments) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        verdicts = judged(arguments[0], Path(arguments[1]), *arguments[2:])
    except BadInput as error:
        print(error, file=sys.stderr)
        return 2
    for each in verdicts:
        print(f"{each.signal:18} {each.status:18} {each.told}".rstrip())
    return int(any(each.status == "outside" for each in verdicts))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
