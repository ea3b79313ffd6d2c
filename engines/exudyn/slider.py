"""The slider on the flexible follower: an ALE joint, and between it and the crank tip the spring and damper of a compliant joint.

The cable does not flow (`movingMassFactor=0`): the axial coordinate of the arbitrary Lagrangian-Eulerian elements is the slider's place on
the cable, and its equation says that the joint passes no force along the tangent.

A compliant joint has a carriage, a point that the ALE joint keeps on the centre line; the joint's force acts between it and the crank tip.
Only a spring holds the carriage along the tangent, so that it stands where that spring has no force: at the foot of the crank tip. The gap
lies along the normal. A linear spring may act equally in all directions, but not rollers and dampers: as the normal turns, the crank tip
moves along the tangent relative to the carriage, and a damper in all directions would drag the carriage along (RIVALS.md, section 2).
"""

import math
from dataclasses import astuple
from typing import Any, Final

import numpy as np

from quickreturn.engines.exudyn.assembly import CARRIAGE, CARRIAGE_MASS, Assembly
from quickreturn.engines.exudyn.cable import Cable
from quickreturn.engines.exudyn.library import exu, items
from quickreturn.engines.exudyn.record import index
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import StartState
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.joint import joint_energy, joint_force, rollers
from quickreturn.reference_model.slider import Slider


class JointLaw:
    """Force, energy and loss of a compliant joint.

    Attributes:
        along: stiffness (N/m) of the spring that holds the carriage at the foot of the crank tip, along the follower's tangent: between
            the rollers nothing else would hold it. The carriage has hardly any mass, so that the spring has no force. With a hundredth of
            the stiffness the tip deflection of run 24 with clearance changes by 2e-10, with a millionth by 1.8e-6.
    """

    def __init__(self, slider: Slider) -> None:
        self._law = astuple(rollers(slider))
        self._lossless = (*self._law[:4], 0.0, 0.0)
        self.along = max(slider.sides)

    def force(self, gap: float, rate: float) -> float:
        """Force on the follower along n, N, for a gap (m) and its rate (m/s)."""
        return joint_force(gap, rate, *self._law)

    def loss(self, gap: float, rate: float) -> float:
        """Power that the joint dissipates, W."""
        return rate * (self.force(gap, rate) - joint_force(gap, 0.0, *self._lossless))

    def energy(self, gaps: Array) -> Array:
        """Energy stored at the gaps (m), J."""
        return np.array([joint_energy(gap, *self._law[:4]) for gap in gaps.tolist()])


#: Outputs of a connector: place (m) and velocity (m/s) of its second marker relative to the first.
_APART: Final = (exu.OutputVariableType.Displacement, exu.OutputVariableType.Velocity)


def add_slider(
    assembly: Assembly, cable: Cable, state: StartState, start: Start, crank: Any, elements: list[Any], axial: Any | None
) -> tuple[Any, "CarriageSpring | None"]:
    """Add the joint between the crank tip and the cable.

    Args:
        assembly: the system under construction.
        cable: the follower.
        state: state of the follower at the start, without a gap.
        start: gives the crank's speed.
        crank: object number of the crank.
        elements: object numbers of the cable's elements.
        axial: number of the node that holds the slider's travel along ALE cables; None: a sliding joint, which keeps it itself.

    Returns:
        Object number of the joint, whose multipliers are the force on crank tip or carriage along x and y, of a sliding joint those of
        `sliding_force`; and the force law that Exudyn calls back, None for a rigid joint or where the connector's own force suffices.
    """
    mbs, h = assembly.mbs, cable.element_length
    rider = assembly.point_marker(crank, assembly.mechanism.crank.length)
    spring = None
    if assembly.joint_is_compliant:
        rider, spring = _add_carriage(assembly, cable, state, start, rider)
    markers = [mbs.AddMarker(items.MarkerBodyCable2DCoordinates(bodyNumber=element)) for element in elements]
    first = min(int(state.slider_position / h), len(elements) - 1)
    placed: dict[str, Any] = {
        "markerNumbers": [rider, markers[first]],
        "slidingMarkerNumbers": markers,
        "slidingMarkerOffsets": [i * h for i in range(len(elements))],
    }
    name = f"slider on the follower{assembly.joint_text}"
    if axial is None:
        history = mbs.AddNode(items.NodeGenericData(initialCoordinates=[first, state.slider_position], numberOfDataCoordinates=2))
        joint = items.ObjectJointSliding2D(**placed, nodeNumber=history, useClassicalFormulation=False)
        return assembly.add_joint(name, joint, 1), None  # of its three equations one finds the slider's place, and one is 0 = 0
    history = mbs.AddNode(items.NodeGenericData(initialCoordinates=[first], numberOfDataCoordinates=1))
    joint = items.ObjectJointALEMoving2D(**placed, slidingOffset=state.slider_position, nodeNumbers=[history, axial])
    # Two equations, for travel and normal. The joint takes one of the carriage's two coordinates, the balance of forces along the tangent
    # the other.
    return assembly.add_joint(name, joint, 3 if assembly.joint_is_compliant else 2), spring


