"""Warns of a machine whose crank turns so slowly that the simulation of whole turns takes minutes."""

from typing import Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.resonance import resonance
from quickreturn.reference_model.rigid import mean_crank_speed

#: Slowest crank (rad/s, 9.5 rpm) that is not looked at more closely: the computation of the first mode takes a while.
SLOWEST_CRANK: Final = 1.0
#: Vibrations of the first mode in a turn above which a steady state takes more than about a minute.
MOST_VIBRATIONS: Final = 1000.0
#: Computing time (s) of a steady state by `reference` for each of them: 0.02 to 0.07 were measured for 250 to 500 of run 24's arm.
SECONDS_PER_VIBRATION: Final = 0.07


def warning(case: Case) -> str:
    """How long the steady state of a case will take, and what to do (a sentence); "" if that is not long."""
    if case.scene.crank is None or not 0.0 < abs(mean_crank_speed(case.mechanism)) < SLOWEST_CRANK:
        return ""
    first = resonance(case.mechanism)
    if first is None or first.ratio < MOST_VIBRATIONS:
        return ""
    minutes, times = max(round(SECONDS_PER_VIBRATION * first.ratio / 60.0), 1), float(f"{first.ratio:.2g}")
    return (
        f"the crank takes {1.0 / first.crank:.3g} s for a turn, in which the arm vibrates about {times:,.0f} times: a steady state by"
        f" reference takes about {minutes} min, by other engines longer; give a higher speed, or simulate a shorter time with"
        " `quickreturn simulate --duration`"
    )
