"""First rung: natural frequencies, sag under gravity and the rigid limit of every engine against closed forms.

Tolerances are estimates made before anything is computed: what a discretization cannot bend into acts like a missing compliance under
the loads on the beam, and shifts a natural frequency by f R^2 / 2 omega^2 times that compliance (R: modal load; Rayleigh's principle).
"""

import dataclasses
import math
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.own.thesis import ThesisSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.slider import Slider
from tests.verification.ladder.overhung_beam import Mode, Sag, cubic_frequencies, cubic_sag, natural_modes, sag
from tests.verification.ladder.rigid_loop import RigidLoop, rigid_loop
from tests.verification.row import Row, smoothed

#: m/s^2: so little that the sag's square, which the linear theory leaves out, is 1e-6 of it.
WEIGHT: Final = 0.5
#: m, of the tip's centre of mass beyond the end, wherever the scenes here have a tip body.
OFFSET: Final = 0.0127
#: Of the sag: what is left of vibrations that the discretization starts.
LEFT: Final = 1e-4
SETTLING: Final = 40  # rows of 1 ms that are left out where accelerations of the start need to find themselves
STANDING: Final = 1e-6  # rad/s, of a crank as good as held: it turns by a millionth
SPEED: Final = 16.0  # rad/s, of the crank in the rigid limit


@dataclass(frozen=True)
class Climber:
    """An engine with settings, and what these are expected to leave."""

    name: str  # of the engine
    settings: Settings  # of it
    label: str  # what the tables call it
    frequency: Callable[[Mode, Follower], tuple[float, str]]  # relative error of a natural frequency, with the reason


def climbers(fineness: int = 1) -> Iterator[Climber]:
    """All engines; their discretizations are `fineness` times as fine as the coarse ones they have with 1."""
    shapes, elements, links = 12 * fineness, 12 * fineness, 24 * fineness
    yield Climber("reference", ReferenceSettings(modes=7, tolerance=1e-8), "reference", lambda *_: (1e-9, "converged shapes, rounding"))
    fixed = FixedShapesSettings(shapes=shapes, tolerance=1e-8)
    yield Climber("fixed-shapes", fixed, f"fixed-shapes, {shapes}", lambda *_: (1e-6, "refined until no frequency changes by more"))
    yield Climber("thesis", ThesisSettings(tolerance=1e-8), "thesis", lambda *_: (1e-9, "the same two cubics, rounding"))
    multiplier = MultiplierSettings(shapes=shapes, tolerance=1e-8)
    yield Climber("multiplier", multiplier, f"multiplier, {shapes} modes", lambda mode, beam: _clamped_free(mode, beam, shapes))
    nodal = NodalLoadSettings(elements=elements, distribution="consistent", tolerance=1e-7)
    yield Climber("nodal-load", nodal, f"nodal-load, {elements} elements", lambda mode, beam: _elements(mode, beam, elements, 1e-9))
    spring = StiffSpringSettings(shapes=shapes, stiffness=1e7, damping=300.0, tolerance=1e-7)
    yield Climber("stiff-spring", spring, f"stiff-spring, {shapes}", lambda mode, beam: _spring(mode, beam, shapes, spring.stiffness))
    cable = ExudynSettings(elements=elements, step=2.5e-4, newton_tolerance=1e-5)
    # stretching vibrations reach 1e6 rad/s: rounding is relative to their squares
    yield Climber("exudyn", cable, f"exudyn, {elements} elements", lambda mode, beam: _elements(mode, beam, elements, 1e-7))
    chain = ChainSettings(links=links)
    yield Climber("mujoco", chain, f"mujoco, {links} links", lambda mode, beam: _links(mode, beam, links))


def mode_rows(mechanism: Mechanism, scene: str, fineness: int, degrees: tuple[float, ...], count: int = 4) -> Iterator[Row]:
    """Frozen-crank frequencies against the roots of the transcendental determinant, the thesis' against Ritz' two cubics."""
    for angle in degrees:
        s = _slider_at(mechanism, math.radians(angle))
        modes = natural_modes(mechanism, s, count)
        for climber in climbers(fineness):
            found = engine(climber.name).natural_frequencies(mechanism, math.radians(angle), count, climber.settings)
            exact = cubic_frequencies(mechanism, s) if climber.name == "thesis" else np.array([mode.frequency for mode in modes])
            for number, (frequency, expected, mode) in enumerate(zip(found, exact, modes, strict=False), start=1):
                tolerance, reason = climber.frequency(mode, mechanism.follower)
                yield Row(
                    scene=f"{scene}, crank at {angle:g} deg", engine=climber.label, quantity=f"frequency {number}, Hz",
                    value=float(frequency), expected=float(expected), tolerance=tolerance, reason=reason,
                )  # fmt: skip