def _add_carriage(assembly: Assembly, cable: Cable, state: StartState, start: Start, crank_tip: Any) -> tuple[Any, "CarriageSpring | None"]:
    """Add the carriage with its spring and damper, at the crank tip and with its velocity; returns its marker and the force law."""
    mbs, slider = assembly.mbs, assembly.scene.slider
    place = state.position(np.array([state.slider_position]))[0]
    velocity = start.crank_speed * np.array([-place[1], place[0]])  # of the crank tip, which is at the same place
    node = mbs.AddNode(items.NodePoint2D(referenceCoordinates=list(place), initialVelocities=list(velocity)))
    mbs.AddObject(items.ObjectMassPoint2D(mass=CARRIAGE_MASS, nodeNumber=node))
    assembly.listed_body(CARRIAGE)
    carriage = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
    law = JointLaw(slider)
    connector = items.ObjectConnectorCartesianSpringDamper(markerNumbers=[carriage, crank_tip], stiffness=[law.along, law.along, 0.0])
    if slider.is_linear and slider.joint_damping == 0.0:  # the connector's own force suffices
        mbs.AddObject(connector)
        return carriage, None
    spring = CarriageSpring(cable, state.slider_position, law)
    connector.springForceUserFunction = spring
    spring.connector = mbs.AddObject(connector)
    return carriage, spring


class CarriageSpring:
    """Force of the joint's law along the cable's normal n at the slider, and of a spring along its tangent.

    Exudyn calls it some seven times a step, derivatives included, so that a run takes a quarter to a third longer. It computes with plain
    numbers, because arrays of two cost more.
    """

    connector: Any  # object number of the connector that calls it

    def __init__(self, cable: Cable, slider_start: float, law: JointLaw) -> None:
        self._h, self._last = cable.element_length, cable.elements - 1
        self._slider_start = slider_start
        self._law = law

    def locate(self, assembly: Assembly, nodes: list[Any], axial: Any) -> None:
        """Find the coordinates of the nodes and of the slider's travel; call after `mbs.Assemble()`."""
        self._mbs = assembly.mbs
        self._nodes = [index(assembly, node) for node in nodes]
        self._axial = index(assembly, axial)
        self._reference = assembly.mbs.systemData.GetODE2Coordinates(configuration=exu.ConfigurationType.Reference)

    def __call__(self, mbs: Any, time: float, item: int, displacement: Any, velocity: Any, *parameters: Any) -> list[float]:
        """Force on the crank tip, sign reversed, N, for its displacement (m) and velocity (m/s) relative to the carriage."""
        tx, ty = self._tangent(mbs)
        force = self._law.force(tx * displacement[1] - ty * displacement[0], tx * velocity[1] - ty * velocity[0])
        along = self._law.along * (tx * displacement[0] + ty * displacement[1])
        return [along * tx - force * ty, along * ty + force * tx, 0.0]

    def loss(self) -> float:
        """Power that the joint dissipates at present, W."""
        tx, ty = self._tangent(self._mbs)
        apart = (self._mbs.GetObjectOutput(self.connector, variable) for variable in _APART)
        return self._law.loss(*(float(tx * vector[1] - ty * vector[0]) for vector in apart))

    def _tangent(self, mbs: Any) -> tuple[float, float]:
        """Unit tangent of the cable at the slider."""
        coordinates, h = mbs.systemData.GetODE2Coordinates(), self._h
        s = float(coordinates[self._axial]) + self._slider_start
        element = min(max(int(s / h), 0), self._last)
        xi, first = s / h - element, self._nodes[element]
        ends = slice(first, first + 8)  # both nodes of the element, which were added one after the other
        x0, y0, tx0, ty0, x1, y1, tx1, ty1 = (coordinates[ends] + self._reference[ends]).tolist()
        rise, left, right = 6.0 * xi * (1.0 - xi) / h, 1.0 + xi * (3.0 * xi - 4.0), xi * (3.0 * xi - 2.0)
        tx = rise * (x1 - x0) + left * tx0 + right * tx1
        ty = rise * (y1 - y0) + left * ty0 + right * ty1
        length = math.hypot(tx, ty)
        return tx / length, ty / length
