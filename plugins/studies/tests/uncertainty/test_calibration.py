"""Parameters found from recorded tables: the truth is known, for the tables are made by other engines, and noise is added."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import chi2

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import text_of
from quickreturn.cases.files.recorded import RecordedTable, table_of
from quickreturn.cases.library import load_case
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import rms
from quickreturn.plugins.studies.uncertainty.calibration import DEFAULT_ERROR, TABLE_ERROR, calibrated
from quickreturn.plugins.studies.uncertainty.fit import Fit, covariance, reach, smooth_part, undetermined
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes
from quickreturn.plugins.studies.uncertainty.table_model import TableModel
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.rigid import crank_pace
from quickreturn.reference_model.scene_values import changed

COLUMNS = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3")
CASE = load_case("thesis-24")
STIFFNESS, DAMPING = CASE.mechanism.follower.bending_stiffness, CASE.mechanism.follower.damping
FREE = ("follower.bending_stiffness", "follower.damping")
#: Where the search begins: 10 % and 30 % off.
BEGUN = CASE.with_({"follower.bending_stiffness": "2340 lbf*in^2", "follower.damping": "1.4e-5 lbf*s/in^2"}, name="thesis-24")
#: Finer than the engines' own choice: what they err by must be small beside the noise, or the test would be of them.
SETTINGS = {"mujoco": {"links": "24"}, "exudyn": {"elements": "24", "step": "2e-4"}}
NOISE = 0.05  # of a column's RMS


@cache
def computed(name: str, seconds: float = 0.5) -> dict[str, Array]:
    """What another engine computes, from the standard start."""
    chosen, scene = engine(name), CASE.mechanism
    settings = chosen.settings_for(chosen.default_accuracy, scene).with_texts(SETTINGS.get(name, {}))
    return dict(run_once(chosen, scene, standard_start(scene), seconds, 1e-3, settings).trajectory.columns)


def noisy(columns: dict[str, Array], generator: np.random.Generator, memory: float = 0.0) -> RecordedTable:
    """A table with noise; `memory`: correlation of a row's noise with the next one's."""
    found = {name: columns[name] for name in ("time", "crank_angle")}
    for name in COLUMNS:
        noise = generator.standard_normal(len(columns[name]))
        for row in range(1, len(noise) if memory else 0):
            noise[row] = memory * noise[row - 1] + np.sqrt(1.0 - memory**2) * noise[row]
        found[name] = columns[name] + NOISE * np.sqrt(np.mean(columns[name] ** 2)) * noise
    return table_of(found, "table", CASE.name)


@pytest.mark.parametrize("first", [0.0, 12.5])
def test_the_model_of_a_table_begins_where_the_table_does(first: float) -> None:
    columns = {name: computed("reference")[name] for name in ("time", "crank_angle", *COLUMNS)}
    model = TableModel(CASE, table_of({**columns, "time": columns["time"] + first}, "table", CASE.name))
    chosen = engine("reference").settings_for(1e-3, CASE.mechanism)
    assert isinstance(chosen, ReferenceSettings)
    simulated = model.simulated(CASE.mechanism, chosen, model.rows)
    assert rms(simulated - model.values) < 1e-9 * rms(model.values)  # the same simulation: rounding of the instants, 1e-15 s, is left


def holds(fit: Fit, values: tuple[float, ...]) -> bool:
    """Whether values lie in the 95 % region of all parameters together."""
    spread, away = np.array(fit.covariance), np.array(values) - [each.value for each in fit.found]
    sizes = np.sqrt(np.diag(spread))
    return bool(away / sizes @ np.linalg.solve(spread / np.outer(sizes, sizes), away / sizes) <= chi2(len(values)).ppf(0.95))


@pytest.mark.verify
@pytest.mark.parametrize("name", ["mujoco", "exudyn"])
@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_the_truth_lies_in_the_region_in_95_of_100_trials(name: str, memory: float) -> None:
    columns, trials = computed(name), 40
    fits = [calibrated(BEGUN, noisy(columns, np.random.default_rng(trial), memory), FREE) for trial in range(trials)]
    held = sum(holds(fit, (STIFFNESS, DAMPING)) for fit in fits)
    # what is left is the noise that was put in: its RMS over 2505 numbers is known to 2 %, three standard deviations are 5 % of a column's
    assert memory > 0.0 or all(abs(share / NOISE - 1.0) < 0.1 for share in fits[0].left.values())
    print(f"{name}, memory {memory}: {held} of {trials}; widened {np.median([fit.widened for fit in fits]):.2f}")
    # 95 % of 40 are 38; of a region that is right 34 or fewer are met in one of 70 such tests
    assert held >= 35


def test_the_covariance_of_correlated_residuals_is_that_of_many_trials() -> None:
    generator, rows, trials, memory = np.random.default_rng(3), 1000, 400, 0.8
    time = np.linspace(0.0, 1.0, rows)
    slopes = np.stack([np.sin(40.0 * time), time], axis=-1)[None]
    estimates, told, independent = [], [], []
    for _ in range(trials):
        noise = generator.standard_normal(rows)
        for row in range(1, rows):
            noise[row] += memory * noise[row - 1]
        step = np.linalg.lstsq(slopes[0], noise, rcond=None)[0]
        estimates.append(step)
        spread, alone = covariance((noise - slopes[0] @ step)[None], slopes)
        told.append(np.diag(spread))
        independent.append(np.diag(alone))
    true = np.var(estimates, axis=0)
    # a variance over 400 trials is known to 7 %; the smoothed spectrum takes from a peak what it gives to its sides: 25 %
    assert np.all(np.abs(np.mean(told, axis=0) / true - 1.0) < 0.3)
    assert np.all(np.mean(independent, axis=0) < 0.5 * true)


def test_errors_of_known_size_stay_in_the_ellipsoid_and_reach_its_end_whatever_the_number_of_rows() -> None:
    generator, levels = np.random.default_rng(5), np.array([0.3, 0.02])
    slopes = generator.standard_normal((2, 200, 3))
    bound = reach(slopes, levels)
    inverse = np.linalg.pinv(slopes.reshape(400, 3))
    for _ in range(100):
        errors = generator.standard_normal((2, 200)) + generator.choice([0.0, 9.0]) * np.einsum(
            "cnk,k->cn", slopes, generator.standard_normal(3)
        )
        moved = inverse @ (errors * (levels / np.sqrt(np.mean(errors**2, axis=1)))[:, None]).ravel()
        assert moved @ np.linalg.solve(bound, moved) <= 1.0
    alike = slopes[:1, :, :1]  # of one column and one parameter: an error that looks like its effect
    farthest = np.linalg.lstsq(alike[0], 0.3 * alike[0, :, 0] / np.sqrt(np.mean(alike**2)), rcond=None)[0][0]
    assert np.allclose(np.sqrt(reach(alike, levels[:1])), farthest, rtol=1e-9)
    assert np.allclose(reach(np.concatenate([slopes, slopes], axis=1), levels), bound, rtol=1e-9)


def test_independent_residuals_are_not_smooth_and_a_slow_course_is() -> None:
    generator = np.random.default_rng(4)
    noise = generator.standard_normal((3, 2000))
    assert smooth_part(noise) < 0.1
    assert smooth_part(0.1 * noise + np.sin(np.linspace(0.0, 60.0, 2000))) > 0.95


@pytest.mark.verify
def test_what_a_table_cannot_tell_is_named() -> None:
    """The thickness turns curvature into strain and does nothing else, where the bending stiffness is given: deflections do not tell it."""
    table = table_of({name: computed("reference")[name] for name in ("time", "crank_angle", "tip_deflection")}, "table", CASE.name)
    fit = calibrated(CASE, table, ("follower.thickness", "follower.bending_stiffness"))
    (direction,) = fit.cannot_tell
    assert direction.startswith("follower.thickness")
    assert "bending_stiffness" not in direction
    assert [each.determined for each in fit.found] == [False, True]
    assert "not determined" in repr(fit)
    # the table is of the engine's default accuracy, and the model is right
    assert "lacks something" not in repr(fit)
    assert fit.found[1].low < STIFFNESS < fit.found[1].high


def test_parameters_that_do_the_same_are_not_told_apart() -> None:
    course = np.sin(np.linspace(0.0, 30.0, 500))
    sensitivities = np.stack([course, 2.0 * course, np.cos(3.0 * course)], axis=-1)[None]
    (direction,) = undetermined(sensitivities, np.diag([1e-6, 1e-6, 1e-6]))
    # what twice the second does undoes the first
    assert np.allclose(np.abs(direction), np.array([2.0, 1.0, 0.0]) / np.sqrt(5.0), atol=1e-9)
    assert direction[0] * direction[1] < 0.0


@pytest.mark.verify
def test_the_steady_state_is_fitted_at_equal_crank_angles() -> None:
    from quickreturn.cases.motion.marching import whole_cycles
    from quickreturn.engines.own.reference import ReferenceEngine

    true = changed(CASE.mechanism, {"follower.bending_stiffness": 1.03 * STIFFNESS})
    reference = ReferenceEngine()
    state = reference.steady_state(true, standard_start(true), reference.settings_for(1e-4, true))
    assert state is not None
    cycle = whole_cycles(state.simulation.advance(1e-3 * (int(state.period / 1e-3) + 4), 1e-3))[0]
    table = table_of({"time": cycle.time, "crank_angle": cycle.crank_angle, "strain_2": cycle.channels["strain_2"]}, "table", CASE.name)
    fit = calibrated(CASE, table, FREE[:1])
    assert not fit.begins
    # the orbits are searched to 1e-3 of the motion, and stiffness changes it several times as much as itself
    assert abs(fit.found[0].value / (1.03 * STIFFNESS) - 1.0) < 1e-3


@pytest.mark.parametrize(
    ("free", "told"),
    [
        ("tip.center_of_mass", "is no value to begin from; give a range"),
        ("mechanism.gravity", "write mechanism.gravity[1] to mechanism.gravity[2]"),
        ("follower.yield_strength", "changes no motion"),
    ],
)
def test_bad_keys_get_one_sentence(free: str, told: str) -> None:
    with pytest.raises(CaseError, match=r".") as wrong:
        calibrated(CASE, noisy(computed("reference"), np.random.default_rng(1)), [free])
    assert told in str(wrong.value)


@pytest.mark.verify
def test_value_and_interval_are_those_of_a_fit_that_shares_nothing_but_the_engine() -> None:
    """Against scipy's least squares with differences of its own, and the closed forms of one parameter and one column."""
    columns, reference = computed("exudyn"), engine("reference")
    values = columns["tip_deflection"] + NOISE * rms(columns["tip_deflection"]) * np.random.default_rng(2).standard_normal(
        len(columns["time"])
    )
    table = table_of({"time": columns["time"], "crank_angle": columns["crank_angle"], "tip_deflection": values}, "table", CASE.name)
    (found,) = calibrated(BEGUN.with_({FREE[1]: "2e-5 lbf*s/in^2"}, name="thesis-24"), table, FREE[:1]).found

    def residuals(times: Array) -> Array:
        scene = changed(CASE.mechanism, {FREE[0]: float(times[0]) * STIFFNESS})
        settings = reference.settings_for(1e-4, scene)
        run = run_once(reference, scene, standard_start(scene), 0.5, 1e-3, settings)
        return np.asarray(run.trajectory["tip_deflection"] - values)

    other = least_squares(residuals, [0.99], diff_step=1e-4, method="lm")
    steepness = float(np.linalg.norm(other.jac))
    noise = 1.96 * float(np.linalg.norm(other.fun)) / np.sqrt(len(values) - 1) / steepness
    of_table = TABLE_ERROR * rms(values) * np.sqrt(len(values)) / steepness
    half = 0.5 * (found.high - found.low) / STIFFNESS
    away, table_off = abs(found.value / STIFFNESS - other.x[0]) / half, found.table_error / STIFFNESS / of_table - 1.0
    print(f"value {away:.2g} half widths, table's error {table_off:.2g}")
    print(f"half width {half / np.hypot(noise, of_table) - 1.0:.2g}")
    assert away < 0.02
    assert abs(table_off) < 0.01  # derivatives of differences of 1e-3 and of 1e-4
    # a spectrum that is averaged over 45 frequencies is known to a seventh
    assert abs(half / np.hypot(noise, of_table) - 1.0) < 0.15


