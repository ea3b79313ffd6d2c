"""Distributed damping of the follower relative to its base frame.

The force on the unit of length is -c (v - omega i r), with r the place from P, v its velocity, omega the rate of the base frame. None of
Exudyn's connectors knows this velocity: a damper between a node and a point fixed in the base body sees v - omega i r', r' the place of
that point. So the points follow the nodes: before every stretch of the simulation each is put where its node will be in the base frame
in the middle of the stretch, by its velocity relative to that frame. What is left is of second order in the length of the stretch. The
error that other points leave (LADDERS.md, section 3) would not show with a finer mesh or step.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.library import items
from quickreturn.engines.exudyn.record import index
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.rigid import crank_pace

Array = NDArray[np.float64]

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
    """Dampers between the nodes of the cable, but for the first, and the base body pinned at P.

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
