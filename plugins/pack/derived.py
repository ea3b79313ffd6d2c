"""The problems described for `quickreturn.derive`, which derives their equations and integrates them."""

from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.polynomial import legendre

from quickreturn.derive import Beam, Model, Statics, System, turned, vector
from quickreturn.plugins.derive.statics import Rest
from quickreturn.plugins.pack.values import BEAD, BRIDGE, CRANK, DECAY, FOUR_BAR, HUB, PENDULUM, SAG, SPIN_UP, UNITS, Columns, G, times


def _system(name: str, values: Any, falls: bool = False) -> tuple[System, SimpleNamespace]:
    """A system, and as its constants `g` and the values of its problem that have a unit; gravity acts along -y if all `falls`."""
    system = System(name)
    given = {each: (getattr(values, each), unit) for each, unit in UNITS.items() if hasattr(values, each)}
    constants = system.constants(g=(G, "m/s^2"), **given)
    system.gravity = vector(0, -constants.g if falls else 0)
    return system, constants


def _strip(system: System, c: Any, shapes: int, origin: Any, angle: Any, damping: Any = 0.0) -> tuple[Beam, Any]:
    """An inextensible strip, `angle` being that of its tangent at its beginning, and its amplitudes: of Legendre polynomials along it."""
    eta = system.amplitudes("eta", shapes, "rad", size=0.01)

    def tangent(x: Any) -> Any:
        z = 2 * x / c.length - 1
        found = [1 + 0 * z, z]
        for k in range(1, shapes):
            found.append(((2 * k + 1) * z * found[k] - k * found[k - 1]) / (k + 1))
        return sum((eta[k] * (each + (-1) ** k) for k, each in enumerate(found[1:])), 0 * z)

    beam = Beam(
        system, "strip", origin=origin, angle=angle, edges=[0, c.length / 2, c.length], points=shapes + 3, tangent=tangent,
        mass_per_length=c.mass, bending_stiffness=c.bending, damping=damping,
    )  # fmt: skip
    return beam, eta


def _outputs(system: System, unit: str, **values: Any) -> None:
    for name, value in values.items():
        system.output(name, value, unit)


def _across(angle: Any, place: Any) -> Any:
    """The coordinate of a place across a line through the origin at an angle."""
    return ca.cos(angle) * place[1] - ca.sin(angle) * place[0]


def _moved(system: System, start: dict[str, float], duration: float, rows: int, tolerance: float = 1e-9) -> Columns:
    """The named outputs of the motion from a start."""
    frame = Model(system).simulate(start, duration, duration / rows, tolerance)
    return {"time": times(duration, rows)} | {name: frame[name].to_numpy() for name in system.outputs}


def sag(rows: int, shapes: int = 9) -> Columns:
    """Equilibria under growing parts of weight and tip force."""
    system, c = _system("sag", SAG)
    part = system.constants(part=(1.0, "1")).part
    beam, _ = _strip(system, c, shapes, vector(0, 0), 0.0)
    system.load("force", beam.end(), vector(0, -part * c.force))
    system.energy("weight", part * c.mass * ca.dot(beam.shares, beam.y) * c.g)
    _outputs(system, "m", tip_x=beam.end()[0], tip_y=beam.end()[1], middle_y=beam.end(0)[1])
    _outputs(system, "rad", tip_angle=beam.end_slope())
    model, rests = Model(system), list[Rest]()
    for each in times(1.0, rows):
        rests.append(Statics(model, parameters={"part": float(each)}).equilibrium(rests[-1] if rests else {}))
    return {"time": times(1.0, rows)} | {name: np.array([rest.outputs[name] for rest in rests]) for name in system.outputs}


def decay(rows: int, shapes: int = 8) -> Columns:
    """A small force on the tip from time 0 on; the deflection is exact, the damping that of Kelvin and Voigt and of the air."""
    system, c = _system("decay", DECAY)
    beam, eta = _strip(system, c, shapes, vector(0, 0), 0.0, c.damping)
    points, weights = legendre.leggauss(shapes + 3)
    slopes = np.array([legendre.legval(points, legendre.legder(np.eye(shapes + 1)[k + 1])) for k in range(shapes)]).T
    curvature = ca.DM(slopes) @ eta * 2 / c.length
    system.damper("material", curvature, c.material * c.bending * c.length / 2 * ca.DM(weights))
    system.load("force", beam.end(), vector(0, c.force))
    _outputs(system, "m", tip_deflection=beam.end()[1], middle_deflection=beam.end(0)[1])
    return _moved(system, {}, DECAY.duration, rows)


def bending_pendulum(rows: int, shapes: int = 10) -> Columns:
    """Pinned at its beginning; it hangs down and is pushed."""
    system, c = _system("bending pendulum", PENDULUM, falls=True)
    beam, _ = _strip(system, c, shapes, vector(0, 0), system.coordinate("angle", "rad"))
    middle, end = beam.end(0), beam.end()
    _outputs(system, "m", tip_x=end[0], tip_y=end[1], middle_x=middle[0], middle_y=middle[1])
    return _moved(system, {"angle": -np.pi / 2, "angle_rate": PENDULUM.rate}, PENDULUM.duration, rows)


