"""Closed forms of the slider's joint: statics on one roller, blows, friction of a rigid follower, and the limits of a soft joint."""

import cmath
import math
from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.integrate import REACHED_END
from quickreturn.reference_model.joint import ROLLERS, Rollers, SliderConstraint, joint_energy, joint_force, rollers
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.slider import CONTACT_STIFFNESS, Slider
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_states import rates

#: Weight (m/s²) across a follower that lies along n1.
WEIGHT: Final = 9.81


def model_of(mechanism: Mechanism, modes: int = 3) -> BeamModel:
    """The model with the scene's own rollers."""
    return BeamModel.following(mechanism, modes, SliderConstraint(kind=ROLLERS, rollers=rollers(mechanism.slider)))


def held(mechanism: Mechanism) -> Mechanism:
    """The crank does not turn."""
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=0.0)))


def at_rest(model: BeamModel) -> dict[str, Array]:
    """Observables of the equilibrium near the straight follower."""
    n, m = model.shapes, model.parameters.speeds
    begin = model.straight_state(math.pi, 0.0)
    places = [*range(1, n + 2), m]  # amplitudes, base angle, slider

    def residual(x: Array) -> Array:
        y = begin.copy()
        y[places] = x
        rate = rates(model, y)
        return np.append(rate[m + 2 : 2 * m + 1], rate[m])

    y = begin.copy()
    y[places] = fsolve(residual, begin[places], xtol=1e-13)
    return model.observe(y[None])


@pytest.mark.parametrize("preload", [0.0, 0.4])
@pytest.mark.parametrize("down", [1.0, -1.0])
def test_a_follower_at_rest_leans_on_one_roller(down: float, preload: float) -> None:
    """Moments about P give the force, the roller's stiffness the gap, the cantilever's formulas the bend. Found: 2e-8 of each."""
    minus, plus = 2e4, 7e4
    scene = held(
        run_24(
            gravity=(0.0, -down * WEIGHT),
            tip=None,
            follower={"bending_stiffness": 600.0},
            slider=Slider(joint_stiffness_plus=plus, joint_stiffness_minus=minus, preload=preload),
        )
    )
    found = {name: float(values[0]) for name, values in at_rest(model_of(scene)).items()}
    L, EI, s = scene.follower.length, scene.follower.bending_stiffness, scene.pivot_distance + scene.crank.length
    load = scene.follower.mass_per_length * WEIGHT * down  # along the normal of a follower that points against n1
    force = -load * L**2 / (2.0 * s)
    pushes, other = (plus, minus) if force > 0.0 else (minus, plus)
    gap = force / (plus + minus)
    if preload <= other * abs(gap):  # the other one has let go
        gap = (force - math.copysign(preload, force)) / pushes
    assert found["slider_force"] == pytest.approx(force, rel=1e-6)
    assert found["constraint_gap"] == pytest.approx(abs(gap), rel=1e-6)
    bend_at_slider = (force * s**3 / 3.0 + load * s**2 * (6.0 * L**2 - 4.0 * L * s + s**2) / 24.0) / EI
    tip = (force * s**2 * (3.0 * L - s) / 6.0 + load * L**4 / 8.0) / EI
    assert found["tip_deflection"] == pytest.approx(tip, rel=1e-6)
    assert found["follower_angle"] - math.pi == pytest.approx(-(bend_at_slider + gap) / s, rel=1e-6)
    stored = joint_energy(gap, plus, minus, -preload / plus, -preload / minus)
    # the energy is that of three modes, which bend a little less than the line that equilibrium makes: found 1.5e-4
    assert found["strain_energy"] == pytest.approx(stored + _bending_energy(load, force, s, L, EI), rel=5e-4)


def _bending_energy(load: float, force: float, s: float, L: float, EI: float) -> float:
    """Of the line that carries `load` per length and `force` at s, J: the integral of the moment's square."""
    x, dx = (np.arange(4000) + 0.5) * L / 4000, L / 4000
    moment = load * (L - x) ** 2 / 2.0 + np.where(x < s, force * (s - x), 0.0)
    return float(np.sum(moment**2) * dx / (2.0 * EI))


def restitution(cv: float) -> float:
    """Part of its speed with which a mass leaves a roller that it hits with `cv`, contact damping times speed (Hunt and Crossley).

    From v dv / (1 + c v) = -(k / m) x dx over the way in and out: c v (1 + e) = log((1 + c v) / (1 - c e v)).
    """
    return float(brentq(lambda e: cv * (1.0 + e) - math.log((1.0 + cv) / (1.0 - cv * e)), 1e-12, min(1.0, (1.0 - 1e-12) / cv)))


