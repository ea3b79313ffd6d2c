"""From results of several formulations to a table with bounds, and a comparison of a table made anew with the kept one."""

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from quickreturn.pack.check import PACK, interpolated
from quickreturn.plugins.pack.values import Array, Columns

#: Columns of a formulation over a number of rows after the first.
Formulation = Callable[[int], Columns]
#: A bound is the largest difference of two formulations times this, with errors of interpolation and rounding added.
MARGIN: Final = 2.0
#: Least bound over the largest value of a signal: nobody asks for more, and the tables stay short.
LEAST: Final = 1e-6
#: Rounding of a table's numbers, at most this part of the bound.
ROUNDED: Final = 0.02


class Problem(NamedTuple):
    """A problem and its formulations: words that name each -> how it is computed. The first gives the table."""

    signals: Mapping[str, str]  # the main one first -> unit
    rows: int  # after the first
    formulations: Mapping[str, Formulation]
    finer: Formulation  # the first one with a finer resolution
    horizon: float | None = None  # s; None: the duration


def made(problem: Problem) -> tuple[str, dict[str, Any]]:
    """The text of results.csv, and the content of bounds.json but for names."""
    names, count = list(problem.formulations), problem.rows
    first, *others = (formulation(count) for formulation in problem.formulations.values())
    between = problem.finer(2 * count)
    fine = {name: values[::2] for name, values in between.items()}
    time = fine["time"]
    horizon = problem.horizon or float(time[-1])
    until = time <= horizon * (1 + 1e-9)

    def largest(differences: Array) -> float:
        return float(np.max(np.abs(differences[until])))

    columns, signals = [[f"{t:.10g}" for t in time]], {}
    for name, unit in problem.signals.items():
        values, scale = fine[name], float(np.max(np.abs(fine[name])))
        own = largest(first[name] - values)
        differences = {words: largest(other[name] - values) for words, other in zip(names[1:], others, strict=True) if name in other}
        halfway = [interpolated(time.tolist(), values.tolist(), t) for t in ((time[:-1] + time[1:]) / 2).tolist()]
        gap = float(np.max(np.abs(halfway - between[name][1::2])[until[1:]]))
        bound = _rounded_up(max((MARGIN * max(min(differences.values()), own) + gap) / (1 - ROUNDED), LEAST * scale))
        decimals = max(0, math.ceil(-math.log10(2 * ROUNDED * bound)))
        columns.append([f"{value:.{decimals}f}".replace("-0." + "0" * decimals, "0." + "0" * decimals) for value in values])
        relative = bound / float(np.sqrt(np.mean(values[until] ** 2)))
        signals[name] = {"bound": bound, "horizon": horizon, "scale": float(f"{scale:.6g}"), "unit": unit}
        signals[name] |= {"main": name == next(iter(problem.signals)), "relative": _digits(relative)}
        signals[name] |= {"differences": {words: _digits(each) for words, each in differences.items()}}
        signals[name] |= {"own": _digits(own), "interpolation": _digits(gap)}
    text = "\n".join(",".join(row) for row in [["time", *problem.signals], *zip(*columns, strict=True)]) + "\n"
    return text, {"formulation": names[0], "confirmed_by": names[1:], "signals": signals}


def _digits(value: float) -> float:
    return float(f"{value:.2g}")


def _rounded_up(bound: float) -> float:
    """With two digits."""
    size = 10.0 ** (math.floor(math.log10(bound)) - 1)
    return _digits(math.ceil(bound / size) * size)


def written(folder: Path, name: str, made: tuple[str, dict[str, Any]]) -> None:
    """Write results.csv and bounds.json of a problem; each signal is on a line of its own, which the checkers rely on."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / "results.csv").write_text(made[0], "utf-8")
    content = {"problem": name, "version": (PACK / "VERSION").read_text("utf-8").strip()} | made[1]
    signals = ",\n".join(f"    {json.dumps(key)}: {json.dumps(value)}" for key, value in content.pop("signals").items())
    head = "".join(f"  {json.dumps(key)}: {json.dumps(value)},\n" for key, value in content.items())
    (folder / name / "bounds.json").write_text(f'{{\n{head}  "signals": {{\n{signals}\n  }}\n}}\n', "utf-8")
