"""The mechanism with a flexible follower: construction in Exudyn and observables from its coordinates."""

from typing import Any, Final

import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from engines.exudyn.assembly import Assembly
from engines.exudyn.cable import Cable
from engines.exudyn.damping import Dampers
from engines.exudyn.record import Record, accumulated, drive_columns, index
from engines.exudyn.slider import Gap, add_slider, gap
from engines.start import Start
from engines.start_state import StartState
from reference_model.mechanism import Follower, Mechanism

Array = NDArray[np.float64]

_CLAMPED: Final = [1, 1, 0, 0, 0, 1]  # axes of a generic joint: both places and the rotation in the plane


def cable_of(follower: Follower, elements: int) -> Cable:
    """The follower as a chain of `elements` cable elements."""
    return Cable(follower.length, elements, follower.mass_per_length, follower.bending_stiffness, follower.axial_stiffness)


def add_nodes(assembly: Assembly, cable: Cable, state: StartState) -> list[Any]:
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
    d, base, tip = mechanism.pivot_distance, mechanism.base, mechanism.tip
    ends = np.array([0.0, cable.length])
    angle, rate = state.tangent(ends), state.tangent_rate(ends)
    base_body = None
    if base.inertia > 0.0 or base.damping > 0.0 or mechanism.follower.damping > 0.0:
        base_body = assembly.pinned_body("base", d, angle[0], rate[0], base.inertia)
        assembly.rotary_damper(base_body[0], base.damping)
        markers = [assembly.frame_marker(base_body[1]), mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))]
        assembly.add_joint("follower clamped to the base", _clamp(markers), 3)
    else:
        markers = [assembly.point_marker(assembly.ground, d), mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[0]))]
        assembly.add_joint("pin of the follower", items.ObjectJointRevolute2D(markerNumbers=markers), 2)
    if tip is not None:
        c = tip.center_of_mass
        direction = np.array([np.cos(angle[1]), np.sin(angle[1])])
        place = state.position(ends)[1] + c * direction
        velocity = state.velocity(ends)[1] + c * rate[1] * np.array([-direction[1], direction[0]])
        _, body = assembly.rigid_body(place, angle[1], velocity, rate[1], tip.mass, tip.inertia)
        assembly.listed_body("tip")
        assembly.weight(body, 0.0, tip.mass)
        markers = [assembly.frame_marker(body, -c), mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[-1]))]
        assembly.add_joint("tip clamped to the follower", _clamp(markers), 3)
    return base_body


def _clamp(markers: list[Any]) -> Any:
    return items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=_CLAMPED)