def sag_rows(mechanism: Mechanism, scene: str, degrees: tuple[float, ...], engines: Container[str] | None = None) -> Iterator[Row]:
    """The follower at rest under a small weight across it, the overhung beam of the textbooks; None: with all engines.

    Without `nodal-load`, whose explicit integration of stiff elements takes minutes here.
    """
    for angle in degrees:
        scene_at_rest = _resting(mechanism, math.radians(angle))
        s = _slider_at(mechanism, math.radians(angle))
        for climber in climbers():
            if climber.name == "nodal-load" or (engines is not None and climber.name not in engines):
                continue
            exact = cubic_sag(mechanism, s, WEIGHT) if climber.name == "thesis" else sag(mechanism, s, WEIGHT)
            last = _at_rest(climber, scene_at_rest, math.radians(angle), exact)
            yield from _sag_rows(f"{scene}, crank at {angle:g} deg", climber, last, exact, scene_at_rest)


def rigid_rows(mechanism: Mechanism, scene: str) -> Iterator[Row]:
    """A turn of the rigid mechanism, at a prescribed speed and driven by its torque: place, acceleration and forces."""
    rigid = dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, bending_stiffness=math.inf))
    prescribed = dataclasses.replace(rigid, crank=dataclasses.replace(rigid.crank, drive=PrescribedSpeed(speed=SPEED)))
    for kind, driven in (("prescribed speed", prescribed), ("driven", rigid)):
        for climber in climbers():
            found = engine(climber.name).prepare(driven, standard_start(driven), climber.settings).advance(0.4, 1e-3)
            yield from _rigid_rows(f"{scene}, rigid, {kind}", climber, found, driven)


def scene_of(mechanism: Mechanism) -> Mechanism:
    """With what the thesis leaves out, and what every engine can do: a tip body whose centre is offset, gravity, a slider with mass."""
    assert mechanism.tip is not None
    tip = dataclasses.replace(mechanism.tip, center_of_mass=OFFSET)
    return dataclasses.replace(mechanism, tip=tip, gravity=(2.0, -9.81), slider=Slider(mass=0.3))


def _slider_at(mechanism: Mechanism, angle: float) -> float:
    return abs(mechanism.crank.length * complex(math.cos(angle), math.sin(angle)) - mechanism.pivot_distance)


def _resting(mechanism: Mechanism, angle: float) -> Mechanism:
    """Crank as good as held, weight across the chord, damping that is critical for the first mode."""
    q2 = float(rigid_loop(mechanism, np.array(angle), 0.0).follower_angle)
    first = natural_modes(mechanism, _slider_at(mechanism, angle), 1)[0]
    beam = mechanism.follower
    damping = 2.0 * math.pi * first.frequency / first.bending
    return dataclasses.replace(
        mechanism,
        gravity=(-WEIGHT * math.sin(q2), WEIGHT * math.cos(q2)),
        crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=STANDING)),
        follower=dataclasses.replace(beam, damping=damping),
    )


def _at_rest(climber: Climber, mechanism: Mechanism, angle: float, exact: Sag) -> Trajectory:
    """Put where it should rest, it must stay there for ten times what the first mode takes to decay; the mean of the second half counts."""
    settings = climber.settings
    if not isinstance(settings, (ChainSettings, ExudynSettings)):  # relative to states of usual size, which a sag of 0.1 mm is not
        settings = settings.with_texts({"tolerance": "1e-10"})
    return engine(climber.name).prepare(mechanism, Start(angle, STANDING, exact.shape), settings).advance(0.2, 5e-4)


