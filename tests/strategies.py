"""Random scenes and starts of moderate motion, for properties that hold whatever the numbers are.

Every scene is drawn relative to a beam of its own: lengths relative to the pivot's distance, masses and inertias relative to the beam's,
speeds relative to the beam's slowest bending, dampings relative to what damps within a few turns. The ranges hold the thesis' run 24
and keep the slider on the follower and the tip's deflection below some tenth of the length; each part that a scene may lack is
lacking in some.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from hypothesis import strategies as st

from quickreturn.engines.start import Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import FIXED, FOLLOWING, Tip

Drive = Literal["torque", "prescribed", "any"]


@dataclass(frozen=True)
class Bend:
    """Deflection of a cantilever loaded at its end: W = `tip` x² (3 L - x) / (2 L³)."""

    tip: float  # m, or m/s of a rate
    length: float  # m

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        xi = x / self.length
        shape = (xi**2 * (1.5 - 0.5 * xi), xi * (3.0 - 1.5 * xi), 3.0 - 3.0 * xi)[nu]
        return self.tip / self.length**nu * shape


@dataclass(frozen=True)
class Scene:
    """A mechanism, how its follower is bent at the start, and for how long it runs."""

    mechanism: Mechanism
    bend: float  # m, the tip's deflection at the start
    bend_rate: float  # m/s
    duration: float  # s
    rows: int  # output steps

    @property
    def start(self) -> Start:
        """Standard start, bent where the scene says so."""
        length, crank = self.mechanism.follower.length, self.mechanism.crank
        bends = [Bend(size, length) if size else None for size in (self.bend, self.bend_rate)]
        return Start(crank.initial_angle, crank.drive.initial_speed, *bends)

    @property
    def output_step(self) -> float:
        """Output step, s."""
        return self.duration / self.rows

    def with_part(self, **parts: object) -> Self:
        """The scene with parts of its mechanism replaced."""
        return replace(self, mechanism=replace(self.mechanism, **parts))  # type: ignore[arg-type]


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of six decimals in a range: an example that fails can be read."""
    return st.floats(low, high).map(lambda value: round(value, 6))


def perhaps(low: float, high: float) -> st.SearchStrategy[float]:
    """Zero or a number in a range."""
    return st.just(0.0) | numbers(low, high)


