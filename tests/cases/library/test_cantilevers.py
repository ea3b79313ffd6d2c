"""The clamped rods of the library against closed forms: the elastica at rest, and the modes of a clamped beam that is let go."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import FollowerAlone
from quickreturn.reference_model.scene_values import changed

ENGINES = ["reference", pytest.param("exudyn", marks=pytest.mark.verify), pytest.param("mujoco", marks=pytest.mark.verify)]
#: Accuracy asked of an engine; its error may be three times as large (`conformance.bench.TOLERANCE_FACTOR`). Links take minutes for less.
ACCURACY = {"reference": 3e-3, "exudyn": 3e-3, "mujoco": 2e-2}
BOUND = {name: 3.0 * accuracy for name, accuracy in ACCURACY.items()}


def scene_of(name: str, **changes: Any) -> FollowerAlone:
    scene = changed(load_case(name).scene, {key.replace("__", "."): value for key, value in changes.items()})
    assert isinstance(scene, FollowerAlone)
    return scene


def run(name: str, of: str, scene: FollowerAlone) -> Result:
    case = load_case(of)
    return simulate(engine(name), scene, standard_start(scene), case.duration, case.output_step, accuracy=ACCURACY[name])


def elastica(scene: FollowerAlone) -> tuple[float, float]:
    """Place of the end at rest, m, by collocation: EI theta'' = -(w (L - s) + F) cos(theta), clamped at s = 0, no moment at s = L."""
    follower, gravity = scene.follower, scene.gravity[1]
    weight, force, L = follower.mass_per_length * gravity, scene.tip_body.mass * gravity, follower.length

    def slopes(s: Array, y: Array) -> Array:
        angle = y[0]
        return np.array([y[1], -(weight * (L - s) + force) * np.cos(angle) / follower.bending_stiffness, np.cos(angle), np.sin(angle)])

    def ends(a: Array, b: Array) -> Array:
        return np.array([a[0], b[1], a[2], a[3]])

    found = solve_bvp(slopes, ends, np.linspace(0.0, L, 41), np.zeros((4, 41)), tol=1e-10, max_nodes=20000)
    assert found.success
    return float(found.y[2, -1]), float(found.y[3, -1])


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("mass", [0.05, 0.0], ids=["force", "weight"])
def test_the_strip_comes_to_rest_on_the_elastica(name: str, mass: float) -> None:
    scene = scene_of("cantilever-sag", tip__mass=mass)
    table = run(name, "cantilever-sag", scene).trajectory
    x, y = elastica(scene)
    assert abs(table["tip_y"][-1] / y - 1.0) < BOUND[name]
    assert abs(table["tip_x"][-1] - x) < BOUND[name] * abs(y)
    assert np.ptp(table["tip_y"][-20:]) < 1e-4 * abs(y)  # what its damping leaves of the vibration


def test_small_deflections_of_the_strip_are_those_of_the_textbook() -> None:
    """Sag w L^4 / 8 EI + F L^3 / 3 EI and strain of the clamped end; the error of small deflections is the square of the sag over L."""
    scene = scene_of("cantilever-sag", **{"mechanism.gravity": (0.0, -0.5)})
    table, f = run("reference", "cantilever-sag", scene).trajectory, scene.follower
    weight, force = f.mass_per_length * 0.5, 0.05 * 0.5
    sag = weight * f.length**4 / (8.0 * f.bending_stiffness) + force * f.length**3 / (3.0 * f.bending_stiffness)
    assert sag / f.length < 0.02
    assert table["tip_deflection"][-1] == pytest.approx(-sag, rel=BOUND["reference"] + (sag / f.length) ** 2)
    arm = f.length - f.strain_gauges[0]
    moment = weight * arm**2 / 2.0 + force * arm
    strain = moment / f.bending_stiffness * 0.0004
    assert abs(table["strain_1"][-1]) == pytest.approx(strain, rel=BOUND["reference"] + (sag / f.length) ** 2)


def let_go(scene: FollowerAlone, time: Array) -> Array:
    """Deflection of the end, m, after a release from straight: each mode is an oscillator with its share of the sag.

    Modes of a clamped beam: 1 + cos b cosh b = 0 (Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1); the share of a mode
    in a uniform load and its value at the end are 4 s / b and 2 for unit mass, s = (sin b + sinh b) / (cos b + cosh b) to a sign.
    """
    f, total = scene.follower, np.zeros_like(time)
    unit = math.sqrt(f.bending_stiffness / f.mass_per_length) / f.length**2
    for n in range(1, 9):
        b = brentq(lambda b: math.cos(b) + 1.0 / math.cosh(b), (n - 0.9) * math.pi, n * math.pi, xtol=1e-14)
        omega = b**2 * unit
        shape = (math.cosh(b) + math.cos(b)) / (math.sinh(b) + math.sin(b))
        # phi(x) = cosh - cos - shape (sinh - sin): mean square 1, mean 2 shape / b, end 2 (-1)^(n+1)
        sag = scene.gravity[1] / omega**2 * 2.0 * shape / b * 2.0 * (-1.0) ** (n + 1)
        rate = 0.5 * (f.damping / f.mass_per_length + f.material_damping * omega**2)
        ring = np.emath.sqrt(rate**2 - omega**2)  # imaginary unless the mode only creeps
        slow, fast = -rate + ring, -rate - ring
        total += sag * (1.0 - (fast * np.exp(slow * time) - slow * np.exp(fast * time)) / (fast - slow)).real
    return total


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize(
    ("case", "dampings"),
    [
        ("cantilever-decay", {}),
        ("cantilever-decay", {"follower__material_damping": 2e-3}),
        ("cantilever-decay", {"follower__material_damping": 0.0, "follower__damping": 1.0}),
        ("cantilever-round", {}),
        ("cantilever-round", {"follower__damping": 0.0}),
    ],
)
def test_a_rod_that_is_let_go_vibrates_as_its_modes(name: str, case: str, dampings: dict[str, float]) -> None:
    """The tolerance adds the square of the deflection over the length, in phase: times the turns of the first mode, 2 pi f T."""
    scene = scene_of(case, **dampings)
    table = run(name, case, scene).trajectory
    right = let_go(scene, table["time"])
    finite = (np.max(np.abs(right)) / scene.follower.length) ** 2 * 2.0 * math.pi * 11.0 * load_case(case).duration
    error = math.sqrt(np.mean((table["tip_deflection"] - right) ** 2) / np.mean(right**2))
    assert error < BOUND[name] + finite


def test_the_round_rod_has_the_second_moment_of_a_circle() -> None:
    """Stiffness E pi d^4 / 64 and mass rho pi d^2 / 4; with that of the square d x d the vibration would be 1.303 times as fast."""
    f = load_case("cantilever-round").scene.follower
    assert f.bending_stiffness == pytest.approx(210e9 * math.pi * 0.004**4 / 64.0, rel=1e-12)
    assert f.mass_per_length == pytest.approx(7850.0 * math.pi * 0.004**2 / 4.0, rel=1e-12)
    square = changed(load_case("cantilever-round").scene, {"follower.bending_stiffness": 210e9 * 0.004**4 / 12.0})
    ratio = math.sqrt(square.follower.bending_stiffness / f.bending_stiffness)
    assert ratio == pytest.approx(math.sqrt(16.0 / (3.0 * math.pi)), rel=1e-12)
    assert isinstance(square, FollowerAlone)
    table = run("reference", "cantilever-round", square).trajectory
    right = let_go(scene_of("cantilever-round"), table["time"])
    assert np.max(np.abs(table["tip_deflection"] - right)) > 0.3 * np.max(np.abs(right))
