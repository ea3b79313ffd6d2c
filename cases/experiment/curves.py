"""Reads measured curves from CSV files that declare what they are; the form is described in `curves/README.md`."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cases.errors import CaseError, as_written, nearest, printable
from cases.experiment.published import INCH, PERCENT, channel_is_usable
from cases.library.thesis import RUNS, run_name

Origin = Literal["measured", "digitised", "synthetic"]

#: The folder to read instead of the project's own.
FOLDER_VARIABLE: Final = "QUICKRETURN_CURVES"

_ACCELERATION_UNITS: Final = {"m/s^2": 1.0, "in/s^2": INCH, "g": 9.80665}
_STRAIN_UNITS: Final = {"strain": 1.0, "percent": PERCENT, "microstrain": 1e-6}
#: Channel -> accepted units with their SI values.
CHANNELS: Final[Mapping[str, Mapping[str, float]]] = {
    "tip_acceleration": _ACCELERATION_UNITS,
    "strain_1": _STRAIN_UNITS,
    "strain_2": _STRAIN_UNITS,
    "strain_3": _STRAIN_UNITS,
}
_CHOICES: Final[Mapping[str, tuple[str, ...]]] = {
    "run": tuple(str(run) for run in RUNS),
    "channel": tuple(CHANNELS),
    "unit": (*_ACCELERATION_UNITS, *_STRAIN_UNITS),
    "sign": ("+1", "-1"),
    "axis": ("phase", "time", "crank_angle"),
    "origin": ("measured", "digitised", "synthetic"),
}
_KEYS: Final = (*_CHOICES, "source")
_LARGEST_GAP: Final = 0.01  # of a cycle, also at its ends: the first mode turns up to some 25 times in a cycle, that is 4 points each
_LARGEST_FILE: Final = 20_000_000  # bytes


@dataclass(frozen=True)
class MeasuredCurve:
    """One channel of one run over one cycle, in SI units and with our sign.

    Attributes:
        run: number of the run.
        channel: trajectory column.
        crank_angle: rad, shape (n,), increasing, from about pi (slider farthest) to about 3 pi.
        time: s since the crank stood at pi, shape (n,): (crank_angle - pi) / crank_speed.
        values: m/s^2 or 1, shape (n,).
        crank_speed: rad/s, the mean one that relates time and crank angle.
        origin: "measured", "digitised" or "synthetic"; a synthetic curve must never be shown without this word.
        source: where it is from, in the words of the file.
        declared: the header as written: unit, sign, axis and the rest, to be shown with the curve.
        path: the file.
    """

    run: int
    channel: str
    crank_angle: NDArray[np.float64]
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    crank_speed: float
    origin: Origin
    source: str
    declared: Mapping[str, str]
    path: Path

    @property
    def case_name(self) -> str:
        """The run's case in the library."""
        return run_name(self.run)

    @property
    def usable(self) -> bool:
        """Whether the thesis calls this channel of this run valid (section 3.5)."""
        return channel_is_usable(self.run, self.channel)


def load_curves(folder: str | Path | None = None) -> list[MeasuredCurve]:
    """All curves of a folder, in the order of runs and channels.

    Args:
        folder: default: what the environment variable QUICKRETURN_CURVES names, else the project's own folder.

    Raises:
        CaseError: no such folder, a file that breaks the documented form, two files for the same run and channel.
    """
    place = Path(folder or os.environ.get(FOLDER_VARIABLE) or str(files("cases.experiment") / "curves"))
    if not place.is_dir():
        raise CaseError(printable(str(place)), None, None, "is no folder", f"{FOLDER_VARIABLE} names a folder of CSV files")
    curves: dict[tuple[int, str], MeasuredCurve] = {}
    for path in sorted(place.glob("*.csv")):
        curve = read_curve(path)
        if (curve.run, curve.channel) in curves:
            other = curves[curve.run, curve.channel].path.name
            raise CaseError(str(path), None, None, f"{curve.channel} of run {curve.run} is already given by {other}", "keep one of them")
        curves[curve.run, curve.channel] = curve
    return [curves[key] for key in sorted(curves)]


