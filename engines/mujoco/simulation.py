"""A link chain in MuJoCo, ready to be advanced."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.mujoco import chain, time_loop
from quickreturn.engines.mujoco.chain import stable_step
from quickreturn.engines.mujoco.context import CONTEXT
from quickreturn.engines.mujoco.hook import control_hook
from quickreturn.engines.mujoco.settings import ChainSettings, hinge_count
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import Trajectory, trajectory_type
from quickreturn.engines.units import Units
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import ROW, by_column, recorded_columns
from quickreturn.reference_model.constants import drive_constants
from quickreturn.reference_model.joint import rollers
from quickreturn.reference_model.mechanism import Mechanism, MotorCurve, Scene, TorqueDrive
from quickreturn.reference_model.rigid import crank_pace
from quickreturn.reference_model.tip import tool_constants

#: Longest step over the stable one with a rigid follower, whose only vibration is that of a compliant joint.
_RESOLVED = 1.0 / 64.0
_STEPS_PER_TURN = 360  # of the crank, at least
_ROWS_AT_ONCE = 250  # from one call of compiled code, after which Python answers an interrupt from the keyboard


class ChainSimulation(Simulation):
    """See `Simulation`. MuJoCo's data hold the state, a `CONTEXT` that of the constraint, both in units of the scene's own.

    MuJoCo has absolute thresholds, such as 1e-15 for masses, inertias and pivots of a factorisation.

    Args:
        scene: the mechanism, or the follower alone.
        start: start of the mechanism; None for the follower alone, straight and at rest.
        settings: settings of the chain.
    """

    def __init__(self, scene: Scene, start: Start | None, settings: ChainSettings) -> None:
        began = time.perf_counter()
        self.time = 0.0
        self._units = Units.of(scene)
        self._scene = scene = self._units.scene(scene)
        self._hinges = hinge_count(scene, settings.links)
        self._model = chain.build(scene, self._hinges, _armature(scene, settings))
        self._data = mujoco.MjData(self._model)
        self._context, *self._tables = _context(scene, self._hinges, self._data)
        self._past = np.zeros((2, self._model.nv))
        self._data.userdata[0] = self._context.ctypes.data
        self._gauges = np.array(scene.follower.strain_gauges)
        self._relative_step, self._stable_step = settings.step, stable_step(self._model, scene, self._hinges)
        if start is not None:
            self._place(self._units.start(start))
        self.setup_seconds = time.perf_counter() - began

    def _step_over(self, duration: float) -> float:
        """Step for the next `duration`, in the scene's units: small enough for the chain's fastest rate and the motion that drives it."""
        return self._relative_step * min(
            self._stable_step * (1.0 if self._hinges else _RESOLVED), self._time_of_drive(duration) / _STEPS_PER_TURN
        )

    def _time_of_drive(self, duration: float) -> float:
        """Shortest time of a turn of the crank within `duration`, or the time in which a base alone spins up, in the scene's units."""
        if self._scene.crank is None:
            return self._scene.spin_up.time
        speed = self._largest_crank_speed(self._scene, duration)
        return 2.0 * math.pi / speed if speed > 0.0 else math.inf

    def _largest_crank_speed(self, mechanism: Mechanism, duration: float) -> float:
        """Largest crank speed that the drive alone can reach within `duration`, or at all against its damping, in the scene's units."""
        drive = mechanism.crank.drive
        if not isinstance(drive, TorqueDrive | MotorCurve):
            return crank_pace(mechanism)
        present = abs(float(self._data.qvel[0]))
        reached = present + drive.largest_torque * duration / mechanism.crank_inertia
        return max(present, min(reached, abs(drive.balanced_speed)))

    def _place(self, start: Start) -> None:
        """Set the chain's state: the hinges have the start's shape, the base such angle and rate that the slider is on the centre line."""
        assert self._scene.crank is not None
        state, length = reconstruct(self._scene, start), self._scene.follower.length
        qpos, qvel = self._data.qpos, self._data.qvel
        first = self._model.nv - self._hinges - 1
        if first:
            qpos[0], qvel[0] = start.crank_angle, start.crank_speed
        link_centers = np.linspace(0.0, length, self._hinges + 1)
        qpos[first], qvel[first] = state.follower_angle, state.follower_rate
        qpos[first + 1 :] = _hinge_angles(state.tangent(link_centers))
        qvel[first + 1 :] = _hinge_angles(state.tangent_rate(link_centers))
        self._context["slider_position"] = state.slider_position
        self._context["prescribed_angle"] = start.crank_angle
        gap = time_loop.assemble(self._context, qpos, qvel, start.crank_angle, start.crank_speed)
        if not abs(gap) < 1e-12 * length:
            left = gap * self._units.length
            raise EngineFailure(0.0, f"the chain does not reach the slider, a gap of {left:.3g} m is left", "try more links (engine.links)")

    def advance(self, duration: float, output_step: float) -> Trajectory:
        began = time.perf_counter()
        table = np.zeros(round(duration / output_step) + 1, ROW)
        times = self.time + output_step * np.arange(len(table), dtype=np.float64)
        unit = self._units.time
        interval = output_step / unit
        steps = max(1, math.ceil(interval / self._step_over(duration / unit) * (1.0 - 1e-9)))
        self._model.opt.timestep = interval / steps
        self._data.time = self.time / unit
        rows = 1
        with _hooks():
            while True:
                first = rows - 1  # a piece begins with the last row of the previous one
                piece = table[first : first + _ROWS_AT_ONCE + 1]
                filled, state = time_loop.advance(
                    self._model._address,
                    self._data._address,
                    self._context,
                    self._past,
                    interval / steps,
                    steps,
                    self._gauges,
                    piece,
                )
                rows = first + filled
                if state != time_loop.GOOD or rows == len(table):
                    break
        alone, spring = self._scene.crank is None, self._scene.acting_spring is not None
        recorded = recorded_columns(by_column(table[:rows]), alone=alone, bends=self._hinges > 0, spring=spring)
        columns = self._units.columns_in_si(recorded)
        columns["time"] = times[:rows]
        statistics = {"steps": float(steps * max(rows - 1, 0))}
        trajectory = trajectory_type(self._scene)(columns, time.perf_counter() - began, statistics)
        if state != time_loop.GOOD:
            good = times[max(rows - 1, 0)]
            raise EngineFailure(float(good), *self._reason(state), trajectory if rows else None)
        self.time = float(times[-1])
        return trajectory

    def _reason(self, state: int) -> tuple[str, str]:
        """Cause of a failure, and advice, see `EngineFailure`."""
        step = self._model.opt.timestep
        if state == time_loop.SLIDER_LEFT and step < self._stable_step:  # it also leaves in an unstable run
            unit = self._units.length
            place, length = float(self._context["slider_position"][0]) * unit, self._scene.follower.length * unit
            return (
                f"the slider left the follower (arc length {place:.6g} m, follower.length {length:.6g} m)",
                "lengthen the follower or slow the crank",
            )
        return "the motion grew beyond all bounds", f"try a step below {step * self._units.time:.3g} s (engine.step) or more links"