def hub(rows: int, shapes: int = 8) -> Columns:
    """A torque of one sine on a hub that carries a strip."""
    system, c = _system("hub", HUB)
    angle, t = system.coordinate("angle", "rad"), system.time
    system.body("hub", inertia=c.inertia, angle=angle)
    end = _strip(system, c, shapes, turned(angle, c.radius), angle)[0].end()
    system.load("motor", angle, ca.if_else(t < c.period, c.torque * ca.sin(2 * ca.pi * t / c.period), 0 * c.torque))
    _outputs(system, "m", tip_x=end[0], tip_y=end[1], tip_deflection=_across(angle, end))
    _outputs(system, "rad", hub_angle=angle)
    return _moved(system, {}, HUB.duration, rows)


def moving_load(rows: int, shapes: int = 20) -> Columns:
    """A mass rolls along a beam, whose shapes are sines."""
    system, c = _system("moving load", BRIDGE)
    eta = system.amplitudes("eta", shapes, "m", size=1e-3)

    def deflection(x: Any) -> Any:
        return sum((eta[k] * ca.sin((k + 1) * ca.pi * x / c.length) for k in range(shapes)), 0 * x)

    beam = Beam(
        system, "bridge", origin=vector(0, 0), angle=0, edges=[0, c.length], points=2 * shapes + 4, deflection=deflection,
        foreshortening=False, mass_per_length=c.mass, bending_stiffness=c.bending,
    )  # fmt: skip
    contact = beam.place(c.velocity * system.time)
    system.body("load", c.load, contact)
    system.load("weight", contact, vector(0, -c.load * c.g))
    _outputs(system, "m", middle_y=deflection(c.length / 2), quarter_y=deflection(c.length / 4), load_y=contact[1])
    return _moved(system, {}, BRIDGE.duration, rows)


def bead(rows: int) -> Columns:
    """A bead on a rod that swings, held by a spring."""
    system, c = _system("bead", BEAD, falls=True)
    angle, r = system.coordinate("angle", "rad"), system.coordinate("r", "m", guess=0.5)
    system.body("rod", c.rod, turned(angle, c.length / 2), c.rod * c.length**2 / 12, angle)
    system.body("bead", c.bead, turned(angle, r))
    system.spring("spring", r - c.length / 2, c.stiffness)
    _outputs(system, "rad", rod_angle=angle)
    _outputs(system, "rad/s", rod_speed=system.rate(angle))
    _outputs(system, "m", bead_place=r)
    return _moved(system, {"r": BEAD.place}, BEAD.duration, rows, 1e-11)


def _begun(system: System, c: Any) -> Any:
    """The angle of what turns from rest to a steady speed within the time `ramp`."""
    t, period = system.time, c.ramp / (2 * ca.pi)
    beginning = c.speed / c.ramp * (t**2 / 2 + period**2 * (ca.cos(t / period) - 1))
    return ca.if_else(t < c.ramp, beginning, c.speed * (t - c.ramp / 2))


def spin_up(rows: int, shapes: int = 6) -> Columns:
    """A beam on a base that begins to turn."""
    system, c = _system("spin-up", SPIN_UP)
    angle = _begun(system, c)
    end = _strip(system, c, shapes, vector(0, 0), angle)[0].end()
    _outputs(system, "m", tip_x=end[0], tip_y=end[1], tip_deflection=_across(angle, end))
    return _moved(system, {}, SPIN_UP.duration, rows)


def slider_crank(rows: int, shapes: int = 8) -> Columns:
    """A rod that bends between a driven crank and a block."""
    system, c = _system("slider-crank", CRANK)
    rod, x = system.coordinate("rod", "rad"), system.coordinate("x", "m", guess=CRANK.length)
    beam, _ = _strip(system, c, shapes, turned(_begun(system, c), c.crank), rod)
    system.body("block", c.block, vector(x, 0))
    system.loop("pin", beam.end() - vector(x, 0), gives=[rod, x])
    chord, middle = beam.end() - beam.origin, beam.end(0)
    bow = _across(ca.atan2(chord[1], chord[0]), middle - beam.origin)
    _outputs(system, "m", block_x=x, middle_x=middle[0], middle_y=middle[1], bow=bow)
    return _moved(system, {}, CRANK.duration, rows)


def double_four_bar(rows: int) -> Columns:
    """Five equal rods. All arms have one angle: so the loops stay closed where all rods are in line, too."""
    system, c = _system("double four-bar", FOUR_BAR, falls=True)
    arm, inertia = system.coordinate("arm", "rad", guess=np.pi / 2), c.rod * c.length**2 / 12
    tip = turned(arm, c.length)
    for k in range(3):
        system.body(f"arm {k}", c.rod, vector(k * c.length, 0) + tip / 2, inertia, arm)
    for k in range(2):
        system.body(f"coupler {k}", c.rod, vector((k + 0.5) * c.length, 0) + tip)
    _outputs(system, "m", tip_x=tip[0], tip_y=tip[1])
    _outputs(system, "m/s", tip_vx=system.rate(tip[0]), tip_vy=system.rate(tip[1]))
    return _moved(system, {"arm": np.pi / 2, "arm_rate": FOUR_BAR.rate}, FOUR_BAR.duration, rows, 1e-12)
