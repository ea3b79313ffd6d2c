"""Builds the follower in Exudyn: a chain of cable elements with the bodies at its ends, its weight and its distributed damping."""

import itertools
from typing import Any, Final

import numpy as np

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.cable import Cable
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.record import index
from quickreturn.engines.start_state import FollowerState, StartState
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.rigid import crank_pace

_CLAMPED: Final = [1, 1, 0, 0, 0, 1]  # axes of a generic joint: both places and the rotation in the plane


def cable_of(follower: Follower, elements: int, axial_factor: float = 1.0) -> Cable:
    """The follower as a chain of `elements` cable elements, with `axial_factor` times the section's axial stiffness."""
    axial_stiffness = axial_factor * follower.axial_stiffness
    stiffness, damping = follower.bending_stiffness, follower.material_damping * follower.bending_stiffness
    return Cable(follower.length, elements, follower.mass_per_length, stiffness, axial_stiffness, damping)


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


def section_of(cable: Cable) -> dict[str, Any]:
    """Length and section of an element, and the degree of its quadrature, as Exudyn's objects take them.

    Gauss points for polynomials of degree 7 (axial) and 3 (bending) in place of 9 and 5: in runs 24 and 17 and the aluminium shaper errors
    keep their first three digits, and a run takes a twentieth less time.
    """
    return {
        "length": cable.element_length,
        "massPerLength": cable.mass_per_length,
        "bendingStiffness": cable.bending_stiffness,
        "axialStiffness": cable.axial_stiffness,
        "bendingDamping": cable.bending_damping,
        "useReducedOrderIntegration": 1,
    }


def add_cable(assembly: Assembly, cable: Cable, nodes: list[Any], axial: Any | None = None) -> list[Any]:
    """Add elements between the nodes; returns their object numbers. With the node `axial` of the slider's travel they are ALE elements."""
    section = section_of(cable)
    if axial is None:
        elements = [items.ObjectANCFCable2D(**section, nodeNumbers=[*pair]) for pair in itertools.pairwise(nodes)]
    else:
        section |= {"movingMassFactor": 0.0, "useCouplingTerms": False, "addALEvariation": False}
        elements = [items.ObjectALEANCFCable2D(**section, nodeNumbers=[*pair, axial]) for pair in itertools.pairwise(nodes)]
    return [assembly.mbs.AddObject(element) for element in elements]


def add_ends(assembly: Assembly, cable: Cable, state: StartState, nodes: list[Any]) -> tuple[Any, Any] | None:
    """Hold the cable at P and add the tip body.

    A base body is built only where it has something to do: an inertia, or dampings that act on its rotation or relative to it.

    Returns:
        Node and object number of the base body, or None.
    """
    scene, base_body = assembly.scene, None
    if scene.base.inertia > 0.0 or scene.base.damping > 0.0 or scene.follower.damping > 0.0:
        base_body = add_base(assembly, state, nodes)
    else:
        end = assembly.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[0]))
        assembly.pin("follower", assembly.scene.pivot_distance, end)
    add_tip(assembly, cable, state, nodes)
    return base_body


def add_base(assembly: Assembly, state: FollowerState, nodes: list[Any]) -> tuple[Any, Any]:
    """A base body at P, damped, with the cable clamped to it; node and object number."""
    start = np.zeros(1)
    angle, rate = float(state.tangent(start)[0]), float(state.tangent_rate(start)[0])
    body = assembly.pinned_body("base", assembly.scene.pivot_distance, angle, rate, assembly.scene.base.inertia)
    markers = [assembly.frame_marker(body[1]), assembly.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))]
    assembly.add_joint("follower clamped to the base", _clamp(markers), 3)
    assembly.rotary_damper(body[0], assembly.scene.base.damping)
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


def marker_at(assembly: Assembly, cable: Cable, nodes: list[Any], x: float) -> Any:
    """A marker on the cable at the arc length x (m).

    Between nodes it is on an element without mass and stiffness that has the same nodes: on an ALE element its force would also push the
    slider along.
    """
    h = cable.element_length
    element = min(int(x / h), cable.elements - 1)
    for node, place in ((element, element * h), (element + 1, (element + 1) * h)):
        if abs(x - place) < 1e-9 * h:
            return assembly.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[node]))
    line = items.ObjectANCFCable2D(length=h, nodeNumbers=nodes[element : element + 2])
    return assembly.point_marker(assembly.mbs.AddObject(line), x - element * h)


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


#: Longest stretch of the simulation over which the dampers' points may stand still: s, and rad that the crank or the base turns meanwhile.
#: 2 ms change no column of 26 scenes by more than 3.4e-5; Newton's Jacobian is as old as the stretch, and older ones cost more iterations
#: than they save.
LONGEST: Final = 0.032
LONGEST_TURN: Final = 0.1


def longest_stretch(scene: Scene) -> float:
    """The longest stretch for a scene, in its units of time."""
    pace = abs(scene.spin_up.speed) if scene.crank is None else crank_pace(scene)
    return min(LONGEST, LONGEST_TURN / pace) if pace else LONGEST


class Dampers:
    """Distributed damping relative to the base frame: dampers between the nodes of the cable, but for the first, and the base body.

    The force on the unit of length is -c (v - omega i r), with r the place from P, v its velocity, omega the rate of the base frame. None
    of Exudyn's connectors knows this velocity: a damper between a node and a point fixed in the base body, which is pinned at P, sees
    v - omega i r', r' the place of that point. So the points follow the nodes: before every stretch of the simulation each is put where
    its node will be in the base frame in the middle of the stretch, by its velocity relative to that frame. What is left is of second
    order in the length of the stretch. The error that other points leave (LADDERS.md, section 3) would not show with a finer mesh or step.

    Args:
        assembly: under construction.
        base: node and object number of the base body.
        nodes: of the cable.
        x: their arc lengths, m, shape (nodes,).
        weights: damping gathered at each, N s/m, shape (nodes,).
    """

    def __init__(self, assembly: Assembly, base: tuple[Any, Any], nodes: list[Any], x: Array, weights: Array) -> None:
        self._mbs = assembly.mbs
        self._pivot = assembly.scene.pivot_distance
        self._base, self._nodes = base[0], nodes[1:]
        self._points = [assembly.point_marker(base[1], place) for place in x[1:]]
        for point, node, weight in zip(self._points, self._nodes, weights[1:], strict=True):
            markers = [point, assembly.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))]
            assembly.mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=markers, damping=[weight, weight, 0.0]))

    def locate(self, assembly: Assembly) -> None:
        """Find the coordinates; once, after the system is assembled."""
        self._angle = index(assembly, self._base) + 2
        self._places = np.array([index(assembly, node) for node in self._nodes])[:, None] + np.arange(2)

    def follow(self, coordinates: Array, rates: Array, duration: float) -> None:
        """Put the points where the nodes will be halfway through the next `duration` (s).

        Args:
            coordinates: total second-order coordinates of the present instant, shape (coordinates,); `rates` alike.
            rates: their rates.
            duration: s.
        """
        away, rate = (np.ascontiguousarray(values[self._places]).view(complex)[:, 0] for values in (coordinates, rates))  # x + i y
        away = away - self._pivot
        away = away + 0.5 * duration * (rate - 1j * rates[self._angle] * away)
        in_frame = np.exp(-1j * coordinates[self._angle]) * away
        for point, along, across in zip(self._points, in_frame.real.tolist(), in_frame.imag.tolist(), strict=True):
            self._mbs.SetMarkerParameter(point, "localPosition", [along, across, 0.0])
