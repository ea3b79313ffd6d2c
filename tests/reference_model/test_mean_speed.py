"""The mean speed of a crank that a torque drives, beside the energy balance of mass points that are integrated turn after turn."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Base, Mechanism, TorqueDrive
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import run_24

#: Largest relative difference. Friction changes its sign within a part of the spacing of the angles, which moves the mean by up to 3e-6.
TOLERANCE = 1e-5
#: Turns after which a machine must repeat itself, and steps in a turn.
MOST_TURNS = 400
STEPS = 720

#: The crank begins at `initial_speed` far from the mean.
DRIVE = TorqueDrive(torque=2.4, damping=0.15, initial_speed=16.0)
WORKING = Tip(
    mass=0.25, inertia=1e-4, center_of_mass=0.02, force=(5.0, 12.0), force_from=1.4, force_to=4.5, force_ramp=0.4, friction_force=1.5
)
SPRING = Spring(stiffness=60.0, anchor=(0.6, 0.35), free_length=0.3, damping=3.0)


def machine(drive: TorqueDrive = DRIVE, **parts: Any) -> Mechanism:
    """The arm of run 24 in SI with a heavy crank, and the parts given."""
    plain = run_24(crank={"drive": drive, "mass": 2.0, "center_of_mass": 0.03, "inertia": 5e-3}, tip=None)
    return dataclasses.replace(plain, **parts)


MACHINES = {
    "plain": machine(),
    "pivot": machine(base=Base(damping=0.8, friction_torque=0.3)),
    "other way": machine(TorqueDrive(torque=-2.4, damping=0.15, initial_speed=-5.0), base=Base(damping=0.4)),
    "gravity": machine(gravity=(3.0, -9.0)),
    "tool": machine(tip=WORKING, gravity=(0.0, -9.81)),
    "spring": machine(spring=SPRING),
    "slider": machine(slider=Slider(mass=0.3, friction_force=3.0)),
    "no damping": machine(TorqueDrive(torque=0.6, damping=0.0, initial_speed=1.0), base=Base(damping=0.3)),
    "all": machine(base=Base(inertia=2e-4, damping=0.05), tip=WORKING, gravity=(3.0, -9.0), spring=SPRING, slider=Slider(mass=0.1)),
}


def marched(scene: Mechanism) -> float:
    """Mean speed of the last turn of the rigid machine, once turns repeat: d(kinetic energy)/dq1 = torque + loads - losses."""
    beam, tip, slider, crank, drive = scene.follower, scene.tip_body, scene.slider, scene.crank, scene.crank.drive
    way, h = math.copysign(1.0, drive.torque), 1e-3
    # angles at which the classical Runge-Kutta method asks: two in a step
    q1 = way * 2.0 * math.pi / (2 * STEPS) * np.arange(2 * STEPS + 1)

    def slope(function: Callable[[Array], Any]) -> Any:
        """Derivative by differences of fourth order."""
        return (function(q1 - 2 * h) - 8 * function(q1 - h) + 8 * function(q1 + h) - function(q1 + 2 * h)) / (12 * h)

    def arm(angle: Array) -> Any:
        """Unit vector from P to the slider, by the loop."""
        loop = scene.pivot_distance - crank.length * np.exp(1j * angle)
        return -loop / np.abs(loop)

    nodes, weights = np.polynomial.legendre.leggauss(3)
    on_arm = np.r_[0.5 * beam.length * (nodes + 1), beam.length + tip.center_of_mass]
    masses = np.r_[0.5 * beam.mass * weights, tip.mass]
    velocities = [slope(lambda angle, x=x: x * arm(angle)) for x in on_arm]
    velocities += [x * slope(lambda angle: np.exp(1j * angle)) for x in (crank.center_of_mass, crank.length)]
    masses, turning = np.r_[masses, crank.mass, slider.mass], (slope(arm) / arm(q1)).imag
    inertia = masses @ np.abs(velocities) ** 2 + crank.inertia + (scene.base.inertia + tip.inertia + slider.inertia) * turning**2
    load = drive.torque + masses @ np.real(np.array(velocities) * complex(*scene.gravity).conjugate())
    end = beam.length * slope(arm)
    if tip.is_forced:
        turned = q1 % (2.0 * math.pi)
        inside = np.clip(np.minimum(turned - tip.force_from, tip.force_to - turned) / tip.force_ramp, 0.0, 1.0)
        load = load + inside**3 * (10.0 - 15.0 * inside + 6.0 * inside**2) * (end * complex(*tip.force).conjugate()).real
    sliding = slope(lambda angle: np.abs(scene.pivot_distance - crank.length * np.exp(1j * angle)))
    viscous = drive.damping + scene.base.damping * turning**2
    if (spring := scene.spring) is not None:
        assert spring.free_length is not None

        def length(angle: Array) -> Array:
            return np.asarray(np.abs(complex(*spring.anchor) - scene.pivot_distance - beam.length * arm(angle)))

        load = load - spring.stiffness * (length(q1) - spring.free_length) * slope(length)
        viscous = viscous + spring.damping * slope(length) ** 2
    rubbing = (
        (scene.base.friction_torque, turning, scene.base.friction_rate),
        (slider.friction_force, sliding, slider.friction_speed),
        (tip.friction_force, np.abs(end), tip.friction_speed),
    )
    constants = [[float(each) for each in column] for column in (inertia, load, viscous)]
    frictions = [(size, by.tolist(), over) for size, by, over in rubbing if size > 0.0]

    def rates(at: int, energy: float) -> tuple[float, float]:
        of_inertia, of_load, of_damping = (column[at] for column in constants)
        speed = way * math.sqrt(2.0 * energy / of_inertia)
        lost = of_damping * speed + sum(size * by[at] * math.tanh(by[at] * speed / over) for size, by, over in frictions)
        return way * (of_load - lost), way / speed

    step = 2.0 * math.pi / STEPS
    energy = 0.5 * constants[0][0] * drive.initial_speed**2
    for _ in range(MOST_TURNS):
        begun, period = energy, 0.0
        for at in range(0, 2 * STEPS, 2):
            one, slow_1 = rates(at, energy)
            two, slow_2 = rates(at + 1, energy + 0.5 * step * one)
            three, slow_3 = rates(at + 1, energy + 0.5 * step * two)
            four, slow_4 = rates(at + 2, energy + step * three)
            energy += step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
            period += step / 6.0 * (slow_1 + 2.0 * slow_2 + 2.0 * slow_3 + slow_4)
        if abs(energy - begun) < 1e-9 * begun:
            return way * 2.0 * math.pi / period
    raise AssertionError("turns do not repeat")


@pytest.mark.parametrize("name", MACHINES)
def test_it_is_that_of_the_turns_that_repeat(name: str) -> None:
    assert mean_crank_speed(MACHINES[name]) == pytest.approx(marched(MACHINES[name]), rel=TOLERANCE)
