"""Engines with the settings of these tests, and how far two trajectories may lie apart."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from quickreturn.engines.base import Engine, EngineFailure
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.own.thesis import ThesisEngine, ThesisSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.rivals import fixed_shapes
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.reference_model.arrays import Array
from tests.strategies import Scene

#: Local error of the integration in these tests, relative to fixed sizes of the states.
TOLERANCE = 1e-9
#: How far from each other two runs of the same motion may end, in tolerances: the local errors of some hundred steps add up, and a
#: disturbance grows a little. A tenfold to twentyfold was found between runs at this tolerance and at a hundredth of it.
STEPS_ADD_UP = 100.0


@dataclass(frozen=True)
class Method:
    """An engine with settings, and the number of half waves that its finest shape has along the follower."""

    engine: Engine
    settings: Settings
    half_waves: int

    def __str__(self) -> str:
        return self.engine.name

    def run(self, scene: Scene, rows: int | None = None) -> Trajectory:
        """The scene's trajectory, on an output grid of its own if asked."""
        simulation = self.engine.prepare(scene.mechanism, scene.start, self.settings)
        return simulation.advance(scene.duration, scene.duration / (rows or scene.rows))


REFERENCE = Method(ReferenceEngine(), ReferenceSettings(modes=3, tolerance=TOLERANCE), 4)
THESIS = Method(ThesisEngine(), ThesisSettings(tolerance=TOLERANCE), 2)
FIXED_SHAPES = Method(fixed_shapes.ENGINE, FixedShapesSettings(shapes=6, tolerance=TOLERANCE), 6)
EXPLICIT = (REFERENCE, THESIS, pytest.param(FIXED_SHAPES, marks=pytest.mark.verify))
COMPLIANT = Method(ReferenceEngine(), ReferenceSettings(modes=2, tolerance=TOLERANCE), 4)
EXUDYN = Method(ExudynEngine(), ExudynSettings(elements=8, step=1e-3, newton_tolerance=1e-5), 8)
MUJOCO = Method(MujocoEngine(), ChainSettings(links=8), 8)


def sizes(scene: Scene, trajectory: Trajectory, half_waves: int) -> dict[str, float]:
    """What a column changes by when the states are off by their sizes in `error_scales` of the models.

    A tenth of a radian of the crank moves places by a tenth of a length. A hundredth of the length in the highest shape, of wave
    number k, has the curvature 0.01 L k², the acceleration 0.01 L k⁴ EI / rhoA and the shear force 0.01 L EI k³.
    """
    m, L = scene.mechanism, scene.mechanism.follower.length
    k, EI = half_waves * np.pi / L, m.follower.bending_stiffness
    force = 0.01 * L * EI * k**3
    energy = energy_size(scene, trajectory, half_waves)
    return {
        "crank_angle": 0.1,
        "crank_speed": 0.1 * max(abs(m.crank.drive.initial_speed), 1.0),
        "follower_angle": 0.1,
        "slider_position": 0.1 * L,
        "tip_x": 0.1 * L,
        "tip_y": 0.1 * L,
        "tip_deflection": 0.1 * L,
        "tip_acceleration": 0.01 * L * k**4 * EI / m.follower.mass_per_length,
        **dict.fromkeys(("strain_1", "strain_2", "strain_3"), 0.01 * L * k**2 * m.follower.thickness / 2.0),
        "slider_force": force,
        "crank_torque": force * m.crank.length,
        **dict.fromkeys(ENERGIES, energy),
    }


def energy_size(scene: Scene, trajectory: Trajectory, half_waves: int) -> float:
    """What the energies change by with the states, J: a tenth of the crank's speed, a hundredth of the length in the highest shape."""
    L, EI = scene.mechanism.follower.length, scene.mechanism.follower.bending_stiffness
    follower, bent = _follower_energy(scene, trajectory), 0.5 * EI * (0.01 * L * (half_waves * np.pi / L) ** 2) ** 2 * L
    return 0.2 * float(np.max(_crank_energy(scene, trajectory))) + 2.0 * float(np.sqrt(follower * bent))


ENERGIES = ("kinetic_energy", "strain_energy", "gravity_energy", "dissipated_energy", "drive_work")


def _crank_energy(scene: Scene, trajectory: Trajectory) -> Array:
    crank, slider = scene.mechanism.crank, scene.mechanism.slider
    return 0.5 * (crank.inertia_about_pivot + slider.mass * crank.length**2) * trajectory["crank_speed"] ** 2


def _follower_energy(scene: Scene, trajectory: Trajectory) -> float:
    """Largest kinetic and strain energy of all but the crank, J."""
    return float(np.max(trajectory["kinetic_energy"] - _crank_energy(scene, trajectory) + trajectory["strain_energy"]))


def apart(found: dict[str, Array], expected: Trajectory, scene: Scene, method: Method) -> dict[str, float]:
    """Largest difference of each column in `sizes`."""
    unit = sizes(scene, expected, method.half_waves)
    return {name: float(np.max(np.abs(found[name] - expected[name]))) / unit[name] for name in unit if name in found}


def assert_close(found: dict[str, Array], expected: Trajectory, scene: Scene, method: Method, bound: float) -> None:
    """Every column agrees to `bound` of its size."""
    beyond = {name: distance for name, distance in apart(found, expected, scene, method).items() if not distance <= bound}
    assert not beyond, f"{method}: {', '.join(f'{name} {distance:.2g}' for name, distance in beyond.items())} beyond {bound:.2g}"


def both(one: Callable[[], Trajectory], other: Callable[[], Trajectory]) -> tuple[Trajectory, Trajectory] | None:
    """Two runs that should be alike; None where both break down, such as in iterations of steps that are too large for the scene."""
    try:
        first = one()
    except EngineFailure:
        with pytest.raises(EngineFailure):
            other()
        return None
    return first, other()
