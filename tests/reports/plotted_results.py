"""Results to be drawn, made up without any engine: the rigid mechanism's motion with a vibration of known frequency on it."""

import dataclasses
import math
from typing import Any

import numpy as np

from cases.case import Case
from cases.case_file import load_case
from cases.comparison import CaseResult, compare
from cases.engine_run import EngineRun
from cases.measures import CHANNELS
from cases.steady_run import INACCURATE, SETTLED
from engines.trajectory import OPTIONAL, REQUIRED
from reference_model.rigid import rigid_kinetostatics, rigid_motion

ENGINES = ("thesis", "reference", "exudyn", "mujoco")
STIFFER = {"thesis": 1.13, "reference": 1.0, "exudyn": 1.002, "mujoco": 0.997}  # first mode over the reference's


def made_up_run(case: Case, engine: str, status: str = SETTLED, seed: int = 0, samples: int = 400, turning: int = 1) -> EngineRun:
    """A run of any status; a failed one has no cycle, a rigid case no vibration."""
    document: dict[str, Any] = {
        "engine": engine,
        "estimate_of": "integration" if engine == "thesis" else "total",
        "status": status,
        "start": None if status in ("failed", "refused") else "standard",
        "measures": [],
        "consensus": [],
        "unestimated": "" if status in (SETTLED, INACCURATE) else status,
        "settling_error": 5e-4,
        "solve_seconds": 1.0,
        "reached": status == SETTLED,
    }
    if status in ("failed", "refused"):
        return EngineRun(document, {})
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
    columns = dict.fromkeys((*REQUIRED, *OPTIONAL), np.zeros(samples)) | {
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
    for gauge, name in enumerate(CHANNELS[1:], start=1):
        columns[name] = bends * 1e-4 * (gauge * np.sin(angle) + vibration)
    document["settling_errors"] = {name: 5e-4 * float(np.max(np.abs(columns[name]))) for name in CHANNELS}
    if bends and status == SETTLED:
        for half in ("pre", "post"):
            frequency = 17.0 * factor * (1.0 + 0.004 * random.standard_normal())
            document["consensus"].append(
                {"half": half, "first_mode_frequency": frequency, "uncertainty": 0.1, "first_mode_frequency_estimate": 0.02}
            )
            document["measures"] += [_measure(half, name, frequency, columns[name], random) for name in CHANNELS]
    return EngineRun(document, columns)


def _measure(half: str, channel: str, frequency: float, values: np.ndarray, random: np.random.Generator) -> dict[str, Any]:
    peak = float(np.max(np.abs(values)))
    resolvable = random.random() > 0.2
    return {
        "half": half,
        "channel": channel,
        "first_mode_frequency": frequency if resolvable else None,
        "first_mode_frequency_uncertainty": 0.2 if resolvable else None,
        "first_mode_frequency_estimate": 0.02 if resolvable else None,
        "first_mode_amplitude": peak * (0.5 + 0.02 * random.standard_normal()) if resolvable else None,
        "first_mode_amplitude_uncertainty": 0.02 * peak if resolvable else None,
        "first_mode_amplitude_estimate": 0.01 * peak if resolvable else None,
        "second_mode_frequency": None,
        "minimum": -peak * (1.0 + 0.01 * random.standard_normal()),
        "maximum": peak * (1.0 + 0.01 * random.standard_normal()),
        "minimum_estimate": 0.01 * peak,
        "maximum_estimate": 0.01 * peak,
        "reason": "" if resolvable else "made up",
    }


def made_up_result(name: str, statuses: dict[str, str] | None = None, seed: int = 0, turning: int = 1) -> CaseResult:
    """All four engines on a case of the library, settled unless `statuses` says otherwise."""
    case = load_case(name)
    chosen = dict.fromkeys(ENGINES, SETTLED) | (statuses or {})
    runs = {
        engine: made_up_run(case, engine, status, seed + number, turning=turning) for number, (engine, status) in enumerate(chosen.items())
    }
    return compare(case, runs)


def with_mechanism(result: CaseResult, **changes: Any) -> CaseResult:
    """The same results under a changed mechanism."""
    mechanism = dataclasses.replace(result.case.mechanism, **changes)
    return dataclasses.replace(result, case=dataclasses.replace(result.case, scene=mechanism))
