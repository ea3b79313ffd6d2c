"""The mechanism with a flexible follower in Exudyn, and observables from its coordinates."""

from typing import Any, Final

import numpy as np

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.cable import Kink, direction, dot, turned
from quickreturn.engines.exudyn.construction import Dampers, add_cable, add_ends, add_nodes, add_weight, cable_of, marker_at
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.record import (
    Hold,
    Kinematics,
    Model,
    Record,
    TipMotion,
    accumulated,
    bearing_columns,
    crank_bearing_columns,
    drive_columns,
    equation_of,
    force_on_tip,
    index,
    pin_force,
    shape_columns,
    slide_loss,
)
from quickreturn.engines.exudyn.settings import SLIDING, ExudynSettings
from quickreturn.engines.exudyn.slider import JointLaw, add_slider
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import StartState
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import MOMENTS, PLACES
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import follower_angle

#: Number of elements from which on every other node has a damper, the fewest for the quadrature, which is of fourth order.
FEWEST_FOR_HALF_THE_DAMPERS: Final = 12

_SHORT: Final = 1e-5  # in the scene's unit of time: a rate of change by differences, to eight digits


class CableModel(Model):
    """What systems with a flexible follower share: nodes, dampers, and the observables of the follower itself.

    These take the line, nodal coordinates with rates and accelerations, each of shape (rows, nodes, 4); and the frame, the base's tangent,
    (rows, 2), with its angular rate and acceleration, each (rows,).
    """

    def __init__(self, scene: Scene, settings: ExudynSettings) -> None:
        self.assembly = Assembly(scene)
        self._cable = cable_of(scene.follower, settings.elements, settings.axial_factor)
        self._nodes: list[Any] = []
        self._damper_weights = np.zeros(settings.elements + 1)
        self._dampers: Dampers | None = None

    def _load(self, base: tuple[Any, Any] | None) -> None:
        """Add the follower's damping relative to the base body, and its weight."""
        follower = self.assembly.scene.follower
        if base is not None and follower.damping > 0.0:
            some = slice(None, None, 2 if self._cable.elements % 2 == 0 and self._cable.elements >= FEWEST_FOR_HALF_THE_DAMPERS else 1)
            self._damper_weights[some] = follower.damping * self._cable.quadrature(some.step)
            self._dampers = Dampers(self.assembly, base, self._nodes[some], self._cable.nodes[some], self._damper_weights[some])
        add_weight(self.assembly, self._cable, self._nodes)

    def _locate(self) -> None:
        """Find the coordinates; once, after the system is assembled."""
        self._node_indices = np.array([index(self.assembly, node) for node in self._nodes])
        if self._dampers is not None:
            self._dampers.locate(self.assembly)

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        if self._dampers is not None:
            self._dampers.follow(coordinates, rates, duration)

    def _line(self, record: Record) -> Kinematics:
        places = self._node_indices[:, None] + np.arange(4)
        return record.coordinates[:, places], record.rates[:, places], record.accelerations[:, places]

    def _follower_columns(
        self,
        record: Record,
        line: Kinematics,
        frame: Kinematics,
        kinks: tuple[Kink, ...] = (),
        forces: tuple[Array | float, Array | float, Array | float] = (0.0, 0.0, 0.0),
        held: Array | float = 0.0,
    ) -> dict[str, Array]:
        """Place, bend and acceleration of the follower, and the force that holds its base.

        Args:
            record: states of the system.
            line: see the class.
            frame: see the class.
            kinks: at the slider, and at a spring.
            forces: of slider, tool and spring on the follower, N, shape (rows, 2) each.
            held: torque (N m) that turns the base as prescribed, shape (rows,).
        """
        cable, follower, (q, rates, accelerations) = self._cable, self.assembly.scene.follower, line
        across, (tip_tangent, _, _) = turned(frame[0]), direction(*(values[:, -1, 2:] for values in line))
        twelfths, last = cable.length * np.arange(1, PLACES + 1) / (PLACES + 1), cable.nodes[-3:-1]
        places = np.repeat(np.r_[last, follower.strain_gauges, twelfths][:, None], len(q), axis=1)
        if kinks:
            places = np.vstack([places, kinks[0].place])
        loaded, damped = cable.curvatures(q, places, *kinks), np.zeros(places.shape)
        if follower.material_damping > 0.0:  # turned and stretched alike a line keeps this curvature: what is left is that of the rates
            bent, loaded = loaded, cable.curvatures(q + follower.material_damping * rates, places, *kinks)
            damped = loaded - bent
        outboard, h = cable.length - places, cable.element_length
        by_loads = self._moments_near_tip(line, frame, places, kinks, forces[1]) / cable.bending_stiffness
        loaded = np.where(outboard < h, by_loads, loaded)
        if self.assembly.scene.tip is None:  # at a free end curvatures and their rates vanish with their slope
            inner, outer = damped[:2] / outboard[:2] ** 2
            damped = np.where(outboard < h, outboard**2 * (outer + (outer - inner) * (h - outboard) / h), damped)
        first = len(last) + len(follower.strain_gauges)
        strains, moments = (loaded - damped)[len(last) : first], loaded[first:]
        return {
            "follower_rate": frame[1],
            "follower_acceleration": frame[2],
            "tip_x": q[:, -1, 0],
            "tip_y": q[:, -1, 1],
            "tip_deflection": dot(across, q[:, -1, :2] - q[:, 0, :2]),
            "tip_acceleration": dot(turned(tip_tangent), accelerations[:, -1, :2]),
            **{f"strain_{i}": follower.extreme_fibre * strain for i, strain in enumerate(strains, start=1)},
            **shape_columns(cable, q, across),
            **{name: cable.bending_stiffness * moment for name, moment in zip((*MOMENTS, "moment_slider"), moments, strict=False)},
            **({"moment_inboard": cable.bending_stiffness * moments[-1]} if kinks else {}),  # no moment acts at the slider
            "moment_base": self._moment_at_base(line, frame, held),
            "moment_tip": self._moment_at_tip(line),
            **self._axial_columns(line, frame, kinks, *forces),
            **bearing_columns("pivot", self._pivot_force(record, line, frame, forces[0] + forces[1] + forces[2])),
        }

    def _moment_at_base(self, line: Kinematics, frame: Kinematics, held: Array | float) -> Array:
        """Bending moment at the base, N m, (rows,), by Euler's law for the base body, to which the follower's damping is a reaction."""
        base, (_, turn, turn_rate) = self.assembly.scene.base, frame
        radius, relative = self._relative(line, frame)
        damped = dot(turned(radius), relative) @ self._damper_weights
        return np.asarray(base.inertia * turn_rate + base.damping * turn - held - damped)

    def _moment_at_tip(self, line: Kinematics) -> Array:
        """Bending moment at the flexible end, N m, (rows,), by Newton's and Euler's laws for the tip body clamped there."""
        tip, gravity = self.assembly.scene.tip_body, np.array(self.assembly.scene.gravity)
        along, _, turning = direction(*(values[:, -1, 2:] for values in line))
        across = dot(turned(along), line[2][:, -1, :2] - gravity) + tip.center_of_mass * turning
        return np.asarray(-tip.inertia * turning - tip.mass * tip.center_of_mass * across)

    def _moments_near_tip(self, line: Kinematics, frame: Kinematics, places: Array, kinks: tuple[Kink, ...], tool: Array | float) -> Array:
        """Bending moments at places in the last element, by the loads outboard of them, N m; both of shape (places, rows).

        Near an end that carries little the second derivative of the elements is nothing but error. The load along the arm is the parabola
        through the last three nodes. `tool`: force on the flexible end, N.
        """
        cable, scene, tip, gravity = self._cable, self.assembly.scene, self.assembly.scene.tip_body, np.array(self.assembly.scene.gravity)
        tangent, _, turning = direction(*(values[:, -1, 2:] for values in line))
        across = turned(tangent)
        nodes = cable.mass_per_length * (gravity - line[2][:, -3:, :2]) - scene.follower.damping * self._relative(line, frame)[1][:, -3:]
        second, first, last = (dot(across, nodes[:, k]) for k in range(3))
        accelerated = dot(across, line[2][:, -1, :2] - gravity) + tip.center_of_mass * turning
        force = dot(across, tool * np.ones_like(across)) - tip.mass * accelerated
        d, h = cable.length - places, cable.element_length
        slope, bend = (4.0 * first - 3.0 * last - second) / (2.0 * h), (last - 2.0 * first + second) / (2.0 * h**2)
        moments = self._moment_at_tip(line) + d * force + d**2 * (last / 2.0 + slope * d / 6.0 + bend * d**2 / 12.0)
        for kink in kinks:
            moments += cable.bending_stiffness * np.maximum(0.0, kink.place - places) * dot(across, kink.jump)
        return np.asarray(moments)

    def _axial_columns(
        self,
        line: Kinematics,
        frame: Kinematics,
        kinks: tuple[Kink, ...],
        slider: Array | float,
        tool: Array | float,
        spring: Array | float,
    ) -> dict[str, Array]:
        """The columns of normal forces, N, (rows,): loads outboard along the tangent, by the tangents alone like `_momentum_rate`."""
        scene, cable, tip, gravity = self.assembly.scene, self._cable, self.assembly.scene.tip_body, np.array(self.assembly.scene.gravity)
        turning, h, rows = self._turning(line), cable.element_length, np.arange(len(line[0]))
        to_nodes = cable.to_nodes
        swing = to_nodes @ turning
        load = cable.mass_per_length * (gravity - swing) - scene.follower.damping * self._relative(line, frame)[1]
        inboard = to_nodes @ load
        hung = kinks[1].place if len(kinks) > 1 else np.zeros(len(rows))
        end = tool - tip.mass * (swing[:, -1] + tip.center_of_mass * turning[:, -1] - gravity)
        end = end + np.where(hung[:, None] < cable.length, 0.0, spring)
        (at_tip, _, _), whole = direction(*(values[:, -1, 2:] for values in line)), inboard[:, -1] + end
        spring = np.where(hung[:, None] < cable.length, spring, 0.0)  # at the end it is outboard of everything
        columns = {"axial_base": dot(frame[0], whole + slider + spring), "axial_tip": dot(at_tip, end)}
        for kink in kinks[:1]:
            k = np.clip((kink.place / h).astype(int), 0, cable.elements - 1)
            u = (kink.place - k * h)[:, None]
            passed = inboard[rows, k] + u * load[rows, k] + u**2 / (2.0 * h) * (load[rows, k + 1] - load[rows, k])
            slope = cable.evaluate(line[0], kink.place, 1)
            along = slope / np.linalg.norm(slope, axis=1)[:, None]
            columns["axial_slider"] = dot(along, whole - passed + np.where((kink.place < hung)[:, None], spring, 0.0))
            columns["axial_inboard"] = columns["axial_slider"] + dot(along, slider * np.ones_like(along))
        return columns

    def _relative(self, line: Kinematics, frame: Kinematics) -> tuple[Array, Array]:
        """Places of the nodes from P (m) and their velocities relative to the base (m/s), shape (rows, nodes, 2) each."""
        radius = line[0][:, :, :2] - np.array([self.assembly.scene.pivot_distance, 0.0])
        return radius, line[1][:, :, :2] - frame[1][:, None, None] * turned(radius)

    def _pivot_force(self, record: Record, line: Kinematics, frame: Kinematics, pushed: Array | float) -> Array:
        """Force of the ground on the base, N, shape (rows, 2): across the follower the pin's multipliers, along it Newton's law.

        From its unstretched start the cable rings along its axis, in run 24 at 2 kHz and with 0.9 N at the pivot, until the integrator's
        damping has ended it. The multipliers contain that; the follower of other engines does not stretch.
        """
        along, across = frame[0], turned(frame[0])
        held = pin_force(self.assembly, record, "base" if "base" in self.assembly.pins else "follower")
        return dot(across, held)[:, None] * across + dot(along, self._momentum_rate(line) - pushed)[:, None] * along

    def _momentum_rate(self, line: Kinematics) -> Array:
        """Rate of the momentum of cable and tip body, less their weight, N, shape (rows, 2), by the tangents alone, without the stretch.

        With r(x) = ∫ e dξ, e the unit tangent, ∫ ρA r dx = ∫ ρA (L - ξ) e dξ.
        """
        scene, cable, tip = self.assembly.scene, self._cable, self.assembly.scene.tip_body
        weights = cable.quadrature() * (cable.mass_per_length * (cable.length - cable.nodes) + tip.mass)
        weights[-1] += tip.mass * tip.center_of_mass
        weight = (cable.mass_per_length * cable.length + tip.mass) * np.array(scene.gravity)
        return np.einsum("n,rnc->rc", weights, self._turning(line)) - weight

    def _turning(self, line: Kinematics) -> Array:
        """Second rate of the unit tangent at the nodes, 1/s^2, shape (rows, nodes, 2)."""
        tangent, rate, acceleration = direction(*(values[:, :, 2:].reshape(-1, 2) for values in line))
        turning = acceleration[:, None] * turned(tangent) - (rate**2)[:, None] * tangent
        return np.asarray(turning.reshape(*line[0].shape[:2], 2))

    def _stored(self, line: Kinematics, frame: Kinematics, turning: Array | float = 0.0, moment: Array | float = 0.0) -> dict[str, Array]:
        """Energies, with the crank's inertia times the square of its rate (J) and its first moment of mass (kg m, (rows, 2))."""
        scene, cable, (q, rates, _) = self.assembly.scene, self._cable, line
        kinetic = 0.5 * (turning + scene.base.inertia * frame[1] ** 2)
        kinetic += cable.kinetic_energy(rates)
        moment = moment + cable.first_moment(q)
        if (tip := scene.tip) is not None:
            tangent, rate, _ = direction(*(values[:, -1, 2:] for values in line))
            velocity = rates[:, -1, :2] + tip.center_of_mass * rate[:, None] * turned(tangent)
            kinetic += 0.5 * (tip.mass * np.sum(velocity**2, axis=1) + tip.inertia * rate**2)
            moment = moment + tip.mass * (q[:, -1, :2] + tip.center_of_mass * tangent)
        return {
            "kinetic_energy": kinetic,
            "strain_energy": cable.strain_energy(q),
            "gravity_energy": -moment @ np.array(scene.gravity),
        }

    def _damped(
        self, line: Kinematics, frame: Kinematics, crank: Array | float = 0.0, crank_change: Array | float = 0.0
    ) -> tuple[Array, Array]:
        """Power of all dampers but the slider's, and its derivative; `crank`: power of the crank's, `crank_change`: half its derivative."""
        damping, (q, rates, accelerations), (_, turn, turn_rate) = self.assembly.scene.base.damping, line, frame
        radius, relative = self._relative(line, frame)
        across, across_rate = turned(radius), turned(rates[:, :, :2])
        relative_rate = accelerations[:, :, :2] - turn_rate[:, None, None] * across - turn[:, None, None] * across_rate
        power = crank + damping * turn**2 + dot(relative, relative) @ self._damper_weights
        change = 2.0 * (crank_change + damping * turn * turn_rate)
        change = change + 2.0 * dot(relative, relative_rate) @ self._damper_weights
        if self._cable.bending_damping > 0.0:
            before, now, after = (self._cable.bending_loss(q + t * rates, rates + t * accelerations) for t in (-_SHORT, 0.0, _SHORT))
            power, change = power + now, change + (after - before) / (2.0 * _SHORT)
        return power, change