class FlexibleModel:
    """The assembled system with a flexible follower, in the state `state`."""

    def __init__(self, mechanism: Mechanism, start: Start, state: StartState, elements: int) -> None:
        self.assembly = assembly = Assembly(mechanism)
        self._mechanism = mechanism
        self._cable = cable = cable_of(mechanism.follower, elements)
        self._slider_start = state.slider_position
        crank_node, crank, self._speed_constraint = assembly.crank(start)
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
                    axialStiffness=follower.axial_stiffness,
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
            self._damper_weights = follower.damping * _quadrature(cable)
            self._dampers = Dampers(assembly, base, nodes, cable.nodes, self._damper_weights)
        self._add_weight(nodes)
        slider = add_slider(assembly, cable, state, start, crank, cables, axial)
        self._joint = slider.joint
        assembly.mbs.Assemble()
        slider.locate(assembly, nodes, axial)
        self._crank_index = index(assembly, crank_node) + 2
        self._node_indices = np.array([index(assembly, node) for node in nodes])
        self._axial_index = index(assembly, axial)
        if self._dampers is not None:
            self._dampers.locate(assembly)

    def _add_weight(self, nodes: list[Any]) -> None:
        """Consistent nodal forces of the follower's weight.

        Exudyn's mass-proportional load would, on these elements, also push the slider along the follower.
        """
        if not self._mechanism.has_gravity:
            return
        h, last = self._cable.element_length, len(nodes) - 1
        for i, node in enumerate(nodes):
            on_place = h / 2.0 if i in (0, last) else h
            on_slope = {0: h**2 / 12.0, last: -(h**2) / 12.0}.get(i, 0.0)
            for axis, g in enumerate(self._mechanism.gravity):
                for coordinate, factor in ((axis, on_place), (axis + 2, on_slope)):
                    load = self._cable.mass_per_length * g * factor
                    if load != 0.0:
                        marker = self.assembly.coordinate_marker(node, coordinate)
                        self.assembly.mbs.AddLoad(items.LoadCoordinate(markerNumber=marker, load=load))

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

        b1, frame_rate, _ = _direction(q[:, 0, 2:], rates[:, 0, 2:], accelerations[:, 0, 2:])
        tip_tangent, _, _ = _direction(q[:, -1, 2:], rates[:, -1, 2:], accelerations[:, -1, 2:])
        slider_tangent = cable.evaluate(q, s, 1)
        slider_normal = _turned(slider_tangent) / np.linalg.norm(slider_tangent, axis=1)[:, None]
        crank_tip = LA * np.column_stack([np.cos(crank_angle), np.sin(crank_angle)])
        joint = self._gap(record, (q, rates, accelerations), s)
        joint_force = record.multipliers[:, self.assembly.mbs.systemData.GetObjectLTGAE(self._joint)]
        return {
            "time": record.time,
            "crank_angle": crank_angle,
            "crank_speed": crank_speed,
            "follower_angle": np.unwrap(np.arctan2(b1[:, 1], b1[:, 0]) % (2.0 * np.pi)),
            "slider_position": s,
            "tip_x": q[:, -1, 0],
            "tip_y": q[:, -1, 1],
            "tip_deflection": _dot(_turned(b1), q[:, -1, :2] - q[:, 0, :2]),
            "tip_acceleration": _dot(_turned(tip_tangent), accelerations[:, -1, :2]),
            **{f"strain_{i}": cable.curvature(q, x) * follower.thickness / 2.0 for i, x in enumerate(follower.strain_gauges, start=1)},
            "slider_force": -_dot(slider_normal, joint_force),
            **drive_columns(self.assembly, record, self._crank_index, self._speed_constraint),
            "kinetic_energy": self._kinetic_energy(crank_speed, frame_rate, q, rates),
            "strain_energy": cable.strain_energy(q) + self._spring_energy(joint),
            "dissipated_energy": self._dissipated(record, q, rates, accelerations, joint),
            "constraint_gap": np.linalg.norm(cable.evaluate(q, s) - crank_tip, axis=1),
            "gravity_energy": self._gravity_energy(crank_angle, q, tip_tangent),
        }

    def _gap(self, record: Record, line: tuple[Array, Array, Array], s: Array) -> Gap:
        angle, speed, acceleration = (v[:, self._crank_index] for v in (record.coordinates, record.rates, record.accelerations))
        arm = self._mechanism.crank.length * np.column_stack([np.cos(angle), np.sin(angle)])
        across = _turned(arm)
        crank_tip = (arm, speed[:, None] * across, acceleration[:, None] * across - (speed**2)[:, None] * arm)
        return gap(self._cable, line, (s, record.rates[:, self._axial_index]), crank_tip)

    def _spring_energy(self, joint: Gap) -> Array:
        if not self.assembly.joint_is_compliant:
            return np.zeros_like(joint.value)
        return 0.5 * self._mechanism.slider.joint_stiffness * joint.value**2

    def _kinetic_energy(self, crank_speed: Array, frame_rate: Array, q: Array, rates: Array) -> Array:
        crank, slider, tip = self._mechanism.crank, self._mechanism.slider, self._mechanism.tip
        crank_inertia = crank.inertia_about_pivot + slider.mass * crank.length**2
        energy = 0.5 * (crank_inertia * crank_speed**2 + self._mechanism.base.inertia * frame_rate**2)
        energy += self._cable.kinetic_energy(rates)
        if tip is not None:
            tangent, rate, _ = _direction(q[:, -1, 2:], rates[:, -1, 2:], np.zeros_like(rates[:, -1, 2:]))
            velocity = rates[:, -1, :2] + tip.center_of_mass * rate[:, None] * _turned(tangent)
            energy += 0.5 * (tip.mass * np.sum(velocity**2, axis=1) + tip.inertia * rate**2)
        return energy

    def _gravity_energy(self, crank_angle: Array, q: Array, tip_tangent: Array) -> Array:
        crank, slider, tip = self._mechanism.crank, self._mechanism.slider, self._mechanism.tip
        direction = np.column_stack([np.cos(crank_angle), np.sin(crank_angle)])
        moment = (crank.mass * crank.center_of_mass + slider.mass * crank.length) * direction + self._cable.first_moment(q)
        if tip is not None:
            moment = moment + tip.mass * (q[:, -1, :2] + tip.center_of_mass * tip_tangent)
        return -moment @ np.array(self._mechanism.gravity)

    def _dissipated(self, record: Record, q: Array, rates: Array, accelerations: Array, joint: Gap) -> Array:
        """Work taken by the dampers of crank, base, follower and slider."""
        crank_damping = getattr(self._mechanism.crank.drive, "damping", 0.0)
        speed, acceleration = record.rates[:, self._crank_index], record.accelerations[:, self._crank_index]
        _, frame_rate, frame_acceleration = _direction(q[:, 0, 2:], rates[:, 0, 2:], accelerations[:, 0, 2:])
        power = crank_damping * speed**2 + self._mechanism.base.damping * frame_rate**2
        power_rate = 2.0 * (crank_damping * speed * acceleration + self._mechanism.base.damping * frame_rate * frame_acceleration)
        radius = q[:, :, :2] - np.array([self._mechanism.pivot_distance, 0.0])
        turned, turned_rate = _turned(radius), _turned(rates[:, :, :2])
        relative = rates[:, :, :2] - frame_rate[:, None, None] * turned
        relative_rate = accelerations[:, :, :2] - frame_acceleration[:, None, None] * turned - frame_rate[:, None, None] * turned_rate
        power = power + np.sum(relative**2, axis=2) @ self._damper_weights
        power_rate = power_rate + 2.0 * np.sum(relative * relative_rate, axis=2) @ self._damper_weights
        power = power + self._mechanism.slider.joint_damping * joint.rate**2
        power_rate = power_rate + 2.0 * self._mechanism.slider.joint_damping * joint.rate * joint.acceleration
        return accumulated(record.time, power, power_rate)


def _quadrature(cable: Cable) -> Array:
    """Weights of the nodes in ∫ dx along the cable, m: the trapezoidal rule with Gregory's end correction, fourth order."""
    weights = np.full(cable.elements + 1, cable.element_length)
    for i, factor in enumerate((3.0 / 8.0, 7.0 / 6.0, 23.0 / 24.0)):
        weights[[i, -1 - i]] = factor * cable.element_length
    return weights


def _direction(slope: Array, slope_rate: Array, slope_acceleration: Array) -> tuple[Array, Array, Array]:
    """Unit vector along `slope` (rows, 2), its angular rate and angular acceleration (rows,)."""
    squared = np.sum(slope**2, axis=1)
    rate = _dot(_turned(slope), slope_rate) / squared
    acceleration = _dot(_turned(slope), slope_acceleration) / squared - 2.0 * rate * _dot(slope, slope_rate) / squared
    return slope / np.sqrt(squared)[:, None], rate, acceleration


def _turned(a: Array) -> Array:
    """Quarter turn, counter-clockwise."""
    return np.stack([-a[..., 1], a[..., 0]], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)
