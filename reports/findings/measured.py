"""Measured curves, measured like an engine's cycle and held against the engines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cases.experiment import MeasuredCurve
from cases.measures import Measure, consensus_of, measure_cycle, time_scale
from cases.runs.comparison import HALVES, CaseResult
from reports.findings.runs import thesis_runs


@dataclass(frozen=True)
class MeasuredHalf:
    """One half of a measured curve.

    Attributes:
        curve: the curve.
        measure: of it; extremes after a zero-phase low-pass at 200 Hz.
        engines: engine -> the same of its cycle.
    """

    curve: MeasuredCurve
    measure: Measure
    engines: Mapping[str, Measure]


def measured_comparisons(results: Sequence[CaseResult], curves: Sequence[MeasuredCurve]) -> list[MeasuredHalf]:
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
            found.append(MeasuredHalf(curve, measure, engines))
    return found


def statement_values(comparisons: Sequence[MeasuredHalf], engine: str) -> dict[str, dict[int, float]]:
    """Ratios simulation / experiment for the thesis' relations: quantity of a statement -> run -> ratio.

    Made-up curves and channels that the thesis calls unusable do not count.
    """
    values: dict[str, dict[int, float]] = {}
    valid = [item for item in comparisons if item.curve.origin != "synthetic" and item.curve.usable and engine in item.engines]
    for run in sorted({item.curve.run for item in valid}):
        for half in HALVES:
            here = [item for item in valid if item.curve.run == run and item.measure.half == half]
            frequency = _frequency_ratio(here, engine)
            amplitude = _amplitude_ratio(here, engine)
            if frequency is not None:
                values.setdefault(f"{half}_frequency", {})[run] = frequency
            if amplitude is not None:
                values.setdefault(f"{half}_amplitude", {})[run] = amplitude
    pre, post = values.get("pre_frequency", {}), values.get("post_frequency", {})
    both = {run: post[run] / pre[run] for run in pre if run in post}
    return values | ({"post_over_pre_frequency": both} if both else {})


def _frequency_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Of the consensus over the measured channels, and over the same channels of the engine."""
    pairs = [(item.engines[engine], item.measure) for item in items]
    both = [pair for pair in pairs if all(measure.first_mode_frequency is not None for measure in pair)]
    simulated, measured = (consensus_of("", [pair[side] for pair in both]).first_mode_frequency for side in (0, 1))
    return None if simulated is None or measured is None else simulated / measured


def _amplitude_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Geometric mean over the channels."""
    pairs = [(item.engines[engine].first_mode_amplitude, item.measure.first_mode_amplitude) for item in items]
    known = [mine / its for mine, its in pairs if mine is not None and its]
    return float(np.exp(np.mean(np.log(known)))) if known else None
