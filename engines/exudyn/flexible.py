"""The mechanism with a flexible follower: construction in Exudyn and observables from its coordinates."""

from typing import Any, Final

import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from engines.exudyn.assembly import Assembly
from engines.exudyn.cable import Cable, Kink
from engines.exudyn.damping import Dampers
from engines.exudyn.record import Record, accumulated, drive_columns, equation_of, index, shape_columns
from engines.exudyn.settings import ExudynSettings
from engines.exudyn.slider import Gap, add_slider, gap
from engines.start import Start
from engines.start_state import FollowerState, StartState
from reference_model.mechanism import Follower, Mechanism

Array = NDArray[np.float64]

_CLAMPED: Final = [1, 1, 0, 0, 0, 1]  # axes of a generic joint: both places and the rotation in the plane


def cable_of(follower: Follower, elements: int, axial_factor: float = 1.0) -> Cable:
    """The follower as a chain of `elements` cable elements, with `axial_factor` times the section's axial stiffness."""
    axial_stiffness = axial_factor * follower.axial_stiffness
    return Cable(follower.length, elements, follower.mass_per_length, follower.bending_stiffness, axial_stiffness)


def add_nodes(assembly: Assembly, cable: Cable, state: FollowerState) -> list[Any]:
    """Add the cable's nodes in the state `state`; returns their numbers."""
    x = cable.nodes
    place, velocity, angle, rate = state.position(x), state.velocity(x), state.tangent(x), state.tangent_rate(x)
    tangent = np.column_stack([np.cos(angle), np.sin(angle)])
    tangent_rate = rate[:, None] * np.column_stack([-np.sin(angle), np.cos(angle)])
    return [
        assembly.mbs.AddNode(
            items.NodePoint2DSlope1(referenceCoordinates=[*place[i], *tangent[i]], initialVelocities=[*velocity[i], *tangent_rate[i]])
        )
        for i in range(len(x))
    ]


def add_ends(assembly: Assembly, cable: Cable, state: StartState, nodes: list[Any]) -> tuple[Any, Any] | None:
    """Hold the cable at P and add the tip body.

    A base body is built only where it has something to do: an inertia, or dampings that act on its rotation or relative to it.

    Returns:
        Node and object number of the base body, or None.
    """
    mechanism, mbs = assembly.mechanism, assembly.mbs
    d, base = mechanism.pivot_distance, mechanism.base
    base_body = None
    if base.inertia > 0.0 or base.damping > 0.0 or mechanism.follower.damping > 0.0:
        base_body = add_base(assembly, d, state, nodes)
        assembly.rotary_damper(base_body[0], base.damping)
    else:
        markers = [assembly.point_marker(assembly.ground, d), mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[0]))]
        assembly.add_joint("pin of the follower", items.ObjectJointRevolute2D(markerNumbers=markers), 2)
    add_tip(assembly, cable, state, nodes)
    return base_body


def add_base(assembly: Assembly, pivot: float, state: FollowerState, nodes: list[Any]) -> tuple[Any, Any]:
    """A base body at the point (`pivot`, 0) with the cable clamped to it; node and object number."""
    start = np.zeros(1)
    angle, rate = float(state.tangent(start)[0]), float(state.tangent_rate(start)[0])
    body = assembly.pinned_body("base", pivot, angle, rate, assembly.scene.base.inertia)
    markers = [assembly.frame_marker(body[1]), assembly.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))]
    assembly.add_joint("follower clamped to the base", _clamp(markers), 3)
    return body


def add_tip(assembly: Assembly, cable: Cable, state: FollowerState, nodes: list[Any]) -> None:
    """Clamp the tip body to the cable's end; nothing is built where there is none."""
    tip, end = assembly.scene.tip, np.array([cable.length])
    if tip is None:
        return
    c, angle, rate = tip.center_of_mass, float(state.tangent(end)[0]), float(state.tangent_rate(end)[0])
    axis = np.array([np.cos(angle), np.sin(angle)])
    place = state.position(end)[0] + c * axis
    velocity = state.velocity(end)[0] + c * rate * np.array([-axis[1], axis[0]])
    _, body = assembly.rigid_body(place, angle, velocity, rate, tip.mass, tip.inertia)
    assembly.listed_body("tip")
    assembly.weight(body, 0.0, tip.mass)
    markers = [assembly.frame_marker(body, -c), assembly.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[-1]))]
    assembly.add_joint("tip clamped to the follower", _clamp(markers), 3)


