"""The follower alone in Exudyn: a cable clamped to a base body whose angle is a prescribed function of time."""

import time

import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from engines.base import Comparison, ModelDescription, Simulation
from engines.exudyn import settings as ladder
from engines.exudyn.assembly import Assembly
from engines.exudyn.damping import Dampers
from engines.exudyn.flexible import add_base, add_nodes, add_tip, add_weight, cable_of, direction, dot, quadrature, turned
from engines.exudyn.record import Record, accumulated, index, shape_columns
from engines.exudyn.settings import LARGEST_STEP, ExudynSettings
from engines.exudyn.simulation import ExudynSimulation
from engines.follower import FollowerEngine, slowest_frequency
from engines.start_state import at_rest
from engines.trajectory import FollowerTrajectory
from reference_model.mechanism import FollowerAlone
from reference_model.spin_up import base_motion

Array = NDArray[np.float64]

#: Hz, the slowest of run 24's motions, on which the engine's ladder was measured.
MEASURED_FREQUENCY = 10.9


class FollowerModel:
    """The assembled system, straight and at rest.

    Attributes:
        drive_equation: there is no crank.
        assembly: what was built.
        clock: s, the instant at which Exudyn's own clock stands at zero.
    """

    drive_equation: int | None = None

    def __init__(self, scene: FollowerAlone, settings: ExudynSettings) -> None:
        elements = settings.elements
        self.assembly = assembly = Assembly(scene)
        self.clock = 0.0
        self._scene, self._cable = scene, cable_of(scene.follower, elements, settings.axial_factor)
        state = at_rest(scene.follower.length)
        nodes = add_nodes(assembly, self._cable, state)
        for i in range(elements):
            assembly.mbs.AddObject(
                items.ObjectANCFCable2D(
                    length=self._cable.element_length,
                    massPerLength=scene.follower.mass_per_length,
                    bendingStiffness=scene.follower.bending_stiffness,
                    axialStiffness=self._cable.axial_stiffness,
                    nodeNumbers=[nodes[i], nodes[i + 1]],
                )
            )
        assembly.listed_body(f"follower: {elements} ANCF cable elements")
        base_body = add_base(assembly, 0.0, state, nodes)
        base_node = base_body[0]
        assembly.rotary_damper(base_node, scene.base.damping)
        self._drive = assembly.add_joint(
            "prescribed base angle",
            items.ObjectConnectorCoordinate(
                markerNumbers=[assembly.ground_coordinate, assembly.coordinate_marker(base_node, 2)],
                offsetUserFunction=lambda mbs, t, number, offset: self._motion(t)[0],
                offsetUserFunction_t=lambda mbs, t, number, offset: self._motion(t)[1],
            ),
            1,
        )
        add_tip(assembly, self._cable, state, nodes)
        self._damper_weights = scene.follower.damping * quadrature(self._cable)
        self._dampers: Dampers | None = None
        if scene.follower.damping > 0.0:
            self._dampers = Dampers(assembly, base_body, nodes, self._cable.nodes, self._damper_weights)
        add_weight(assembly, self._cable, nodes)
        assembly.mbs.Assemble()
        if self._dampers is not None:
            self._dampers.locate(assembly)
        self._base_index = index(assembly, base_node) + 2
        self._node_indices = np.array([index(assembly, node) for node in nodes])

    def _motion(self, t: float) -> tuple[float, float, float]:
        return base_motion(self._scene.spin_up.speed, self._scene.spin_up.time, self.clock + t)

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        """See `engines.exudyn.record.Model`."""
        if self._dampers is not None:
            self._dampers.follow(coordinates, rates, duration)

    def slider_position(self, coordinates: Array) -> None:
        """There is no slider."""

    def columns(self, record: Record) -> dict[str, Array]:
        """All columns of a trajectory; `dissipated_energy` and `drive_work` counted from the record's first row."""
        scene, cable = self._scene, self._cable
        q, rates, accelerations = (
            values[:, self._node_indices[:, None] + np.arange(4)] for values in (record.coordinates, record.rates, record.accelerations)
        )
        angle, speed, acceleration = (v[:, self._base_index] for v in (record.coordinates, record.rates, record.accelerations))
        b1 = np.column_stack([np.cos(angle), np.sin(angle)])
        tip_tangent, tip_rate, _ = direction(q[:, -1, 2:], rates[:, -1, 2:], accelerations[:, -1, 2:])
        (equation,) = self.assembly.mbs.systemData.GetObjectLTGAE(self._drive)
        torque = -record.multipliers[:, equation]
        work = np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2.0 * np.diff(angle))])
        moment, kinetic = cable.first_moment(q), 0.5 * scene.base.inertia * speed**2 + cable.kinetic_energy(rates)
        if scene.tip is not None:
            velocity = rates[:, -1, :2] + scene.tip.center_of_mass * tip_rate[:, None] * turned(tip_tangent)
            kinetic += 0.5 * (scene.tip.mass * np.sum(velocity**2, axis=1) + scene.tip.inertia * tip_rate**2)
            moment = moment + scene.tip.mass * (q[:, -1, :2] + scene.tip.center_of_mass * tip_tangent)
        return {
            "time": record.time,
            "follower_angle": angle,
            "tip_x": q[:, -1, 0],
            "tip_y": q[:, -1, 1],
            "tip_deflection": dot(turned(b1), q[:, -1, :2] - q[:, 0, :2]),
            "tip_acceleration": dot(turned(tip_tangent), accelerations[:, -1, :2]),
            **{
                f"strain_{i}": cable.curvature(q, x) * scene.follower.thickness / 2.0 for i, x in enumerate(scene.follower.strain_gauges, 1)
            },
            "base_torque": torque,
            "axial_stretch": cable.stretch(q),
            "kinetic_energy": kinetic,
            "strain_energy": cable.strain_energy(q),
            "dissipated_energy": self._dissipated(record.time, (speed, acceleration), q, rates, accelerations),
            "gravity_energy": -moment @ np.array(scene.gravity),
            "drive_work": work,
            **shape_columns(cable, q, turned(b1)),
        }

    def _dissipated(self, times: Array, turn: tuple[Array, Array], q: Array, rates: Array, accelerations: Array) -> Array:
        """Work taken by the dampers of base and follower, exactly as they are built."""
        speed, acceleration = turn
        across, across_rate = turned(q[:, :, :2]), turned(rates[:, :, :2])
        relative = rates[:, :, :2] - speed[:, None, None] * across
        change = accelerations[:, :, :2] - acceleration[:, None, None] * across - speed[:, None, None] * across_rate
        power = self._scene.base.damping * speed**2 + np.sum(relative**2, axis=2) @ self._damper_weights
        power_rate = 2.0 * (self._scene.base.damping * speed * acceleration + np.sum(relative * change, axis=2) @ self._damper_weights)
        return accumulated(times, power, power_rate)


