"""Finds the library case of a recorded table that does not fit the case that it is compared with.

A turn of the crank has traits that follow from the scene in closed form or nearly so: its duration, the slider's nearest and farthest
place, the reach of the arm, the first natural frequency, the size of deflection and slider force. Each is a positive number, and the ratio
of a table's to a case's expected one is compared. An engine on the given case shows the error of the expectation itself.
"""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from quickreturn.cases.case import Case
from quickreturn.cases.library import case_names, library_case
from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.request import NOTHING, Run
from quickreturn.engines.relative import rms
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes, turn_angles
from quickreturn.reference_model.rigid import crank_pace, mean_crank_speed, rigid_kinetostatics, static_deflection


class Trait(NamedTuple):
    """A trait of a turn in words, and its tolerance."""

    words: str  # with places for the table's value, the given case's, and that case's name
    unit: str  # SI
    factor: float  # largest ratio of a table's value to that expected for its own case, or of this to the table's
    elsewhere: float = 1.0  # factor on the logarithm of this tolerance if the given case is not the table's own


#: Value of `Trait.elsewhere` for frequencies: the first mode is fitted with the shapes of the given case. If these are not the table's own,
#: the frequency is up to 5 % off in the thesis' runs.
_WRONG_SHAPE: Final = 2.0
#: An engine that is 10 % off in the deflection keeps the length of a turn to 1e-4 and places of the slider to 1e-3. One cubic, the coarsest
#: model known here, has a first frequency that is 13 % too high, but the length of the turn and all places are right.
TRAITS: Final[Mapping[str, Trait]] = {
    "turn": Trait("a turn takes {} in it, {} in {}", "s", 1.003),
    "nearest": Trait("the slider comes as near as {} to P in it, {} in {}", "m", 1.005),
    "farthest": Trait("the slider goes as far as {} from P in it, {} in {}", "m", 1.005),
    "reach": Trait("the tip is {} beyond O when the slider is farthest, {} in {}", "m", 1.01),
    "pre frequency": Trait("its first mode has {} before the return, {} in {}", "Hz", 1.04, _WRONG_SHAPE),
    "post frequency": Trait("its first mode has {} after the return, {} in {}", "Hz", 1.04, _WRONG_SHAPE),
    # Deflection and force grow with vibration, which depends on how near a harmonic of the crank is to the first mode.
    "deflection": Trait("the tip deflects by {} RMS in it, by {} in {}", "m", 2.5),
    "force": Trait("the slider force is {} RMS in it, {} in {}", "N", 1.6),
}
#: Scatter of measured traits, as a part of the logarithm of their factor: a trait that fits the given case better by more rules out a case.
_SCATTER: Final = 0.25
#: Least number of traits in a table for a verdict that it is of another case.
FEWEST: Final = 2
#: Largest number of cases that are named.
MOST_NAMED: Final = 3
#: Traits that a single wrong column may also explain: a unit, a factor.
_WEAK: Final = frozenset(("deflection", "force"))
#: Likewise, if the table has one column only in which vibration is measured.
_OF_CHANNELS: Final = frozenset(("pre frequency", "post frequency"))
_ANGLES: Final = 24  # number of crank angles in a turn at which frequencies and forces of a case are taken


class OtherCases(NamedTuple):
    """Cases of the library that fit a table which does not fit its own."""

    names: tuple[str, ...] = ()  # empty if the given case fits, or if no case of the library does
    told: str = ""  # evidence that the given case does not fit (a clause); "" if it fits
    sure: bool = False  # whether the evidence is more than the size of single columns


def other_cases(run: Run, other: Run, case: Case) -> OtherCases:
    """The cases of the library that fit a table better than the given one.

    `run` is that of the table, `other` that of an engine on the given case, in the same turn or the same state.
    """
    shown, right, expected = _measured_traits(run), _measured_traits(other), _expected_traits(case.mechanism)
    names = [name for name in TRAITS if name in shown and name in right and name in expected]
    errors = {name: _trait_error(shown[name], right[name], name) for name in names}
    odd = [name for name in names if errors[name] > 1.0]
    if not odd or len(names) < FEWEST:
        return OtherCases()
    worth_telling = [name for name in odd if name != "post frequency" or "pre frequency" not in odd][:2]
    units = {name: case.units.of(TRAITS[name].unit) for name in worth_telling}
    told = "; ".join(TRAITS[name].words.format(unit.text(shown[name]), unit.text(right[name]), case.name) for name, unit in units.items())
    fitting: dict[str, float] = {}
    for candidate in case_names():
        mechanism = _scene(candidate)
        if mechanism is None or mechanism == case.mechanism or _rotation(mechanism) != _rotation(case.mechanism):
            continue
        worst = None
        for tried in ([name for name in names if "frequency" not in name], names):  # frequencies take longest
            theirs = _expected_traits(mechanism, tried)
            corrections = {name: right[name] / expected[name] for name in tried}
            worst = _largest_error(shown, theirs, errors, corrections) if len(theirs) == len(tried) else None
            if worst is None:
                break
        if worst is not None:
            fitting[candidate] = worst
    weak = _WEAK if len(run.cycle.keys() & set(CHANNELS)) > 1 else _WEAK | _OF_CHANNELS
    return OtherCases(_best(fitting), told, not weak.issuperset(odd))