class FlexibleModel(CableModel):
    """The assembled system with a flexible follower, in the state `state`."""

    def __init__(self, mechanism: Mechanism, start: Start, state: StartState, settings: ExudynSettings) -> None:
        super().__init__(mechanism, settings)
        assembly, cable, mbs = self.assembly, self._cable, self.assembly.mbs
        self._mechanism = mechanism
        self._slider_start = state.slider_position
        crank_node, crank, prescribed = assembly.crank(start)
        self._nodes = nodes = add_nodes(assembly, cable, state)
        axial = None if settings.joint == SLIDING else _travel(mbs, state)
        cables = add_cable(assembly, cable, nodes, axial)
        assembly.listed_body(f"follower: {cable.elements} ANCF cable elements")
        self._load(add_ends(assembly, cable, state, nodes))
        end = items.MarkerNodeRigid if mechanism.tip_body.follows else items.MarkerNodePosition
        assembly.push_tip(mbs.AddMarker(end(nodeNumber=nodes[-1])), crank_node)
        if (held := mechanism.acting_spring) is not None:
            assembly.hold(marker_at(assembly, cable, nodes, held.place_on(cable.length)))
        self._joint, spring = add_slider(assembly, cable, state, start, crank, cables, axial)
        mbs.Assemble()
        self._locate()
        self.drive_equation = equation_of(assembly, prescribed)
        self._crank_index = index(assembly, crank_node) + 2
        self._axial_index = None if axial is None else index(assembly, axial)
        self._spring = spring
        if spring is not None:
            spring.locate(assembly, nodes, axial)

    def joint_loss(self) -> float:
        loss = 0.0 if self._spring is None else self._spring.loss()
        if (tip := self._mechanism.tip_body).friction_force > 0.0:
            last = self._node_indices[-1]
            loss += slide_loss(tip, self.assembly.mbs.systemData.GetODE2Coordinates_t()[last : last + 2])
        return loss

    def slider_position(self, coordinates: Array) -> float:
        if self._axial_index is not None:
            return float(coordinates[self._axial_index]) + self._slider_start
        places = self._node_indices[None, :, None] + np.arange(4)
        return float(self._slider_positions(coordinates[None], coordinates[places])[0])

    def _slider_positions(self, coordinates: Array, q: Array) -> Array:
        """Arc lengths of the slider, m, shape (rows,): the joint's own coordinate, or the foot of the crank tip on the line `q`."""
        if self._axial_index is not None:
            return np.asarray(coordinates[:, self._axial_index] + self._slider_start)
        tip = self._crank_tip(coordinates[:, self._crank_index])
        return self._cable.foot(q, tip, np.linalg.norm(tip - q[:, 0, :2], axis=1))

    def _crank_tip(self, angle: Array) -> Array:
        return self._mechanism.crank.length * np.column_stack([np.cos(angle), np.sin(angle)])

    def columns(self, record: Record) -> dict[str, Array]:
        mechanism, cable, line = self._mechanism, self._cable, self._line(record)
        q, rates, accelerations = line
        angle, speed, acceleration = (v[:, self._crank_index] for v in (record.coordinates, record.rates, record.accelerations))
        s = self._slider_positions(record.coordinates, q)
        frame = direction(*(values[:, 0, 2:] for values in line))
        b1, chord = frame[0], follower_angle(mechanism, angle)
        slider_tangent = cable.evaluate(q, s, 1)
        stretch = np.linalg.norm(slider_tangent, axis=1)
        slider_normal = turned(slider_tangent) / stretch[:, None]
        crank_tip = self._crank_tip(angle)
        apart = crank_tip - cable.evaluate(q, s)
        joint_force = record.multipliers[:, self.assembly.mbs.systemData.GetObjectLTGAE(self._joint)]
        # a sliding joint's multipliers are along its tangent and normal, which are as long as the tangent
        slider_force = -dot(slider_normal, joint_force) if self._axial_index is not None else -joint_force[:, 1] * stretch
        stiffness, spring = mechanism.follower.bending_stiffness, mechanism.acting_spring
        hung = np.full(len(q), cable.length if spring is None else spring.place_on(cable.length))
        hold = Hold.of(spring, (cable.evaluate(q, hung), cable.evaluate(rates, hung), cable.evaluate(accelerations, hung)))
        kinks: tuple[Kink, ...] = (Kink(s, slider_force[:, None] * slider_normal / stiffness),)
        if spring is not None:
            kinks = (*kinks, Kink(hung, hold.force / stiffness))
        stored = self._stored(line, frame, mechanism.crank_inertia * speed**2, mechanism.crank_moment / mechanism.crank.length * crank_tip)
        if self.assembly.joint_is_compliant:
            stored["strain_energy"] = stored["strain_energy"] + JointLaw(mechanism.slider).energy(dot(slider_normal, apart))
        tangent, turn, _ = direction(*(values[:, -1, 2:] for values in line))
        tip_motion = TipMotion(rates[:, -1, :2], accelerations[:, -1, :2], np.arctan2(tangent[:, 1], tangent[:, 0]), turn)
        pushed = slider_force[:, None] * slider_normal
        crank_damping = mechanism.crank.drive.damping
        stored["strain_energy"] = stored["strain_energy"] + hold.energy
        power, power_rate = self._damped(line, frame, crank_damping * speed**2, crank_damping * speed * acceleration)
        return {
            "time": record.time,
            "crank_angle": angle,
            "crank_speed": speed,
            "follower_angle": chord + np.angle((b1 @ np.array([1.0, 1j])) * np.exp(-1j * chord)),
            "slider_position": s,
            **self._follower_columns(record, line, frame, kinks, (pushed, force_on_tip(mechanism.tip_body, angle, tip_motion), hold.force)),
            **hold.columns,
            "slider_force": slider_force,
            **crank_bearing_columns(self.assembly, record, self._crank_index),
            **drive_columns(self.assembly, record, self._crank_index, self.drive_equation, tip_motion),
            **stored,
            "dissipated_energy": accumulated(record.time, power + hold.power, power_rate + hold.power_rate) + record.lost - record.lost[0],
            "constraint_gap": np.linalg.norm(apart, axis=1),
        }


def _travel(mbs: Any, state: StartState) -> Any:
    """Add the coordinate of the slider's travel along ALE cables; its node's number."""
    zero = {"referenceCoordinates": [0.0], "initialCoordinates": [0.0]}
    return mbs.AddNode(items.NodeGenericODE2(numberOfODE2Coordinates=1, **zero, initialCoordinates_t=[state.slider_speed]))
