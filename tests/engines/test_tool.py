"""A tool whose force is steady, tabled or turning with the follower, and whose slide rubs: closed forms, energy, engine against engine."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.optimize import fsolve

from quickreturn.cases.library import library_case
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import Refusal
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import FIXED, FOLLOWING, Tip, tip_force, tool_force
from tests.engines.energy import assert_agree, from_nowhere
from tests.engines.scenes import FOLLOWER_ALONE, run_24
from tests.strategies import tables

SHARED = ("fixed-shapes", "multiplier", "stiff-spring", "nodal-load")  # the equations of `reference` with other shapes
HAVING = ("reference", "exudyn", "mujoco", *SHARED)
ANGLES = np.radians([10.0, 60.0, 100.0, 170.0, 200.0, 260.0, 300.0, 345.0])
VALUES = np.array([[0.0, -1.0, -4.0, 2.0, 6.0, 3.0, -2.0, 1.0], [1.0, 3.0, 2.0, -2.0, -5.0, -1.0, 2.0, 0.5]])
TABLE = Table(FIXED, tuple(ANGLES), (tuple(VALUES[0]), tuple(VALUES[1])))
#: On 130 degrees of a turn, at whose ends the force comes and goes.
CUTTING: dict[str, Any] = {"force": (-5.0, 2.0), "force_from": np.radians(200.0), "force_to": np.radians(330.0)}
FORCES: dict[str, dict[str, Any]] = {
    "cutting": CUTTING,
    "always": {"force": CUTTING["force"]},
    "table": {"force_table": TABLE},
    "table that follows": {"force_table": replace(TABLE, names=FOLLOWING), "force_scale": -0.7},
    "following": {"force_following": (3.0, -2.0)},
}


def tabled(crank_angle: Array) -> Array:
    """The force of `TABLE` by scipy, N, along n1 + i n2."""
    turns = np.concatenate([ANGLES + turn * 2.0 * np.pi for turn in (-1, 0, 1)])
    first, second = PchipInterpolator(turns, np.tile(VALUES, 3), axis=1)(crank_angle % (2.0 * np.pi))
    return np.asarray(first + 1j * second)


@given(tables(5.0), st.floats(-7.0, 7.0))
@settings(max_examples=100, deadline=None)
def test_between_two_points_a_table_stays_between_their_values(table: Table, angle: float) -> None:
    """A product that is touched at 70 degrees does not pull before that, as under a spline. By scipy's `pchip` through three turns."""
    found = complex(tip_force(Tip(mass=1.0, inertia=0.0, force_table=replace(table, names=FIXED)), np.array(angle), 0.0))
    points = np.array(table.points)
    behind = points[0] + (angle - points[0]) % (2.0 * np.pi)
    at = int(np.searchsorted(points, behind, side="right")) - 1
    turns = np.concatenate([points + turn * 2.0 * np.pi for turn in (-1, 0, 1)])
    for values, force in zip(table.values, (found.real, found.imag), strict=True):
        ends = values[at], values[(at + 1) % len(values)]
        assert min(ends) - 1e-12 <= force <= max(ends) + 1e-12
        assert force == pytest.approx(float(PchipInterpolator(turns, np.tile(values, 3))(behind)), abs=1e-9)


def prescribed(mechanism: Mechanism, speed: float = 16.0) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=speed)))


def short(name: str, mechanism: Mechanism, duration: float = 0.4, **settings: Any) -> Trajectory:
    chosen = engine(name)
    picked = chosen.settings_for(1e-2, mechanism)
    return chosen.prepare(mechanism, standard_start(mechanism), picked.replaced(**settings)).advance(duration, 1e-3)


@pytest.mark.parametrize(
    ("name", "given"), [(name, given) for name in (*MAIN, *RIVALS) for given in FORCES if name in HAVING or "force" in FORCES[given]]
)
def test_on_a_rigid_follower_the_drive_gives_what_the_tool_takes(name: str, given: str) -> None:
    """By moments about P and a virtual turn of the crank: the tip moves by L dq2 across the follower, and s dq2 = LA cos(q1 - q2) dq1."""
    bare = prescribed(run_24(follower={"bending_stiffness": np.inf}))
    scenes = bare, replace(bare, tip=replace(bare.tip_body, **FORCES[given]))
    without, with_force = (short(name, scene) for scene in scenes)
    q1, q2, s = (with_force[column] for column in ("crank_angle", "follower_angle", "slider_position"))
    turned, steady = np.degrees(q1) % 360.0, complex(*CUTTING["force"]) * np.exp(-1j * q2)
    part = np.where((turned > 210.0) & (turned < 320.0), 1.0, np.where((turned < 200.0) | (turned > 330.0), 0.0, np.nan))
    across = {
        "cutting": (part * steady).imag,
        "always": steady.imag,
        "table": (tabled(q1) * np.exp(-1j * q2)).imag,
        "table that follows": -0.7 * tabled(q1).imag,
        "following": np.full_like(q1, -2.0),
    }[given]
    L, LA = bare.follower.length, bare.crank.length
    # a spring takes up a sudden load in some 10 ms, and lags behind one that comes and goes
    known = np.isfinite(across) & (with_force["time"] > (0.05 if name == "stiff-spring" else -1.0))
    tolerance = 2e-3 if name == "stiff-spring" else 1e-4  # of exudyn's steps; the others leave some 1e-9
    for column, expected in (("slider_force", -across * L / s), ("crank_torque", -across * L * LA * np.cos(q1 - q2) / s)):
        difference = with_force[column] - without[column]
        assert np.max(np.abs(difference - expected)[known]) < tolerance * np.max(np.abs(expected[known])), column


