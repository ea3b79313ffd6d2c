"""A chain of links in MuJoCo, ready to be advanced. Between two rows MuJoCo is alone at work."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import mujoco
import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import Trajectory
from quickreturn.engines.units import Units
from quickreturn.plugins.as_built.contact import chain
from quickreturn.plugins.as_built.contact.observables import Row, columns
from quickreturn.plugins.as_built.contact.settings import ContactSettings
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive

#: Warnings after which the numbers are no motion any more.
_BROKEN: Final = (mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL)


class ContactSimulation(Simulation):
    """See `Simulation`. MuJoCo's data hold the state, in units of the scene's own."""

    def __init__(self, scene: Mechanism, start: Start, settings: ContactSettings) -> None:
        began = time.perf_counter()
        self._units = Units.of(scene)
        self._scene = scene = self._units.scene(scene)
        self._settings, self._links = settings, settings.links
        h = scene.follower.length / settings.links
        armature = settings.armature * scene.follower.mass_per_length * h**3
        self._largest_step = settings.step * chain.longest_stable_step(scene, settings.links, armature)
        self._model = chain.build(scene, settings.links, self._largest_step, settings.contact_time * self._largest_step, armature)
        self._data = mujoco.MjData(self._model)
        assert isinstance(scene.crank.drive, TorqueDrive)
        self._data.qfrc_applied[0] = scene.crank.drive.torque
        self._place(self._units.start(start))
        self.time, self._began_at = 0.0, start.crank_angle
        self.setup_seconds = time.perf_counter() - began

    def _place(self, start: Start) -> None:
        """The links have the tangents of the start at their middles; the first turns so that the pin lies on their middle line."""
        scene, n = self._scene, self._links
        h, state = scene.follower.length / n, reconstruct(scene, start)
        middles = h * np.arange(0.5, n, 1.0, dtype=np.float64)
        tangents, rates = state.tangent(middles), state.tangent_rate(middles)
        arm = scene.crank.length * np.exp(1j * start.crank_angle)
        pin, velocity = arm - scene.pivot_distance, 1j * start.crank_speed * arm
        link = min(int(state.slider_position / h), n - 1)
        corner = h * np.exp(1j * tangents[:link]).sum()
        along = np.exp(1j * tangents[link])
        # the chain's point at the pin's distance from P, on the link where the slider is
        reach = math.sqrt(max(abs(pin) ** 2 - (corner / along).imag ** 2, 0.0)) - (corner / along).real
        point = corner + reach * along
        tangents = tangents + np.angle(pin / point)
        e = np.exp(1j * tangents)
        point, normal = point * pin / point, 1j * e[link]
        moves = h * (1j * rates[:link] * e[:link]).sum() + reach * 1j * rates[link] * e[link]
        lever = _dot(1j * point, normal)
        rates = rates + _dot(velocity - moves, normal) / lever
        self._data.qpos[0], self._data.qvel[0] = start.crank_angle, start.crank_speed
        self._data.qpos[1], self._data.qvel[1] = tangents[0], rates[0]
        self._data.qpos[2:], self._data.qvel[2:] = np.diff(tangents), np.diff(rates)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        began = time.perf_counter()
        count, unit = round(duration / output_step) + 1, self._units.time
        steps = max(1, math.ceil(output_step / unit / self._largest_step * (1.0 - 1e-9)))
        step = output_step / unit / steps
        self._model.opt.timestep = step
        self._model.geom_solref[:, 0] = self._settings.contact_time * step
        rows, cause, advice = list[Row](), "", ""
        with _quiet():
            for k in range(count):
                if k:
                    mujoco.mj_step(self._model, self._data, steps)
                mujoco.mj_forward(self._model, self._data)
                row = Row.of(self._model, self._data)
                cause, advice = self._trouble(row)
                if cause:
                    break
                rows.append(row)
        good = self.time + output_step * max(len(rows) - 1, 0)
        trajectory = self._table(rows, output_step, began, steps) if rows else None
        if cause or trajectory is None:
            raise EngineFailure(good, cause, advice, trajectory)
        self.time = good
        return trajectory

    def _table(self, rows: list[Row], output_step: float, began: float, steps: int) -> Trajectory:
        table = self._units.columns_in_si(columns(self._scene, rows, self._links, self._began_at))
        table["time"] = self.time + output_step * np.arange(len(rows), dtype=np.float64)
        return Trajectory(table, time.perf_counter() - began, {"steps": float(steps * (len(rows) - 1))})

    def _trouble(self, row: Row) -> tuple[str, str]:
        """Cause and advice if the state is no motion of the mechanism any more, else empty."""
        finer = f"try a smaller engine.step than {self._settings.step:g} or more links"
        if any(self._data.warning[each].number for each in _BROKEN) or not row.is_finite:
            return "MuJoCo's accelerations grew beyond all bounds", finer
        place, gap = row.slider(self._scene, self._links)
        if place > self._scene.follower.length:
            return "the slider left the follower's end", "lengthen the follower or slow the crank"
        if abs(gap) > chain.reach_of_pin(self._scene):
            return (
                f"the pin was pressed through a wall of the slot: it is {abs(gap) * self._units.length:.3g} m from the centre line",
                finer,
            )
        return "", ""


def _dot(a: complex, b: complex) -> float:
    """Scalar product of two vectors of the plane."""
    return float((a * np.conj(b)).real)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keeps MuJoCo's warnings from a log file."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)