class FollowerSimulation(ExudynSimulation):
    """Tells the model where Exudyn's clock, which restarts at every stretch of steps, really stands."""

    trajectory_type = FollowerTrajectory
    _model: FollowerModel

    def _solved(self) -> tuple[str, str] | None:
        trouble = super()._solved()
        self._model.clock += self._solver.it.endTime
        return trouble


class ExudynAlone(FollowerEngine[ExudynSettings]):
    """A cable that can stretch, on a base whose angle is a constraint of position."""

    def describe(self, scene: FollowerAlone, settings: ExudynSettings) -> ModelDescription:
        """Bodies, joints and degrees of freedom, read off the assembled system."""
        return FollowerModel(scene, settings).assembly.describe()

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> ExudynSettings:
        """The engine's ladder, its steps in proportion to the slowest period."""
        found = ladder.LADDER.pick(accuracy)
        return found.replaced(step=min(found.step * MEASURED_FREQUENCY / slowest_frequency(scene), LARGEST_STEP))

    def comparisons(self, settings: ExudynSettings, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """Time and space apart, as with the mechanism."""
        in_time = ladder.in_time(settings, output_step)
        return in_time, ladder.in_space(settings, in_time)

    def prepare(self, scene: FollowerAlone, start: None, settings: ExudynSettings) -> Simulation:
        """See `FollowerEngine.prepare`."""
        begun = time.perf_counter()
        simulation = FollowerSimulation(FollowerModel(scene, settings), settings)
        simulation.setup_seconds = time.perf_counter() - begun
        return simulation
