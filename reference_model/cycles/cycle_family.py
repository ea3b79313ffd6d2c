"""The cycle of a machine as a map that depends on one quantity of its scene."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.fixed_points import BranchPoint, Image, NotConverged, corrected
from quickreturn.reference_model.cycles.periodic import periodic_orbit
from quickreturn.reference_model.cycles.poincare import CycleBroken, PoincareMap
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.scene_values import changed

#: Accuracy of the periodic orbit with which a branch begins, relative to the size of its motion.
SEARCHED: Final = 1e-3
#: Ratio of successive prescribed speeds for which models are built. A model's tables do not depend on the speed; only the sizes that the
#: errors of its integration refer to do.
PACE: Final = 1.25
#: Length of the last correction (scaled variables) of a point that serves for a comparison only.
COMPARED: Final = 1e-4
#: Number of models that are kept: corrections and derivatives ask for the same values again.
KEPT: Final = 8


@dataclass(frozen=True)
class Neighbour:
    """A point of a branch beside that of a family with fewer modes."""

    point: Array  # shape (m,)
    parameter: float
    displacement: Array  # from the other point, in its scaled variables, shape (m + 1,)


class CycleFamily:
    """The cycle of the machine `scene_at(value)` as a map, by a model with so many modes and an integration to a tolerance."""

    def __init__(self, scene_at: Callable[[float], Mechanism], modes: int, tolerance: float) -> None:
        self.scene_at = scene_at
        self.modes = modes
        self.tolerance = tolerance
        self._built = lru_cache(KEPT)(lambda scene: BeamModel.following(scene, modes))
        self.at = lru_cache(KEPT)(self._at)

    def _at(self, value: float) -> tuple[PoincareMap, Array]:
        """The map for a value, and the state with a straight follower, the slider at its farthest place and the machine's crank speed."""
        scene = self.scene_at(value)
        speed = scene.crank.drive.initial_speed
        if isinstance(scene.crank.drive, PrescribedSpeed) and speed != 0.0:
            rounded = math.copysign(PACE ** round(math.log(abs(speed), PACE)), speed)
            scene = changed(scene, {"crank.prescribed_speed": rounded})
        model = self._built(scene)
        state = model.straight_state(math.pi, speed)
        return PoincareMap(model, self.tolerance), state

    def image(self, point: Array, value: float) -> Image:
        """The state a cycle later. Raises CycleBroken."""
        cycle, straight = self.at(value)
        state = cycle.state(point, straight)
        passage = cycle.passage(state, cycle.time_to_go(state))
        return Image(cycle.point(passage.state), passage.sizes, cycle.noise(state))

    def orbit(self, value: float) -> Array:
        """The free quantities of the periodic orbit that a search from the straight follower finds. Raises NoPeriodicOrbit."""
        cycle, straight = self.at(value)
        return cycle.point(periodic_orbit(cycle.model, straight, SEARCHED, self.tolerance).state)

    def columns(self, point: Array, value: float, rows: int) -> dict[str, Array]:
        """The cycle from a point: `time` (s) and observables by the names of `reference_model.columns`, each of shape (rows + 1,).

        Raises:
            CycleBroken: no whole cycle begins there.
        """
        cycle, straight = self.at(value)
        state = cycle.state(point, straight)
        period = cycle.time_to_go(state)
        if self.scene_at(value).crank_is_free:
            period = cycle.passage(state, period).duration
        states = cycle.model.integrate(state, period / rows, rows, self.tolerance).states
        return {"time": np.linspace(0.0, period, rows + 1), **cycle.model.observe(states)}

    def nearest(self, other: BranchPoint, displacement: Array | None = None) -> Neighbour:
        """The point of this family's branch in the plane across that of a family with fewer modes (equation 10.13).

        The added modes forget their state within a cycle (equation 10.6), so that the other family's derivatives serve here.

        Args:
            other: a point of the other family's branch.
            displacement: that of the neighbour of a point near by, with which the search begins. The added modes then begin without the
                vibration that follows from zeros, whose high frequencies take twice as many steps.

        Raises:
            CycleBroken, NotConverged: this branch has no point near by.
        """
        kept, sizes = self._kept(len(other.point)), np.empty(2 * self.modes + len(other.point) % 2)
        blocks = np.zeros(len(sizes), dtype=int)
        blocks[len(sizes) - self.modes :] = 1
        sizes[:] = np.where(blocks, other.sizes[-1], other.sizes[0])
        sizes[kept] = other.sizes
        rows = np.append(kept, len(sizes))
        matrix = np.hstack([-np.eye(len(sizes)), np.zeros((len(sizes), 1))])
        matrix[np.ix_(kept, rows)] = other.matrix
        point, tangent = np.zeros(len(sizes)), np.zeros(len(sizes) + 1)
        point[kept], tangent[rows] = other.point, other.tangent
        here = replace(other, point=point, sizes=sizes, matrix=matrix, tangent=tangent)
        way = np.zeros(len(tangent)) if displacement is None else displacement - (displacement @ tangent) * tangent
        try:
            found = corrected(self, here, *here.displaced(way), tangent, COMPARED)
        except (CycleBroken, NotConverged):
            if displacement is None:
                raise
            return self.nearest(other)
        return Neighbour(*found, here.scaled(*found))

    def _kept(self, size: int) -> NDArray[np.intp]:
        """Indices, among this model's free quantities (eta, crank speed if free, eta'), of the `size` ones of a model with fewer modes."""
        fewer, crank = divmod(size, 2)
        return np.array([*range(fewer), *range(self.modes, self.modes + crank + fewer)])
