"""Every output with its witness: columns, measures, and the numbers of results.

The witness of an output is an independent computation that confirms it. Two computations are independent if no file computes what is
compared in both. A closed form counts, another engine with its own equations, another package, or differences of another output.

`python -m tests.witnesses` prints the table that `docs/belief.md` shows.
"""

import dataclasses
import fnmatch
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.cycle import ChannelMeasures
from quickreturn.cases.motion.request import PeriodicOrbit
from quickreturn.cases.motion.resonance import Resonance
from quickreturn.cases.motion.solving import Frequencies
from quickreturn.engines.accurate import Result
from quickreturn.plugins.strength.stress import ArmStress, Factor, Fatigue
from quickreturn.plugins.studies.resonance_curve.curve import ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.plugins.studies.uncertainty.fit import FittedParameter
from quickreturn.plugins.studies.uncertainty.scatter import Quantile, Share
from quickreturn.reference_model.columns import COLUMNS


@dataclass(frozen=True)
class Witness:
    """An independent computation of an output, and how far the two differ."""

    by: str  # the independent computation, in words
    largest: float  # largest difference found, relative to the size of the output
    test: str  # the test that computes the difference, by its name in pytest


#: Classes of results besides trajectories and measures -> what they are called.
RESULTS: Final[dict[type[Any], str]] = {
    ChannelMeasures: "half cycle",
    ArmStress: "stress along the arm",
    Fatigue: "fatigue",
    Factor: "safety factor",
    Resonance: "distance to resonance",
    PeriodicOrbit: "periodic orbit",
    ResonanceCurve: "resonance curve",
    SpecialPoint: "special point",
    ResonancePeak: "peak of a curve",
    Quantile: "quantile",
    Share: "share of variance",
    FittedParameter: "fitted parameter",
    Frequencies: "natural frequencies",
    Result: "simulation",
}
#: Numbers that a result repeats from its request.
GIVEN: Final = {("quantile", "probability"), ("fitted parameter", "start"), ("simulation", "accuracy"), ("resonance curve", "settings")}

