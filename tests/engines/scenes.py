"""Scenes built by hand from the thesis' numbers, so that engines can be tested without case files."""

import dataclasses
from typing import Any

from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, FollowerAlone, Mechanism, SpinUp, TorqueDrive
from quickreturn.reference_model.tip import Tip

INCH = 0.0254  # m
POUND_FORCE = 4.4482216152605  # N
POUND_MASS = POUND_FORCE / INCH  # kg, of lbf s²/in

#: A follower alone with everything on: tip body beyond the end, gravity, both dampings, inertia of the base.
FOLLOWER_ALONE = FollowerAlone(
    spin_up=SpinUp(speed=7.0, time=1.5),
    base=Base(inertia=0.02, damping=0.05),
    follower=Follower(
        length=0.8, mass_per_length=0.4, bending_stiffness=5.0, thickness=3e-3, width=4e-2, damping=0.3, strain_gauges=(0.2, 0.4, 0.6)
    ),
    tip=Tip(mass=0.06, inertia=4e-4, center_of_mass=0.03),
    gravity=(1.5, -9.0),
)


def run_24(**changes: Any) -> Mechanism:
    """Run 24 (crank 4 in, six plates, 16.6 rad/s), SI, with changes as of `with_parts`."""
    mechanism = Mechanism(
        pivot_distance=18.0 * INCH,
        crank=Crank(
            length=4.0 * INCH,
            drive=TorqueDrive(torque=10.0 * POUND_FORCE * INCH, damping=0.60176535 * POUND_FORCE * INCH, initial_speed=10.0 / 0.60176535),
            mass=0.1 * POUND_MASS,
            center_of_mass=3.0 * INCH,
            inertia=4.0e-4 * POUND_MASS * INCH**2,
        ),
        base=Base(inertia=1.5e-4 * POUND_MASS * INCH**2, damping=2e-5 * POUND_FORCE * INCH),
        follower=Follower(
            length=25.0 * INCH,
            mass_per_length=4.75987e-5 * POUND_MASS / INCH,
            bending_stiffness=2128.22 * POUND_FORCE * INCH**2,
            thickness=0.125 * INCH,
            width=1.5 * INCH,
            damping=2e-5 * POUND_FORCE / INCH**2,
            strain_gauges=(6.25 * INCH, 12.5 * INCH, 18.75 * INCH),
        ),
        tip=Tip(mass=2.90e-4 * POUND_MASS, inertia=1.96e-5 * POUND_MASS * INCH**2),
    )
    return with_parts(mechanism, **changes)


def with_parts(mechanism: Mechanism, **changes: Any) -> Mechanism:
    """A mechanism with changes of its parts.

    A change given as a dict replaces quantities within a part, anything else replaces the part:
    `with_parts(run_24(), follower={"damping": 0.0}, tip=None, gravity=(0.0, -9.81))`.
    """
    for part, change in changes.items():
        if isinstance(change, dict):
            change = dataclasses.replace(getattr(mechanism, part), **change)
        mechanism = dataclasses.replace(mechanism, **{part: change})
    return mechanism


def violent() -> Mechanism:
    """Crank tip 0.2 in from the follower's end at twice the speed: bending draws the end in."""
    drive = TorqueDrive(torque=10.0 * POUND_FORCE * INCH, damping=0.3 * POUND_FORCE * INCH, initial_speed=10.0 / 0.3)
    return run_24(crank={"length": 6.8 * INCH, "drive": drive}, tip=None)
