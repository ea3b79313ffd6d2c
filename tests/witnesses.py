"""Every output with its witness: columns, measures, and the numbers of results.

The witness of an output is an independent computation that confirms it. Two computations are independent if no file computes what is
compared in both. A closed form counts, another engine with its own equations, another package, or differences of another output.

`python -m tests.witnesses` prints the table that `docs/belief.md` shows.
"""

import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.cycle import EXTREMES, HALVES, VIBRATION, ChannelMeasures
from quickreturn.cases.motion.request import PeriodicOrbit
from quickreturn.cases.motion.resonance import Resonance
from quickreturn.cases.motion.solving import Frequencies
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.accurate import Result
from quickreturn.plugins.strength.measures import BEARINGS, EXPONENTS, HARMONICS
from quickreturn.plugins.strength.stress import ArmStress, Factor, Fatigue
from quickreturn.plugins.studies.resonance_curve.curve import ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.plugins.studies.uncertainty.fit import FittedParameter
from quickreturn.plugins.studies.uncertainty.scatter import Quantile, Share
from quickreturn.reference_model.columns import COLUMNS, MOMENTS, SHAPE


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
GIVEN: Final = {
    ("quantile", "probability"),
    ("fitted parameter", "start"),
    ("simulation", "accuracy"),
    ("resonance curve", "settings"),
}

_HERE: Final = "tests/verification/test_witnesses.py::test_"
#: The three engines have equations, coordinates and formulas of the columns of their own; the difference is relative to the RMS.
_ENGINES: Final = partial(
    Witness,
    "`mujoco` and `exudyn` beside `reference` in four scenes",
    test=f"{_HERE}engines_with_files_of_their_own_confirm_every_column",
)
#: The same where base and tip are heavy. In run 24 they ask for a thousandth of the arm's moment, which ringing of Exudyn's cable hides.
_HEAVY_ENDS: Final = Witness(
    "`mujoco` and `exudyn` beside `reference` with a heavy base and a heavy tip",
    3e-3,
    "tests/engines/test_end_moments.py::test_three_engines_ask_for_the_same_moments_at_the_ends",
)
_PLAIN: Final = partial(
    Witness,
    "plain numpy on rows of 0.1 ms of `mujoco`",
    test=f"{_HERE}plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn",
)
_WORK: Final = Witness(
    "the virtual work of a rigid machine by quadrature",
    1e-5,
    "plugins/strength/tests/test_drive.py::test_the_drive_of_a_rigid_machine_does_the_virtual_work",
)
_DISTURBED: Final = Witness(
    "the decay of disturbances in `mujoco`",
    5e-5,
    f"{_HERE}disturbed_marches_of_a_link_chain_confirm_the_largest_multiplier",
)
_KNOWN: Final = "half cycles made of a known vibration"
_ACCURACY: Final = "tests/verification/test_measures_accuracy.py::test_bias_spread_and_reach"
_FREQUENCY: Final = Witness(
    "the phase of a small free vibration about the motion, without a fit",
    8e-3,
    "tests/cases/motion/test_simulated.py::test_frequencies_of_steady_states_lie_within_their_claims",
)
#: The difference is the spread.
_AMPLITUDE: Final = Witness(_KNOWN, 0.03, _ACCURACY)
_FORCES: Final = "plugins/strength/tests/test_loads.py::test_"
_FATIGUE: Final = "plugins/strength/tests/test_fatigue.py::test_"
_GOODMAN: Final = f"{_FATIGUE}the_factor_is_that_of_goodmans_line"
_MARCHES: Final = Witness(
    "marches of `mujoco` and `exudyn` from a neighbouring speed",
    0.02,
    "tests/verification/test_resonance.py::test_a_march_from_a_neighbouring_speed_settles_on_the_curve",
)
_MORE_MODES: Final = Witness(
    "a model with more modes: errors beyond the claim",
    0.0,
    "plugins/studies/tests/test_resonance.py::test_the_claims_hold_against_a_model_with_more_modes",
)
_SCATTER: Final = "plugins/studies/tests/uncertainty/test_propagation.py::test_"
_FIT: Final = "plugins/studies/tests/uncertainty/test_calibration.py::test_"
_CLOCK: Final = Witness(
    "the clock of the caller: no part takes longer than the call",
    0.0,
    "tests/engines/test_accurate.py::test_no_part_of_a_call_takes_longer_than_the_call",
)