#: The independent computation, its test, and lines of outputs of a kind, each or several with the largest difference. `*` stands for
#: anything, COLUMN for all columns but the time; of two witnesses of an output the later one counts.
_TABLE: Final = """
- the grid that is asked for
tests/properties/test_output.py::test_the_output_step_does_not_show
column: time 0
- `mujoco` and `exudyn` beside `reference` in four scenes
tests/verification/test_witnesses.py::test_engines_with_files_of_their_own_confirm_every_column
column: crank_angle 5e-8, crank_speed slider_position 2e-7, follower_angle tip_x 1e-6, tip_y 5e-6, tip_deflection 1.5e-4
column: tip_acceleration 9e-3, strain_1 3e-4, strain_2 strain_3 2e-4, slider_force 3e-3, crank_torque 5e-3, kinetic_energy 2e-7
column: strain_energy 1.5e-4, dissipated_energy 1e-4, constraint_gap 3e-4, gravity_energy 3e-7, drive_work 2e-5, shape_* 7e-3
column: moment_* 1e-3, moment_slider moment_inboard 3e-4, axial_base axial_inboard axial_slider axial_tip 1.5e-3
column: pivot_force_x 2e-3, pivot_force_y 6e-3, crank_force_x 5e-5, crank_force_y 1e-4, follower_rate 6e-4
- deflections in cubic elements beside the tangent angle in modes
tests/reference_model/test_follower_alone.py::test_two_formulations_agree
column: base_torque 1e-5
- the closed form of a spinning rod
tests/verification/test_literature.py::test_every_engine_meets_theory_and_print_in_the_manoeuvre
column: axial_stretch 1e-3
- `mujoco` and `exudyn` beside `reference` with a heavy base and a heavy tip
tests/engines/test_end_moments.py::test_three_engines_ask_for_the_same_moments_at_the_ends
column: moment_base moment_tip follower_acceleration 3e-3
- `mujoco`, `exudyn` and `derived` beside `reference` with a spring
tests/engines/test_spring.py::test_engines_agree_about_a_spring_within_what_they_claim
column: spring_force 1e-3
- plain numpy on rows of 0.1 ms of `mujoco`
tests/verification/test_witnesses.py::test_plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn
measure: peak.COLUMN min.COLUMN max.COLUMN rms.COLUMN peak.pivot_force peak.crank_force peak.axial_stress 5e-4
measure: *.moment_tip *.follower_acceleration 5e-3, variation.crank_speed equivalent.*_force.* 5e-4
measure: period turn.drive_work turn.dissipated_energy turn.pivot_angle mean.crank_speed 2e-5
measure: mean.drive_power rms.drive_power peak.drive_power peak.returned_power 2e-5
- strain gauges of `mujoco` at the place
tests/verification/test_witnesses.py::test_gauges_of_a_link_chain_confirm_the_stress_along_the_arm
measure: peak.stress amplitude.stress 5e-4
- Goodman's line by hand on a rigid arm
plugins/strength/tests/test_fatigue.py::test_the_factor_is_that_of_goodmans_line
measure: equivalent.stress cycles.stress factor.yielding factor.fatigue 2e-3
- the phase of a small free vibration about the motion, without a fit
tests/cases/motion/test_simulated.py::test_frequencies_of_steady_states_lie_within_their_claims
measure: pre.frequency* post.frequency* 8e-3
half cycle: first_mode_frequency 8e-3
- half cycles made of a known vibration: errors beyond twice the uncertainty
tests/verification/test_measures_accuracy.py::test_bias_spread_and_reach
half cycle: first_mode_frequency_uncertainty first_mode_amplitude_uncertainty 0.05
- half cycles made of a known vibration
tests/verification/test_measures_accuracy.py::test_bias_spread_and_reach
measure: pre.amplitude.* post.amplitude.* 0.03
half cycle: first_mode_amplitude 0.03
- noise that is added to a known vibration
tests/cases/motion/test_cycle.py::test_noise_moves_a_number_as_its_gain_says
half cycle: variation first_mode_frequency_gain first_mode_amplitude_gain 0.45
- half cycles made of a known vibration
tests/cases/motion/test_cycle.py::test_strong_second_mode_is_found_where_channels_agree
half cycle: second_mode_frequency 0.01
- a sine
tests/cases/motion/test_cycle.py::test_extremes_belong_to_their_half
half cycle: minimum maximum 1e-6
- corners between samples
tests/cases/motion/test_cycle.py::test_a_corner_between_samples_is_missed_by_no_more_than_is_said
half cycle: minimum_uncertainty maximum_uncertainty 0
- `reference`, `exudyn` and `mujoco` on random machines: differences beyond both claims
tests/verification/test_sensible_machines.py::test_two_hundred_machines_settle_and_engines_agree
half cycle: *_estimate 0
- the decay of disturbances in `mujoco`
tests/verification/test_witnesses.py::test_disturbed_marches_of_a_link_chain_confirm_the_largest_multiplier
measure: multiplier multiplier.real multiplier.imag 5e-5
periodic orbit: multipliers 5e-5
resonance curve: multipliers 5e-5
- the virtual work of a rigid machine by quadrature
plugins/strength/tests/test_drive.py::test_the_drive_of_a_rigid_machine_does_the_virtual_work
measure: torque.harmonic_* mean.crank_torque turn.driven_energy turn.returned_energy flywheel.energy 1e-5
- a free crank with this inertia
plugins/strength/tests/test_drive.py::test_a_crank_with_the_flywheel_fluctuates_as_wanted
measure: flywheel.inertia 0.005
- the clock of the caller: no part takes longer than the call
tests/engines/test_accurate.py::test_no_part_of_a_call_takes_longer_than_the_call
measure: solve_seconds 0
simulation: setup_seconds solve_seconds compile_seconds estimate_seconds 0
- the closed form of a rigid arm
plugins/strength/tests/test_loads.py::test_largest_stress_and_amplitude_of_a_rigid_arm
stress along the arm: axial mean places lowest highest 0.02
- Goodman's line by hand
plugins/strength/tests/test_fatigue.py::test_the_factor_is_that_of_goodmans_line
fatigue: equivalent notch_factor amplitude mean 1e-9
- the example of ASTM E1049
plugins/strength/tests/test_fatigue.py::test_cycles_are_those_of_the_standard
fatigue: ranges 0
- the closed form of a rigid arm
plugins/strength/tests/test_loads.py::test_forces_and_safety
safety factor: value 1e-6
- intervals inverted by hand
plugins/strength/tests/test_loads.py::test_the_interval_of_a_factor_is_that_of_the_stress_inverted
safety factor: lowest highest error 1e-6
- the textbook's pinned beam
tests/cases/motion/test_resonance.py::test_a_uniform_beam_is_that_of_the_textbook
distance to resonance: first_mode lowest crank 1e-6
- a march of `mujoco`
tests/verification/test_witnesses.py::test_plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn
periodic orbit: period 2e-5
- the error against eigenvalues of the whole Jacobian of 8 modes, over the claim
tests/cases/motion/test_stability.py::test_multipliers_of_all_runs_are_within_their_claims
periodic orbit: multiplier_error multiplier_distance 0.98
- marches of `mujoco` and `exudyn` from a neighbouring speed
tests/verification/test_resonance.py::test_a_march_from_a_neighbouring_speed_settles_on_the_curve
resonance curve: values arclength measures 0.02
peak of a curve: value height 0.02
- a model with more modes: errors beyond the claim
plugins/studies/tests/test_resonance.py::test_the_claims_hold_against_a_model_with_more_modes
resonance curve: errors value_errors 0
special point: error 0
- maps whose folds have a closed form
tests/reference_model/cycles/test_continuation.py::test_both_folds_of_a_cubic
special point: value tolerance 4e-4
- the closed form of uniform numbers
plugins/studies/tests/uncertainty/test_propagation.py::test_the_error_of_a_quantile_is_what_other_samples_show
quantile: value error 0.15
- values that are off by known errors
plugins/studies/tests/uncertainty/test_propagation.py::test_errors_of_the_simulation_move_every_number_by_as_much
quantile: simulation 1e-12
- the closed form of a polynomial
plugins/studies/tests/uncertainty/test_propagation.py::test_the_shares_of_a_polynomial_are_those_of_its_closed_form
share of variance: first first_error total total_error 1e-9
- scipy's least squares on residuals with differences of its own, and closed forms of one parameter, in half widths
plugins/studies/tests/uncertainty/test_calibration.py::test_value_and_interval_are_those_of_a_fit_that_shares_nothing_but_the_engine
fitted parameter: value low high table_error 2.3e-4
- parameters with which three engines made tables: intervals that miss them
plugins/studies/tests/uncertainty/test_calibration.py::test_intervals_contain_the_truth_for_tables_of_any_origin
fitted parameter: simulation_error 0.03
- roots of the transcendental determinant of the overhung beam
tests/reference_model/test_natural_modes.py::test_frequencies_are_roots_of_the_transcendental_determinant
natural frequencies: values 1e-9
- solutions that another engine confirms: claims that do not hold
tests/verification/test_accuracy_campaign.py::test_claims_hold
simulation: error_estimate error_estimates error_parts 0.05
- largest stresses of `mujoco` and `exudyn`: differences beyond the claims
plugins/strength/tests/test_claims_of_stress.py::test_the_largest_stress_of_three_engines_is_within_their_claims
simulation: largest_errors 0
"""
_NAMES: Final = {"column": list(COLUMNS), "measure": list(MEASURES)} | {
    kind: [field.name for field in dataclasses.fields(result)] for result, kind in RESULTS.items()
}


