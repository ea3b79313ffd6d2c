"""Rivals with slowed modes: the added inertia by closed form, the balance of energy, what the slowing does, and its estimate."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from quickreturn.engines.base import Engine
from quickreturn.engines.own.beam_engine import BeamSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.plugins.methods.rivals import fixed_shapes, multiplier, nodal_load, stiff_spring
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.mechanism import Crank, PrescribedSpeed
from tests.engines.energy import from_nowhere
from tests.engines.scenes import run_24

CHANNELS = ("tip_deflection", "tip_acceleration", "strain_2", "slider_force")
DURATION, TOLERANCE = 0.3, 1e-7
METHODS = {
    "fixed-shapes": (fixed_shapes.ENGINE, FixedShapesSettings(shapes=8, tolerance=TOLERANCE, integrator="explicit", slowed_to=3)),
    "multiplier": (multiplier.ENGINE, MultiplierSettings(shapes=8, tolerance=TOLERANCE, integrator="explicit", slowed_to=3)),
    "stiff-spring": (
        stiff_spring.ENGINE,
        StiffSpringSettings(shapes=8, tolerance=TOLERANCE, integrator="explicit", slowed_to=3, joint_inertia=0.2),
    ),
    "nodal-load": (
        nodal_load.ENGINE,
        NodalLoadSettings(elements=6, tolerance=TOLERANCE, integrator="explicit", slowed_to=3, distribution="consistent"),
    ),
}
each_method = pytest.mark.parametrize(("chosen", "settings"), METHODS.values(), ids=METHODS)


def run(chosen: Engine, settings: BeamSettings) -> Trajectory:
    scene = run_24()
    return chosen.prepare(scene, standard_start(scene), settings).advance(DURATION, 1e-3)


def clamped_root(k: int) -> float:
    """The k-th root of cos z cosh z = -1: z^2 is in proportion to the frequency of a clamped-free beam."""
    return float(brentq(lambda z: math.cos(z) + 1.0 / math.cosh(z), (k - 1) * math.pi, k * math.pi, xtol=1e-14))


@pytest.mark.parametrize("slowed_to", [1, 3, 6])
def test_added_inertia_is_that_of_the_clamped_beams_frequencies(slowed_to: int) -> None:
    """Modes up to c keep their inertia, the others get (omega_k / omega_c)^2 - 1, by the characteristic equation of the beam."""
    model = fixed_shapes.ENGINE.model(run_24(), FixedShapesSettings(shapes=6, slowed_to=slowed_to))
    ratios = np.array([(clamped_root(k) / clamped_root(slowed_to)) ** 4 - 1.0 for k in range(1, 7)])
    np.testing.assert_allclose(model.parameters.added_inertia, np.maximum(ratios, 0.0), rtol=1e-6)


@each_method
def test_energy_balances_with_that_of_the_added_inertia(chosen: Engine, settings: BeamSettings) -> None:
    crank = Crank(length=run_24().crank.length, drive=PrescribedSpeed(speed=16.6), mass=1.0, center_of_mass=0.0)
    scene = replace(run_24(), crank=crank)
    trajectory = chosen.prepare(scene, standard_start(scene), settings).advance(DURATION, 1e-3)
    assert np.max(np.abs(from_nowhere(trajectory))) < 1e-4 * np.max(trajectory["strain_energy"] + trajectory["kinetic_energy"])


@each_method
def test_what_slowing_does_is_below_its_estimate_and_saves_right_hand_sides(chosen: Engine, settings: BeamSettings) -> None:
    """Against the same shapes as they are: the error is visible, and the comparison for it shows more."""
    slowed, plain = run(chosen, settings), run(chosen, settings.replaced(slowed_to=0))
    pair = next(pair for pair in chosen.comparisons(settings, run_24(), 1e-3) if pair.of == "slowing")
    other = run(chosen, pair.other)
    for channel in CHANNELS:
        error = relative_error(slowed[channel], plain[channel])
        assert 1e-4 < error < relative_error(slowed[channel], other[channel]) / abs(pair.factor - 1.0), channel
    if isinstance(settings, StiffSpringSettings):  # its spring is slowed, too
        plain = run(chosen, settings.replaced(slowed_to=0, joint_inertia=0.0))
    calls = [trajectory.statistics["right_hand_side_calls"] for trajectory in (slowed, plain)]
    assert calls[0] < 0.5 * calls[1]


def test_the_comparison_is_with_modes_at_most_half_as_stiff_and_absent_where_none_is_slowed() -> None:
    scene, settings = run_24(), FixedShapesSettings(shapes=24, integrator="explicit", tolerance=1e-9)
    for slowed_to in range(2, 24):
        pairs = fixed_shapes.ENGINE.comparisons(settings.replaced(slowed_to=slowed_to), scene, 1e-3)
        other = next(pair.other for pair in pairs if pair.of == "slowing").slowed_to
        assert (clamped_root(slowed_to) / clamped_root(other)) ** 4 > 1.9
    for slowed_to in (0, 24, 30):
        pairs = fixed_shapes.ENGINE.comparisons(settings.replaced(slowed_to=slowed_to), scene, 1e-3)
        assert {pair.of for pair in pairs} == {"modes"}


@pytest.mark.parametrize("inertia_over_stiffness", [0.0, 2e-7])
def test_inertia_beside_the_spring_keeps_its_error_of_first_order_in_the_compliance(inertia_over_stiffness: float) -> None:
    """With the inertia in proportion to the stiffness, as `comparisons` has it, the spring's error halves when the stiffness doubles."""
    settings = StiffSpringSettings(shapes=5, tolerance=1e-8)
    runs = []
    for k in (5e5, 1e6):
        spring = settings.replaced(stiffness=k, damping=3e-5 * k, joint_inertia=inertia_over_stiffness * k)
        runs.append(run(stiff_spring.ENGINE, spring))
    exact = run(multiplier.ENGINE, MultiplierSettings(shapes=5, tolerance=1e-8))
    errors = [relative_error(each["tip_deflection"], exact["tip_deflection"]) for each in runs]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    pair = next(p for p in stiff_spring.ENGINE.comparisons(settings.replaced(joint_inertia=0.2), run_24(), 1e-3) if p.of == "spring")
    assert pair.other.joint_inertia / pair.run.joint_inertia == pytest.approx(pair.other.stiffness / pair.run.stiffness)


@each_method
def test_finer_settings_slow_less_where_that_is_the_larger_part(chosen: Engine, settings: BeamSettings) -> None:
    of_shapes = "space" if chosen.name == "nodal-load" else "modes"
    scarce = chosen.finer(settings, {"slowing": 3.0, of_shapes: 0.1}, 1e-3)
    assert scarce == settings.replaced(slowed_to=6)  # the error falls 16-fold
    more = chosen.finer(settings, {"slowing": 0.1, of_shapes: 3.0}, 1e-3)
    assert more is not None
    assert more.slowed_to == settings.slowed_to
    assert more.shape_count > settings.shape_count
    both = chosen.finer(settings, {"slowing": 3.0, of_shapes: 3.0}, 1e-3)
    assert both is not None
    assert both.shape_count > settings.shape_count
    assert both.slowed_to == 6