@dataclass(frozen=True)
class Trial:
    """A table of known origin, and the fit to it."""

    how: str  # the table was made
    true: Mapping[str, float]  # values of the free parameters, SI
    case: Case  # with which the search begins
    table: RecordedTable


def trial(seed: int) -> Trial:
    """A random machine near one of four of the thesis, and its table by an engine at default settings, noisy or with few digits or not."""
    chance = np.random.default_rng(seed)
    case = load_case(("thesis-05", "thesis-12", "thesis-17", "thesis-24")[seed % 4])
    keys = ("follower.bending_stiffness", "follower.mass_per_length", "follower.damping")
    begun = {Parameter.of_key(key, "test"): Parameter.of_key(key, "test").of(case.mechanism) for key in keys}
    values = {key: begun[key] * np.exp(chance.uniform(-spread, spread)) for key, spread in zip(begun, (0.2, 0.2, 0.6), strict=True)}
    scene = case.mechanism_with(changes(case.mechanism, values))
    name, turns = ("reference", "exudyn", "mujoco")[seed // 4 % 3], chance.choice([1.2, 2.0, 3.5])
    noise, digits = chance.choice([0.0, 0.0, 0.002, 0.05]), chance.choice([3, 5, 17])
    made, seconds = engine(name), round(float(turns) * 2.0 * np.pi / crank_pace(scene), 3)
    settings = made.settings_for(made.default_accuracy, scene)
    columns = run_once(made, scene, standard_start(scene), seconds, 1e-3, settings).trajectory.columns
    kept = [("tip_acceleration", "strain_2"), ("tip_deflection",), COLUMNS][chance.integers(3)]
    rows = {each: columns[each] + noise * rms(columns[each]) * chance.standard_normal(len(columns[each])) for each in kept}
    written = {each: np.array([float(f"{value:.{digits - 1}e}") for value in column]) for each, column in rows.items()}
    table = table_of({each: columns[each] for each in ("time", "crank_angle")} | written, "table", case.name)
    free = [*values][:2] if seed % 2 else [*values][::2]
    known = {key: value for key, value in values.items() if key not in free}
    how = f"{case.name} by {name}, {seconds} s, noise {noise}, {digits} digits, {len(kept)} columns"
    begin = case.with_({path: text_of(path, value) for path, value in changes(case.mechanism, known).items()}, name=case.name)
    return Trial(how, {key.key: values[key] for key in free}, begin, table)


@pytest.mark.verify
def test_intervals_contain_the_truth_for_tables_of_any_origin() -> None:
    """Tables of three engines at default settings, with and without noise, some with few digits: the model of the fit errs as they do."""
    away, widths = [], []
    for one in map(trial, range(36)):
        fit = calibrated(one.case, one.table, tuple(one.true))
        for found in fit.found:
            if found.determined:
                half = 0.5 * (found.high - found.low)
                away.append(abs(one.true[found.key] - 0.5 * (found.high + found.low)) / half)
                widths.append(half / found.value)
                print(f"{one.how}: {found.key} {away[-1]:.2f} half widths of {100.0 * widths[-1]:.2g} %", flush=True)
        if all(share < DEFAULT_ERROR for share in fit.left.values()):
            assert "lacks something" not in repr(fit)
    held = np.mean(np.array(away) <= 1.0)
    print(f"{held:.3f} of {len(away)}, worst {max(away):.2f}, median {np.median(away):.2f}, half widths {np.median(widths):.2g}")
    # 95 % of some 70 miss 3.5; more than 8 are missed in one of 100 such tests of intervals that are right
    assert sum(each > 1.0 for each in away) <= 8
    assert max(away) < 3.0


@pytest.mark.verify
def test_what_a_model_lacks_is_told() -> None:
    """The table's arm is longer by 2 %, or one gauge shows 3 % too little, and only the stiffness is free."""
    longer = changed(CASE.mechanism, {"follower.length": 1.02 * CASE.mechanism.follower.length})
    made = engine("reference")
    run = run_once(made, longer, standard_start(longer), 0.5, 1e-3, made.settings_for(1e-3, longer)).trajectory
    gauge = computed("reference") | {"strain_2": 0.97 * computed("reference")["strain_2"]}
    for columns in (run.columns, gauge):
        table = table_of({name: columns[name] for name in ("time", "crank_angle", *COLUMNS)}, "table", CASE.name)
        assert "the model or the table lacks something" in repr(calibrated(CASE, table, FREE[:1]))
