"""The follower alone in Exudyn: a cable clamped to a base body whose angle is a prescribed function of time."""

import time

import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from quickreturn.engines.base import Comparison, FollowerEngine, ModelDescription, Simulation
from quickreturn.engines.exudyn import settings as ladder
from quickreturn.engines.exudyn.flexible import CableModel, add_base, add_cable, add_nodes, add_tip
from quickreturn.engines.exudyn.record import Record, accumulated, index
from quickreturn.engines.exudyn.settings import LARGEST_STEP, ExudynSettings
from quickreturn.engines.exudyn.simulation import ExudynSimulation
from quickreturn.engines.start_state import at_rest
from quickreturn.engines.trajectory import FollowerTrajectory
from quickreturn.reference_model.mechanism import FollowerAlone
from quickreturn.reference_model.natural_modes import clamped_modes
from quickreturn.reference_model.spin_up import base_motion

Array = NDArray[np.float64]

#: Hz, the slowest of run 24's motions, on which the engine's ladder was measured.
MEASURED_FREQUENCY = 10.9


class FollowerModel(CableModel):
    """The assembled system, straight and at rest.

    Exudyn's clock restarts at every stretch of steps: where it began last is kept here.
    """

    trajectory_type = FollowerTrajectory

    def __init__(self, scene: FollowerAlone, settings: ExudynSettings) -> None:
        super().__init__(scene, settings)
        assembly, cable = self.assembly, self._cable
        self._begun = self._stretch = 0.0
        self._spin_up = scene.spin_up
        state = at_rest(scene.follower.length)
        self._nodes = nodes = add_nodes(assembly, cable, state)
        add_cable(assembly, cable, nodes)
        assembly.listed_body(f"follower: {cable.elements} ANCF cable elements")
        base = add_base(assembly, state, nodes)
        self._drive = assembly.add_joint(
            "prescribed base angle",
            items.ObjectConnectorCoordinate(
                markerNumbers=[assembly.ground_coordinate, assembly.coordinate_marker(base[0], 2)],
                offsetUserFunction=lambda mbs, t, number, offset: self._motion(t)[0],
                offsetUserFunction_t=lambda mbs, t, number, offset: self._motion(t)[1],
            ),
            1,
        )
        add_tip(assembly, cable, state, nodes)
        self._load(base)
        assembly.mbs.Assemble()
        self._locate()
        self._base_index = index(assembly, base[0]) + 2

    def _motion(self, t: float) -> tuple[float, float, float]:
        return base_motion(self._spin_up.speed, self._spin_up.time, self._begun + t)

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        self._begun += self._stretch
        self._stretch = duration
        super().prepare_stretch(coordinates, rates, duration)

    def columns(self, record: Record) -> dict[str, Array]:
        line = self._line(record)
        angle, speed, acceleration = (v[:, self._base_index] for v in (record.coordinates, record.rates, record.accelerations))
        frame = np.column_stack([np.cos(angle), np.sin(angle)]), speed, acceleration
        (equation,) = self.assembly.mbs.systemData.GetObjectLTGAE(self._drive)
        torque = -record.multipliers[:, equation]
        return {
            "time": record.time,
            "follower_angle": angle,
            **self._follower_columns(record, line, frame),
            "base_torque": torque,
            "axial_stretch": self._cable.stretch(line[0]),
            **self._stored(line, frame),
            "dissipated_energy": accumulated(record.time, *self._damped(line, frame)),
            "drive_work": np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2.0 * np.diff(angle))]),
        }


class ExudynAlone(FollowerEngine[ExudynSettings]):
    """A cable that can stretch, on a base whose angle is a constraint of position."""

    def describe(self, scene: FollowerAlone, settings: ExudynSettings) -> ModelDescription:
        """Bodies, joints and degrees of freedom, read off the assembled system."""
        return FollowerModel(scene, settings).assembly.describe()

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> ExudynSettings:
        """The engine's ladder, its steps in proportion to the slowest period."""
        found, slowest = ladder.LADDER.pick(accuracy), float(clamped_modes(scene, 1).frequencies[0])
        return found.replaced(step=min(found.step * MEASURED_FREQUENCY / slowest, LARGEST_STEP))

    def comparisons(self, settings: ExudynSettings, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """Time and space apart, as with the mechanism."""
        in_time = ladder.in_time(settings, output_step)
        return in_time, ladder.in_space(settings, in_time)

    def prepare(self, scene: FollowerAlone, start: None, settings: ExudynSettings) -> Simulation:
        begun = time.perf_counter()
        return ExudynSimulation(FollowerModel(scene, settings), settings, begun)