_OF_COLUMNS: Final = {
    "time": Witness("the grid that is asked for", 0.0, "tests/properties/test_output.py::test_the_output_step_does_not_show"),
    "crank_angle": _ENGINES(5e-8),
    "crank_speed": _ENGINES(2e-7),
    "follower_angle": _ENGINES(1e-6),
    "slider_position": _ENGINES(2e-7),
    "tip_x": _ENGINES(1e-6),
    "tip_y": _ENGINES(5e-6),
    "tip_deflection": _ENGINES(1.5e-4),
    "tip_acceleration": _ENGINES(9e-3),  # the pivot's friction excites more modes than `reference` has: 1.3e-3 without it
    "strain_1": _ENGINES(3e-4),
    "strain_2": _ENGINES(2e-4),
    "strain_3": _ENGINES(2e-4),
    "slider_force": _ENGINES(3e-3),
    "crank_torque": _ENGINES(5e-3),
    "kinetic_energy": _ENGINES(2e-7),
    "strain_energy": _ENGINES(1.5e-4),
    "dissipated_energy": _ENGINES(1e-4),
    "constraint_gap": _ENGINES(3e-4),
    "gravity_energy": _ENGINES(3e-7),
    "drive_work": _ENGINES(2e-5),
    "base_torque": Witness(
        "deflections in cubic elements beside the tangent angle in modes",
        1e-5,
        "tests/reference_model/test_follower_alone.py::test_two_formulations_agree",
    ),
    "axial_stretch": Witness(
        "the closed form of a spinning rod",
        1e-3,
        "tests/verification/test_literature.py::test_every_engine_meets_theory_and_print_in_the_manoeuvre",
    ),
    **dict.fromkeys(SHAPE, _ENGINES(7e-3)),
    **dict.fromkeys(MOMENTS, _ENGINES(1e-3)),
    **dict.fromkeys(("moment_slider", "moment_inboard"), _ENGINES(3e-4)),
    **dict.fromkeys(("moment_base", "moment_tip", "follower_acceleration"), _HEAVY_ENDS),
    **dict.fromkeys(("axial_base", "axial_inboard", "axial_slider", "axial_tip"), _ENGINES(1.5e-3)),
    "pivot_force_x": _ENGINES(2e-3),
    "pivot_force_y": _ENGINES(6e-3),
    "crank_force_x": _ENGINES(5e-5),
    "crank_force_y": _ENGINES(1e-4),
    "follower_rate": _ENGINES(6e-4),
    "spring_force": Witness(
        "`mujoco`, `exudyn` and `derived` beside `reference` with a spring",
        1e-3,
        "tests/engines/test_spring.py::test_engines_agree_about_a_spring_within_what_they_claim",
    ),
}

_OF_MEASURES: Final = {
    # run 24's bodies at the ends are light: the moment at the tip is 3e-4 of that in the arm, the base follows its fast vibrations; both
    # differ more in their own size
    **{
        f"{kind}.{name}": _PLAIN(3e-3 if name in ("moment_tip", "follower_acceleration") else 5e-4)
        for name in COLUMNS
        if name != "time"
        for kind in ("peak", "min", "max", "rms")
    },
    **dict.fromkeys(("peak.pivot_force", "peak.crank_force", "peak.axial_stress"), _PLAIN(5e-4)),
    **dict.fromkeys(("period", "turn.drive_work", "turn.dissipated_energy", "turn.pivot_angle"), _PLAIN(2e-5)),
    **dict.fromkeys(("mean.crank_speed", "mean.drive_power", "rms.drive_power", "peak.drive_power", "peak.returned_power"), _PLAIN(2e-5)),
    "variation.crank_speed": _PLAIN(5e-4),
    **{f"equivalent.{force}.{kind}": _PLAIN(5e-4) for force in BEARINGS for kind in EXPONENTS},
    **dict.fromkeys(
        ("peak.stress", "amplitude.stress"),
        Witness("strain gauges of `mujoco` at the place", 5e-4, f"{_HERE}gauges_of_a_link_chain_confirm_the_stress_along_the_arm"),
    ),
    **dict.fromkeys(
        ("equivalent.stress", "cycles.stress", "factor.yielding", "factor.fatigue"),
        Witness("Goodman's line by hand on a rigid arm", 2e-3, _GOODMAN),
    ),
    **{f"{half}.frequency{channel}": _FREQUENCY for half in HALVES for channel in ("", *(f".{name}" for name in CHANNELS))},
    **{f"{half}.amplitude.{channel}": _AMPLITUDE for half in HALVES for channel in CHANNELS},
    **dict.fromkeys(("multiplier", "multiplier.real", "multiplier.imag"), _DISTURBED),
    **{f"torque.harmonic_{n}{part}": _WORK for n in range(1, HARMONICS + 1) for part in ("", ".phase", ".cos", ".sin")},
    **dict.fromkeys(("mean.crank_torque", "turn.driven_energy", "turn.returned_energy", "flywheel.energy"), _WORK),
    "flywheel.inertia": Witness(
        "a free crank with this inertia", 0.005, "plugins/strength/tests/test_drive.py::test_a_crank_with_the_flywheel_fluctuates_as_wanted"
    ),
    "solve_seconds": _CLOCK,
}