def _armature(mechanism: Scene, settings: ChainSettings) -> float:
    """Inertia added to a hinge. With the power 1.5 its error falls with the number of links as fast as the chain's own."""
    follower = mechanism.follower
    return settings.armature * follower.mass_per_length * (follower.length**2 / settings.links) ** 1.5


def _hinge_angles(tangents: Array) -> Array:
    """Hinge angles (N,) of the chain for a beam with these tangent angles (N + 1,) at the link centres, rad.

    A hinge's angle is h times the beam's curvature at the hinge: up to order h⁴ the difference of the tangents' angles, less the second
    difference of that / 24.
    """
    angles = np.diff(tangents)
    angles[1:-1] -= np.diff(angles, 2) / 24.0
    return angles


def _context(scene: Scene, hinges: int, data: mujoco.MjData) -> tuple[NDArray[np.void], Array, Array]:
    """The `CONTEXT` of a scene, shape (1,), and two arrays to which it has the addresses."""
    follower, context, tool = scene.follower, np.zeros(1, CONTEXT), tool_constants(scene.tip_body)
    drive = drive_constants(None if scene.crank is None else scene.crank.drive)
    table, drive_table = tool.pop("force_table"), drive.pop("drive_table")
    values: dict[str, Any] = {
        "qpos": data.qpos.ctypes.data,
        "qvel": data.qvel.ctypes.data,
        "qacc": data.qacc.ctypes.data,
        "force_bias": data.qfrc_bias.ctypes.data,
        "force_passive": data.qfrc_passive.ctypes.data,
        "force_applied": data.qfrc_applied.ctypes.data,
        "energy": data.energy.ctypes.data,
        "coordinates": len(data.qpos),
        "hinges": hinges,
        "link_length": follower.length / max(hinges, 1),
        "follower_length": follower.length,
        "bending_stiffness": follower.bending_stiffness if hinges else 0.0,
        "extreme_fibre": follower.extreme_fibre,
        "beam_damping": follower.damping,
        "material_damping": follower.material_damping,
        "base_inertia": scene.base.inertia,
        "base_damping": scene.base.damping,
        "base_friction": scene.base.friction_torque,
        "base_friction_rate": scene.base.friction_rate,
        "mass_per_length": follower.mass_per_length,
        "tip_mass": scene.tip_body.mass,
        "tip_inertia": scene.tip_body.inertia,
        "tip_offset": scene.tip_body.center_of_mass,
        "gravity": complex(*scene.gravity),
        **tool,
        "force_table": table.ctypes.data,
        "force_points": len(table),
        **drive,
        "drive_table": drive_table.ctypes.data,
        "drive_points": len(drive_table),
        "force_follows": scene.tip_body.follows,
        "slide_friction": scene.tip_body.friction_force,
        "slide_speed": scene.tip_body.friction_speed,
    }
    if scene.crank is None:
        values |= {"base_is_prescribed": 1, "spin_up_speed": scene.spin_up.speed, "spin_up_time": scene.spin_up.time}
    else:
        values |= _crank_and_slider(scene)
    for name, value in values.items():
        context[name] = value
    return context, table, drive_table