@pytest.mark.parametrize("name", HAVING)
def test_on_a_rigid_follower_the_drive_gives_what_the_slide_of_the_tool_loses(name: str) -> None:
    """The friction opposes the tip's velocity L dq2/dt; the drive gives its power and nothing else, whatever the sense of the crank."""
    bare = prescribed(run_24(follower={"bending_stiffness": np.inf}), -16.0)
    size, over = 4.0, 0.5
    rubbing = replace(bare, tip=replace(bare.tip_body, friction_force=size, friction_speed=over))
    without, with_friction = (short(name, scene) for scene in (bare, rubbing))
    q1, q2, s = (with_friction[column] for column in ("crank_angle", "follower_angle", "slider_position"))
    velocity = bare.follower.length * -16.0 * bare.crank.length * np.cos(q1 - q2) / s
    lost = size * np.tanh(velocity / over) * velocity
    assert lost.min() >= 0.0
    begun = with_friction["time"] > (0.05 if name == "stiff-spring" else -1.0)
    found = -16.0 * (with_friction["crank_torque"] - without["crank_torque"])
    tolerance = 1e-2 if name == "stiff-spring" else 1e-4
    assert np.max(np.abs(found - lost)[begun]) < tolerance * lost.max()
    loss = with_friction["dissipated_energy"] - without["dissipated_energy"]
    summed = CubicSpline(with_friction["time"], lost).antiderivative()(with_friction["time"])
    assert np.max(np.abs(loss - summed)) < 2e-3 * summed[-1]  # exudyn sums it by the trapezoidal rule over its steps
    assert np.max(np.abs(from_nowhere(with_friction))) < 2e-3 * summed[-1]


def deflected(mechanism: Mechanism, force: complex, follows: bool) -> tuple[float, float]:
    """Deflection (m) of the end and force of the slider (N) of the elastica that the tool bends, the crank held at 0 deg.

    From the end towards P: the angle of the tangent, the place, the moment. At the slider the force jumps along the normal. At P, which is
    a hinge, the moment vanishes and the line ends.
    """
    beam = mechanism.follower
    chord = mechanism.pivot_distance - mechanism.crank.length

    def shot(end_angle: float, s: float, across: float) -> tuple[Array, complex]:
        tool = force * np.exp(1j * end_angle) if follows else force
        state, acting, held = np.array([end_angle, 0.0, 0.0, 0.0]), tool, 0j
        for length in (beam.length - s, s):

            def rate(_x: float, y: Array, acting: complex = acting) -> list[float]:
                along = np.exp(1j * y[0])
                return [-y[3] / beam.bending_stiffness, -along.real, -along.imag, (along.conjugate() * acting).imag]

            state = solve_ivp(rate, (0.0, length), state, rtol=1e-11, atol=1e-13).y[:, -1]
            if held == 0.0:
                held = complex(state[1], state[2])
                acting = tool + 1j * across * np.exp(1j * state[0])
        return state, held - complex(state[1], state[2])

    def missed(unknown: Array) -> list[float]:
        state, slider = shot(*unknown)
        return [state[3], (slider + chord).real, (slider + chord).imag]

    end_angle, s, across = fsolve(missed, [np.pi, chord, -force.imag * beam.length / chord], xtol=1e-12)
    state, _ = shot(end_angle, s, across)
    to_end = -complex(state[1], state[2])
    return float((np.exp(-1j * state[0]) * to_end).imag), float(across)


