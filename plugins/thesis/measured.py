"""Evaluates the thesis' statements from recordings of its experiment."""

from collections.abc import Sequence

import numpy as np

from quickreturn.cases.library.thesis.runs import RUNS, run_name
from quickreturn.cases.motion.cycle import HALVES, consensus_of
from quickreturn.plugins.thesis.experiment import channel_is_usable
from quickreturn.reports.page.content import MeasuredHalf


def counts(item: MeasuredHalf) -> bool:
    """Whether an item is a genuine recording of the experiment, in a channel that section 3.5 calls valid."""
    recording, run = item.table.recording, next((number for number in RUNS if run_name(number) == item.case.name), None)
    if recording is None or run is None or item.case.source != "library":
        return False
    return recording.of_experiment and recording.declared.get("origin") != "synthetic" and channel_is_usable(run, item.measure.channel)


def statement_values(comparisons: Sequence[MeasuredHalf], engine: str) -> dict[str, dict[int, float]]:
    """Ratios simulation / experiment for the thesis' relations: quantity of a statement -> run -> ratio.

    Only recordings of the experiment count; made-up curves and channels that the thesis calls unusable do not.
    """
    values: dict[str, dict[int, float]] = {}
    valid = [item for item in comparisons if counts(item) and engine in item.engines]
    for run, name in ((number, run_name(number)) for number in RUNS):
        for half in HALVES:
            here = [item for item in valid if item.case.name == name and item.measure.half == half]
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
    """Ratio of the consensus over the engine's channels to that over the same measured channels."""
    pairs = [(item.engines[engine], item.measure) for item in items]
    both = [pair for pair in pairs if all(measure.first_mode_frequency is not None for measure in pair)]
    simulated, measured = (consensus_of("", [pair[side] for pair in both]).first_mode_frequency for side in (0, 1))
    return None if simulated is None or measured is None else simulated / measured


def _amplitude_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Ratio of amplitudes, as the geometric mean over the channels."""
    pairs = [(item.engines[engine].first_mode_amplitude, item.measure.first_mode_amplitude) for item in items]
    ratios = [value / other_value for value, other_value in pairs if value is not None and other_value]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else None
