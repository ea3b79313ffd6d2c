"""A machine about its settled cycle, from turn to turn: the derivatives of the cycle's map (DERIVATION.md, section 10).

The state is that of `cycles.poincare` at the slider's farthest place. An input is a quantity of the scene that is constant over a turn; the
amplitudes are those of the modes that the machine then has. The outputs are columns at the beginning of the turn.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.keys import PATHS
from quickreturn.engines.base import Refusal
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.plugins.linear.model import LinearModel, chosen, named_states
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit, periodic_orbit
from quickreturn.reference_model.cycles.poincare import CycleBroken, PoincareMap
from quickreturn.reference_model.errors import EngineTrouble
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.scene_values import value_at

#: Tolerance of the integration, which leaves 3e-8 of the motion's size in a cycle's end (run 24), and accuracy of the cycle that is found.
INTEGRATION: Final = 1e-10
FOUND: Final = 1e-6
#: Disturbances for central differences, which twice as large ones extrapolate: of a state over its size, of an input over its value. The
#: changes of run 24's settled motion with torque or speed are then within 3e-5 of marched ones, those of its forces within 2e-3.
OF_STATE: Final = 6e-4
OF_INPUT: Final = 1e-3


def about_cycle(case: Case, inputs: str | Sequence[str], outputs: str | Sequence[str], modes: int) -> LinearModel:
    """The linear model about the settled cycle; arguments and errors as of `linearise`."""
    scene, engine = case.mechanism, ReferenceEngine()
    values = {key: value for key in PATHS if isinstance(value := value_at(scene, key), float) and 0.0 < abs(value) < math.inf}
    keys = chosen("inputs", inputs, {key: PATHS[key].unit for key in values}, "of the keys whose value is finite and not zero")
    engine.check(scene)
    if scene.follower.is_rigid or engine.opens_loop(scene):
        raise Refusal("the settled cycle is not found with a rigid follower or with a [slider] that gives way or rubs; change these keys")
    model = cache(lambda scene: BeamModel.following(scene, modes))

    def straight(scene: Mechanism) -> Array:
        return model(scene).straight_state(math.pi, scene.crank.drive.initial_speed)

    def turned(disturbed: Array) -> Array:
        """State a turn later and outputs, by state and inputs."""
        there = case.mechanism_with(dict(zip(keys, map(float, disturbed[n:]), strict=True)))
        turn = PoincareMap(model(there), INTEGRATION)
        begin = turn.state(disturbed[:n], straight(there))
        columns = turn.model.observe(begin[None])
        return np.r_[turn.point(turn.passage(begin, turn.time_to_go(begin)).state), [columns[name][0] for name in of_outputs]]

    def slopes(size: float) -> Array:
        return np.column_stack([(turned(whole + step) - turned(whole - step)) / (2.0 * step.sum()) for step in np.diag(size * steps)])

    try:
        orbit, cycle = periodic_orbit(model(scene), straight(scene), FOUND, INTEGRATION), PoincareMap(model(scene), INTEGRATION)
        known = {name: COLUMNS[name].unit for name in model(scene).observe(orbit.state[None])}
        of_outputs = chosen("outputs", outputs, known, "of the columns of this model")
        whole = np.r_[cycle.point(orbit.state), [values[key] for key in keys]]
        n = len(whole) - len(keys)
        steps = np.r_[OF_STATE * cycle.passage(orbit.state, orbit.period).sizes, OF_INPUT * np.abs(whole[n:])]
        J = (4.0 * slopes(1.0) - slopes(2.0)) / 3.0
    except (NoPeriodicOrbit, CycleBroken) as reason:
        raise EngineTrouble(f"{case.name}: no settled cycle: {reason}; try more damping or another speed") from reason
    matrices, about = (J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:]), "from turn to turn about the settled cycle"
    states = named_states(modes, speed="crank_speed" if scene.crank_is_free else "")
    return LinearModel(case, about, *matrices, states, keys, of_outputs, math.pi, 0.5 / orbit.period, orbit.period)
