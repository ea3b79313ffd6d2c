"""Frozen-crank natural frequencies.

The ALE joint carries its massless axial coordinate into the eigenvalue problem and is several per cent off; the sliding joint on
ordinary cable elements, with its point held on the ground, gives the frequencies of the beam supported at the slider.
"""

import math

import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from engines.exudyn.assembly import Assembly
from engines.exudyn.flexible import add_ends, add_nodes, cable_of
from engines.start import Start
from engines.start_state import reconstruct
from reference_model.mechanism import Mechanism

_LOWEST = 1e-3  # Hz; below lies only the round-off of a mechanism's own mobility


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, elements: int) -> NDArray[np.float64]:
    """The `count` lowest frequencies with the crank held, follower straight and at rest, Hz, ascending, shape (<= count,)."""
    if mechanism.follower.is_rigid:
        return np.empty(0)
    state = reconstruct(mechanism, Start(crank_angle, 0.0))
    assembly = Assembly(mechanism)
    mbs, cable = assembly.mbs, cable_of(mechanism.follower, elements)
    nodes = add_nodes(assembly, cable, state)
    cables = [
        mbs.AddObject(
            items.ObjectANCFCable2D(
                length=cable.element_length,
                massPerLength=cable.mass_per_length,
                bendingStiffness=cable.bending_stiffness,
                axialStiffness=cable.axial_stiffness,
                nodeNumbers=[nodes[i], nodes[i + 1]],
            )
        )
        for i in range(elements)
    ]
    add_ends(assembly, cable, state, nodes)
    LA, h = mechanism.crank.length, cable.element_length
    held = assembly.point_marker(assembly.ground, LA * math.cos(crank_angle), LA * math.sin(crank_angle))
    markers = [mbs.AddMarker(items.MarkerBodyCable2DCoordinates(bodyNumber=body)) for body in cables]
    element = min(int(state.slider_position / h), elements - 1)
    history = mbs.AddNode(items.NodeGenericData(initialCoordinates=[element, state.slider_position], numberOfDataCoordinates=2))
    mbs.AddObject(
        items.ObjectJointSliding2D(
            markerNumbers=[held, markers[element]],
            slidingMarkerNumbers=markers,
            slidingMarkerOffsets=[i * h for i in range(elements)],
            nodeNumber=history,
            useClassicalFormulation=False,
        )
    )
    mbs.Assemble()
    frequencies = np.asarray(mbs.ComputeODE2Eigenvalues(convert2Frequencies=True)[0])
    return np.sort(frequencies[np.isfinite(frequencies) & (frequencies > _LOWEST)])[:count]
