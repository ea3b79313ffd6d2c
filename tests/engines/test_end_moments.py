"""The bending moments at base and tip, which each engine takes from accelerations of its own; and stress that does not see the rows."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from quickreturn.engines.accurate import simulate
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import engine, usable_engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Columns, relative_error
from quickreturn.reference_model.mechanism import Base
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import FOLLOWER_ALONE, run_24
from tests.witnesses import WITNESSES

#: Bodies at both ends that bend the arm there nearly as much as at the slider: in run 24 they ask for a thousandth of that.
HEAVY = run_24(
    base=Base(inertia=2e-2, damping=0.1),
    tip=Tip(mass=0.2, inertia=3e-3, center_of_mass=0.05),
    gravity=(1.0, -9.80665),
    follower={"damping": 0.5},
    crank={"mass": 40.0},
)
SETTINGS: dict[str, Settings] = {
    "reference": ReferenceSettings(modes=9, tolerance=1e-8),
    "mujoco": ChainSettings(links=48),
    "exudyn": ExudynSettings(elements=24, step=1e-4, axial_factor=4.0),
}


@cache
def columns(engine: str) -> Columns:
    return usable_engine(engine).prepare(HEAVY, standard_start(HEAVY), SETTINGS[engine]).advance(0.3, 5e-4).columns


@pytest.mark.parametrize("name", ["moment_base", "moment_tip", "follower_acceleration"])
@pytest.mark.parametrize("others", [("mujoco",), pytest.param(("mujoco", "exudyn"), marks=pytest.mark.verify)], ids="+".join)
def test_three_engines_ask_for_the_same_moments_at_the_ends(name: str, others: tuple[str, ...]) -> None:
    """`reference` sums the loads outboard, the others take the laws of the bodies, with angles of a cable's slopes and of links."""
    right, witness = columns("reference"), WITNESSES["column", name].largest
    assert name == "follower_acceleration" or np.max(np.abs(right[name])) > 0.1 * np.max(np.abs(right["moment_06"]))
    size = np.sqrt(np.mean(right[name] ** 2))
    apart = {each: float(np.sqrt(np.mean((columns(each)[name] - right[name]) ** 2)) / size) for each in others}
    assert max(apart.values()) < witness, apart
    if "exudyn" in others:
        assert max(apart.values()) > 0.2 * witness, f"the declared difference is out of date: {apart}"


@pytest.mark.parametrize("name", [pytest.param("exudyn", marks=pytest.mark.verify), "mujoco"])
@pytest.mark.parametrize("tip", [None, Tip(mass=0.06, inertia=4e-4, center_of_mass=-0.03)], ids=["free", "tip body"])
def test_gauges_at_the_ends_keep_their_claims(name: str, tip: Tip | None) -> None:
    """A gauge at 0.5 % from the free end of an arm without a tip body reads a ten-thousandth of the strain at the base.

    By the curvature of the nearest elements or hinges it was 23 % (`exudyn`) and 40 % (`mujoco`) off, at twice the claim.
    """
    length = FOLLOWER_ALONE.follower.length
    gauges = replace(FOLLOWER_ALONE.follower, strain_gauges=(0.01 * length, 0.5 * length, 0.995 * length))
    scene = replace(FOLLOWER_ALONE, follower=gauges, tip=tip, gravity=(0.0, 0.0))  # whose sudden start rings in all modes
    duration, step = 1.0, 0.01
    truth = simulate(
        engine("reference"), scene, standard_start(scene), duration, step, {"modes": "11", "tolerance": "1e-10"}, estimate=False
    ).trajectory
    found = simulate(engine(name), scene, standard_start(scene), duration, step)
    for column in ("strain_1", "strain_2", "strain_3"):
        claim = found.error_estimates[column]
        error = relative_error(found.trajectory[column], truth[column])
        assert error < 1.5 * claim < 0.05, f"{column}: claims {claim:.2g}, off by {error:.2g}"
