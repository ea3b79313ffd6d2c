"""Measured curves, measured like an engine's cycle and held against the engines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.comparison import HALVES, CaseResult
from cases.experiment import MeasuredCurve
from cases.measures import measure_cycle, time_scale
from cases.measures.consensus import consensus
from reports.findings.runs import thesis_runs


@dataclass(frozen=True)
class Comparison:
    """One half of a measured curve.

    Attributes:
        curve: the curve.
        half: "pre" or "post".
        measure: numbers of `cases.measures.Measure`; extremes after a zero-phase low-pass at 200 Hz.
        engines: engine -> the same numbers of its cycle.
    """

    curve: MeasuredCurve
    half: str
    measure: dict[str, Any]
    engines: dict[str, dict[str, Any]]


def measured_comparisons(results: Sequence[CaseResult], curves: Sequence[MeasuredCurve]) -> list[Comparison]:
    """All curves of the runs shown, both halves each."""
    shown = thesis_runs(results)
    found = []
    for curve in curves:
        if curve.run not in shown:
            continue
        result = shown[curve.run]
        measured = measure_cycle(
            time_scale(result.case.mechanism), curve.time, curve.crank_angle, {curve.channel: curve.values}, measured=True
        )
        for measure in measured.measures:
            engines = {}
            for name, run in result.runs.items():
                its = run.measure(measure.half, curve.channel)
                if run.usable and its is not None:
                    engines[name] = its
            found.append(Comparison(curve, measure.half, vars(measure), engines))
    return found


def statement_values(comparisons: Sequence[Comparison], engine: str) -> dict[str, dict[int, float]]:
    """Ratios simulation / experiment for the thesis' relations: quantity of a statement -> run -> ratio.

    Made-up curves and channels that the thesis calls unusable do not count.
    """
    values: dict[str, dict[int, float]] = {}
    valid = [item for item in comparisons if item.curve.origin != "synthetic" and item.curve.usable and engine in item.engines]
    for run in sorted({item.curve.run for item in valid}):
        for half in HALVES:
            here = [item for item in valid if item.curve.run == run and item.half == half]
            frequency = _frequency_ratio(here, engine)
            amplitude = _amplitude_ratio(here, engine)
            if frequency is not None:
                values.setdefault(f"{half}_frequency", {})[run] = frequency
            if amplitude is not None:
                values.setdefault(f"{half}_amplitude", {})[run] = amplitude
    pre, post = values.get("pre_frequency", {}), values.get("post_frequency", {})
    both = {run: post[run] / pre[run] for run in pre if run in post}
    return values | ({"post_over_pre_frequency": both} if both else {})


def _frequency_ratio(items: Sequence[Comparison], engine: str) -> float | None:
    """Of the consensus over the measured channels, and over the same channels of the engine."""
    sides: list[list[tuple[float, float]]] = [[], []]
    for item in items:
        for side, numbers in zip(sides, (item.engines[engine], item.measure), strict=True):
            if item.measure["first_mode_frequency"] is not None and item.engines[engine]["first_mode_frequency"] is not None:
                side.append((numbers["first_mode_frequency"], numbers["first_mode_frequency_uncertainty"]))
    if not sides[0]:
        return None
    simulated, measured = (consensus("", [value for value, _ in side], [width for _, width in side]) for side in sides)
    assert simulated.first_mode_frequency is not None
    assert measured.first_mode_frequency is not None
    return simulated.first_mode_frequency / measured.first_mode_frequency


def _amplitude_ratio(items: Sequence[Comparison], engine: str) -> float | None:
    """Geometric mean over the channels."""
    ratios = [_ratio(item.engines[engine], item.measure, "first_mode_amplitude") for item in items]
    known = [ratio for ratio in ratios if ratio is not None]
    return float(np.exp(np.mean(np.log(known)))) if known else None


def _ratio(numbers: Mapping[str, Any], other: Mapping[str, Any], quantity: str) -> float | None:
    pair = numbers[quantity], other[quantity]
    return None if pair[0] is None or not pair[1] else float(pair[0]) / float(pair[1])
