"""Random bent and moving states of the one beam with every slider constraint, and what `plain_beam` says about them."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.joint import Rollers
from quickreturn.reference_model.mechanism import Base, Follower, FollowerAlone, Mechanism, PrescribedSpeed, Slider, SpinUp, Tip
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.equations import evaluate, kernel
from quickreturn.reference_model.motion.layout import state_size
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements, vibrating
from quickreturn.reference_model.slider_constraint import BASE, CHORDS, CLOSED, LEVER, MULTIPLIER, ROLLERS, SliderConstraint
from tests.engines.scenes import INCH, run_24
from tests.reference_model.beam_runs import fine_family, with_fine_tables
from tests.reference_model.plain_beam import Following, Motion, PlainBeam, motion, of_clamped_modes, of_set

Array = NDArray[np.float64]

EVERYTHING: Final = run_24(
    gravity=(3.0, -9.81),
    slider=Slider(mass=0.1, inertia=3e-4),
    tip={"center_of_mass": 0.0127, "force": (8.0, -5.0), "force_from": 0.7, "force_to": 5.2, "force_ramp": 1.1},
    follower={"damping": 2.0},
    base={"damping": 0.02},
)
#: Elements carry no slider with rotary inertia: their curvature jumps at the nodes.
ON_ELEMENTS: Final = replace(EVERYTHING, slider=Slider(mass=0.1))
#: With all frictions, at speeds over which they change; and with a material that damps.
RUBBING: Final = replace(
    EVERYTHING,
    slider=replace(EVERYTHING.slider, friction=0.3, friction_force=2.0, friction_speed=1.5),
    base=replace(EVERYTHING.base, friction_torque=0.2),
)
DAMPED: Final = replace(RUBBING, follower=replace(RUBBING.follower, material_damping=3e-4))
BARE: Final = run_24(tip=None, base={"inertia": 0.0, "damping": 0.0}, follower={"damping": 0.0}, crank={"length": 6.0 * INCH})
ALONE: Final = FollowerAlone(
    spin_up=SpinUp(speed=7.0, time=1.5),
    base=Base(inertia=0.02, damping=0.05, friction_torque=0.3),
    follower=Follower(
        length=0.8, mass_per_length=0.4, bending_stiffness=5.0, thickness=3e-3, width=4e-2, damping=0.3, strain_gauges=(0.15, 0.42, 0.6)
    ),
    tip=Tip(mass=0.06, inertia=4e-4, center_of_mass=0.03),
    gravity=(1.5, -9.0),
)
SPRING: Final = Rollers(plus=2e3, minus=2e3, damping=8.0)
COMPLIANT: Final = SliderConstraint(kind=ROLLERS, rollers=SPRING)
HEAVY: Final = SliderConstraint(kind=ROLLERS, rollers=SPRING, inertia=0.05)
#: Rollers that differ in all, apart or pressed together by more than any of the states opens them, and with an inertia beside them.
APART: Final = SliderConstraint(
    kind=ROLLERS, rollers=Rollers(plus=4e3, minus=9e3, plus_from=5e-4, minus_from=4e-4, loss=0.1, damping=3.0), inertia=0.02
)
PRELOADED: Final = SliderConstraint(kind=ROLLERS, rollers=Rollers(plus=2e3, minus=5e3, plus_from=-5e-3, minus_from=-2e-3, loss=0.1))
FREE: Final = SliderConstraint(kind=ROLLERS, rollers=Rollers(plus=4e3, minus=9e3, plus_from=2e-2, minus_from=2e-2, loss=0.9, damping=3.0))
BY_FORCE: Final = SliderConstraint(kind=MULTIPLIER, stabilization=80.0)
BY_LEVER: Final = SliderConstraint(kind=LEVER, stabilization=60.0, bending_damping=2e-4)
ON_CHORDS: Final = SliderConstraint(kind=CHORDS, stabilization=40.0)

#: Angle (rad) by which the follower of an open loop stands off the crank tip, and its rate (rad/s).
OPENED: Final = 0.004
OPENING: Final = 0.4


@dataclass(frozen=True)
class State:
    """A model, a state of it, and what the plain beam says about it."""

    model: BeamModel
    beam: PlainBeam
    y: Array
    expected: Motion

    def rate(self) -> Array:
        """dy/dt; fills the model's workspace."""
        return rates(self.model, self.y)


def rates(model: BeamModel, y: Array) -> Array:
    """dy/dt by the compiled equations."""
    rate = np.zeros_like(y)
    p, w = model._at
    assert evaluate(kernel(), p.address, w.address, y, rate)
    return rate


def at_constant_speed(mechanism: Mechanism) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=17.0)))


