"""Loads on the parts of the library's example with known numbers, by the reference alone."""

import dataclasses
from typing import Any

from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.resonance import Resonance
from quickreturn.plugins.strength.case_loads import CaseLoads, loads_of_case
from quickreturn.plugins.strength.stress import Factor, Fatigue
from tests.reports.reported_results import reported_result

#: 9.2 oscillations in a turn.
RESONANCE = Resonance(first_mode=18.4, lowest=12.1, crank=2.0)


def made_up_loads() -> CaseLoads:
    """12.346 MPa at 375 mm off by 1 %, an amplitude of 8 MPa about -0.02 MPa at 400 mm, safety 2 and 3, 9.2 oscillations in a turn."""
    found = loads_of_case(reported_result("example"))
    loads = found.loads["reference"]
    assert loads.stress is not None
    known = {"value": 12.346e6, "place": 0.375, "crank_angle": 5.65, "measurement": 0.0, "estimate": 0.12346e6}
    largest = dataclasses.replace(loads.stress.largest, **known)  # type: ignore[arg-type]
    amplitude = dataclasses.replace(loads.stress.amplitude, value=8e6, place=0.4)
    fatigue = Fatigue(equivalent=amplitude, notch_factor=1.0, amplitude=8e6, mean=-0.02e6, ranges=(16e6, 4e6))
    stress = dataclasses.replace(loads.stress, largest=largest, axial=Number(-0.05e6), amplitude=amplitude, mean=-0.02e6, fatigue=fatigue)
    factors = {"yield_factor": Factor(2.0, 1.9, 2.1, 0.05), "fatigue_factor": Factor(3.0, 2.9, 3.1, 0.03)}
    return with_resonance(CaseLoads(found.result, {"reference": dataclasses.replace(loads, stress=stress, modulus=70e9, **factors)}))


def with_resonance(case: CaseLoads, **known: Any) -> CaseLoads:
    """The same loads beside another first mode, whose error is 0.092 Hz; `known`: further values of `CaseLoads`."""
    made = dataclasses.replace(case)
    vars(made).update(resonance=RESONANCE, shift_of_motion=0.092, **{"share": None} | known)  # in place of what would be computed
    return made


def without(case: CaseLoads, *factors: str) -> CaseLoads:
    """The same loads without some safety factors."""
    return with_resonance(
        dataclasses.replace(case, loads={"reference": dataclasses.replace(case.loads["reference"], **dict.fromkeys(factors))})
    )
