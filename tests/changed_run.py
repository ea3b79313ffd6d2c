"""Runs and measures with values chosen by tests."""

from dataclasses import replace
from typing import Any

from quickreturn.cases.motion.cycle import ChannelMeasures
from quickreturn.cases.motion.request import Run


def changed_run(run: Run, **values: Any) -> Run:
    """The run with other values of its fields and of the fields of its parts, by their names."""
    parts = {}
    for part in ("computation", "approach", "measured"):
        of_part = getattr(run, part)
        parts[part] = replace(of_part, **{name: values.pop(name) for name in vars(of_part) if name in values})
    return replace(run, **(parts | values))


#: What measures say of a mode that they do not resolve.
UNRESOLVED = dict.fromkeys(
    ("first_mode_frequency", "first_mode_frequency_uncertainty", "first_mode_amplitude", "first_mode_amplitude_uncertainty")
)


def measured(half: str = "pre", channel: str = "strain_1", **values: Any) -> ChannelMeasures:
    """Measures of a channel that vibrates with 17 Hz, and between -5 and 5, with other values of some."""
    modes = {**UNRESOLVED, "first_mode_frequency": 17.0, "second_mode_frequency": None}
    extremes = {"minimum": -5.0, "minimum_uncertainty": 0.0, "maximum": 5.0, "maximum_uncertainty": 0.0}
    return ChannelMeasures(**{"half": half, "channel": channel, **modes, **extremes, "reason": "", **values})