_OF_RESULTS: Final[dict[type[Any], dict[str, Witness]]] = {
    ChannelMeasures: {
        "first_mode_frequency": _FREQUENCY,
        # the difference is the part of the errors that exceed twice what is claimed
        **dict.fromkeys(
            ("first_mode_frequency_uncertainty", "first_mode_amplitude_uncertainty"),
            Witness(f"{_KNOWN}: errors beyond twice the uncertainty", 0.05, _ACCURACY),
        ),
        "first_mode_amplitude": _AMPLITUDE,
        "second_mode_frequency": Witness(
            _KNOWN, 0.01, "tests/cases/motion/test_cycle.py::test_strong_second_mode_is_found_where_channels_agree"
        ),
        **dict.fromkeys(EXTREMES, Witness("a sine", 1e-6, "tests/cases/motion/test_cycle.py::test_extremes_belong_to_their_half")),
        **dict.fromkeys(
            ("minimum_uncertainty", "maximum_uncertainty"),
            Witness(
                "corners between samples",
                0.0,
                "tests/cases/motion/test_cycle.py::test_a_corner_between_samples_is_missed_by_no_more_than_is_said",
            ),
        ),
        **dict.fromkeys(
            [f"{name}_estimate" for name in (*VIBRATION, *EXTREMES)],
            Witness(
                "`reference`, `exudyn` and `mujoco` on random machines: differences beyond both claims",
                0.0,
                "tests/verification/test_sensible_machines.py::test_two_hundred_machines_settle_and_engines_agree",
            ),
        ),
    },
    ArmStress: dict.fromkeys(
        ("axial", "mean", "places", "lowest", "highest"),
        Witness("the closed form of a rigid arm", 0.02, f"{_FORCES}largest_stress_and_amplitude_of_a_rigid_arm"),
    ),
    Fatigue: {
        **dict.fromkeys(("equivalent", "notch_factor", "amplitude", "mean"), Witness("Goodman's line by hand", 1e-9, _GOODMAN)),
        "ranges": Witness("the example of ASTM E1049", 0.0, f"{_FATIGUE}cycles_are_those_of_the_standard"),
    },
    Factor: {
        "value": Witness("the closed form of a rigid arm", 1e-6, f"{_FORCES}forces_and_safety"),
        **dict.fromkeys(
            ("lowest", "highest", "error"),
            Witness("intervals inverted by hand", 1e-6, f"{_FORCES}the_interval_of_a_factor_is_that_of_the_stress_inverted"),
        ),
    },
    Resonance: dict.fromkeys(
        ("first_mode", "lowest", "crank"),
        Witness("the textbook's pinned beam", 1e-6, "tests/cases/motion/test_resonance.py::test_a_uniform_beam_is_that_of_the_textbook"),
    ),
    PeriodicOrbit: {
        "period": Witness("a march of `mujoco`", 2e-5, f"{_HERE}plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn"),
        "multipliers": _DISTURBED,
        **dict.fromkeys(
            ("multiplier_error", "multiplier_distance"),
            Witness(
                "the error against eigenvalues of the whole Jacobian of 8 modes, over the claim",
                0.98,
                "tests/cases/motion/test_stability.py::test_multipliers_of_all_runs_are_within_their_claims",
            ),
        ),
    },
    ResonanceCurve: {
        **dict.fromkeys(("values", "arclength", "measures"), _MARCHES),
        **dict.fromkeys(("errors", "value_errors"), _MORE_MODES),
        "multipliers": _DISTURBED,
    },
    SpecialPoint: {
        # the difference is relative to the range of the parameter
        **dict.fromkeys(
            ("value", "tolerance"),
            Witness(
                "maps whose folds have a closed form",
                4e-4,
                "tests/reference_model/cycles/test_continuation.py::test_both_folds_of_a_cubic",
            ),
        ),
        "error": _MORE_MODES,
    },
    ResonancePeak: dict.fromkeys(("value", "height"), _MARCHES),
    Quantile: {
        **dict.fromkeys(
            ("value", "error"),
            Witness("the closed form of uniform numbers", 0.15, f"{_SCATTER}the_error_of_a_quantile_is_what_other_samples_show"),
        ),
        "simulation": Witness(
            "values that are off by known errors",
            1e-12,
            f"{_SCATTER}errors_of_the_simulation_move_every_number_by_as_much",
        ),
    },
    Share: dict.fromkeys(
        ("first", "first_error", "total", "total_error"),
        Witness("the closed form of a polynomial", 1e-9, f"{_SCATTER}the_shares_of_a_polynomial_are_those_of_its_closed_form"),
    ),
    FittedParameter: {
        **dict.fromkeys(
            ("value", "low", "high", "table_error"),
            Witness(
                "scipy's least squares on residuals with differences of its own, and closed forms of one parameter, in half widths",
                2.3e-4,
                f"{_FIT}value_and_interval_are_those_of_a_fit_that_shares_nothing_but_the_engine",
            ),
        ),
        "simulation_error": Witness(
            "parameters with which three engines made tables: intervals that miss them",
            0.03,
            f"{_FIT}intervals_contain_the_truth_for_tables_of_any_origin",
        ),
    },
    Frequencies: {
        "values": Witness(
            "roots of the transcendental determinant of the overhung beam",
            1e-9,
            "tests/reference_model/test_natural_modes.py::test_frequencies_are_roots_of_the_transcendental_determinant",
        )
    },
    Result: {
        **dict.fromkeys(
            ("error_estimate", "error_estimates", "error_parts"),
            Witness(
                "solutions that another engine confirms: claims that do not hold",
                0.05,
                "tests/verification/test_accuracy_campaign.py::test_claims_hold",
            ),
        ),
        "largest_errors": Witness(
            "largest stresses of `mujoco` and `exudyn`: differences beyond the claims",
            0.0,
            "plugins/strength/tests/test_claims_of_stress.py::test_the_largest_stress_of_three_engines_is_within_their_claims",
        ),
        **dict.fromkeys(("setup_seconds", "solve_seconds", "compile_seconds", "estimate_seconds"), _CLOCK),
    },
}

