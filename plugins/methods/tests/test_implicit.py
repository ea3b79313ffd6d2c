"""The implicit integrator on the engines whose model is a beam: the explicit one's motion, within what the error estimate claims."""

from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import Engine
from quickreturn.engines.own.beam_engine import BeamSettings, compared_integration
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import as_texts
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import relative_error
from quickreturn.plugins.methods.rivals import fixed_shapes, multiplier, nodal_load, stiff_spring
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import run_24

CHANNELS = ("tip_deflection", "tip_acceleration", "strain_2", "slider_force")
REFERENCE = ReferenceEngine()
RUN_24 = run_24()
SOFT = run_24(follower={"bending_stiffness": RUN_24.follower.bending_stiffness / 10.0})
PLAY = run_24(slider=Slider(joint_stiffness=1e5, clearance=2e-4, contact_damping=0.5), follower={"material_damping": 1e-4})
RUBBING = run_24(slider=Slider(friction=0.3, friction_force=1.0))
HELD = replace(RUN_24, crank=replace(RUN_24.crank, drive=PrescribedSpeed(speed=16.6)))


@dataclass(frozen=True)
class _Run:
    engine: Engine
    settings: BeamSettings
    scene: Mechanism = RUN_24
    duration: float = 0.4
    limits: dict[str, float] = field(default_factory=dict)


RUNS = {
    "fixed-shapes": _Run(fixed_shapes.ENGINE, FixedShapesSettings(shapes=12, tolerance=3e-5)),
    "multiplier": _Run(multiplier.ENGINE, MultiplierSettings(shapes=12, tolerance=3e-5)),
    "stiff-spring": _Run(stiff_spring.ENGINE, StiffSpringSettings(shapes=6, tolerance=1e-5)),
    "consistent elements": _Run(nodal_load.ENGINE, NodalLoadSettings(elements=5, tolerance=3e-5, distribution="consistent")),
    "reference": _Run(REFERENCE, ReferenceSettings(modes=5, tolerance=1e-5)),
    "run 17": _Run(fixed_shapes.ENGINE, FixedShapesSettings(shapes=8, tolerance=1e-5), load_case("thesis-17").mechanism),
    "soft follower": _Run(REFERENCE, ReferenceSettings(modes=7, tolerance=1e-5), SOFT),
    "play": _Run(REFERENCE, ReferenceSettings(modes=5, tolerance=1e-6), PLAY, 0.25),
    "friction": _Run(REFERENCE, ReferenceSettings(modes=5, tolerance=1e-5), RUBBING),
    "hard shaper": _Run(REFERENCE, ReferenceSettings(modes=5, tolerance=1e-5), load_case("hard-shaper-aluminium").mechanism),
    "prescribed speed": _Run(fixed_shapes.ENGINE, FixedShapesSettings(shapes=8, tolerance=1e-5), HELD),
}


def made(run: _Run, **changes: Any) -> Any:
    settings = run.settings.replaced(**changes)
    return run.engine.prepare(run.scene, standard_start(run.scene), settings).advance(run.duration, 1e-3)


@pytest.mark.parametrize("name", RUNS)
def test_the_motion_is_the_explicit_ones_within_the_part_of_the_estimate(name: str) -> None:
    run = RUNS[name]
    explicit, implicit = made(run, tolerance=1e-9, integrator="explicit"), made(run, integrator="implicit")
    pair = compared_integration(run.settings.replaced(integrator="implicit"))[0]
    other = made(run, **pair.other.as_dict())
    for channel in CHANNELS:
        error = relative_error(implicit[channel], explicit[channel])
        assert error < relative_error(implicit[channel], other[channel]) / abs(pair.factor - 1.0), channel
        assert error < 2e-2, channel


@pytest.mark.parametrize("name", ["fixed-shapes", "multiplier", "stiff-spring", "consistent elements"])
def test_it_takes_fewer_right_hand_sides_where_shapes_are_fast(name: str) -> None:
    run = RUNS[name]
    explicit, implicit = (made(run, integrator=integrator) for integrator in ("explicit", "implicit"))
    calls = [each.statistics["right_hand_side_calls"] for each in (explicit, implicit)]
    assert calls[1] < 0.5 * calls[0]


def test_the_estimate_names_the_part_of_time() -> None:
    """And covers the error against `reference` with many modes."""
    settings = as_texts({"shapes": 8, "tolerance": 1e-4, "integrator": "implicit"})
    start = standard_start(RUN_24)
    result = simulate(fixed_shapes.ENGINE, RUN_24, start, 0.4, 1e-3, settings)
    exact = REFERENCE.prepare(RUN_24, start, ReferenceSettings(modes=12, tolerance=1e-9)).advance(0.4, 1e-3)
    assert {part.of for part in result.error_parts["tip"]} == {"modes", "time"}
    for channel in CHANNELS:
        estimate = result.error_estimates[channel]
        assert estimate is not None
        assert relative_error(result.trajectory[channel], exact[channel]) < estimate, channel


@pytest.mark.parametrize(("tolerance", "others"), [(1e-4, [1e-5, 1e-6]), (5e-11, [5e-12]), (1e-12, [1e-11])])
def test_the_estimate_compares_with_tolerances_that_are_allowed(tolerance: float, others: list[float]) -> None:
    settings = ReferenceSettings(tolerance=tolerance, integrator="implicit")
    pair = compared_integration(settings)[0]
    found = [pair.other, *([pair.before.other] if pair.before else [])]
    assert [each.as_dict()["tolerance"] for each in found] == pytest.approx(others)
    assert (pair.factor < 1.0) == (pair.other.as_dict()["tolerance"] < tolerance)
    assert not compared_integration(settings.replaced(integrator="explicit", tolerance=1e-8))


def test_a_loose_explicit_integration_is_in_the_estimate() -> None:
    """At 1e-3 the fast modes' acceleration is off by a tenth, and tighter tolerances leave none of that."""
    settings = FixedShapesSettings(shapes=12, tolerance=1e-3, integrator="explicit")
    parts = [pair for pair in fixed_shapes.ENGINE.comparisons(settings, RUN_24, 1e-3) if pair.of == "time"]
    run = _Run(fixed_shapes.ENGINE, settings)
    loose, other, exact = made(run), made(run, **parts[0].other.as_dict()), made(run, tolerance=1e-10)
    error = relative_error(loose["tip_acceleration"], exact["tip_acceleration"])
    assert 1e-3 < error < relative_error(loose["tip_acceleration"], other["tip_acceleration"]) / abs(parts[0].factor - 1.0)
    assert not [pair for pair in fixed_shapes.ENGINE.comparisons(settings.replaced(tolerance=1e-9), RUN_24, 1e-3) if pair.of == "time"]


def test_the_steady_cycle_is_the_explicit_ones() -> None:
    """Its period, its state and the largest multiplier, of `reference` with many modes, whose fast ones bound the last steps of a turn."""
    start = standard_start(RUN_24)
    settings = ReferenceSettings(modes=9, tolerance=1e-7)
    explicit, implicit = (
        REFERENCE.steady_state(RUN_24, start, settings.replaced(integrator=integrator)) for integrator in ("explicit", "implicit")
    )
    assert explicit is not None
    assert implicit is not None
    assert implicit.period == pytest.approx(explicit.period, rel=1e-6)
    assert abs(implicit.multipliers[0] - explicit.multipliers[0]) < 1e-3 * abs(explicit.multipliers[0])
    found, expected = (orbit.simulation.advance(orbit.period, orbit.period / 200) for orbit in (implicit, explicit))
    for channel in CHANNELS:
        assert relative_error(found[channel], expected[channel]) < 1e-3, channel
