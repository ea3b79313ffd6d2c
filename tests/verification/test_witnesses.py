"""Outputs beside their witnesses: columns by three engines, measures by plain numpy, stress by dense gauges, multipliers by marching.

`tests/witnesses.py` names the largest difference that was found (`Witness.largest`). A test fails if it finds a larger one, and also if the
largest one that it finds is less than a fifth of that: then the table is older than the code.
"""

import dataclasses
import math
from collections.abc import Mapping
from functools import cache
from typing import Final

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from quickreturn.cases.library import library_case
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.orbit import Curve, Orbit, PeriodicStart, find_orbit
from quickreturn.engines.base import Refusal
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Columns, rms
from quickreturn.plugins.strength.loads import loads_of
from quickreturn.plugins.studies.sweep.rows import MeasureRequest, row
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.scene_values import changed
from tests.engines.scenes import run_24
from tests.witnesses import WITNESSES, Witness

DURATION: Final = 0.5  # s
#: Part of a declared difference that the test must find, or the declaration is out of date.
FOUND_AGAIN: Final = 0.2
OF_COLUMNS, OF_MEASURES = ({name: each for (of, name), each in WITNESSES.items() if of == kind} for kind in ("column", "measure"))
#: m, to which a rigid loop is closed, and J of what is zero but for rounding.
NOTHING: Final = 1e-10

FINE: Final[dict[str, Settings]] = {
    "reference": ReferenceSettings(modes=11, tolerance=1e-9),
    "mujoco": ChainSettings(links=48),
    "exudyn": ExudynSettings(elements=32, step=5e-5, newton_tolerance=1e-7, axial_factor=4.0),
}
SCENES: Final = {
    "run 24": run_24(),
    "prescribed speed": run_24(crank={"drive": PrescribedSpeed(speed=16.6)}),
    "soft joint": run_24(slider={"mass": 0.1, "joint_stiffness": 2e4, "joint_damping": 2.0}),
    "gravity, friction and a force": run_24(
        gravity=(1.0, -3.0),
        slider={"mass": 0.3},
        base={"friction_torque": 0.02},
        tip={"center_of_mass": 0.0127, "force": (1.5, -2.0), "force_from": 0.5, "force_to": 2.5, "force_ramp": 0.3},
        follower={"damping": 0.5},
    ),
}


def motion(engine: str, scene: Mechanism, start: Start, settings: Settings, duration: float, step: float) -> Columns:
    return usable_engine(engine).prepare(scene, start, settings).advance(duration, step).columns


@cache
def differences_of_columns() -> dict[str, dict[str, float]]:
    """Column -> engine and scene -> RMS of the difference from `reference` over the RMS."""
    found: dict[str, dict[str, float]] = {}
    for name, scene in SCENES.items():
        runs = {}
        for engine, settings in FINE.items():
            try:
                runs[engine] = motion(engine, scene, standard_start(scene), settings, DURATION, 1e-3)
            except Refusal:
                assert engine == "exudyn", f"{engine} refuses {name}"
        ours = runs.pop("reference")
        for engine, theirs in runs.items():
            for column in ours.keys() & theirs.keys():
                size, apart = rms(ours[column]), rms(theirs[column] - ours[column])
                if size > NOTHING:
                    found.setdefault(column, {})[f"{engine}, {name}"] = apart / size
                else:
                    assert apart < NOTHING, (column, engine, name)
    return found


@pytest.mark.verify
def test_engines_with_files_of_their_own_confirm_every_column() -> None:
    witnesses = of_test("engines_with_files_of_their_own_confirm_every_column", OF_COLUMNS)
    found = {column: max(differences_of_columns()[column].values()) for column in witnesses}
    assert out_of_date(witnesses, found) == {}


def of_test(name: str, witnesses: Mapping[str, Witness]) -> dict[str, Witness]:
    """Those of a test of this file."""
    return {output: each for output, each in witnesses.items() if each.test == f"tests/verification/test_witnesses.py::test_{name}"}


def out_of_date(witnesses: Mapping[str, Witness], found: Mapping[str, float]) -> dict[str, float]:
    """Outputs that differ by more than their witness declares, and those of whose witness far smaller differences were found."""
    largest = {each: max(found[output] for output in found if witnesses[output] == each) for each in {witnesses[name] for name in found}}
    return {
        output: found[output]
        for output in found
        if found[output] > witnesses[output].largest or largest[witnesses[output]] < FOUND_AGAIN * witnesses[output].largest
    }


@cache
def orbit_of_run_24() -> Orbit:
    return find_orbit(library_case("thesis-24").mechanism)


STEP: Final = 1e-4  # s, between rows whose largest is the peak, as no curve between them is asked
TURNS: Final = 11  # after which a disturbance of the start has shrunk to a fifteenth


def quiet_arm() -> Mechanism:
    """Run 24 with a damping of the material that stops the ringing of the highest modes, and takes 1e-5 of the first one's amplitude."""
    return changed(library_case("thesis-24").mechanism, {"follower.material_damping": 2e-7})


