"""Estimates hold where coarser runs mislead: what each engine says of its error, against `reference` with nine modes."""

from functools import cache

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import run_24


@cache
def truth_of(scene: Mechanism, duration: float) -> Trajectory:
    """Good to 1e-4 at the very most in the scenes of this file."""
    settings = ReferenceSettings(modes=9, tolerance=1e-8)
    return run_once(ReferenceEngine(), scene, standard_start(scene), duration, 1e-3, settings).trajectory


def errors_over_claims(result: Result, truth: Trajectory) -> dict[str, float]:
    ratios = {}
    for column in ESTIMATED:
        claim = result.error_estimates[column]
        assert claim is not None, column
        error = np.sqrt(np.mean((result.trajectory[column] - truth[column]) ** 2) / np.mean(truth[column] ** 2))
        ratios[column] = float(error) / claim
    return ratios


def errors_over_claims_of(case: str, name: str, duration: float, settings: dict[str, str]) -> dict[str, float]:
    scene = load_case(case).mechanism
    result = simulate(engine(name), scene, standard_start(scene), duration, 1e-3, settings)
    return errors_over_claims(result, truth_of(scene, duration))


@pytest.mark.parametrize("links", ["8", "12"])
def test_chain_of_few_links_where_fewer_err_less(links: str) -> None:
    """Thesis' run 09 errs more with 8 links than with 6, so that neither says anything of the other's error."""
    ratios = errors_over_claims_of("thesis-09", "mujoco", 1.0, {"links": links})
    assert max(ratios.values()) < 1.0  # measured 0.66 and 0.23


@pytest.mark.verify
def test_chain_that_the_slider_shakes() -> None:
    """On its quick return an aluminium shaper's slider passes links at the rate of a natural frequency: 9 and 12 of them err alike."""
    scene = load_case("hard-shaper-aluminium").mechanism
    result = simulate(engine("mujoco"), scene, standard_start(scene), 0.7, 1e-3, {"links": "12"})
    ratios = errors_over_claims(result, truth_of(scene, 0.7))
    assert max(ratios.values()) < 1.5  # of the acceleration; 1.25 measured, 1.56 where an order of 2.4 is counted on


@pytest.mark.verify
def test_elements_that_the_slider_shakes() -> None:
    """In a slender arm 12 and 24 elements are shaken alike as the slider turns back; 18 are not."""
    follower = Follower(
        length=0.2706,
        mass_per_length=0.02556,
        bending_stiffness=0.0426,
        thickness=0.00283,
        width=0.00753,
        damping=0.01627,
        strain_gauges=(0.06765, 0.1353, 0.20295),
    )
    crank = Crank(length=0.05452, drive=PrescribedSpeed(speed=2.4266))
    scene = Mechanism(pivot_distance=0.14733, crank=crank, base=Base(inertia=4.32e-6), follower=follower)
    result = simulate(engine("exudyn"), scene, standard_start(scene), 1.5, 1e-3, {"elements": "24", "step": "2.5e-4"})
    ratios = errors_over_claims(result, truth_of(scene, 1.5))
    assert max(ratios.values()) < 1.0  # of the deflection 0.46 measured, 1.6 over two seconds without the 18


@pytest.mark.verify
def test_steps_too_large_for_a_violent_motion() -> None:
    """With steps twice as large as these the run does not get past 0.462 s; finer ones take their place."""
    ratios = errors_over_claims_of("hard-speed-x2", "exudyn", 0.6, {"step": "5e-4", "elements": "12"})
    assert max(ratios.values()) < 1.0


@pytest.mark.verify
def test_strain_while_the_slider_passes_the_gauge() -> None:
    """In thesis' run 20 the kink at the slider, rounded off by cubic elements, made 4.4e-3 of strain 3; its claim was 2.0e-3."""
    ratios = errors_over_claims_of("thesis-20", "exudyn", 0.3, {"step": "2.5e-4", "elements": "24"})
    assert ratios["strain_3"] < 1.0


@pytest.mark.parametrize("shapes", ["2", "8", *(pytest.param(shapes, marks=pytest.mark.verify) for shapes in ("6", "12"))])
def test_shapes_that_stay(shapes: str) -> None:
    """In thesis' run 17 8 shapes err less than 10, so that these two say nothing of each other's error."""
    ratios = errors_over_claims_of("thesis-17", "fixed-shapes", 0.5, {"shapes": shapes, "tolerance": "1e-9"})
    assert min(ratios.values()) > 0.05
    assert max(ratios.values()) < 1.0


@pytest.mark.verify
def test_elements_in_place_of_modes() -> None:
    ratios = errors_over_claims_of("thesis-17", "multiplier", 0.3, {"shapes": "12", "family": "hermite", "tolerance": "1e-9"})
    assert max(ratios.values()) < 1.0


@pytest.mark.parametrize(("shapes", "stiffness"), [("10", "3e4"), ("4", "1e6")])
def test_spring_and_shapes_are_shown_apart(shapes: str, stiffness: str) -> None:
    """A spring too soft and shapes too stiff err with opposite signs: whichever is the larger part, the claim covers it."""
    settings = {"shapes": shapes, "stiffness": stiffness, "damping": str(3e-5 * float(stiffness)), "tolerance": "1e-8"}
    ratios = errors_over_claims_of("thesis-24", "stiff-spring", 0.5, settings)
    assert min(ratios.values()) > 0.1
    assert max(ratios.values()) < 1.0


@pytest.mark.parametrize(
    "name", ["multiplier", *(pytest.param(name, marks=pytest.mark.verify) for name in ("fixed-shapes", "stiff-spring"))]
)
def test_fewer_shapes_do_where_the_follower_is_stiff(name: str) -> None:
    scene = load_case("hard-ei-x1000").mechanism
    result = simulate(engine(name), scene, standard_start(scene), 0.3, 1e-3, accuracy=1e-3)
    assert result.reached
    assert result.settings["shapes"] <= 3
    assert max(errors_over_claims(result, truth_of(scene, 0.3)).values()) < 1.0


def test_the_first_row_of_a_sudden_start_is_in_the_claim() -> None:
    """A spring that pulls at a light tip: at first the straight arm carries nothing, and the tip body alone is accelerated, by F / m.

    With four modes 31 % is lacking, with seven hardly less: the runs compared agree to 1 % of the RMS.
    """
    mass, anchor, stiffness, free = 0.05, np.array([-0.1, 0.6]), 20.0, 0.2
    spring = Spring(stiffness=stiffness, anchor=(float(anchor[0]), float(anchor[1])), free_length=free)
    scene = run_24(tip=Tip(mass=mass, inertia=2e-5), spring=spring, follower={"material_damping": 2e-3})
    found = simulate(engine("reference"), scene, standard_start(scene), 0.2, 1e-3)
    pull = anchor - np.array([scene.pivot_distance - scene.follower.length, 0.0])
    length = float(np.linalg.norm(pull))
    right = -stiffness * (length - free) * pull[1] / length / mass  # the arm points along -n1, its normal along -n2
    accelerations = found.trajectory["tip_acceleration"]
    error = abs(accelerations[0] - right) / np.sqrt(len(accelerations) * np.mean(accelerations**2))
    claim = found.error_estimates["tip_acceleration"]
    of_the_motion = sum(part.error for part in found.error_parts["tip_acceleration"] if part.of != "start")
    assert of_the_motion < error < claim < 5.0 * error
