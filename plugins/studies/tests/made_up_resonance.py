"""A made-up resonance curve that folds twice about a machine's own speed: everything on it is known in closed form.

Along u from -1 to 1 the speed over the machine's own is 1 + WIDTH (8 u³ - 3 u) / 5. It turns back at u = ±FOLD, and is the machine's own at
u = 0 and at u = ±OWN.
"""

import math

import numpy as np

from quickreturn.cases.files.shown import Unit
from quickreturn.cases.library import load_case
from quickreturn.plugins.studies.around import Around
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, Range, ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.plugins.studies.resonance_curve.search import USUAL
from quickreturn.reference_model.rigid import mean_crank_speed

WIDTH, FOLD, OWN = 0.14, math.sqrt(1.0 / 8.0), math.sqrt(3.0 / 8.0)
PEAK = 0.85
RPM = math.pi / 30.0


def speed(u: float) -> float:
    """Over the machine's own."""
    return 1.0 + WIDTH * (8.0 * u**3 - 3.0 * u) / 5.0


def height(u: float) -> float:
    """Of the tip acceleration, m/s²; its logarithm is greatest at PEAK."""
    return 300.0 * math.exp(-((u - PEAK) ** 2))


def made_up_around(name: str = "example") -> Around:
    """The curve around the speed of a case of the library."""
    case = load_case(name)
    pace = mean_crank_speed(case.mechanism)
    u = np.union1d(np.linspace(-1.0, 1.0, 61), [-FOLD, FOLD])
    folds = np.searchsorted(u, [-FOLD, FOLD]).tolist()
    unstable = np.abs(u) < FOLD
    peak = int(np.argmin(np.abs(u - PEAK)))
    heights = np.array([height(each) for each in u])
    unknown = np.full(u.shape, math.nan)
    curve = ResonanceCurve(
        range=Range(SPEED, 0.85 * pace, 1.15 * pace, "rpm", RPM),
        prescribed=case.mechanism.crank_is_free,
        values=np.array([pace * speed(each) for each in u]),
        arclength=u + 1.0,
        measures={USUAL: heights},
        errors={USUAL: unknown},
        value_errors=unknown,
        multipliers=np.stack([np.where(unstable, 1.5, 0.5), np.zeros(u.shape)], axis=1),
        kinds=tuple("fold" if each else "" for each in unstable),
        special=tuple(SpecialPoint("fold", pace * speed(float(u[at])), 1e-6, None, at) for at in folds),
        peaks=(ResonancePeak(pace * speed(PEAK), height(PEAK), peak, 8),),
        settings={"modes": 4, "finer_modes": 7, "tolerance": 1e-10},
    )
    return Around(case, curve, Unit("rpm", RPM))