@cache
def turn_of_links() -> Columns:
    """The last turn of a link chain that marched from the periodic state of `reference`."""
    orbit = orbit_of_run_24()
    assert orbit.begin is not None
    columns = motion("mujoco", quiet_arm(), orbit.begin, FINE["mujoco"], STEP * math.ceil((TURNS + 0.5) * orbit.period / STEP), STEP)
    turned = (columns["crank_angle"] - columns["crank_angle"][0]) / math.tau
    begin, end = np.interp([TURNS - 1.0, TURNS], turned, columns["time"])
    time = np.concatenate([[begin], columns["time"][(columns["time"] > begin) & (columns["time"] < end)], [end]])
    turn = {name: np.interp(time, columns["time"], values) for name, values in columns.items()}
    drive = library_case("thesis-24").mechanism.crank.drive
    lost = drive.damping * turn["crank_speed"]  # of a motor's torque, before its shaft
    power = lost * turn["crank_speed"]
    taken = np.append(0.0, np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time)))
    less = {"crank_torque": lost, "drive_work": taken, "dissipated_energy": taken}
    return turn | {name: turn[name] - values for name, values in less.items()} | {"taken": taken}


def plain(name: str, turn: Columns) -> tuple[float, float]:
    """A measure of a turn by numpy alone, and the size that its difference is relative to."""
    kind, _, column = name.partition(".")
    time = turn["time"]
    if kind == "period":
        return float(np.ptp(time)), float(np.ptp(time))
    if kind == "equivalent":
        load = equivalent(column, turn)
        return load, load
    if column == "pivot_angle":
        swung = float(np.abs(np.diff(turn["follower_angle"])).sum())
        return swung, swung
    if column.endswith("_power"):
        power = turn["crank_torque"] * turn["crank_speed"]
        size = float(np.abs(power).max())
        mean, mean_square = (float(np.trapezoid(values, time)) / float(np.ptp(time)) for values in (power, power**2))
        peak = max(0.0, float((power if column == "drive_power" else -power).max()))
        return {"mean": mean, "rms": math.sqrt(mean_square), "peak": peak}[kind], size
    if column in ("pivot_force", "crank_force"):
        largest = float(np.hypot(turn[f"{column}_x"], turn[f"{column}_y"]).max())
        return largest, largest
    if column == "axial_stress":
        largest = max(float(np.abs(turn[name]).max()) for name in AXIAL) / library_case("thesis-24").mechanism.follower.section.area()
        return largest, largest
    values = turn[column]
    mean_speed = float(np.ptp(turn["crank_angle"])) / float(np.ptp(time))
    if kind in ("mean", "variation"):
        found = mean_speed if kind == "mean" else float(np.ptp(values)) / mean_speed
        return found, found
    size = float(np.abs(values).max())
    if kind == "turn":
        of_motor = float(turn["taken"][-1]) if column in ("drive_work", "dissipated_energy") else 0.0  # which is taken from both
        return float(values[-1] - values[0]), max(abs(float(values[-1] - values[0])), of_motor)
    mean_square = float(np.trapezoid(values**2, time)) / float(np.ptp(time))
    return {"peak": size, "min": float(values.min()), "max": float(values.max()), "rms": math.sqrt(mean_square)}[kind], size


def equivalent(name: str, turn: Columns) -> float:
    """Equivalent load of a bearing, by the sum over steps of the angle that it turns."""
    force, _, kind = name.partition(".")
    parts = [turn[column] for column in (f"{force}_x", f"{force}_y", force) if column in turn]
    angle = {"pivot": turn["follower_angle"], "crank": turn["crank_angle"], "slider": turn["crank_angle"] - turn["follower_angle"]}
    power, turned = {"ball": 3.0, "roller": 10.0 / 3.0}[kind], np.abs(np.diff(angle[force.partition("_")[0]]))
    middle = [(part[1:] + part[:-1]) / 2.0 for part in parts]
    return float(np.average(np.linalg.norm(middle, axis=0) ** power, weights=turned) ** (1.0 / power))


#: Columns that count from the start of a simulation, or are nothing in run 24.
WITHOUT_A_TURN: Final = ("crank_angle", "dissipated_energy", "drive_work", "constraint_gap", "gravity_energy")


@pytest.mark.verify
def test_plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn() -> None:
    turn = turn_of_links()
    of_turn = of_test("plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn", OF_MEASURES)
    names = tuple(
        name
        for name in of_turn
        if {*MEASURES[name].columns} <= turn.keys() and (name.startswith("turn.") or name.partition(".")[2] not in WITHOUT_A_TURN)
    )
    values = row([library_case("thesis-24").mechanism], MeasureRequest(measures=names, accuracy=1e-4)).values[0]
    found = {}
    for name, value in zip(names, values, strict=True):
        confirmed, size = plain(name, turn)
        found[name] = abs(value - confirmed) / size
    assert out_of_date(OF_MEASURES, found) == {}