def following(mechanism: Mechanism, modes: int, seed: int, constraint: SliderConstraint = CLOSED) -> State:
    """With natural modes that follow the slider, in tables of 400 intervals and as many points a span as leave no error of theirs."""
    rng = np.random.default_rng(seed)
    q1, s = _crank(mechanism, rng)
    shapes = Following(mechanism, modes)
    u = np.linspace(0.0, 1.0, 40)
    shapes.orient(s, u * s, fine_family(mechanism, modes).shapes_at(np.array([s]), u, 0)[0][0])
    beam = PlainBeam(mechanism, shapes, constraint, s)
    fine = with_fine_tables(mechanism, modes, points=11 if modes <= 3 else 15, constraint=constraint)
    return _moving(fine, beam, q1, rng)


def staying(
    mechanism: Mechanism, shapes: ShapeSet, seed: int, constraint: SliderConstraint = CLOSED, *, transverse_damping: bool = False
) -> State:
    """With shapes that stay where they are."""
    rng = np.random.default_rng(seed)
    q1, s = _crank(mechanism, rng)
    own = vibrating(shapes, mechanism.follower.mass_per_length, mechanism.follower.bending_stiffness)[0]
    nodes = shapes.edges if shapes.coefficients.shape[1] == 4 else None
    along = 0.0 if transverse_damping else 1.0
    plain = of_set(own, mechanism.follower.bending_stiffness, s)
    beam = PlainBeam(mechanism, plain, constraint, s, damps_along=along, node_edges=nodes)
    return _moving(BeamModel.staying(mechanism, shapes, constraint, transverse_damping=transverse_damping), beam, q1, rng)


def alone(scene: FollowerAlone, shapes: int | ShapeSet, seed: int, *, transverse_damping: bool = False) -> State:
    """The follower alone, half-way through its spin-up."""
    rng, split = np.random.default_rng(seed), 0.5 * scene.follower.length
    model = BeamModel.alone(scene, shapes, transverse_damping=transverse_damping)
    if isinstance(shapes, int):
        plain = of_clamped_modes(scene, shapes, split)
    else:
        own = vibrating(shapes, scene.follower.mass_per_length, scene.follower.bending_stiffness)[0]
        plain = of_set(own, scene.follower.bending_stiffness, split)
    along = 0.0 if transverse_damping else 1.0
    beam = PlainBeam(scene, plain, SliderConstraint(kind=BASE), split, damps_along=along)
    return _moving(model, beam, float(rng.uniform(0.5, 1.0)), rng)


def modes_of(mechanism: Mechanism, count: int) -> ShapeSet:
    return clamped_free_modes(mechanism.follower.length, count)


def elements_of(mechanism: Mechanism, count: int) -> ShapeSet:
    return hermite_elements(mechanism.follower.length, count)


def _crank(mechanism: Mechanism, rng: np.random.Generator) -> tuple[float, float]:
    """Any angle of the crank, and where the slider of the rigid mechanism is then."""
    q1 = float(rng.uniform(0.0, 2.0 * np.pi))
    return q1, abs(mechanism.crank.length * np.exp(1j * q1) - mechanism.pivot_distance)


def _moving(model: BeamModel, beam: PlainBeam, q1: float, rng: np.random.Generator) -> State:
    """Slopes up to a third, every shape moving at its own pace, the crank turning either way; an open loop stands open, and opens."""
    n, m = beam.shapes.count, beam.speeds
    x = np.linspace(0.0, beam.scene.follower.length, 101)
    size = 0.2 / np.max(np.abs(beam.shapes.angles(beam.near, x)), axis=0) / np.arange(1, n + 1)
    pace = np.sqrt(np.diag(beam.shapes.stiffness(beam.near)))
    y = np.zeros(state_size(model.parameters))
    y[0], y[1 : n + 1] = q1, rng.uniform(-1.0, 1.0, n) * size
    speed = float(rng.uniform(5.0, 20.0)) * (1.0 if rng.random() < 0.5 else -1.0)
    y[m + 1], y[m + 2 : m + 2 + n] = speed, rng.uniform(-1.0, 1.0, n) * size * pace
    if isinstance(beam.scene, FollowerAlone):
        y[m + 1] = 1.0
    elif m > n + 1:
        closed = PlainBeam(beam.scene, beam.shapes, CLOSED, beam.near)
        y[n + 1] = closed.hung(y[:m]).q2 + OPENED * float(rng.uniform(0.5, 1.0)) * (1.0 if rng.random() < 0.5 else -1.0)
        y[2 * m] = float(rigid_motion(beam.scene, np.array(q1), speed).follower_speed) + OPENING * float(rng.uniform(-1.0, 1.0))
    y[m] = beam.hung(y[:m]).s
    if beam.kind == BASE:
        y[m] = model.parameters.tables.low
    return State(model, beam, y, motion(beam, y))