def _clamp(markers: list[Any]) -> Any:
    return items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=_CLAMPED)


def add_weight(assembly: Assembly, cable: Cable, nodes: list[Any]) -> None:
    """Consistent nodal forces of the follower's weight.

    Exudyn's mass-proportional load would, on elements that a slider rides on, also push the slider along the follower.
    """
    if not assembly.scene.has_gravity:
        return
    h, last = cable.element_length, len(nodes) - 1
    for i, node in enumerate(nodes):
        on_place = h / 2.0 if i in (0, last) else h
        on_slope = {0: h**2 / 12.0, last: -(h**2) / 12.0}.get(i, 0.0)
        for axis, g in enumerate(assembly.scene.gravity):
            for coordinate, factor in ((axis, on_place), (axis + 2, on_slope)):
                load = cable.mass_per_length * g * factor
                if load != 0.0:
                    assembly.mbs.AddLoad(items.LoadCoordinate(markerNumber=assembly.coordinate_marker(node, coordinate), load=load))


class FlexibleModel:
    """The assembled system with a flexible follower, in the state `state`."""

    def __init__(self, mechanism: Mechanism, start: Start, state: StartState, settings: ExudynSettings) -> None:
        elements = settings.elements
        self.assembly = assembly = Assembly(mechanism)
        self._mechanism = mechanism
        self._cable = cable = cable_of(mechanism.follower, elements, settings.axial_factor)
        self._slider_start = state.slider_position
        crank_node, crank, prescribed = assembly.crank(start)
        nodes = add_nodes(assembly, cable, state)
        axial = assembly.mbs.AddNode(
            items.NodeGenericODE2(
                numberOfODE2Coordinates=1,
                referenceCoordinates=[0.0],
                initialCoordinates=[0.0],
                initialCoordinates_t=[state.slider_speed],
            )
        )
        follower = mechanism.follower
        cables = [
            assembly.mbs.AddObject(
                items.ObjectALEANCFCable2D(
                    length=cable.element_length,
                    massPerLength=follower.mass_per_length,
                    bendingStiffness=follower.bending_stiffness,
                    axialStiffness=cable.axial_stiffness,
                    movingMassFactor=0.0,
                    useCouplingTerms=False,
                    addALEvariation=False,
                    nodeNumbers=[nodes[i], nodes[i + 1], axial],
                )
            )
            for i in range(elements)
        ]
        assembly.listed_body(f"follower: {elements} ANCF cable elements")
        base = add_ends(assembly, cable, state, nodes)
        self._damper_weights = np.zeros(elements + 1)
        self._dampers: Dampers | None = None
        if base is not None and follower.damping > 0.0:
            self._damper_weights = follower.damping * quadrature(cable)
            self._dampers = Dampers(assembly, base, nodes, cable.nodes, self._damper_weights)
        add_weight(assembly, cable, nodes)
        assembly.push_tip(assembly.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1])), crank_node)
        slider = add_slider(assembly, cable, state, start, crank, cables, axial)
        self._joint = slider.joint
        assembly.mbs.Assemble()
        self.drive_equation = equation_of(assembly, prescribed)
        slider.locate(assembly, nodes, axial)
        self._crank_index = index(assembly, crank_node) + 2
        self._node_indices = np.array([index(assembly, node) for node in nodes])
        self._axial_index = index(assembly, axial)
        if self._dampers is not None:
            self._dampers.locate(assembly)

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        """See `engines.exudyn.record.Model`."""
        if self._dampers is not None:
            self._dampers.follow(coordinates, rates, duration)

    def slider_position(self, coordinates: Array) -> float:
        """Arc length of the slider for one row of coordinates, m."""
        return float(coordinates[self._axial_index]) + self._slider_start

    def columns(self, record: Record) -> dict[str, Array]:
        """All columns of a trajectory; `dissipated_energy` and `drive_work` counted from the record's first row."""
        mechanism, cable = self._mechanism, self._cable
        follower, LA = mechanism.follower, mechanism.crank.length
        q, rates, accelerations = (
            values[:, self._node_indices[:, None] + np.arange(4)] for values in (record.coordinates, record.rates, record.accelerations)
        )
        crank_angle = record.coordinates[:, self._crank_index]
        crank_speed = record.rates[:, self._crank_index]
        s = record.coordinates[:, self._axial_index] + self._slider_start

        b1, frame_rate, _ = direction(q[:, 0, 2:], rates[:, 0, 2:], accelerations[:, 0, 2:])
        tip_tangent, _, _ = direction(q[:, -1, 2:], rates[:, -1, 2:], accelerations[:, -1, 2:])
        slider_tangent = cable.evaluate(q, s, 1)
        slider_normal = turned(slider_tangent) / np.linalg.norm(slider_tangent, axis=1)[:, None]
        crank_tip = LA * np.column_stack([np.cos(crank_angle), np.sin(crank_angle)])
        joint = self._gap(record, (q, rates, accelerations), s)
        joint_force = record.multipliers[:, self.assembly.mbs.systemData.GetObjectLTGAE(self._joint)]
        slider_force = -dot(slider_normal, joint_force)
        kink = Kink(s, slider_force[:, None] * slider_normal / follower.bending_stiffness)
        return {
            "time": record.time,
            "crank_angle": crank_angle,
            "crank_speed": crank_speed,
            "follower_angle": np.unwrap(np.arctan2(b1[:, 1], b1[:, 0]) % (2.0 * np.pi)),
            "slider_position": s,
            "tip_x": q[:, -1, 0],
            "tip_y": q[:, -1, 1],
            "tip_deflection": dot(turned(b1), q[:, -1, :2] - q[:, 0, :2]),
            "tip_acceleration": dot(turned(tip_tangent), accelerations[:, -1, :2]),
            **{
                f"strain_{i}": cable.curvature(q, x, kink) * follower.thickness / 2.0 for i, x in enumerate(follower.strain_gauges, start=1)
            },
            "slider_force": slider_force,
            **drive_columns(self.assembly, record, self._crank_index, self.drive_equation, (rates[:, -1, :2], accelerations[:, -1, :2])),
            "kinetic_energy": self._kinetic_energy(crank_speed, frame_rate, q, rates),
            "strain_energy": cable.strain_energy(q) + self._spring_energy(joint),
            "dissipated_energy": self._dissipated(record, q, rates, accelerations, joint),
            "constraint_gap": np.linalg.norm(cable.evaluate(q, s) - crank_tip, axis=1),
            "gravity_energy": self._gravity_energy(crank_angle, q, tip_tangent),
            **shape_columns(cable, q, turned(b1)),
        }

    def _gap(self, record: Record, line: tuple[Array, Array, Array], s: Array) -> Gap:
        angle, speed, acceleration = (v[:, self._crank_index] for v in (record.coordinates, record.rates, record.accelerations))
        arm = self._mechanism.crank.length * np.column_stack([np.cos(angle), np.sin(angle)])
        across = turned(arm)
        crank_tip = (arm, speed[:, None] * across, acceleration[:, None] * across - (speed**2)[:, None] * arm)
        return gap(self._cable, line, (s, record.rates[:, self._axial_index]), crank_tip)

    def _spring_energy(self, joint: Gap) -> Array:
        if not self.assembly.joint_is_compliant:
            return np.zeros_like(joint.value)
        return 0.5 * self._mechanism.slider.joint_stiffness * joint.value**2

    def _kinetic_energy(self, crank_speed: Array, frame_rate: Array, q: Array, rates: Array) -> Array:
        tip = self._mechanism.tip
        energy = 0.5 * (self._mechanism.crank_inertia * crank_speed**2 + self._mechanism.base.inertia * frame_rate**2)
        energy += self._cable.kinetic_energy(rates)
        if tip is not None:
            tangent, rate, _ = direction(q[:, -1, 2:], rates[:, -1, 2:], np.zeros_like(rates[:, -1, 2:]))
            velocity = rates[:, -1, :2] + tip.center_of_mass * rate[:, None] * turned(tangent)
            energy += 0.5 * (tip.mass * np.sum(velocity**2, axis=1) + tip.inertia * rate**2)
        return energy

    def _gravity_energy(self, crank_angle: Array, q: Array, tip_tangent: Array) -> Array:
        tip = self._mechanism.tip
        crank_arm = np.column_stack([np.cos(crank_angle), np.sin(crank_angle)])
        moment = self._mechanism.crank_moment * crank_arm + self._cable.first_moment(q)
        if tip is not None:
            moment = moment + tip.mass * (q[:, -1, :2] + tip.center_of_mass * tip_tangent)
        return -moment @ np.array(self._mechanism.gravity)

    def _dissipated(self, record: Record, q: Array, rates: Array, accelerations: Array, joint: Gap) -> Array:
        """Work taken by the dampers of crank, base, follower and slider."""
        crank_damping = getattr(self._mechanism.crank.drive, "damping", 0.0)
        speed, acceleration = record.rates[:, self._crank_index], record.accelerations[:, self._crank_index]
        _, frame_rate, frame_acceleration = direction(q[:, 0, 2:], rates[:, 0, 2:], accelerations[:, 0, 2:])
        power = crank_damping * speed**2 + self._mechanism.base.damping * frame_rate**2
        power_rate = 2.0 * (crank_damping * speed * acceleration + self._mechanism.base.damping * frame_rate * frame_acceleration)
        radius = q[:, :, :2] - np.array([self._mechanism.pivot_distance, 0.0])
        across, across_rate = turned(radius), turned(rates[:, :, :2])
        relative = rates[:, :, :2] - frame_rate[:, None, None] * across
        relative_rate = accelerations[:, :, :2] - frame_acceleration[:, None, None] * across - frame_rate[:, None, None] * across_rate
        power = power + np.sum(relative**2, axis=2) @ self._damper_weights
        power_rate = power_rate + 2.0 * np.sum(relative * relative_rate, axis=2) @ self._damper_weights
        power = power + self._mechanism.slider.joint_damping * joint.rate**2
        power_rate = power_rate + 2.0 * self._mechanism.slider.joint_damping * joint.rate * joint.acceleration
        return accumulated(record.time, power, power_rate)


def quadrature(cable: Cable) -> Array:
    """Weights of the nodes in ∫ dx along the cable, m: the trapezoidal rule with Gregory's end correction, fourth order."""
    weights = np.full(cable.elements + 1, cable.element_length)
    for i, factor in enumerate((3.0 / 8.0, 7.0 / 6.0, 23.0 / 24.0)):
        weights[[i, -1 - i]] = factor * cable.element_length
    return weights


def direction(slope: Array, slope_rate: Array, slope_acceleration: Array) -> tuple[Array, Array, Array]:
    """Unit vector along `slope` (rows, 2), its angular rate and angular acceleration (rows,)."""
    squared = np.sum(slope**2, axis=1)
    rate = dot(turned(slope), slope_rate) / squared
    acceleration = dot(turned(slope), slope_acceleration) / squared - 2.0 * rate * dot(slope, slope_rate) / squared
    return slope / np.sqrt(squared)[:, None], rate, acceleration


def turned(a: Array) -> Array:
    """Quarter turn, counter-clockwise."""
    return np.stack([-a[..., 1], a[..., 0]], axis=-1)


def dot(a: Array, b: Array) -> Array:
    """Scalar products along the last axis."""
    return np.sum(a * b, axis=-1)