@pytest.mark.parametrize("name", ["reference", "mujoco", pytest.param("exudyn", marks=pytest.mark.verify)])
@pytest.mark.parametrize(
    ("force", "follows"), [((8.0, 6.0), True), ((-8.0, 6.0), True), ((-8.0, -6.0), False)], ids=["pulled", "pushed", "fixed"]
)
def test_a_follower_that_is_held_bends_as_the_elastica(name: str, force: tuple[float, float], follows: bool) -> None:
    """By a twentieth of its length; a push along the end bends it by a fifth more than a pull."""
    key = "force_following" if follows else "force"
    scene = prescribed(run_24(tip={key: force}, follower={"damping": 3.0}, crank={"initial_angle": 0.0}), 1e-9)
    expected, across = deflected(scene, complex(*force), follows)
    assert abs(expected) > 0.03 * scene.follower.length
    settings = {"reference": {"modes": "5"}, "mujoco": {"links": "24"}, "exudyn": {"elements": "16"}}[name]
    chosen = engine(name)
    run = chosen.prepare(scene, standard_start(scene), chosen.settings_for(1e-2, scene).with_texts(settings)).advance(4.0, 2e-2)
    within = {"reference": 2e-4, "mujoco": 3e-3, "exudyn": 2e-3}[name]
    assert run["tip_deflection"][-1] == pytest.approx(expected, rel=within)
    assert run["slider_force"][-1] == pytest.approx(across, rel=within)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        *((name, given) for name in ("reference", "mujoco", *SHARED[1:2]) for given in FORCES),
        *(pytest.param("exudyn", given, marks=pytest.mark.verify) for given in FORCES),
        ("thesis", "cutting"),
    ],
)
def test_the_work_of_the_tool_and_the_loss_in_its_slide_are_accounted_for(name: str, given: str) -> None:
    """A force that turns with the end has no potential: its work depends on the way."""
    friction = {} if name == "thesis" else {"friction_force": 0.5, "friction_speed": 0.3}
    scene = run_24(tip={**FORCES[given], "force_scale": 0.3, **friction})
    # the error of mujoco's energy falls with the square of the step
    settings = {"step": 0.4} if name == "mujoco" else {"tolerance": 1e-7} if name in ("reference", *SHARED) else {}
    trajectory = short(name, scene, **settings)
    scale = float(np.ptp(trajectory["strain_energy"]))
    lost = {"exudyn": 2e-3, "mujoco": 1e-4}.get(name, 1e-5)  # exudyn's generalized-alpha method dissipates a little of its own
    assert np.ptp(from_nowhere(trajectory)) < lost * scale
    assert np.ptp(trajectory["drive_work"] - short(name, run_24(), **settings)["drive_work"]) > 0.1 * scale


SOFT = run_24(tip={**FORCES["table"], "force_scale": 0.2, "friction_force": 0.5, "friction_speed": 0.3})

CHIPS = library_case("shaper-chips").mechanism


@cache
def claimed(name: str, scene: Mechanism, accuracy: float | None = None) -> Result:
    return simulate(engine(name), scene, standard_start(scene), 0.7, 1e-3, None, accuracy)


@pytest.mark.parametrize(
    ("name", "scene", "accuracy"),
    [
        ("mujoco", run_24(tip={**CUTTING, "force_scale": 0.2}), None),
        *(
            pytest.param(*each, marks=pytest.mark.verify)
            for each in (("mujoco", CHIPS, None), ("exudyn", SOFT, 1e-2), ("derived", CHIPS, 1e-2))
        ),
    ],
)
def test_engines_agree_about_a_tool_within_what_they_claim(name: str, scene: Mechanism, accuracy: float | None) -> None:
    """The library's `shaper-chips`, over a turn; for exudyn, which takes minutes there as in every stiff shaper, run 24 with a tool."""
    if name == "derived":
        pytest.importorskip("casadi")
    assert_agree(claimed("reference", scene), claimed(name, scene, accuracy))


@pytest.mark.parametrize("name", ["thesis", "moving-boundaries", "mujoco-contact"])
@pytest.mark.parametrize(
    ("tip", "key"),
    [(FORCES["table"], "tip.force_table"), (FORCES["following"], "tip.force_following"), ({"friction_force": 1.0}, "tip.friction_force")],
)
def test_other_engines_refuse_it_by_name(name: str, tip: dict[str, Any], key: str) -> None:
    scene = run_24(tip=tip, follower={"damping": 0.0})
    scene = prescribed(scene) if name == "moving-boundaries" else scene
    with pytest.raises(Refusal, match=rf"{key}: .* is not modelled by engine {name}; accepted: "):
        engine(name).check(scene)


@pytest.mark.parametrize(
    ("tip", "told"),
    [
        ({"force_table": TABLE, "force": (1.0, 0.0)}, r"tip\.force_table conflicts with tip\.force;"),
        ({"force_table": TABLE, "force_ramp": 0.3}, r"tip\.force_table conflicts with tip\.force_ramp;"),
        ({"force": (1.0, 0.0), "force_following": (0.0, 1.0)}, r"tip\.force_following conflicts with tip\.force;"),
    ],
)
def test_forces_that_exclude_each_other_are_both_named(tip: dict[str, Any], told: str) -> None:
    with pytest.raises(ImpossibleMechanism, match=told):
        run_24(tip=tip)


def test_a_follower_alone_has_no_crank_to_wait_for() -> None:
    tip = replace(FOLLOWER_ALONE.tip_body, force=(1.0, 0.0))
    with pytest.raises(ImpossibleMechanism, match=r"tip\.force"):
        replace(FOLLOWER_ALONE, tip=tip)


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