#: Kind and name of an output -> its witness, in the order of the table.
WITNESSES: Final = {
    **{("column", name): witness for name, witness in _OF_COLUMNS.items()},
    **{("measure", name): witness for name, witness in _OF_MEASURES.items()},
    **{(RESULTS[result], name): witness for result, named in _OF_RESULTS.items() for name, witness in named.items()},
}


def outputs(types: str = "") -> set[tuple[str, str]]:
    """Kind and name of the columns, the measures, and the fields of results whose type matches a pattern."""
    fields = {
        (kind, field.name) for result, kind in RESULTS.items() for field in dataclasses.fields(result) if re.search(types, str(field.type))
    }
    return {*(("column", name) for name in COLUMNS), *(("measure", name) for name in MEASURES)} | fields


def unconfirmed() -> set[tuple[str, str]]:
    """Kind and name of the outputs without a witness: all columns and measures need one, and all numbers of results."""
    return outputs(r"\b(float|Array|complex)\b") - GIVEN - WITNESSES.keys()


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Rows of the table: outputs, witness, largest difference, test; outputs with one witness and one test share a row."""
    groups: dict[tuple[str, str, str], list[tuple[str, float]]] = {}
    for (kind, name), witness in WITNESSES.items():
        groups.setdefault((kind, witness.by, witness.test), []).append((name, witness.largest))
    for (kind, by, test), members in groups.items():
        least, most = min(largest for _, largest in members), max(largest for _, largest in members)
        largest = f"{most:.0e}" if least == most else f"{least:.0e} to {most:.0e}"
        yield f"{kind} {_named([name for name, _ in members])}", by, largest.replace("0e+00", "none"), test


def _named(names: list[str]) -> str:
    """Names in one cell; those that differ in a number or behind a dot are joined."""
    joined: dict[str, str] = {}
    for name in names:
        stem = name.split(".")[0] if "." in name else name.rstrip("0123456789")
        joined[stem] = name if stem not in joined else f"{stem}.*" if "." in name else f"{stem}*"
    return ", ".join(f"`{name}`" for name in joined.values())


def table() -> str:
    """The table in Markdown; a test by its function, as `pytest -k` finds it."""
    heading = ("output", "confirmed by", "largest difference", "test"), ("---",) * 4
    shown = ((output, by, largest, f"`{test.partition('::')[2]}`") for output, by, largest, test in rows())
    return "\n".join(f"| {' | '.join(row)} |" for row in (*heading, *shown))


if __name__ == "__main__":
    print(table())