@st.composite
def scenes(
    draw: st.DrawFn,
    *,
    drive: Drive = "any",
    damped: bool = True,
    turning_slider: bool = False,
    compliant: bool = False,
    rollers: bool = False,
    tool: bool = False,
    bent: bool = True,
) -> Scene:
    """Scenes with a flexible follower.

    Some are damped, or none at all; some have a slider with rotary inertia (`turning_slider`), some begin `bent` and vibrating. `rollers`:
    two soft ones that differ, clearance or preload between them in some, friction in some, and a material that damps: without any,
    rattling makes trajectories part. `tool`: a table of forces on the tip, friction of its slide in some, and a spring with stops.
    """
    d = draw(numbers(0.2, 1.0))
    LA = d * draw(numbers(0.1, 0.35))
    L = (d + LA) * draw(numbers(1.1, 1.5))
    rhoA, EI = draw(numbers(0.1, 1.0)), draw(numbers(1.0, 20.0))
    beam, beam_inertia = rhoA * L, rhoA * L**3 / 3.0
    tip = draw(tips(beam, L, EI) if tool else st.none() | tips(beam, L, EI))
    heavy = 1.0 + 4.0 * (tip.mass if tip else 0.0) / beam
    slow = math.sqrt(EI / (rhoA * heavy)) / L**2  # rad/s, about a quarter of the cantilever's lowest angular frequency
    speed = slow * draw(numbers(0.5, 1.8)) * draw(st.sampled_from([1.0, -1.0]))
    slider = Slider(
        mass=beam * draw(perhaps(0.05, 0.5)),
        inertia=beam_inertia * draw(perhaps(1e-4, 1e-2)) if turning_slider else 0.0,
        joint_stiffness=EI / L**3 * draw(numbers(1e3, 1e4)) if compliant else math.inf,
        joint_damping=beam * slow * draw(_damping(damped)) if compliant else 0.0,
    )
    base_friction = material = 0.0
    if rollers:
        slider = replace(slider, **draw(joints(L, EI, beam * LA * speed**2, LA * abs(speed))))
        base_friction, material = beam_inertia * speed**2 * draw(perhaps(0.01, 0.1)), draw(numbers(1e-3, 1e-2)) / slow
    spring = None
    if tool and tip:
        force = 0.03 * EI / L**2
        slide = {"friction_force": force * draw(perhaps(0.1, 1.0)), "friction_speed": 0.1 * LA * abs(speed)}
        tip = replace(Tip(mass=tip.mass, inertia=tip.inertia, center_of_mass=tip.center_of_mass), force_table=draw(tables(force)), **slide)
        spring = draw(springs(d, L, EI, beam * slow))
    arm = LA * draw(numbers(0.0, 1.0))
    mass = beam * draw(numbers(1.0, 20.0))
    gravity = LA * speed**2 * draw(perhaps(0.02, 0.2))
    direction = draw(numbers(-math.pi, math.pi))
    return Scene(
        mechanism=Mechanism(
            pivot_distance=d,
            crank=Crank(
                length=LA,
                drive=draw(drives(speed, beam_inertia * heavy, drive, damped)),
                mass=mass,
                center_of_mass=arm,
                inertia=beam_inertia * heavy * draw(numbers(0.5, 5.0)),
                initial_angle=draw(numbers(-math.pi, math.pi)),
            ),
            base=Base(
                inertia=beam_inertia * draw(perhaps(1e-3, 0.1)),
                damping=beam_inertia * abs(speed) * draw(_damping(damped)),
                friction_torque=base_friction,
            ),
            follower=Follower(
                length=L,
                mass_per_length=rhoA,
                bending_stiffness=EI,
                thickness=L * draw(numbers(0.004, 0.006)),
                width=L * draw(numbers(0.05, 0.07)),
                damping=rhoA * slow * draw(_damping(damped)),
                material_damping=material,
                strain_gauges=(0.25 * L, 0.5 * L, 0.75 * L),
            ),
            tip=tip,
            slider=slider,
            spring=spring,
            gravity=(gravity * math.cos(direction), gravity * math.sin(direction)),
        ),
        bend=L * draw(_either_sign(0.002, 0.02)) if bent else 0.0,
        bend_rate=L * slow * draw(_either_sign(0.005, 0.05)) if bent else 0.0,
        duration=2.0 * math.pi / abs(speed) * draw(numbers(0.1, 0.4)),
        rows=draw(st.integers(8, 40)),
    )


@st.composite
def joints(draw: st.DrawFn, length: float, stiffness: float, force: float, speed: float) -> dict[str, float]:
    """Of a slider with two rollers beside a follower of a length (m) and EI (N m²), some `force` (N) and sliding `speed` (m/s)."""
    plus, minus = (stiffness / length**3 * draw(numbers(1e3, 1e4)) for _ in range(2))
    clearance = draw(perhaps(1e-4, 1e-3))
    return {
        "joint_stiffness_plus": plus,
        "joint_stiffness_minus": minus,
        "clearance": length * clearance,
        "preload": 0.0 if clearance else force * draw(perhaps(0.02, 0.5)),
        "contact_damping": draw(numbers(0.1, 1.0) if clearance else perhaps(0.1, 1.0)) / speed,
        "joint_damping": draw(perhaps(0.005, 0.05)) * force / speed,
        "friction": draw(perhaps(0.05, 0.5)),
        "friction_force": force * draw(perhaps(0.02, 0.2)),
        "friction_speed": 0.1 * speed,
    }