@pytest.mark.parametrize("cv", [0.01, 0.1, 0.6, 2.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_bead_leaves_a_stop_as_hunt_and_crossley_say(side: float, cv: float) -> None:
    """A mass on the crank tip's side of a follower that stands; the roller that it hits pushes it back."""
    mass, speed, loss, begin = 0.3, 0.5, cv / 0.5, 1e-3
    plus, minus = 4e4, 9e4
    stiffness = plus if side > 0.0 else minus

    def rate(_: float, y: Array) -> Array:
        return np.array([y[1], -joint_force(y[0], y[1], plus, minus, begin, begin, loss, 0.0) / mass])

    def leaves(t: float, y: Array) -> float:
        return float(side * y[0] - begin) if t > 0.0 else 1.0

    leaves.terminal, leaves.direction = True, -1.0  # type: ignore[attr-defined]
    run = solve_ivp(rate, (0.0, 1.0), [side * begin, side * speed], rtol=1e-11, atol=1e-14, max_step=1e-4, events=leaves)
    e, half = -side * float(run.y[1, -1]) / speed, math.pi * math.sqrt(mass / stiffness)
    assert e == pytest.approx(restitution(cv), abs=1e-8)
    if cv <= 0.1:
        assert e == pytest.approx(1.0 - 2.0 / 3.0 * cv, abs=cv**2)
        assert run.t[-1] == pytest.approx(half, rel=cv**2)  # what loss adds on the way out it takes off on the way in
    assert np.all(side * np.array([joint_force(gap, rate, plus, minus, begin, begin, loss, 0.0) for gap, rate in run.y.T]) >= 0.0)


@pytest.mark.parametrize("loss", [0.0, 0.5, 4.0])
def test_a_rigid_follower_rebounds_from_its_roller(loss: float) -> None:
    """A swinging arm across a clearance is a bead of mass I_P / s²; it hits one roller, crosses, and hits the other one."""
    stiffness, clearance, speed = {1.0: 3e4, -1.0: 8e4}, 1e-3, 0.2
    slider = Slider(joint_stiffness_plus=stiffness[1.0], joint_stiffness_minus=stiffness[-1.0], clearance=clearance, contact_damping=loss)
    scene = held(run_24(tip=None, follower={"bending_stiffness": math.inf, "damping": 0.0}, base={"damping": 0.0}, slider=slider))
    model, s = model_of(scene), scene.pivot_distance + scene.crank.length
    follower = scene.follower
    mass = (scene.base.inertia + follower.mass_per_length * follower.length**3 / 3.0) / s**2
    y = model.straight_state(math.pi, 0.0)
    y[4] = speed / s  # the base angle's rate: the tip of the crank comes to lie behind the line
    step, rows = 2e-5, 2500
    result = model.integrate(y, step, rows, 1e-11)
    assert result.status == REACHED_END
    columns = model.observe(result.states)
    force, closing = columns["slider_force"], columns["gap_rate"]
    touching = np.abs(force) > 0.0
    begins, ends = np.flatnonzero(~touching[:-1] & touching[1:]), np.flatnonzero(touching[:-1] & ~touching[1:])
    assert len(ends) >= 3
    sides = np.sign(force[begins + 1])
    assert np.all(sides[:-1] == -sides[1:])
    for begin, end, side in zip(begins, ends, sides, strict=False):
        before, after = abs(closing[begin]), abs(closing[end + 1])
        # the arc is longer than the chord by a millionth
        assert after / before == pytest.approx(restitution(loss * before) if loss else 1.0, abs=1e-5)
        lasts = (end - begin) * step
        half = math.pi * math.sqrt(mass / stiffness[float(side)])
        assert lasts == pytest.approx(half, abs=step + half * (loss * before) ** 2)


def test_friction_on_a_rigid_follower_and_in_its_pivot_is_what_the_drive_must_overcome() -> None:
    """Places, rates and accelerations of the rigid loop by hand; friction along the follower has no lever about its pivot."""
    speed, gravity = 13.0, complex(2.0, -9.81)
    slider = Slider(mass=0.2, friction=0.4, friction_force=1.5, friction_speed=0.3)
    scene = run_24(
        gravity=(gravity.real, gravity.imag),
        follower={"bending_stiffness": math.inf},
        base={"friction_torque": 0.3},
        crank={"drive": PrescribedSpeed(speed=speed)},
        slider=slider,
    )
    run = ReferenceEngine().prepare(scene, standard_start(scene), ReferenceSettings(tolerance=1e-10)).advance(0.4, 1e-3)
    f, tip, LA, d = scene.follower, scene.tip_body, scene.crank.length, scene.pivot_distance
    inertia = scene.base.inertia + f.mass_per_length * f.length**3 / 3.0 + tip.inertia + tip.mass * f.length**2
    first = f.mass_per_length * f.length**2 / 2.0 + tip.mass * f.length
    heat = []
    for row, q1 in enumerate(run["crank_angle"]):
        e1 = cmath.exp(1j * q1)
        place, velocity, acceleration = LA * e1 - d, 1j * LA * speed * e1, -LA * speed**2 * e1
        s, e = abs(place), place / abs(place)
        v, a = velocity / e, acceleration / e
        q2_rate = v.imag / s
        moment = inertia * (a.imag - 2.0 * v.real * q2_rate) / s + scene.base.damping * q2_rate + 0.3 * math.tanh(q2_rate / 0.1)
        normal = (moment - first * (gravity / e).imag) / s
        friction = (1.5 + 0.4 * abs(normal)) * math.tanh(v.real / 0.3)
        on_crank = -complex(friction, normal) * e
        weight = (scene.crank.mass * scene.crank.center_of_mass + slider.mass * LA) * gravity
        torque = -(1j * e1 * (LA * on_crank + weight).conjugate()).real
        assert run["slider_force"][row] == pytest.approx(normal, abs=1e-5)
        assert run["crank_torque"][row] == pytest.approx(torque, abs=1e-6)
        heat.append(friction * v.real + 0.3 * math.tanh(q2_rate / 0.1) * q2_rate + scene.base.damping * q2_rate**2)
    assert np.max(np.abs(run["slider_force"])) > 5.0  # N
    # the trapezoidal rule; friction of the pivot changes its sign within some rows
    np.testing.assert_allclose(np.gradient(run["dissipated_energy"], 1e-3)[5:-5], heat[5:-5], atol=0.02 * max(heat))


def test_a_linear_spring_is_two_equal_rollers() -> None:
    """To rounding: without clearance and contact damping; with preload it is one of twice the stiffness until a roller lets go."""
    spring, pair, pressed = (
        rollers(slider)
        for slider in (
            Slider(joint_stiffness=3e4, joint_damping=7.0),
            Slider(joint_stiffness_plus=3e4, joint_stiffness_minus=3e4, joint_damping=7.0),
            Slider(joint_stiffness=3e4, joint_damping=7.0, preload=12.0),
        )
    )
    assert spring == pair
    for gap, rate in ((2e-4, 0.3), (-3.9e-4, -0.1), (0.0, 0.2)):
        assert _force(spring, gap, rate) == pytest.approx(3e4 * gap + 7.0 * rate, rel=1e-14)
        assert _force(pressed, gap, rate) == pytest.approx(6e4 * gap + 7.0 * rate, rel=1e-12)
    assert _force(pressed, 5e-4, 0.0) == pytest.approx(12.0 + 3e4 * 5e-4, rel=1e-14)  # the minus roller has let go


def _force(law: Rollers, gap: float, rate: float) -> float:
    return joint_force(gap, rate, law.plus, law.minus, law.plus_from, law.minus_from, law.loss, law.damping)


def test_what_no_key_makes_soft_is_as_stiff_as_a_contact() -> None:
    assert rollers(Slider(joint_stiffness_minus=1e4)) == Rollers(plus=CONTACT_STIFFNESS, minus=1e4)
    with_clearance = rollers(Slider(clearance=2e-4))
    assert (with_clearance.plus, with_clearance.minus) == (CONTACT_STIFFNESS, CONTACT_STIFFNESS)
    assert (with_clearance.plus_from, with_clearance.minus_from) == (1e-4, 1e-4)
    preloaded = rollers(Slider(joint_stiffness_minus=1e4, preload=5.0))
    assert _force(preloaded, 0.0, 0.0) == 0.0
    assert (preloaded.plus_from, preloaded.minus_from) == (-5.0 / CONTACT_STIFFNESS, -5e-4)


#: Most of the turn of run 24: the slider is pressed against one roller, then against the other one.
_SHORT: Final = 0.3  # s


def _run(slider: Slider) -> Trajectory:
    scene = replace(run_24(follower={"material_damping": 1e-4}), slider=slider)
    engine, settings = ReferenceEngine(), ReferenceSettings(modes=3, tolerance=1e-9)
    return engine.prepare(scene, standard_start(scene), settings).advance(_SHORT, 1e-3)


def _apart(one: Trajectory, other: Trajectory) -> float:
    difference = one["tip_deflection"] - other["tip_deflection"]
    return float(np.sqrt(np.mean(difference**2)))


def test_stiff_rollers_that_differ_approach_the_rigid_joint_at_first_order() -> None:
    """Damped, so that the joint's own vibration, which a start without a force in the joint sets going, is over."""
    rigid = _run(Slider())
    far, near = (
        _apart(_run(Slider(joint_stiffness_plus=k, joint_stiffness_minus=3.0 * k, joint_damping=1e-3 * k)), rigid) for k in (5e4, 2e5)
    )
    assert far / near == pytest.approx(4.0, rel=0.02)


def test_a_small_clearance_is_nearly_none() -> None:
    """Half the clearance, half the difference; both rollers are soft enough for the blows to be resolved."""
    own = {"joint_stiffness_plus": 5e4, "joint_stiffness_minus": 2e5, "joint_damping": 30.0}
    none = _run(Slider(**own))
    far, near = (_apart(_run(Slider(**own, clearance=clearance)), none) for clearance in (1e-6, 2.5e-7))
    assert far / near == pytest.approx(4.0, rel=0.1)