def read_curve(path: Path) -> MeasuredCurve:
    """One curve.

    Raises:
        CaseError: the file breaks the documented form.
    """
    source = printable(str(path))
    lines = _read_lines(path, source)
    declared = _read_header(source, lines)
    table = _read_columns(source, lines)
    run, channel, unit = int(declared["run"]), declared["channel"], declared["unit"]
    if unit not in CHANNELS[channel]:
        raise CaseError(source, "unit", as_written(unit), f"does not measure {channel}", f"accepted are {', '.join(CHANNELS[channel])}")
    speed = float(RUNS[run].crank_speed)
    phase = table[:, 0] * {"phase": 1.0, "time": speed / (2.0 * np.pi), "crank_angle": 1.0 / 360.0}[declared["axis"]]
    if declared["axis"] == "crank_angle":
        phase -= 0.5
    _check_cycle(source, phase)
    return MeasuredCurve(
        run=run,
        channel=channel,
        crank_angle=np.pi + 2.0 * np.pi * phase,
        time=2.0 * np.pi * phase / speed,
        values=table[:, 1] * CHANNELS[channel][unit] * float(declared["sign"]),
        crank_speed=speed,
        origin=declared["origin"],  # type: ignore[arg-type]  # one of the accepted texts
        source=declared["source"],
        declared=declared,
        path=path,
    )


def _read_lines(path: Path, source: str) -> list[tuple[int, str]]:
    """Numbered lines that are not empty."""
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise CaseError(source, None, None, f"is larger than {_LARGEST_FILE // 1_000_000} MB", "a curve is one cycle of one channel")
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise CaseError(source, None, None, "is not in UTF-8", "save it as plain text in UTF-8") from None
    except OSError as trouble:
        raise CaseError(source, None, None, f"cannot be read ({trouble.strerror})") from None
    return [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]


def _read_header(source: str, lines: list[tuple[int, str]]) -> dict[str, str]:
    declared: dict[str, str] = {}
    for number, line in lines:
        if not line.startswith("#"):
            continue
        key, equals, value = (part.strip() for part in line.lstrip("#").partition("="))
        if not equals:
            raise CaseError(source, f"line {number}", as_written(line), "is no header line", 'write "# key = value"')
        if key not in _KEYS:
            raise CaseError(source, f"line {number}", as_written(key), "is no known key", f"the nearest one is {nearest(key, _KEYS)}")
        if key in declared:
            raise CaseError(source, f"line {number}", as_written(key), "is declared twice", "declare each key once")
        if not value or value not in _CHOICES.get(key, (value,)):
            accepted = "where the curve is from" if key == "source" else f"one of {', '.join(_CHOICES[key])}"
            raise CaseError(source, key, as_written(value), "is not accepted", f"give {accepted}")
        declared[key] = value
    for key in _KEYS:
        if key not in declared:
            choices = ", ".join(_CHOICES.get(key, ("free text",)))
            raise CaseError(source, key, None, "this declaration is missing", f'write "# {key} = ..." with one of: {choices}')
    return declared


def _read_columns(source: str, lines: list[tuple[int, str]]) -> NDArray[np.float64]:
    rows = []
    for number, line in lines:
        if line.startswith("#"):
            continue
        fields = line.split(",")
        try:
            row = tuple(float(field) for field in fields)
        except ValueError:
            row = ()
        if len(row) != 2 or not all(np.isfinite(row)):
            hint = " (the decimal sign is a point)" if len(fields) in (3, 4) else ""
            raise CaseError(source, f"line {number}", as_written(line), f"is not two numbers{hint}", 'write a row such as "0.002, -655"')
        rows.append(row)
    if not rows:
        raise CaseError(source, None, None, "has no points", 'after the header come rows such as "0.002, -655"')
    return np.array(rows)


def _check_cycle(source: str, phase: NDArray[np.float64]) -> None:
    """Raise unless the points cover one cycle, in order and without gaps."""
    for index, (before, after) in enumerate(pairwise(phase.tolist()), start=2):
        if after <= before:
            raise CaseError(source, f"point {index}", None, "the first column does not increase", "sort the rows and drop doubles")
        if after - before > _LARGEST_GAP:
            raise CaseError(
                source, f"point {index}", None, f"{after - before:.3g} of a cycle lie before it", f"at most {_LARGEST_GAP} are accepted"
            )
    first, last = float(phase[0]), float(phase[-1])
    if not (0.0 <= first <= _LARGEST_GAP and 1.0 - _LARGEST_GAP <= last <= 1.0 + 1e-9):
        raise CaseError(
            source,
            None,
            None,
            f"covers {first:.4g} to {last:.4g} cycles after 180 deg",
            f"exactly one cycle is accepted: from 0 (at most {_LARGEST_GAP} later) to 1 (at most {_LARGEST_GAP} earlier)",
        )
