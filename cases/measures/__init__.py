"""What is measured in a cycle, the same for simulated and measured signals.

Pre-return is the half in which the slider travels from its farthest to its nearest place, post-return the way back, whatever the
crank's direction; a cycle starts farthest, at a crank angle of 180°. A half holds three to six oscillations of a first mode whose
frequency drifts with the crank angle, on a large slow part: what is fitted is the drifting oscillation, on the time scale that
the mechanism itself dictates.
"""

from quickreturn.cases.measures.consensus import Consensus
from quickreturn.cases.measures.cycle import CycleMeasures, Measure, consensus_of, extremes_by_half, measure_cycle
from quickreturn.cases.measures.mean_cycle import AVERAGED, mean_measures, standard_error
from quickreturn.cases.measures.steady_state import Cycle, Settling, cut_cycles, on_common_grid, relative_change
from quickreturn.cases.measures.time_scale import CHANNELS, TimeScale, time_scale

__all__ = [
    "AVERAGED",
    "CHANNELS",
    "Consensus",
    "Cycle",
    "CycleMeasures",
    "Measure",
    "Settling",
    "TimeScale",
    "consensus_of",
    "cut_cycles",
    "extremes_by_half",
    "mean_measures",
    "measure_cycle",
    "on_common_grid",
    "relative_change",
    "standard_error",
    "time_scale",
]