def cases_of_pace(turn: float, slider: tuple[float, float] | None) -> tuple[str, ...]:
    """Cases of the library with a given duration of a turn and, if known, the slider's least and greatest distance, in either rotation.

    Args:
        turn: duration of a turn, s.
        slider: its least and its greatest distance from P, m.
    """
    shown = {"turn": turn} | (dict(zip(("nearest", "farthest"), slider, strict=True)) if slider else {})
    shown = {name: value for name, value in shown.items() if value > 0.0}
    scenes = {name: scene for name in case_names() if (scene := _scene(name)) is not None}
    errors = {name: _largest_error(shown, _expected_traits(scene, list(shown)), {}, {}) for name, scene in scenes.items()}
    return _best({name: error for name, error in errors.items() if error is not None})


def _best(fitting: Mapping[str, float]) -> tuple[str, ...]:
    """The cases that fit about as well as the best one, at most `MOST_NAMED`, in the library's order.

    `fitting`: name of a case -> its largest error of a trait.
    """
    least = min(fitting.values(), default=0.0)
    return tuple(name for name, worst in fitting.items() if worst <= least + _SCATTER)[:MOST_NAMED]


def _scene(name: str) -> Mechanism | None:
    """The mechanism of a case of the library; None if it has none or its crank does not turn."""
    scene = library_case(name).scene
    return scene if scene.crank is not None and crank_pace(scene) > 0.0 else None


def _rotation(mechanism: Mechanism) -> bool:
    return mean_crank_speed(mechanism) > 0.0


def _measured_traits(run: Run) -> dict[str, float]:
    """The traits of a measured turn."""
    cycle = run.cycle
    traits = {"turn": float(cycle["time"][-1] - cycle["time"][0])}
    if "slider_position" in cycle:
        traits |= {"nearest": float(np.min(cycle["slider_position"])), "farthest": float(np.max(cycle["slider_position"]))}
    if "tip_x" in cycle:
        traits["reach"] = -float(cycle["tip_x"][0])
    for half in HALVES:
        traits[f"{half} frequency"] = run.consensus_frequency(half) or 0.0
    for name, column in (("deflection", "tip_deflection"), ("force", "slider_force")):
        traits[name] = rms(cycle[column]) if column in cycle else 0.0
    return {name: value for name, value in traits.items() if value > NOTHING}


def _expected_traits(mechanism: Mechanism, names: list[str] | None = None) -> dict[str, float]:
    """The expected traits of a scene, all or those of some names."""
    pace, crank, angles = crank_pace(mechanism), mechanism.crank, np.linspace(0.0, 2.0 * math.pi, _ANGLES, endpoint=False)
    traits = {
        "turn": 2.0 * math.pi / pace,
        "nearest": mechanism.nearest,
        "farthest": mechanism.pivot_distance + crank.length,
        "reach": mechanism.follower.length - mechanism.pivot_distance,
        "deflection": static_deflection(mechanism, pace),
        "force": rms(rigid_kinetostatics(mechanism, angles, pace)[0]),
    }
    halves = [name for name in TRAITS if "frequency" in name and (names is None or name in names)]
    if halves and not mechanism.follower.is_rigid:
        half = turn_angles(mechanism, _ANGLES // 2 + 1)
        traits |= dict.fromkeys(halves, float(np.mean([frozen_crank_modes(mechanism, float(angle), 1).frequencies[0] for angle in half])))
    return {name: value for name, value in traits.items() if value > NOTHING and (names is None or name in names)}


def _trait_error(value: float, expected: float, name: str) -> float:
    """The error of a trait over its tolerance, both as logarithms."""
    return abs(math.log(value / expected)) / math.log(TRAITS[name].factor)


def _largest_error(
    shown: Mapping[str, float], expected: Mapping[str, float], given_errors: Mapping[str, float], corrections: Mapping[str, float]
) -> float | None:
    """The largest error of a table's traits for a tried case; None if that case does not fit.

    Args:
        shown: traits of the table.
        expected: traits of the tried case.
        given_errors: error of each trait for the given case; the tried case must not fit any much worse.
        corrections: factors by which an engine's traits on the given case differ from the expected ones. Each expectation is tried with and
            without its factor, which may be less in the tried case.
    """
    errors = {
        name: min(_trait_error(shown[name], value * factor, name) for factor in (1.0, corrections.get(name, 1.0)))
        for name, value in expected.items()
    }
    for name, error in errors.items():
        elsewhere = TRAITS[name].elsewhere
        if error > min(elsewhere, given_errors.get(name, math.inf) + _SCATTER if elsewhere == 1.0 else math.inf):
            return None
    return max(errors.values())