def _witnesses() -> Iterator[tuple[tuple[str, str], Witness]]:
    for block in _TABLE.strip().split("\n- "):
        by, test, *lines = block.removeprefix("- ").split("\n")
        for kind, listed in (line.split(": ") for line in lines):
            for *patterns, largest in map(str.split, listed.split(", ")):
                for pattern in patterns:
                    of_columns = [pattern.replace("COLUMN", name) for name in COLUMNS if name != "time"] if "COLUMN" in pattern else ()
                    for name in of_columns or fnmatch.filter(_NAMES[kind], pattern) or [pattern]:
                        yield (kind, name), Witness(by, float(largest), test)


#: Kind and name of an output -> its witness, in the order of the kinds and of the table.
WITNESSES: Final = dict(sorted(dict(_witnesses()).items(), key=lambda found: list(_NAMES).index(found[0][0])))


def outputs(types: str = "") -> set[tuple[str, str]]:
    """Kind and name of the columns, the measures, and the fields of results whose type matches a pattern."""
    numbers = {
        (kind, field.name) for result, kind in RESULTS.items() for field in dataclasses.fields(result) if re.search(types, str(field.type))
    }
    return {(kind, name) for kind in ("column", "measure") for name in _NAMES[kind]} | numbers


def unconfirmed() -> set[tuple[str, str]]:
    """Kind and name of the outputs without a witness: all columns and measures need one, and all numbers of results."""
    return outputs(r"\b(float|Array|complex)\b") - GIVEN - WITNESSES.keys()


def rows() -> Iterator[tuple[str, str, str]]:
    """Rows of the table: outputs, witness, largest difference; outputs of a kind with one witness share a row."""
    groups: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for (kind, name), witness in WITNESSES.items():
        groups.setdefault((kind, witness.by), []).append((name, witness.largest))
    for (kind, by), members in groups.items():
        least, most = min(largest for _, largest in members), max(largest for _, largest in members)
        largest = f"{most:.0e}" if least == most else f"{least:.0e} to {most:.0e}"
        yield f"{kind} {_named([name for name, _ in members])}", by, largest.replace("0e+00", "none")


def _named(names: list[str]) -> str:
    """Names in one cell; those that differ in a number or behind a dot are joined."""
    joined: dict[str, str] = {}
    for name in names:
        stem = name.split(".")[0] if "." in name else name.rstrip("0123456789")
        joined[stem] = name if stem not in joined else f"{stem}.*" if "." in name else f"{stem}*"
    return ", ".join(f"`{name}`" for name in joined.values())


def table() -> str:
    """The table in Markdown."""
    heading = ("output", "confirmed by", "largest difference"), ("---",) * 3
    return "\n".join(f"| {' | '.join(row)} |" for row in (*heading, *rows()))


if __name__ == "__main__":
    print(table())
