"""Names what is probably wrong with a machine that was built in another program, whose table has right columns and a wrong motion.

The rules are those of the constructions in `examples/as_built/`: a soft contact shows in the gap and in a low frequency, friction in a
slow crank, an integrator in too much damping, and a polygon of links, or a long step, in neither of these.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from quickreturn.cases.measures.time_scale import TimeScale, time_scale
from quickreturn.cases.shown import Units
from quickreturn.engines.relative import rms
from quickreturn.reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: Least largest gap, as a part of the largest tip deflection, that a soft contact explains: rigid ones of examples/as_built have 0.3 %.
LOOSE: Final = 5e-3
#: Least part by which a turn takes longer that friction explains: without it constructions of examples/as_built take 0.7 % longer at most.
SLOW: Final = 0.01
#: Deviation of a first frequency that counts as right.
RIGHT: Final = 0.01
#: Least additional damping ratio that an integrator explains, and the most that it leaves of what the fit without damping leaves: sliding
#: joints and chains without damping show 0.0022 at most, integrators that damp leave 0.4 to 0.8.
ADDED: Final = 3e-3
LEAVES: Final = 0.82
POINTS: Final = 400  # crank angles in a turn
_TOLERANCE: Final = 1e-6
_TRY: Final = "take friction away, double the links, halve the step: what moves it is the cause"


@dataclass(frozen=True)
class Departure:
    """A tip deflection's departure from the right one, taken as a change of the first mode.

    Attributes:
        frequency: relative change of the mode's frequency.
        damping: change of its damping ratio.
        left: RMS that both changes leave, over what the frequency alone leaves.
    """

    frequency: float
    damping: float
    left: float


def built_otherwise(table: Mapping[str, Array], right: Mapping[str, Array], gap: float | None, mechanism: Mechanism, units: Units) -> str:
    """A hypothesis on the construction, with its evidence and what to do; "" where the tip deflection shows none.

    Args:
        table: columns of the table's turn, SI.
        right: columns of an engine's, in the same turn or state.
        gap: largest distance of the slider from the centre line in the table, m; None: not recorded.
        mechanism: the scene.
        units: units of the sentence.
    """
    scale = time_scale(mechanism)
    if scale is None or not {"tip_deflection", "crank_angle"} <= table.keys() & right.keys():
        return ""
    later = float(np.ptp(table["time"]) / np.ptp(right["time"])) - 1.0
    found = departure(table, right, scale, mechanism)
    if gap is not None and mechanism.slider.is_rigid and gap > LOOSE * float(np.max(np.abs(right["tip_deflection"]))):
        low = f", and the first mode's frequency is {-100.0 * found.frequency:.2g} % low" if found.frequency < 0.0 else ""
        advice = "give the contact a time constant of two steps, or hold the slider by a joint"
        return f"probably a soft contact: the slider is up to {units.of('m').text(gap, '.2g')} off the centre line{low}; {advice}"
    if later > SLOW:
        told = f"a turn of the crank takes {100.0 * later:.2g} % longer"
        return f"probably friction, or another drive: {told}; set the friction of the slider's contact to zero"
    if abs(found.frequency) > RIGHT:
        return ""
    if found.damping > ADDED and found.left < LEAVES:
        told = f"the first mode's damping ratio is {found.damping:.2g} larger, its frequency right"
        return f"probably an integrator that damps: {told}; halve the step, or take another integrator"
    told = "neither the first mode's frequency nor its damping explains the tip deflection"
    return f"probably friction, the corners of a chain of links, or a long step: {told}; {_TRY}"


def departure(table: Mapping[str, Array], right: Mapping[str, Array], scale: TimeScale, mechanism: Mechanism) -> Departure:
    """How the first mode of a table differs, from the difference d of the tip deflections at equal crank angles.

    With the mode's angular frequency w and damping ratio z, y'' + 2 z w y' + w² y is the load of both motions. So to first order
    d'' + 2 z w d' + w² d = -2 dz w y' - 2 (dw / w) w² y, where z is the table's. Least squares give dz, dw / w and the start of d.
    """
    (time, angle, other), (_, _, y) = (_on_turn(columns) for columns in (table, right))
    frequency = 2.0 * np.pi * scale.running_frequencies(angle, np.gradient(angle, time))[:, 0]
    omega, course = CubicSpline(time, frequency), CubicSpline(time, y)
    rate, difference, follower = course.derivative(), other - y, mechanism.follower
    natural = float(np.mean(frequency))
    own = 0.5 * (follower.material_damping * natural + follower.damping / (follower.mass_per_length * natural))
    damping = 0.0
    for _ in range(3):  # the damping of the left side is the result

        def motions(t: float, state: Array, ratio: float = max(own + damping, 0.0)) -> Array:
            w, x = float(omega(t)), state.reshape(4, 2)
            loads = np.array([0.0, 0.0, -2.0 * w * float(rate(t)), -2.0 * w**2 * float(course(t))])
            return np.column_stack([x[:, 1], loads - 2.0 * ratio * w * x[:, 1] - w**2 * x[:, 0]]).ravel()

        start = np.array([1.0, 0.0, 0.0, natural, 0.0, 0.0, 0.0, 0.0])
        solved = solve_ivp(motions, (time[0], time[-1]), start, t_eval=time, rtol=_TOLERANCE, atol=_TOLERANCE)
        parts = solved.y.reshape(4, 2, -1)[:, 0].T
        shares, undamped = (np.linalg.lstsq(some, difference, rcond=None)[0] for some in (parts, parts[:, [0, 1, 3]]))
        damping = float(shares[2])
    left, without = rms(difference - parts @ shares), rms(difference - parts[:, [0, 1, 3]] @ undamped)
    return Departure(float(shares[3]), damping, left / without if without > 0.0 else 1.0)


def _on_turn(columns: Mapping[str, Array]) -> tuple[Array, Array, Array]:
    """Time from the start of the turn, crank angle and tip deflection at evenly spaced crank angles."""
    turned = np.abs(columns["crank_angle"] - columns["crank_angle"][0])
    even = np.linspace(0.0, turned[-1], POINTS)
    time, angle = (np.interp(even, turned, columns[name]) for name in ("time", "crank_angle"))
    return time - time[0], angle, CubicSpline(columns["time"], columns["tip_deflection"])(time)
