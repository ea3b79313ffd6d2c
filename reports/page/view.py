"""The moving first screen as data for the script: engines, signals, and for each case its geometry and the engines' motion.

Signals are packed, and `templates/script/unpack.js` unpacks them:

1. A value becomes a whole number of steps above its column's minimum. A column that is only drawn has 65,535 steps over its range and
   takes 2 bytes (`planes`) a value; a column whose values are shown has 16,777,215 steps and takes 3.
2. Third differences of these numbers, modulo 2^(8 planes), take their place, in zigzag: 0, -1, 1, -2 ... as 0, 1, 2, 3 ...
3. The lowest bytes of all values come first, then the next higher ones.
4. The bytes of all columns are compressed by deflate.
"""

import base64
import cmath
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.library import ENTRIES
from quickreturn.cases.library.hard import ORIGINAL
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS, SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.tip import tip_force
from quickreturn.reports.line_styles import Look, looks
from quickreturn.reports.page.content import of_library

#: What is drawn along the arm, in the script's form (`FirstScreen.along_arm`).
Along = Mapping[str, Any]

#: Column that the curve can show -> its name.
SIGNALS: Final = {
    "tip_acceleration": "tip acceleration",
    "tip_deflection": "tip deflection",
    "strain_1": "strain at gauge 1",
    "strain_2": "strain at gauge 2",
    "strain_3": "strain at gauge 3",
    "slider_force": "slider force",
    "slider_position": "slider position",
    "crank_speed": "crank speed",
    "crank_torque": "crank torque",
}
#: Crank angles at which the direction of the tool's force is told.
FORCES: Final = 72
#: Bytes a value in a column whose values are shown, and in one that is only drawn.
READ: Final = 3
DRAWN: Final = 2
#: Further columns, which place the mechanism.
_PLACES: Final = ("time", "crank_angle", "follower_angle")


@dataclass
class View:
    """The data of a page's first screen."""

    axis: str  # column on the horizontal axis of curves: "crank_angle" of a cycle, "time" of a trajectory
    engines: Sequence[str]  # names
    units: Units  # in which it shows numbers
    runs: list[dict[str, Any]] = field(default_factory=list)  # one per case, in the script's form
    blobs: list[str] = field(default_factory=list)  # the packed motions of each of them
    drawn: Sequence[str] = ()  # names of other items drawn on the page

    def add(self, case: Case, motions: Mapping[str, Mapping[str, Array]], facts: Mapping[str, str], along: Along | None = None) -> None:
        """Add a case with the columns of each engine that has a motion; `facts`: remarks on engines; `along`: see `cycles`."""
        entry = ENTRIES.get(case.name) if case.source == "library" else None
        kept = {name: _kept(columns) for name, columns in motions.items()}
        blob, layouts = packed(kept, frozenset(SHAPE))
        self.blobs.append(blob)
        self.runs.append(
            {
                "name": case.name,
                "title": case.title,
                "short": entry.number if entry else case.name,
                "group": entry.group if entry else "",
                "scene": _scene(case.mechanism),
                "engines": layouts,
                "facts": dict(facts),
                "stress": along or None,
            }
        )

    @property
    def looks(self) -> dict[str, Look]:
        """The looks of all items drawn on the page."""
        return looks((*self.engines, *self.drawn))

    @property
    def document(self) -> dict[str, Any]:
        """The data for the script, without the blobs."""
        return {
            "axis": self.axis,
            "looks": {name: vars(look) for name, look in self.looks.items()},
            "engines": self.engines,
            "signals": {name: {"label": label, **_scaled(self.units.column(COLUMNS[name].unit))} for name, label in SIGNALS.items()},
            "length": _scaled(self.units.of("m")),
            "units": {name: COLUMNS[name].unit for name in (*_PLACES, *SIGNALS)},
            "runs": self.runs,
        }