#: Disturbance of the start, as a part of the motion; turns that are left out and turns that are used after it. Earlier, faster disturbances
#: remain; later, the difference is the integration's error. Three motions, one of the crank and a pair of the arm, last longer than a turn.
DISTURBED: Final = 0.02
FIRST, LAST, LASTING = 1, 6, 3
SIGNALS: Final = ("crank_speed", "tip_deflection", "strain_1", "strain_2", "strain_3", "shape_06", "shape_03")


def at_every_turn(start: Start, period: float) -> Array:
    """Signals of a link chain, and rates of all but the first, each time when a turn is complete; shape (13, turns)."""
    duration, step = (LAST + 0.5) * period, 5e-4
    columns = motion("mujoco", quiet_arm(), start, ChainSettings(links=24, step=0.45), step * math.ceil(duration / step), step)
    angle, time = columns["crank_angle"], columns["time"]
    crossings = CubicSpline(angle, time)(angle[0] + math.tau * np.arange(1, LAST + 1))
    curves = [CubicSpline(time, columns[name]) for name in SIGNALS]
    return np.array([*(curve(crossings) for curve in curves), *(curve(crossings, 1) for curve in curves[1:])])


def disturbed(start: PeriodicStart, part: float) -> list[PeriodicStart]:
    """The start with another speed, another deflection and other rates."""
    bent, rates = (Curve(curve.x, (1.0 + part) * curve.c) for curve in (start.deflection, start.deflection_rate))
    return [
        dataclasses.replace(start, crank_speed=(1.0 + 0.3 * part) * start.crank_speed),
        dataclasses.replace(start, deflection=bent),
        dataclasses.replace(start, deflection_rate=rates),
    ]


@pytest.mark.verify
def test_disturbed_marches_of_a_link_chain_confirm_the_largest_multiplier() -> None:
    """The linear map from turn to turn that fits the differences best (dynamic mode decomposition: Schmid, J. Fluid Mech. 656, 2010)."""
    orbit = orbit_of_run_24()
    assert orbit.begin is not None
    pairs = zip(disturbed(orbit.begin, DISTURBED), disturbed(orbit.begin, -DISTURBED), strict=True)
    differences = [at_every_turn(plus, orbit.period) - at_every_turn(minus, orbit.period) for plus, minus in pairs]
    sizes = np.max([np.abs(each).max(axis=1) for each in differences], axis=0)[:, None]
    before = np.hstack([each[:, FIRST : LAST - 1] / sizes for each in differences])
    after = np.hstack([each[:, FIRST + 1 : LAST] / sizes for each in differences])
    left, values, right = np.linalg.svd(before, full_matrices=False)
    turn = left[:, :LASTING].T @ after @ right[:LASTING].T / values[:LASTING]
    found = float(np.abs(np.linalg.eigvals(turn)).max())
    name = "multiplier"
    value = row([library_case("thesis-24").mechanism], MeasureRequest(measures=(name,), accuracy=1e-4)).values[0, 0]
    assert out_of_date(OF_MEASURES, {name: abs(value - found)}) == {}


def largest(strain: Array) -> float:
    return float(np.abs(strain).max())


def half_range(strain: Array) -> float:
    return float(np.ptp(strain)) / 2.0


@pytest.mark.verify
def test_gauges_of_a_link_chain_confirm_the_stress_along_the_arm() -> None:
    """The moments along the arm are those of `reference`; a gauge is where they say that the stress is largest."""
    found: dict[str, float] = {}
    for name in ("thesis-24", "example", "shaper-cutting"):
        scene = library_case(name).mechanism
        length, modulus = scene.follower.length, scene.follower.elastic_modulus
        columns = motion("reference", scene, standard_start(scene), ReferenceSettings(modes=9, tolerance=1e-9), DURATION, 1e-3)
        stress = loads_of(scene, columns, lambda column, angle: 0.0).stress
        assert stress is not None
        for what, peak, size in (("peak.stress", stress.largest, largest), ("amplitude.stress", stress.amplitude, half_range)):
            assert peak.place is not None
            gauges = 0.1 * length, 0.2 * length, peak.place
            gauged = dataclasses.replace(scene, follower=dataclasses.replace(scene.follower, strain_gauges=gauges))
            links = motion("mujoco", gauged, standard_start(scene), ChainSettings(links=48), DURATION, 2e-4)
            forces = np.column_stack([links[name] for name in ("axial_base", "axial_slider", "axial_tip")]) / scene.follower.section.area()
            squares = [[0.0, s**2, length**2] for s in links["slider_position"]]
            pulled = np.array([np.interp(peak.place**2, *each) for each in zip(squares, forces, strict=True)])
            there = max(size(side * modulus * links["strain_3"] + pulled) for side in (1.0, -1.0))
            found[what] = max(found.get(what, 0.0), (abs(peak.value - there) - peak.uncertainty) / there)
    assert out_of_date(OF_MEASURES, found) == {}
