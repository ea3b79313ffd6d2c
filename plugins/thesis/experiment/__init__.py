"""Remaining data of the experiment: speeds, frequencies, axis labels, words; recordings of it belong into `curves`."""

from quickreturn.plugins.thesis.experiment.published import AxisLabels, axis_labels, channel_is_usable, measured_crank_speed
from quickreturn.plugins.thesis.experiment.statements import Statement, statements

__all__ = ["AxisLabels", "Statement", "axis_labels", "channel_is_usable", "measured_crank_speed", "statements"]
