"""The description of a follower alone, and of the lines that a slider rides on beside the follower itself."""

import math

import casadi as ca

from quickreturn.derive import System, turned, vector
from quickreturn.plugins.derive.witness.description import UNITS, Follower, follower
from quickreturn.reference_model.mechanism import FollowerAlone
from quickreturn.reference_model.motion.layout import BeamTables


def follower_alone(scene: FollowerAlone, tables: BeamTables, shapes: int) -> tuple[System, Follower]:
    """The follower alone: its base turns as prescribed (DERIVATION.md, equation 11.1), and the points stay where they are."""
    system = System("follower alone")
    p = system.constants(**{name: (1.0, unit) for name, unit in UNITS.items()})
    system.gravity = vector(p.gravity_1, p.gravity_2)
    q2, s = system.coordinate("follower_angle", "rad", rate="follower_rate"), system.coordinate("slider_position", "m")
    arm = follower(system, p, q2, s, tables, shapes)
    speed, time, t = scene.spin_up.speed, scene.spin_up.time, system.time
    starting = speed / time * (t**2 / 2.0 + (time / (2.0 * math.pi)) ** 2 * (ca.cos(2.0 * math.pi * t / time) - 1.0))
    system.loop("base", q2 - ca.if_else(t < time, starting, speed * (t - time / 2.0)), "rad", gives=[q2])
    system.loop("place", s - tables.low, gives=[s])
    system.output("strain_energy", arm.strain, "J")
    absent = ("crank_angle", "crank_speed", "slider_force", "slider_moment", "crank_torque")
    vectors = ("slider_on_follower", "tool", "slide", "foot", "crank_force")
    for name in (*absent, *(f"{name}_{k}" for name in vectors for k in (0, 1))):
        system.output(name, 0.0, "1")
    return system, arm


def nodes(system: System, arm: Follower) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Places of the nodes of the slider's element, and the slider's share of its length."""
    beam, cell, s = arm.beam, arm.slider_cell, system.coordinates[2].q
    left = beam.end(cell - 1) if cell else ca.SX(beam.origin)
    advance = s - system.freeze(s)
    return left, beam.end(cell + 1), (beam.lengths[cell] + advance) / (beam.lengths[cell] + beam.lengths[cell + 1])


def chord_line(system: System, arm: Follower) -> tuple[ca.SX, ca.SX, ca.SX]:
    """The line from node to node."""
    left, right, share = nodes(system, arm)
    chord = right - left
    return left + share * chord, ca.atan2(chord[1], chord[0]), ca.SX(0)


def lever(system: System, arm: Follower, q: ca.SX) -> ca.SX:
    """What a unit of force along the normal does, sign reversed, if the nodes carry it by the lever rule; shares and normal held."""
    left, right, share = nodes(system, arm)
    crank_tip = turned(system.coordinates[0].q, system.parameters["crank_length"][0])
    way = ca.jacobian(crank_tip, q) - (1 - share) * ca.jacobian(left, q) - share * ca.jacobian(right, q)
    return turned(arm.angle, 0, 1).T @ way
