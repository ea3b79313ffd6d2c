"""Bending moments and bearing forces of the models, against closed forms and laws that they are not made of."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import BENDING, MOMENTS, PLACES
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.rigid import rigid_kinetostatics, rigid_motion
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.thesis.model import ThesisModel
from quickreturn.reference_model.tip import tip_force
from tests.engines.scenes import run_24, with_parts
from tests.reference_model.motion.beam_runs import run
from tests.reference_model.motion.beam_states import HELD_BY_SPRING
from tests.reference_model.rigid_loads import rigid_bearing_forces, rigid_bending_moment
from tests.reference_model.thesis.thesis_runs import rigid

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(12)


def everything(**changes: Any) -> Mechanism:
    """Run 24 with gravity, a force on the tip, a heavy slider, a tip body beside the end, and friction at the base."""
    full = run_24(
        gravity=(2.0, -9.81),
        slider=Slider(mass=0.3, inertia=4e-4),
        tip={"center_of_mass": 0.0127, "force": (-1.0, 2.0), "force_from": math.radians(200.0), "force_to": math.radians(320.0)},
        base={"damping": 0.01},
    )
    return with_parts(full, **changes)


RIGID = everything(follower={"bending_stiffness": math.inf}, base={"friction_torque": 0.4})


def second_derivative(places: Any, h: float) -> Any:
    """Of places (complex) as a function of time, at time 0, by differences of fourth order."""
    return (-places(-2 * h) + 16 * places(-h) - 30 * places(0.0) + 16 * places(h) - places(2 * h)) / (12 * h * h)


@pytest.mark.parametrize("q1", [2.0, 0.3, -1.1, 4.5])
def test_closed_forms_of_the_rigid_follower_are_newtons_law_for_mass_points(q1: float) -> None:
    mechanism, speed, acceleration = RIGID, 11.0, -70.0
    beam, tip, crank, slider, gravity = mechanism.follower, mechanism.tip_body, mechanism.crank, mechanism.slider, complex(2.0, -9.81)

    def points(x: Array | float) -> Any:
        """The follower's point at x, as a function of time."""

        def at(t: float) -> Any:
            loop = crank.length * np.exp(1j * (q1 + speed * t + 0.5 * acceleration * t * t)) - mechanism.pivot_distance
            return mechanism.pivot_distance + loop / abs(loop) * x

        return at

    def on_crank(r: float) -> Any:
        return lambda t: r * np.exp(1j * (q1 + speed * t + 0.5 * acceleration * t * t))

    def weighed(place: Any) -> Any:
        return second_derivative(place, 1e-4) - gravity

    angle = np.array(q1)
    motion = rigid_motion(mechanism, angle, speed, acceleration)
    force = float(rigid_kinetostatics(mechanism, angle, speed, acceleration)[0])
    along, tool = np.exp(1j * motion.follower_angle), complex(tip_force(tip, angle, motion.follower_angle))
    x, dm = 0.5 * beam.length * (1.0 + POINTS), 0.5 * beam.length * beam.mass_per_length * WEIGHTS
    centre = beam.length + tip.center_of_mass
    pivot = dm @ weighed(points(x)) + tip.mass * weighed(points(centre)) - tool - 1j * force * along
    at_crank = crank.mass * weighed(on_crank(crank.center_of_mass)) + slider.mass * weighed(on_crank(crank.length)) + 1j * force * along
    found = [complex(*pair) for pair in rigid_bearing_forces(mechanism, angle, speed, acceleration)]
    # fourth-order differences: rounding 1e-16 / h^2 in m/s^2, times some kg
    np.testing.assert_allclose(found, [pivot, at_crank], atol=1e-5)

    for place in (0.05, 0.3, float(motion.slider_position) + 1e-9, 0.55):
        x = place + 0.5 * (beam.length - place) * (1.0 + POINTS)
        dm = 0.5 * (beam.length - place) * beam.mass_per_length * WEIGHTS
        levers = np.r_[x, centre] - place
        moment = -np.imag(np.conj(along) * weighed(points(np.r_[x, centre]))) @ (np.r_[dm, tip.mass] * levers)
        moment += np.imag(np.conj(along) * tool) * (beam.length - place) - tip.inertia * motion.follower_acceleration
        if place < motion.slider_position:
            moment += force * (motion.slider_position - place) - slider.inertia * motion.follower_acceleration
        assert float(rigid_bending_moment(mechanism, place, angle, speed, acceleration)) == pytest.approx(float(moment), abs=1e-6)
    base, rate = mechanism.base, float(motion.follower_speed)
    moment = base.inertia * float(motion.follower_acceleration) + base.damping * rate + base.friction_torque * math.tanh(rate / 0.1)
    assert float(rigid_bending_moment(mechanism, 0.0, angle, speed, acceleration)) == pytest.approx(moment, abs=1e-12)


assert HELD_BY_SPRING.spring is not None
#: Without the stop, at which the acceleration changes more quickly than differences can follow.
SPRING = dataclasses.replace(HELD_BY_SPRING.spring, longest=None, stop_stiffness=0.0)


