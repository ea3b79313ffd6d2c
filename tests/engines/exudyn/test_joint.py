"""Exudyn's two joints of the slider, along ALE cables and sliding: two formulations that check each other."""

import itertools
import math

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.engines import accurate
from quickreturn.engines.base import Refusal
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import relative_error
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from tests.engines.energy import imbalance
from tests.engines.exudyn.runs import bent_start, simulate
from tests.engines.scenes import INCH, run_24
from tests.slices import Portion
from tests.verification.random_machines import sensible_machines
from tests.verification.random_scenes import OUTPUT_STEP

ENGINE = ExudynEngine()
SEED = 1999
RUNS = tuple(f"thesis-{number:02}" for number in range(1, 25))
MACHINES = 20
#: Runs and machines that a slice of the long tests computes.
DRAWN = 4


def disagreement(mechanism: Mechanism, duration: float) -> dict[str, float]:
    """Difference of the two joints over what both claim at the default accuracy, by column."""
    start = standard_start(mechanism)
    ale, sliding = (accurate.simulate(ENGINE, mechanism, start, duration, OUTPUT_STEP, {"joint": joint}) for joint in ("ale", "sliding"))
    assert (ale.settings["joint"], sliding.settings["joint"]) == ("ale", "sliding")
    found = {}
    for name in ESTIMATED:
        claims = ale.error_estimates[name], sliding.error_estimates[name]
        assert None not in claims, name
        assert np.any(ale.trajectory[name])
        found[name] = relative_error(sliding.trajectory[name], ale.trajectory[name]) / sum(claims)  # type: ignore[arg-type]
    return found


@pytest.mark.verify
def test_joints_agree_within_claims(portion: Portion) -> None:
    """The thesis' runs and twenty machines."""
    runs = [(name, load_case(name)) for name in RUNS]
    scenes = [(name, case.mechanism, case.duration) for name, case in runs]
    scenes += [(scene.name, scene.mechanism, scene.duration) for scene in itertools.islice(sensible_machines(SEED), MACHINES)]
    for name, mechanism, duration in portion(scenes, DRAWN):
        found = disagreement(mechanism, duration)
        assert max(found.values()) <= 1.0, (name, found)


@pytest.mark.parametrize("drawn", [False, True])
def test_the_joints_are_one_to_the_end_of_newtons_iteration(drawn) -> None:
    """The drawn machine's forces are 1e-8 N: in its own units of mass Exudyn's sliding joint drives it along the tangent: it runs away."""
    mechanism = next(itertools.islice(sensible_machines(SEED), 2, 3)).mechanism if drawn else run_24()
    ale, sliding = (simulate(mechanism, 0.1, elements=8, step=1e-3, joint=joint) for joint in ("ale", "sliding"))
    for name in ("crank_speed", "tip_deflection", "slider_force", "slider_position", "kinetic_energy"):
        assert relative_error(sliding[name], ale[name]) < 1e-4, name  # measured 2e-5 and less
    assert imbalance(sliding) == pytest.approx(imbalance(ale), rel=1e-2)


@pytest.mark.parametrize(
    "changes",
    [
        {"gravity": (1.0, -9.81), "tip": {"center_of_mass": 0.5 * INCH}, "slider": {"mass": 0.2}, "base": {"damping": 1e-2}},
        pytest.param({"crank": {"drive": PrescribedSpeed(speed=16.6)}, "follower": {"material_damping": 1e-4}}, marks=pytest.mark.verify),
    ],
)
def test_everything_else_works_with_a_sliding_joint(changes) -> None:
    mechanism = run_24(**changes)
    sliding, ale = (simulate(mechanism, 0.2, elements=12, step=1e-4, joint=joint) for joint in ("sliding", "ale"))
    assert sliding.columns.keys() == ale.columns.keys()
    for name in (
        "tip_deflection",
        "slider_force",
        "slider_position",
        "pivot_force_y",
        "crank_torque",
        "dissipated_energy",
        "moment_slider",
    ):
        assert relative_error(sliding[name], ale[name]) < 5e-5, name  # Newton's iteration leaves 2e-5 and less
    assert sliding["constraint_gap"].max() < 1e-7


def test_a_bent_start_is_taken_over_by_a_sliding_joint() -> None:
    sliding, ale = (simulate(run_24(), 0.02, bent_start(), elements=12, step=1e-4, joint=joint) for joint in ("sliding", "ale"))
    assert sliding["slider_position"][0] == pytest.approx(ale["slider_position"][0], abs=1e-6)
    assert relative_error(sliding["tip_deflection"], ale["tip_deflection"]) < 1e-3


@pytest.mark.parametrize(
    ("scene", "named"),
    [
        (run_24(slider={"joint_stiffness": 2e4}), "slider.joint_stiffness: 20000.0 N/m"),
        (run_24(slider={"clearance": 1e-4}), "slider.clearance"),
        (run_24(follower={"bending_stiffness": math.inf}), "follower.bending_stiffness: inf"),
        (load_case("spin-up").scene, "accepted: a scene with [crank]"),
    ],
)
def test_what_a_sliding_joint_cannot_do_is_refused_by_name(scene, named) -> None:
    settings = ExudynSettings(joint="sliding")
    for ask in (lambda: ENGINE.prepare(scene, None, settings), lambda: ENGINE.describe(scene, settings)):
        with pytest.raises(Refusal, match=r'is not modelled by engine exudyn with engine\.joint = "sliding"; accepted') as refused:
            ask()
        assert named in str(refused.value)
