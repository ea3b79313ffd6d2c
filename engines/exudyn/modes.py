"""Frozen-crank natural frequencies.

With the ALE joint the frequencies would be several per cent off, because its massless axial coordinate enters the eigenvalue problem.
The sliding joint on ordinary cable elements, with its point held on the ground, gives the frequencies of the beam supported at the
slider. A compliant joint is a spring along the normal from the ground to the follower's point at the slider: in its modes the follower
does not slide.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.cable import Cable
from quickreturn.engines.exudyn.construction import add_cable, add_ends, add_nodes, cable_of
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.rigid import follower_inertia
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import StartState, reconstruct
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import stiffness_across

_LOWEST = 1e-4  # in the scene's unit of time; below it lies the round-off of a motion without stiffness


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, elements: int) -> NDArray[np.float64]:
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
