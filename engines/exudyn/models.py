"""The Exudyn model that suits a scene, and its frozen-crank natural frequencies.

With the ALE joint the frequencies would be several per cent off, because its massless axial coordinate enters the eigenvalue problem.
The sliding joint on ordinary cable elements, with its point held on the ground, gives the frequencies of the beam supported at the
slider. A compliant joint is a spring along the normal from the ground to the follower's point at the slider: in its modes the follower
does not slide.
"""

import math
from typing import Any

import numpy as np

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.cable import Cable
from quickreturn.engines.exudyn.construction import add_base, add_cable, add_ends, add_nodes, add_tip, cable_of
from quickreturn.engines.exudyn.flexible import CableModel, FlexibleModel
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.record import Model, Record, accumulated, index
from quickreturn.engines.exudyn.rigid import RigidModel, follower_inertia
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import StartState, at_rest, reconstruct
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, Scene, base_motion
from quickreturn.reference_model.rigid import stiffness_across


def model_of(scene: Scene, start: Start | None, settings: ExudynSettings) -> Model:
    """The model of a scene in the state `start`, which a follower alone does not need."""
    if scene.crank is None:
        return FollowerModel(scene, settings)
    assert start is not None
    state = reconstruct(scene, start)
    if scene.follower.is_rigid:
        return RigidModel(scene, start, state)
    return FlexibleModel(scene, start, state, settings)


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


_LOWEST = 1e-4  # in the scene's unit of time; below it lies the round-off of a motion without stiffness


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, elements: int) -> Array:
    """The `count` lowest frequencies with the crank held, follower straight and at rest, ascending, shape (<= count,).

    The mechanism, and so the frequencies, are in units of the scene's own.
    """
    state = reconstruct(mechanism, Start(crank_angle, 0.0))
    assembly = Assembly(mechanism)
    if mechanism.follower.is_rigid:
        if not assembly.joint_is_compliant:
            return np.empty(0)
        _, follower = assembly.pinned_body("follower", mechanism.pivot_distance, state.follower_angle, 0.0, follower_inertia(mechanism))
        x, stiffness = state.slider_position, mechanism.slider.closed_stiffness
        _add_spring(assembly, state, x, stiffness, assembly.frame_marker(follower, x))
        if mechanism.acting_spring is not None:
            x, stiffness = mechanism.acting_spring.place_on(mechanism.follower.length), stiffness_across(mechanism, crank_angle)
            _add_spring(assembly, state, x, stiffness, assembly.frame_marker(follower, x))
    else:
        cable = cable_of(mechanism.follower, elements)
        nodes = add_nodes(assembly, cable, state)
        bodies = add_cable(assembly, cable, nodes)
        add_ends(assembly, cable, state, nodes)
        springs = [(state.slider_position, mechanism.slider.closed_stiffness)] if assembly.joint_is_compliant else []
        if mechanism.acting_spring is not None:
            springs.append((mechanism.acting_spring.place_on(cable.length), stiffness_across(mechanism, crank_angle)))
        for x, stiffness in springs:
            element = min(int(x / cable.element_length), elements - 1)
            _add_spring(assembly, state, x, stiffness, assembly.frame_marker(bodies[element], x - element * cable.element_length))
        if not assembly.joint_is_compliant:
            _add_support(assembly, cable, state, crank_angle, bodies)
    assembly.mbs.Assemble()
    frequencies = np.asarray(assembly.mbs.ComputeODE2Eigenvalues(convert2Frequencies=True)[0])
    return np.sort(frequencies[np.isfinite(frequencies) & (frequencies > _LOWEST)])[:count]


def _add_support(assembly: Assembly, cable: Cable, state: StartState, crank_angle: float, bodies: list[Any]) -> None:
    """Hold the follower's point at the slider on the ground."""
    mbs, LA, h = assembly.mbs, assembly.mechanism.crank.length, cable.element_length
    held = assembly.point_marker(assembly.ground, LA * math.cos(crank_angle), LA * math.sin(crank_angle))
    markers = [mbs.AddMarker(items.MarkerBodyCable2DCoordinates(bodyNumber=body)) for body in bodies]
    element = min(int(state.slider_position / h), cable.elements - 1)
    history = mbs.AddNode(items.NodeGenericData(initialCoordinates=[element, state.slider_position], numberOfDataCoordinates=2))
    mbs.AddObject(
        items.ObjectJointSliding2D(
            markerNumbers=[held, markers[element]],
            slidingMarkerNumbers=markers,
            slidingMarkerOffsets=[i * h for i in range(cable.elements)],
            nodeNumber=history,
            useClassicalFormulation=False,
        )
    )


def _add_spring(assembly: Assembly, state: StartState, x: float, across: float, point: Any) -> None:
    """Add a spring of a stiffness `across` (N/m) from the ground to a marker at the arc length x, along the follower's normal."""
    place = state.position(np.array([x]))[0]
    ground = assembly.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=assembly.ground, localPosition=[*place, 0.0]))
    c, s = math.cos(state.follower_angle), math.sin(state.follower_angle)
    stiffness = np.zeros((6, 6))
    stiffness[1, 1] = across
    assembly.mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=[ground, point], stiffness=stiffness, rotationMarker0=np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        )
    )