def _crank_and_slider(mechanism: Mechanism) -> dict[str, Any]:
    """Fields of the `CONTEXT` for crank, slider and spring."""
    crank, slider, drive = mechanism.crank, mechanism.slider, mechanism.crank.drive
    values: dict[str, Any] = {
        "pivot_distance": mechanism.pivot_distance,
        "crank_length": crank.length,
        "crank_is_free": int(mechanism.crank_is_free),
        "crank_mass": mechanism.crank_mass,
        "crank_moment": mechanism.crank_moment,
    }
    if (spring := mechanism.acting_spring) is not None:
        anchor, place = complex(*spring.anchor) - mechanism.pivot_distance, spring.place_on(mechanism.follower.length)
        values |= {"is_held": 1, "anchor": anchor, "spring_place": place, "spring": spring.law}
    values |= {"friction": slider.friction, "friction_force": slider.friction_force, "friction_speed": slider.friction_speed}
    if not slider.is_rigid:
        law = asdict(rollers(slider))
        values |= {"joint_is_compliant": 1, "contact_loss": law.pop("loss"), "joint_damping": law.pop("damping"), **law}
    if isinstance(drive, TorqueDrive):
        values |= {"crank_torque": drive.torque, "crank_damping": drive.damping}
    elif not isinstance(drive, MotorCurve):
        values |= {
            "prescribed_speed": drive.initial_speed,
            "prescribed_inertia": mechanism.crank_inertia,
            "prescribed_weight_1": -mechanism.crank_moment * mechanism.gravity[0],
            "prescribed_weight_2": -mechanism.crank_moment * mechanism.gravity[1],
        }
    return values


@contextmanager
def _hooks() -> Iterator[None]:
    """Installs the control hook for one call of `advance`, because MuJoCo's callbacks are global; keeps its warnings from a log file."""
    previous = mujoco.get_mjcb_control(), mujoco.get_mju_user_warning()
    mujoco.set_mjcb_control(control_hook.ctypes)
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mjcb_control(previous[0])
        mujoco.set_mju_user_warning(previous[1])