def _sag_rows(scene: str, climber: Climber, found: Trajectory, exact: Sag, mechanism: Mechanism) -> Iterator[Row]:
    mean = {name: float(smoothed(values, len(values) // 2)[-1]) for name, values in found.columns.items()}
    angle = mean["crank_angle"]
    loop, beam, s = rigid_loop(mechanism, np.array(angle), 0.0), mechanism.follower, _slider_at(mechanism, angle)
    tolerance, reason = max(climber.frequency(mode, beam) for mode in natural_modes(mechanism, s, 2))
    bent = 2.0 * tolerance + LEFT, f"twice that of a frequency ({reason}), and {LEFT:g} of vibration"
    balanced = LEFT, f"follows from equilibrium alone; {LEFT:g} of vibration"
    largest = float(np.abs(exact.shape(np.linspace(0.0, beam.length, 50))).max())
    strains = beam.extreme_fibre * exact.curvatures
    expected = {
        "tip_deflection": (exact.tip_deflection, largest, *bent),
        "follower_angle": (float(loop.follower_angle) + exact.turn, largest / s, *bent),
        "slider_force": (exact.slider_force, abs(exact.slider_force), *balanced),
        "crank_torque": (float(loop.torque), abs(exact.slider_force) * mechanism.crank.length, *balanced),
    }
    for number, (gauge, strain) in enumerate(zip(beam.strain_gauges, strains, strict=True), start=1):
        scale = float(np.abs(strains).max())
        estimate = balanced
        if isinstance(climber.settings, ExudynSettings) and abs(gauge - s) < 2.0 * beam.length / climber.settings.elements:
            kink = abs(exact.slider_force) * beam.length / climber.settings.elements / beam.bending_stiffness
            estimate = (
                kink / 8.0 * beam.extreme_fibre / scale + LEFT,
                "nodes of beam elements are exact; between them lacks the moment of a clamped beam under the slider force, F h/8 amid",
            )
        expected[f"strain_{number}"] = (float(strain), scale, *estimate)
    for name, (value, scale, tolerance, reason) in expected.items():
        yield Row(
            scene=scene, engine=climber.label, quantity=f"sag: {name}", value=mean[name], expected=value, scale=scale,
            tolerance=tolerance, reason=reason,
        )  # fmt: skip


def _rigid_rows(scene: str, climber: Climber, found: Trajectory, mechanism: Mechanism) -> Iterator[Row]:
    found = Trajectory({name: values[SETTLING:] for name, values in found.columns.items()}, 0.0)
    q1, speed, drive = found["crank_angle"], found["crank_speed"], mechanism.crank.drive
    acceleration = np.zeros_like(q1)
    if isinstance(drive, TorqueDrive):
        # the torque is linear in the acceleration
        still, moved = (rigid_loop(mechanism, q1, speed, a).torque for a in (0.0, 1.0))
        acceleration = (drive.torque - still) / (moved - still)
    exact = rigid_loop(mechanism, q1, speed, acceleration)
    tolerance, reason = _rigid_estimate(climber.settings, exact, mechanism)
    columns = {
        "slider_position": exact.slider_position,
        "follower_angle": exact.follower_angle,
        "tip_acceleration": mechanism.follower.length * exact.follower_acceleration,
        "slider_force": exact.slider_force,
    }
    if isinstance(drive, PrescribedSpeed):
        columns["crank_torque"] = exact.torque
    for name, expected in columns.items():
        worst = int(np.argmax(np.abs(found[name] - expected)))
        yield Row(
            scene=scene, engine=climber.name, quantity=f"{name}, worst of a turn", value=float(found[name][worst]),
            expected=float(expected[worst]), scale=float(np.sqrt(np.mean(expected**2))), tolerance=tolerance, reason=reason,
        )  # fmt: skip


def _rigid_estimate(settings: Settings, exact: RigidLoop, mechanism: Mechanism) -> tuple[float, str]:
    """Of the worst column; the motion contains harmonics of the crank's speed up to about the fifth."""
    fastest = 5.0 * SPEED
    if isinstance(settings, ExudynSettings):
        return (fastest * settings.step) ** 2, "generalized-alpha: (5 Omega h)^2"
    if isinstance(settings, StiffSpringSettings):
        carried = float(np.max(np.abs(exact.slider_force))) / float(np.max(np.abs(exact.slider_position * exact.follower_acceleration)))
        return 2.0 * fastest**2 * carried / settings.stiffness, "the spring gives way: (5 Omega)^2 m/k, to and fro"
    if isinstance(settings, (MultiplierSettings, NodalLoadSettings)):
        return settings.tolerance, "the gap is kept to the tolerance of the integration"
    return 1e-10, "loop closed exactly: rounding"


def _shift(mode: Mode, *loads_and_compliances: tuple[float, float]) -> float:
    """Relative shift of the frequency by missing compliances under modal loads; energies of several loads add at most like amplitudes."""
    omega = 2.0 * math.pi * mode.frequency
    return sum(abs(load) * math.sqrt(compliance / 2.0) / omega for load, compliance in loads_and_compliances) ** 2


def _elements(mode: Mode, beam: Follower, elements: int, rounding: float) -> tuple[float, str]:
    h = beam.length / elements
    within = _shift(mode, (mode.reaction, h**3 / (192.0 * beam.bending_stiffness)))
    return 1.1 * (within + (mode.wave_number * h) ** 4 / 1440.0) + rounding, "cubic elements, slider amid one at worst: h^3/192 EI"


def _clamped_free(mode: Mode, beam: Follower, shapes: int) -> tuple[float, str]:
    """The sums over modes beyond, of phi^2 / EI beta^4 with phi^2 = 2 amid the beam and 4 at its end, slopes there 4 beta^2."""
    L, EI, n = beam.length, beam.bending_stiffness, float(shapes)
    transverse = L**3 / (3.0 * math.pi**4 * n**3 * EI)
    loads = ((mode.reaction, 2.0 * transverse), (mode.tip_force, 4.0 * transverse), (mode.tip_moment, 4.0 * L / (math.pi**2 * n * EI)))
    return 1.1 * _shift(mode, *loads), "clamped-free modes: what those left out would give way under slider and tip body"


def _spring(mode: Mode, beam: Follower, shapes: int, stiffness: float) -> tuple[float, str]:
    softer = _shift(mode, (mode.reaction, 1.0 / stiffness))
    return _clamped_free(mode, beam, shapes)[0] + softer, "as with a multiplier, and the spring's own compliance"


def _links(mode: Mode, beam: Follower, links: int) -> tuple[float, str]:
    waves = mode.wave_number * beam.length / links
    return waves**2 / 100.0, "links: second order at the ends, (k h)^2/100 from 6 to 96 links"
