"""The mechanism with a rigid follower: base, beam and tip are one body, on whose axis the crank tip slides."""

import math
from typing import Any

import numpy as np

from quickreturn.engines.exudyn.assembly import CARRIAGE, CARRIAGE_MASS, Assembly
from quickreturn.engines.exudyn.library import exu, items
from quickreturn.engines.exudyn.record import (
    Hold,
    Model,
    Record,
    TipMotion,
    accumulated,
    bearing_columns,
    crank_bearing_columns,
    drive_columns,
    equation_of,
    index,
    pin_force,
    slide_loss,
    swing,
)
from quickreturn.engines.exudyn.slider import JointLaw
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import StartState
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import SHAPE
from quickreturn.reference_model.mechanism import Mechanism


def follower_inertia(mechanism: Mechanism) -> float:
    """Moment of inertia about P of base, rigid beam and tip, kg m^2."""
    follower, tip = mechanism.follower, mechanism.tip_body
    beam = follower.mass_per_length * follower.length**3 / 3.0
    return mechanism.base.inertia + beam + (tip.inertia + tip.mass * (follower.length + tip.center_of_mass) ** 2)


class RigidModel(Model):
    """The assembled system with a rigid follower, in the state `state`."""

    def __init__(self, mechanism: Mechanism, start: Start, state: StartState) -> None:
        self.assembly = assembly = Assembly(mechanism)
        self._mechanism = mechanism
        self._law = JointLaw(mechanism.slider)
        follower, tip = mechanism.follower, mechanism.tip
        beam = follower.mass_per_length * follower.length
        reach = follower.length + mechanism.tip_body.center_of_mass
        self._mass = beam + mechanism.tip_body.mass
        self._moment = beam * follower.length / 2.0 + mechanism.tip_body.mass * reach  # kg m, first moment of mass about P
        self._inertia = follower_inertia(mechanism)

        crank_node, crank, prescribed = assembly.crank(start)
        name = "follower: rigid, with the base" + ("" if tip is None else " and the tip")
        node, body = assembly.pinned_body(name, mechanism.pivot_distance, state.follower_angle, state.follower_rate, self._inertia)
        assembly.rotary_damper(node, mechanism.base.damping)
        assembly.weight(body, follower.length / 2.0, beam)
        if tip is not None:
            assembly.weight(body, reach, tip.mass)
            assembly.push_tip((assembly.frame_marker if tip.follows else assembly.point_marker)(body, follower.length), crank_node)
        if mechanism.acting_spring is not None:
            assembly.hold(assembly.point_marker(body, mechanism.acting_spring.place_on(follower.length)))
        self._joint = self._add_slider(start, state, crank, body)
        assembly.mbs.Assemble()
        self._reference = assembly.mbs.systemData.GetODE2Coordinates(configuration=exu.ConfigurationType.Reference)
        self.drive_equation = equation_of(assembly, prescribed)
        self._crank_index = index(assembly, crank_node) + 2
        self._follower_index = index(assembly, node) + 2

    def _add_slider(self, start: Start, state: StartState, crank: Any, follower: Any) -> Any:
        """Add the joint that keeps the crank tip, or a compliant joint's carriage, on the follower's axis; returns its object number.

        The carriage turns with the follower, so that the joint's force lies along the follower's normal. It is free along the axis, where
        a spring without force holds it at the foot of the crank tip.
        """
        assembly, slider = self.assembly, self._mechanism.slider
        crank_tip, axis = assembly.frame_marker(crank, self._mechanism.crank.length), assembly.frame_marker(follower)
        rider, equations = crank_tip, 1  # the joint's second equation, for the rotation, is switched off
        if assembly.joint_is_compliant:
            place = state.position(np.array([state.slider_position]))[0]
            velocity = start.crank_speed * np.array([-place[1], place[0]])
            node, _ = assembly.rigid_body(list(place), state.follower_angle, list(velocity), state.follower_rate, CARRIAGE_MASS, 0.0)
            assembly.listed_body(CARRIAGE)
            rider = assembly.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
            equations = 3  # normal and rotation, and the balance along the axis, which leaves the carriage no motion of its own
            law = self._law
            stiffness, damping = np.zeros((6, 6)), np.zeros((6, 6))
            stiffness[0, 0] = stiffness[1, 1] = law.along
            damping[1, 1] = slider.joint_damping
            connector = items.ObjectConnectorRigidBodySpringDamper(markerNumbers=[rider, crank_tip], stiffness=stiffness, damping=damping)
            if not slider.is_linear:
                connector.springForceTorqueUserFunction = lambda mbs, time, item, displacement, rotation, velocity, *parameters: [
                    law.along * displacement[0], law.force(displacement[1], velocity[1]), *[0.0] * 4
                ]  # fmt: skip
            assembly.mbs.AddObject(connector)
        joint = items.ObjectJointPrismatic2D(
            markerNumbers=[rider, axis],
            axisMarker0=[1.0, 0.0, 0.0],
            normalMarker1=[0.0, 1.0, 0.0],
            constrainRotation=assembly.joint_is_compliant,
        )
        return assembly.add_joint(f"slider on the follower{assembly.joint_text}", joint, equations)

    def joint_loss(self) -> float:
        data, tip = self.assembly.mbs.systemData, self._mechanism.tip_body
        rubs = tip.friction_force > 0.0
        if not (self.assembly.joint_is_compliant or rubs):
            return 0.0
        coordinates, rates = self._reference + data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
        loss = slide_loss(tip, np.array([0.0, self._mechanism.follower.length * rates[self._follower_index]])) if rubs else 0.0
        if not self.assembly.joint_is_compliant:
            return loss
        (place, gap), turning = self._slider_in_frame(coordinates[None])[0], rates[self._follower_index]
        angle = coordinates[self._crank_index] - coordinates[self._follower_index]
        rate = self._mechanism.crank.length * math.cos(angle) * rates[self._crank_index] - place * turning
        return loss + self._law.loss(float(gap), float(rate))

    def slider_position(self, coordinates: Array) -> float:
        return float(self._slider_in_frame(coordinates[None])[0, 0])

    def columns(self, record: Record) -> dict[str, Array]:
        mechanism = self._mechanism
        d, length = mechanism.pivot_distance, mechanism.follower.length
        q1, q2 = record.coordinates[:, self._crank_index], record.coordinates[:, self._follower_index]
        q1_rate, q2_rate = record.rates[:, self._crank_index], record.rates[:, self._follower_index]
        q1_acceleration, q2_acceleration = (record.accelerations[:, i] for i in (self._crank_index, self._follower_index))
        place, gap = self._slider_in_frame(record.coordinates).T
        along, across = np.column_stack([np.cos(q2), np.sin(q2)]), np.column_stack([-np.sin(q2), np.cos(q2)])
        tip_velocity = length * q2_rate[:, None] * across
        tip_acceleration = length * (q2_acceleration[:, None] * across - (q2_rate**2)[:, None] * along)
        tip_motion, straight = TipMotion(tip_velocity, tip_acceleration, q2, q2_rate), np.zeros_like(q1)
        hung = 1.0 if mechanism.acting_spring is None else mechanism.acting_spring.place_on(length) / length
        from_origin = hung * length * along + np.array([d, 0.0])
        hold = Hold.of(mechanism.acting_spring, (from_origin, hung * tip_velocity, hung * tip_acceleration))
        c_crank, c_base = mechanism.crank.drive.damping, mechanism.base.damping
        power = c_crank * q1_rate**2 + c_base * q2_rate**2
        half_change = c_crank * q1_rate * q1_acceleration + c_base * q2_rate * q2_acceleration
        gx, gy = mechanism.gravity
        equation = self.assembly.mbs.systemData.GetObjectLTGAE(self._joint)[0]
        return {
            "time": record.time,
            "crank_angle": q1,
            "crank_speed": q1_rate,
            "follower_angle": q2,
            "follower_rate": q2_rate,
            "follower_acceleration": q2_acceleration,
            "slider_position": place,
            "tip_x": d + length * along[:, 0],
            "tip_y": length * along[:, 1],
            "tip_acceleration": length * q2_acceleration,
            "slider_force": -record.multipliers[:, equation],
            **bearing_columns("pivot", pin_force(self.assembly, record, "follower") + swing(self._moment, q2, q2_rate, q2_acceleration)),
            **crank_bearing_columns(self.assembly, record, self._crank_index),
            **drive_columns(self.assembly, record, self._crank_index, self.drive_equation, tip_motion),
            "kinetic_energy": 0.5 * (mechanism.crank_inertia * q1_rate**2 + self._inertia * q2_rate**2),
            "strain_energy": (self._law.energy(gap) if self.assembly.joint_is_compliant else straight) + hold.energy,
            "dissipated_energy": accumulated(record.time, power + hold.power, 2.0 * half_change + hold.power_rate)
            + record.lost
            - record.lost[0],
            **hold.columns,
            "constraint_gap": np.abs(gap),
            "gravity_energy": -mechanism.crank_moment * (gx * np.cos(q1) + gy * np.sin(q1))
            - self._moment * (gx * along[:, 0] + gy * along[:, 1])
            - self._mass * gx * d,
            **dict.fromkeys(("tip_deflection", "strain_1", "strain_2", "strain_3", *SHAPE), straight),
        }

    def _slider_in_frame(self, coordinates: Array) -> Array:
        """The crank tip in frame B, along and across the follower, shape (rows, 2)."""
        q1, q2 = coordinates[:, self._crank_index], coordinates[:, self._follower_index]
        LA, d = self._mechanism.crank.length, self._mechanism.pivot_distance
        return np.column_stack([LA * np.cos(q1 - q2) - d * np.cos(q2), LA * np.sin(q1 - q2) + d * np.sin(q2)])