def tips(beam: float, length: float, stiffness: float) -> st.SearchStrategy[Tip]:
    """Bodies at the end of a follower of mass `beam` (kg), a length (m) and EI (N m²), some of them a mere point, some of them pushed."""

    def tip(share: float, gyration: float, offset: float, push: float, direction: float, begin: float, span: float) -> Tip:
        return Tip(
            mass=beam * share,
            inertia=beam * share * (gyration * length) ** 2,
            center_of_mass=offset * length,
            force=(push * stiffness / length**2 * math.cos(direction), push * stiffness / length**2 * math.sin(direction)),
            force_from=begin,
            force_to=begin + span,
            force_ramp=math.radians(25.0),
        )

    angles = numbers(-math.pi, math.pi)
    spans = numbers(1.5, 5.0) | st.just(2.0 * math.pi)
    return st.builds(tip, numbers(0.05, 0.5), perhaps(0.01, 0.05), perhaps(0.01, 0.04), perhaps(0.005, 0.03), angles, angles, spans)


@st.composite
def tables(draw: st.DrawFn, force: float) -> Table:
    """Tables of a force (N) over the crank's turn, in the fixed frame or turning with the follower's end."""
    begin, gaps = draw(numbers(-math.pi, math.pi)), draw(st.lists(numbers(0.5, 1.5), min_size=5, max_size=8))
    angles = begin + 2.0 * math.pi * np.cumsum([0.0, *gaps[:-1]]) / sum(gaps)
    values = st.lists(numbers(-1.0, 1.0).map(lambda share: share * force), min_size=len(gaps), max_size=len(gaps)).map(tuple)
    return Table(draw(st.sampled_from((FIXED, FOLLOWING))), tuple(map(float, angles)), (draw(values), draw(values)))


@st.composite
def springs(draw: st.DrawFn, distance: float, length: float, stiffness: float, damping: float) -> Spring:
    """Springs from a follower of a length (m) and EI (N m²), whose pivot is at a distance (m) from O, to a point beside its swing."""
    place = length * draw(numbers(0.4, 1.0))
    aside = draw(numbers(1.0, 1.8)) * draw(st.sampled_from([1.0, -1.0]))  # rad, from the direction of P to O
    away = length * draw(numbers(0.5, 1.0))
    anchor = distance - away * math.cos(aside), away * math.sin(aside)
    straight = math.hypot(distance - place - anchor[0], anchor[1])  # m, its length with the follower on the line OP
    stops = draw(st.booleans())
    return Spring(
        stiffness=stiffness / length**3 * draw(numbers(0.1, 3.0)),
        anchor=anchor,
        place=place,
        free_length=straight * draw(numbers(0.7, 1.1)),
        damping=damping * draw(perhaps(0.01, 0.1)),
        shortest=0.95 * straight if stops else None,
        longest=1.05 * straight if stops else None,
        stop_stiffness=3.0 * stiffness / length**3 if stops else 0.0,
        stop_ramp=0.1 * straight,
    )


@st.composite
def drives(draw: st.DrawFn, speed: float, inertia: float, kind: Drive, damped: bool) -> TorqueDrive | PrescribedSpeed:
    """Drives of a crank that begins at `speed` (rad/s) and moves some `inertia` (kg m²)."""
    if kind == "prescribed" or (kind == "any" and draw(st.booleans())):
        return PrescribedSpeed(speed=speed)
    # a torque that would change the speed by up to a fifth within a turn
    torque = inertia * speed**2 * draw(_either_sign(0.005, 0.03))
    return TorqueDrive(torque=torque, damping=inertia * abs(speed) * draw(_damping(damped)), initial_speed=speed)


def _damping(damped: bool) -> st.SearchStrategy[float]:
    return perhaps(0.01, 0.3) if damped else st.just(0.0)


def _either_sign(low: float, high: float) -> st.SearchStrategy[float]:
    return st.builds(lambda size, sign: size * sign, perhaps(low, high), st.sampled_from([1.0, -1.0]))