def cycles(results: Sequence[CaseResult], engines: Sequence[str], along: Mapping[str, Along] | None = None) -> View:
    """The steady cycles of all cases, from the slider's farthest place to the next; recorded tables follow the engines.

    Args:
        results: results of the cases.
        engines: names.
        along: case -> what is drawn along its arm.
    """
    names = list(dict.fromkeys([*engines, *(name for result in results for name in result.recorded)]))
    view = View("crank_angle", names, results[0].case.units)
    for result in results:
        runs = result.with_tables.runs
        motions = {name: run.cycle for name, run in runs.items() if (run.usable or run.status == Ending.NOT_SETTLED) and run.cycle}
        facts = {name: _fact(run, view.units) for name, run in runs.items()}
        view.add(result.case, motions, facts, (along or {}).get(result.case.name))
    return view


def trajectories(case: Case, motions: Mapping[str, Mapping[str, Array]]) -> View:
    """Trajectories of one case from its start."""
    view = View("time", list(motions), case.units)
    view.add(case, motions, {})
    return view


def _scaled(unit: Unit) -> dict[str, Any]:
    """A unit for the script: its sign, and the factor from SI."""
    return {"unit": unit.sign, "factor": 1.0 / unit.size}


def _fact(run: Run, units: Units) -> str:
    """A remark on a run: peak of the tip acceleration and first-mode frequency, or its status."""
    if not run.usable:
        return run.status
    unit, form = units.of("m/s^2"), units.form("m/s^2", ".1f")
    texts = [f"{run.peak('tip_acceleration') / unit.size:{form}} {unit.sign}"] if "tip_acceleration" in run.cycle else []
    frequency = run.consensus_frequency("post") or run.consensus_frequency("pre")
    return ", ".join(texts + ([f"{frequency:.1f} Hz"] if frequency else []))


def _kept(columns: Mapping[str, Array]) -> dict[str, Array]:
    """The columns that are drawn, without those that have gaps."""
    present = {name: np.asarray(columns[name]) for name in (*_PLACES, *SIGNALS, *SHAPE) if name in columns}
    return {name: values for name, values in present.items() if np.all(np.isfinite(values))}


def _scene(mechanism: Mechanism) -> dict[str, Any]:
    """Lengths in m, and the crank angle (rad, either side of 0) at which the return begins and ends.

    Where the spring is fixed, and at which part of the follower. For a compliant joint: whether its rollers have clearance, and whether the
    plus and the minus roller are softer than the other. Of the tool's force: its directions (rad) at equal steps of the crank from 0 on,
    None where there is none, and whether they are relative to the arm's end.
    """
    slider, spring, length, tool = mechanism.slider, mechanism.acting_spring, mechanism.follower.length, mechanism.tip_body
    forces = tip_force(tool, np.linspace(0.0, 2.0 * math.pi, FORCES, endpoint=False), 0.0).tolist()
    return {
        "pivot": mechanism.pivot_distance,
        "crank": mechanism.crank.length,
        "follower": length,
        "tip": mechanism.tip is not None,
        "rigid": mechanism.follower.is_rigid,
        "rollers": None
        if slider.is_rigid
        else {"free": slider.clearance > 0.0, "soft": [side < max(slider.sides) for side in slider.sides]},
        "spring": None if spring is None else {"anchor": spring.anchor, "part": spring.place_on(length) / length},
        "quick": mechanism.half_return,
        "force": {"follows": tool.follows, "ways": [round(cmath.phase(force), 3) if force else None for force in forces]}
        if tool.is_forced
        else None,
    }


def shown_first(results: Sequence[CaseResult]) -> CaseResult:
    """The case with which the page opens: the thesis' example, otherwise the first case in which most engines have a cycle."""
    example = of_library(results, ORIGINAL)
    if example is not None and all(run.usable for run in example.runs.values()):
        return example
    return max(results, key=lambda result: sum(run.usable for run in result.runs.values()))


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
