"""Results to be drawn, made up without any engine: the rigid mechanism's motion with a vibration of known frequency on it."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.cycle import ChannelMeasures
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Consensus
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.trajectory import OPTIONAL, REQUIRED
from quickreturn.reference_model.columns import MOMENTS, SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import RigidMotion, rigid_kinetostatics, rigid_motion
from tests.changed_run import UNRESOLVED, changed_run, measured
from tests.reference_model.rigid_loads import rigid_bearing_forces, rigid_bending_moment

ENGINES = ("thesis", "reference", "exudyn", "mujoco")
STIFFER = {"thesis": 1.13, "reference": 1.0, "exudyn": 1.002, "mujoco": 0.997}  # first mode over the reference's


def made_up_run(case: Case, engine: str, status: str = Ending.SETTLED, seed: int = 0, samples: int = 400, turning: int = 1) -> Run:
    """A run of any status; a failed one has no cycle, a rigid case no vibration."""
    run = changed_run(
        Run(engine=engine, estimate_of="integration" if engine == "thesis" else "total"),
        status=status,
        start=None if status in ("failed", "refused") else "standard",
        unestimated="" if status in (Ending.SETTLED, Ending.INACCURATE) else status,
        settling_error=5e-4,
        solve_seconds=1.0,
        reached=status == Ending.SETTLED,
    )
    if status in ("failed", "refused"):
        return run
    mechanism, factor = case.mechanism, STIFFER.get(engine, 1.01)
    random = np.random.default_rng(seed)
    speed = turning * abs(mechanism.crank.drive.initial_speed)
    time = np.linspace(0.0, 2.0 * math.pi / abs(speed), samples)
    angle = math.pi + speed * time
    motion = rigid_motion(mechanism, angle, speed)
    force, torque = rigid_kinetostatics(mechanism, angle, speed)
    bends = 0.0 if mechanism.follower.is_rigid else 1.0
    vibration = bends * np.sin(2.0 * np.pi * round(8 * factor) * time / time[-1])
    length = mechanism.follower.length
    columns = (
        dict.fromkeys((*REQUIRED, *OPTIONAL), np.zeros(samples))
        | {
            "time": 3.0 + time,
            "crank_angle": angle,
            "crank_speed": speed * (1.0 + 0.01 * np.cos(angle)),
            "follower_angle": motion.follower_angle,
            "slider_position": motion.slider_position,
            "tip_x": mechanism.pivot_distance + length * np.cos(motion.follower_angle),
            "tip_y": length * np.sin(motion.follower_angle),
            "tip_deflection": 0.01 * vibration,
            "tip_acceleration": length * motion.follower_acceleration + 20.0 * vibration,
            "slider_force": force + 2.0 * vibration,
            "crank_torque": torque,
        }
        | _bending(mechanism, angle, speed, motion)
    )
    for place, name in enumerate(SHAPE, start=1):
        columns[name] = columns["tip_deflection"] * (place / (len(SHAPE) + 1)) ** 2
    for gauge, name in enumerate(CHANNELS[1:], start=1):
        columns[name] = bends * 1e-4 * (gauge * np.sin(angle) + vibration)
    errors = {name: 5e-4 * float(np.max(np.abs(columns[name]))) for name in CHANNELS}
    estimates = {name: dict.fromkeys(("pre", "post"), 2e-3 * float(np.max(np.abs(values)))) for name, values in columns.items()}
    waveforms = {name: dict.fromkeys(("pre", "post"), 2e-3 * float(np.std(columns[name]))) for name in CHANNELS}
    run = changed_run(run, settling_errors=errors, cycle=columns, extreme_estimates=estimates, waveform_estimates=waveforms)
    if not (bends and status == Ending.SETTLED):
        return run
    consensus, measures = [], []
    for half in ("pre", "post"):
        frequency = 17.0 * factor * (1.0 + 0.0004 * random.standard_normal())
        consensus.append(Consensus(half, frequency, 0.1, 0.02))
        measures += [_measure(half, name, frequency, columns[name], random) for name in CHANNELS]
    return changed_run(run, consensus=tuple(consensus), measures=tuple(measures))


def _bending(mechanism: Mechanism, angle: np.ndarray, speed: float, motion: RigidMotion) -> dict[str, np.ndarray]:
    """Moments and bearing forces of the rigid mechanism."""
    pivot, crank = rigid_bearing_forces(mechanism, angle, speed)
    length = mechanism.follower.length
    places = {name: (k + 1) * length / 12.0 for k, name in enumerate(MOMENTS)} | {"moment_base": 0.0, "moment_tip": length}
    places |= dict.fromkeys(("moment_slider", "moment_inboard"), motion.slider_position)
    moments = {name: rigid_bending_moment(mechanism, at, angle, speed) for name, at in places.items()}
    return moments | {
        f"{name}_force_{axis}": force
        for name, forces in (("pivot", pivot), ("crank", crank))
        for axis, force in zip("xy", forces, strict=True)
    }


def _measure(half: str, channel: str, frequency: float, values: np.ndarray, random: np.random.Generator) -> ChannelMeasures:
    peak = float(np.max(np.abs(values)))
    resolvable = random.random() > 0.2
    amplitude = peak * (0.5 + 0.003 * random.standard_normal()) if resolvable else None
    numbers = {"minimum": -peak * (1.0 + 0.01 * random.standard_normal()), "maximum": peak * (1.0 + 0.01 * random.standard_normal())}
    numbers |= {"minimum_estimate": 0.01 * peak, "maximum_estimate": 0.01 * peak}
    if not resolvable:
        return measured(half, channel, **UNRESOLVED, **numbers, reason="made up")
    sizes = {"first_mode_frequency": (frequency, 0.14, 0.06), "first_mode_amplitude": (amplitude, 0.01 * peak, 0.01 * peak)}
    for name, (value, uncertainty, estimate) in sizes.items():
        numbers |= {name: value, f"{name}_uncertainty": uncertainty, f"{name}_estimate": estimate}
    return measured(half, channel, **numbers)


def made_up_result(name: str, statuses: dict[str, str] | None = None, seed: int = 0, turning: int = 1) -> CaseResult:
    """All four engines on a case of the library, settled unless `statuses` says otherwise."""
    case = load_case(name)
    chosen = dict.fromkeys(ENGINES, Ending.SETTLED) | (statuses or {})
    runs = {
        engine: made_up_run(case, engine, status, seed + number, turning=turning) for number, (engine, status) in enumerate(chosen.items())
    }
    return compare(case, runs)


def with_run(result: CaseResult, engine: str, **changes: Any) -> CaseResult:
    """The same results with another run of one engine."""
    return dataclasses.replace(result, runs={**result.runs, engine: changed_run(result.runs[engine], **changes)})


def with_table(
    result: CaseResult,
    name: str,
    columns: Sequence[str],
    declared: Mapping[str, str] | None = None,
    of_experiment: bool = False,
    factor: float = 1.0,
) -> CaseResult:
    """The same results beside a recorded table: some columns of the reference's turn, times a factor."""
    cycle = result.runs["reference"].cycle
    values = {"time": cycle["time"], "crank_angle": cycle["crank_angle"], **{column: factor * cycle[column] for column in columns}}
    table = RecordedTable(name, name, values, declared or {"origin": "measured"}, of_experiment)
    return compare(result.case, result.runs, {**result.recorded, name: recorded_run(table, result.case)})


def with_strength(result: CaseResult, **strengths: Any) -> CaseResult:
    """The same results of an arm of another material."""
    mechanism = result.case.mechanism
    scene = dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, **strengths))
    return dataclasses.replace(result, case=dataclasses.replace(result.case, scene=scene))
