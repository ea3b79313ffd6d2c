"""A force on the tip, in every engine: by closed forms with a rigid follower, by energy, and engine against engine."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.columns import BENDING, ENDS
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, PrescribedSpeed
from quickreturn.reference_model.tip_force import tool_force
from tests.engines.energy import from_nowhere
from tests.engines.scenes import run_24
from tests.engines.test_follower_alone import SCENE as ALONE

Array = NDArray[np.float64]

CUTTING = {"force": (-5.0, 2.0), "force_from": np.radians(200.0), "force_to": np.radians(330.0)}
ALWAYS = {"force": (-5.0, 2.0)}


def prescribed(mechanism: Mechanism) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=16.0)))


@cache
def run(name: str, mechanism: Mechanism, duration: float = 0.4, accuracy: float | None = None, **settings: str) -> Result:
    return simulate(engine(name), mechanism, standard_start(mechanism), duration, 1e-3, settings, accuracy)


def acting(crank_angle: Array) -> Array:
    """Share of the force of `CUTTING` where it does not come or go, else NaN."""
    turned = np.degrees(crank_angle) % 360.0
    inside, outside = (turned > 210.0) & (turned < 320.0), (turned < 200.0) | (turned > 330.0)
    return np.where(inside, 1.0, np.where(outside, 0.0, np.nan))


@pytest.mark.parametrize("name", [*MAIN, *RIVALS])
@pytest.mark.parametrize("tip", [CUTTING, ALWAYS], ids=["cutting", "always"])
def test_on_a_rigid_follower_slider_force_and_torque_follow_from_moments_and_virtual_work(name: str, tip: dict[str, object]) -> None:
    """The slider bears the force's moment about P; the drive gives what the force takes, by a virtual turn of the crank."""
    bare = prescribed(run_24(follower={"bending_stiffness": np.inf}))
    assert bare.tip is not None
    forced = replace(bare, tip=replace(bare.tip, **tip))  # type: ignore[arg-type]
    with_force, without = (run(name, scene).trajectory for scene in (forced, bare))
    q1, q2, s = (with_force[column] for column in ("crank_angle", "follower_angle", "slider_position"))
    L, LA, (F1, F2) = bare.follower.length, bare.crank.length, CUTTING["force"]  # type: ignore[misc]
    part = acting(q1) if tip is CUTTING else np.ones_like(q1)
    # a spring takes up a sudden load in some 10 ms, and lags behind one that comes and goes
    known = np.isfinite(part) & (with_force["time"] > (0.05 if name == "stiff-spring" else -1.0))
    tolerance = 2e-3 if name == "stiff-spring" else 1e-4  # exudyn's steps leave 5e-5, the others some 1e-9
    across = part * (np.cos(q2) * F2 - np.sin(q2) * F1)
    force = with_force["slider_force"] - without["slider_force"]
    torque = with_force["crank_torque"] - without["crank_torque"]
    assert np.max(np.abs(force + across * L / s)[known]) < tolerance * np.max(np.abs(across * L / s)[known])
    # the tip moves by L dq2 across the follower, and s dq2 = LA cos(q1 - q2) dq1
    expected = -across * L * LA * np.cos(q1 - q2) / s
    assert np.max(np.abs(torque - expected)[known]) < tolerance * np.max(np.abs(expected[known]))


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.verify] if name == "exudyn" else []) for name in MAIN])
def test_the_work_of_the_force_is_accounted_for(name: str) -> None:
    mechanism = run_24(tip={**CUTTING, "force": (-1.0, 0.5)})
    settings = {"step": "0.4"} if name == "mujoco" else {}  # its error of the energy falls with the square of the step
    trajectory = run(name, mechanism, **settings).trajectory
    plain = run("thesis" if name == "thesis" else "reference", run_24()).trajectory
    scale = float(np.ptp(trajectory["strain_energy"]))
    # exudyn's generalized-alpha method dissipates a little of its own, with and without the force
    lost = {"exudyn": 2e-3}.get(name, 1e-5)
    assert np.ptp(from_nowhere(trajectory)) < lost * scale
    assert np.ptp(trajectory["tip_deflection"] - plain["tip_deflection"]) > 0.1 * np.ptp(plain["tip_deflection"])


@pytest.mark.parametrize(("name", "accuracy"), [("mujoco", None), pytest.param("exudyn", 1e-2, marks=pytest.mark.verify)])
def test_engines_agree_about_a_force_within_what_they_claim(name: str, accuracy: float | None) -> None:
    mechanism = run_24(tip={**CUTTING, "force": (-1.0, 0.5)})
    ours, theirs = run("reference", mechanism), run(name, mechanism, accuracy=accuracy)
    for column, estimate in theirs.error_estimates.items():
        assert estimate is not None
        own = ours.error_estimates[column]
        assert own is not None
        difference = theirs.trajectory[column] - ours.trajectory[column]
        sizes = {each: np.sqrt(np.mean(ours.trajectory[each] ** 2)) for each in (BENDING if column in ENDS else [column])}
        size = max(sizes.values())
        assert np.sqrt(np.mean(difference**2)) <= (estimate + own) * size, column  # a constant torque is exact


def test_the_force_comes_and_goes_twice_continuously_differentiable() -> None:
    begin, span, ramp, h = 6.0, 1.2, 0.3, 1e-4
    angles = begin + np.arange(-0.2, span + 0.2, h)
    values = np.array([tool_force(angle - 4.0 * np.pi, 1.0, 0.0, begin, span, ramp, np.zeros((0, 9)))[0] for angle in angles])
    assert values.min() == 0.0
    assert values.max() == 1.0
    assert values[np.searchsorted(angles, begin + 0.5 * ramp)] == pytest.approx(0.5, abs=1e-3)
    # the second derivative is at most 10 / sqrt(3) / ramp^2, and changes by no more than its slope 60 / ramp^3 allows
    second = np.diff(values, 2) / h**2
    assert np.max(np.abs(second)) == pytest.approx(10.0 / np.sqrt(3.0) / ramp**2, rel=1e-3)
    assert np.max(np.abs(np.diff(second))) < 1.1 * 60.0 / ramp**3 * h
    np.testing.assert_allclose(values, values[::-1], atol=2e-3)


def test_a_follower_alone_has_no_crank_to_wait_for() -> None:
    assert ALONE.tip is not None
    with pytest.raises(ImpossibleMechanism, match=r"tip\.force"):
        FollowerAlone(
            spin_up=ALONE.spin_up, base=ALONE.base, follower=ALONE.follower, tip=replace(ALONE.tip, force=(1.0, 0.0)), gravity=ALONE.gravity
        )
