"""The Exudyn model that suits a scene."""

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.exudyn.construction import add_base, add_cable, add_nodes, add_tip
from quickreturn.engines.exudyn.flexible import CableModel, FlexibleModel
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.record import Model, Record, accumulated, index
from quickreturn.engines.exudyn.rigid import RigidModel
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import at_rest, reconstruct
from quickreturn.reference_model.mechanism import FollowerAlone, Scene, base_motion


def model_of(scene: Scene, start: Start | None, settings: ExudynSettings) -> Model:
    """The model of a scene in the state `start`, which a follower alone does not need."""
    if scene.crank is None:
        return FollowerModel(scene, settings)
    assert start is not None
    state = reconstruct(scene, start)
    if scene.follower.is_rigid:
        return RigidModel(scene, start, state)
    return FlexibleModel(scene, start, state, settings)


Array = NDArray[np.float64]


class FollowerModel(CableModel):
    """The assembled system, straight and at rest.

    Exudyn's clock restarts at every stretch of steps, so that the time of the last restart is kept here.
    """

    def __init__(self, scene: FollowerAlone, settings: ExudynSettings) -> None:
        super().__init__(scene, settings)
        assembly, cable = self.assembly, self._cable
        self._restart_time = self._stretch = 0.0
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
        """Prescribed angle, rate and acceleration of the base at Exudyn's time `t` (s), which counts from the last restart."""
        return base_motion(self._spin_up.speed, self._spin_up.time, self._restart_time + t)

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        self._restart_time += self._stretch
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
            **self._follower_columns(record, line, frame, held=torque),
            "base_torque": torque,
            "axial_stretch": self._cable.stretch(line[0]),
            **self._stored(line, frame),
            "dissipated_energy": accumulated(record.time, *self._damped(line, frame)),
            "drive_work": np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2.0 * np.diff(angle))]),
        }