def forces(columns: dict[str, Array]) -> dict[str, Array]:
    return {name: columns[name] for name in ("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y")}


@pytest.mark.parametrize("prescribed", [False, True], ids=["torque", "prescribed speed"])
@pytest.mark.parametrize(
    ("model_of", "mechanism"),
    [
        (lambda scene: BeamModel.following(scene, 0), RIGID),
        (lambda scene: BeamModel.following(scene, 0), dataclasses.replace(RIGID, spring=SPRING)),
        (rigid, everything(follower={"bending_stiffness": math.inf})),
    ],
    ids=["one beam", "held by a spring", "thesis"],  # which has no friction
)
def test_a_rigid_follower_has_the_closed_forms(model_of: Any, mechanism: Mechanism, prescribed: bool) -> None:
    if prescribed:
        mechanism = dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=-14.0)))
    model: BeamModel | ThesisModel = model_of(mechanism)
    h = 2e-4
    columns = run(model, 0.2, 1000, 1e-10)[1]
    speed = columns["crank_speed"]
    # differences of fourth order: (16.6 rad/s h)^4 of the value, and the integration's 1e-9 rad/s over h
    acceleration = (speed[:-4] - 8.0 * speed[1:-3] + 8.0 * speed[3:-1] - speed[4:]) / (12.0 * h)
    columns = {name: values[2:-2] for name, values in columns.items()}
    motion = columns["crank_angle"], columns["crank_speed"], acceleration
    at_pivot, at_crank = rigid_bearing_forces(mechanism, *motion)
    found = forces(columns)
    for name, expected in zip(found, (*at_pivot, *at_crank), strict=True):
        np.testing.assert_allclose(found[name], expected, atol=1e-6 * np.max(np.abs(expected)), err_msg=name)
    if isinstance(model, ThesisModel):
        assert not set(BENDING) & set(columns)
        return
    for number, name in enumerate(MOMENTS, 1):
        expected = rigid_bending_moment(mechanism, number / (PLACES + 1) * mechanism.follower.length, *motion)
        np.testing.assert_allclose(columns[name], expected, atol=1e-6 * np.max(np.abs(expected)), err_msg=name)
    s = rigid_motion(mechanism, *motion).slider_position
    for name, x in (("slider", s + 1e-9), ("inboard", s - 1e-9), ("base", 0.0), ("tip", mechanism.follower.length)):
        expected = rigid_bending_moment(mechanism, x, *motion)
        # at the ends it is small: rounding is measured by the largest moment along the arm
        np.testing.assert_allclose(columns[f"moment_{name}"], expected, atol=1e-6 * np.max(np.abs(columns["moment_06"])), err_msg=name)


@pytest.mark.parametrize("tip_force_acts", [False, True], ids=["weight", "weight and force"])
def test_a_standing_follower_bears_what_statics_says(tip_force_acts: bool) -> None:
    """Crank held, follower damped to rest: an overhanging beam with a uniform load, a weight at its end, and a force there.

    It hangs along -n1 from P, so that b2 = -n2 and a pull along +n2 is one along -b2.
    """
    crank = dataclasses.replace(run_24().crank, drive=PrescribedSpeed(speed=1e-9))
    g, pull = 0.5, 0.3 if tip_force_acts else 0.0  # m/s^2 and N: small deflections
    tip = {"center_of_mass": 0.01, "force": (0.0, pull)}
    mechanism = dataclasses.replace(run_24(gravity=(0.0, g), follower={"damping": 2.0}, tip=tip), crank=crank)
    columns = run(BeamModel.following(mechanism, 4), 8.0, 8, 1e-7)[1]
    beam, tip_body = mechanism.follower, mechanism.tip_body
    s, L, load, weight = mechanism.pivot_distance + crank.length, beam.length, beam.mass_per_length * g, tip_body.mass * g
    reaction = (0.5 * load * L**2 + weight * (L + 0.01) + pull * L) / s
    largest = 0.5 * load * (L - s) ** 2 + weight * (L + 0.01 - s) + pull * (L - s)
    places = [*(L * k / (PLACES + 1) for k in range(1, PLACES + 1)), s, s, 0.0, L]
    for name, x in zip(BENDING, places, strict=True):
        moment = -0.5 * load * (L - x) ** 2 - weight * (L + 0.01 - x) - pull * (L - x) + reaction * max(0.0, s - x)
        # the deflection, some thousandths of the length, shortens the levers by its square
        assert columns[name][-1] == pytest.approx(moment, abs=1e-4 * largest), name
    held = load * L + weight + pull - reaction  # along -n2, what the slider leaves to the pivot
    assert columns["pivot_force_y"][-1] == pytest.approx(-held, abs=1e-4 * reaction)
    # the slider pushes along the normal -n2, which leans with the line
    assert columns["pivot_force_x"][-1] == pytest.approx(0.0, abs=1e-2 * reaction)
    assert columns["crank_force_y"][-1] == pytest.approx(-reaction - mechanism.crank_mass * g, rel=1e-4)
