"""What is left of the experiment: speeds, frequencies, axis labels, words; and a place for measured curves when they turn up."""

from cases.experiment.curves import CHANNELS, MeasuredCurve, load_curves
from cases.experiment.published import AxisLabels, axis_labels, channel_is_usable, measured_crank_speed
from cases.experiment.statements import Statement, statements

__all__ = [
    "CHANNELS",
    "AxisLabels",
    "MeasuredCurve",
    "Statement",
    "axis_labels",
    "channel_is_usable",
    "load_curves",
    "measured_crank_speed",
    "statements",
]
