"""A machine built in another size moves alike: lengths, masses and times may be any multiples, in every engine.

MuJoCo takes an inertia of 1e-15 for none; an arm of 4 mm had strains 1.1 times, one of 6 mm 11,000 times their size off. Such thresholds
are in many libraries, and in rates such as 100 1/s and steps such as 1e-5 s that look harmless.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.mechanism import PrescribedSpeed
from tests.engines.scenes import run_24
from tests.properties.law import for_all
from tests.properties.runs import (
    COMPLIANT,
    EXUDYN,
    FIXED_SHAPES,
    MUJOCO,
    REFERENCE,
    STEPS_ADD_UP,
    THESIS,
    TOLERANCE,
    Method,
    assert_close,
    both,
)
from tests.properties.sizes import Size
from tests.strategies import Scene, scenes

#: Small, large, light, heavy, fast and slow machines.
SIZES = st.builds(
    lambda length, mass, time: Size(10.0**length, 10.0**mass, 10.0**time), st.floats(-3.0, 3.0), st.floats(-9.0, 9.0), st.floats(-3.0, 3.0)
)
#: In these nothing is rounded.
EXACT = (Size(length=2.0**-10), Size(length=2.0**10), Size(mass=2.0**-30), Size(time=2.0**-10), Size(time=2.0**5))
ALL = (*MAIN, *RIVALS, "derived")
#: Engines whose library would have absolute thresholds, but for the units in which they compute.
IN_UNITS = (MUJOCO, EXUDYN)


def within(method: Method) -> float:
    """Largest difference of two sizes, in sizes of the columns.

    Steps of the integrator in other numbers of the last digit: two runs of their own (see `STEPS_ADD_UP`). Exudyn moves its dampers at
    instants that depend on the unit of time, a power of two: 3e-5 were found; and Newton's iteration ends at 1e-5 of its first change.
    """
    return {"exudyn": 1e-4, "mujoco": 1e-7}.get(method.engine.name, STEPS_ADD_UP * TOLERANCE)


#: A blow's force is what the joint's stiffness, some thousand times the follower's, makes of the error of the gap.
BLOWS = 10.0
#: Blows also multiply what steps in other numbers leave: 8.6e-6 with a tolerance of 1e-9, 1.2e-7 with 1e-10, 1.8e-8 with this one.
RATTLING = replace(COMPLIANT, settings=COMPLIANT.settings.replaced(tolerance=1e-2 * TOLERANCE))


def check_motion(method: Method, scene: Scene, size: Size, times: float = 1.0) -> None:
    sized = replace(method, settings=size.settings(method.settings))
    if runs := both(lambda: method.run(scene), lambda: sized.run(size.random_scene(scene))):
        assert_close(size.back(runs[1].columns), runs[0], scene, method, times * within(method))


@pytest.mark.parametrize("method", [REFERENCE, THESIS, MUJOCO], ids=str)
@for_all(few=2, many=12, scene=scenes(), size=SIZES)
def test_a_machine_of_another_size_moves_alike(method: Method, scene: Scene, size: Size) -> None:
    check_motion(method, scene, size)


@pytest.mark.verify
@pytest.mark.parametrize("method", [FIXED_SHAPES, EXUDYN], ids=str)
@for_all(few=2, many=8, scene=scenes(), size=SIZES.filter(lambda size: size.time <= 50.0))
def test_a_machine_of_another_size_moves_alike_in_slower_engines(method: Method, scene: Scene, size: Size) -> None:
    check_motion(method, scene, size)


@pytest.mark.parametrize("method", [RATTLING, MUJOCO], ids=str)
@for_all(few=2, many=12, scene=scenes(rollers=True), size=SIZES)
def test_a_machine_of_another_size_rattles_and_rubs_alike(method: Method, scene: Scene, size: Size) -> None:
    check_motion(method, scene, size, BLOWS)


@pytest.mark.parametrize("size", EXACT, ids=str)
@pytest.mark.parametrize("method", IN_UNITS, ids=str)
def test_engines_that_compute_in_units_of_the_scene_give_the_same_bits(method: Method, size: Size) -> None:
    scene = Scene(run_24(gravity=(0.0, -9.81)), 0.0, 0.0, 0.01, 10)
    expected = method.run(scene)
    found = replace(method, settings=size.settings(method.settings)).run(size.random_scene(scene))
    for name, values in size.back(found.columns).items():
        assert np.array_equal(values, expected[name], equal_nan=True), name


def machine(name: str) -> Any:
    """Run 24, with a drive that the engine has."""
    return run_24(crank={"drive": PrescribedSpeed(speed=16.6)}) if name in ("moving-boundaries",) else run_24()


def of_engines(*quick: str) -> list[Any]:
    return [name if name in quick else pytest.param(name, marks=pytest.mark.verify) for name in ALL]


@pytest.mark.parametrize("name", of_engines(*ALL))
@for_all(few=2, many=20, size=SIZES)
def test_settings_fit_the_size(name: str, size: Size) -> None:
    """Those of springs are rounded to two digits, the expected ones too.

    Exudyn's step is in seconds, and at most the output step. So it depends on the size whether its steps are to be shortened, or the table
    extrapolated, for the energy's sake.
    """
    asked, scene = engine(name), machine(name)
    for accuracy in (asked.default_accuracy, 0.3 * asked.default_accuracy):
        chosen, found = asked.settings_for(accuracy, scene), asked.settings_for(accuracy, size.scene(scene))
        if name == "exudyn":
            chosen, found = (each.replaced(step=1e-3, extrapolated=False) for each in (chosen, found))
            assert found == chosen
        else:
            assert numbers(found) == pytest.approx(numbers(size.settings(chosen)), rel=0.11)


def numbers(settings: Settings) -> dict[str, float]:
    return {key: value for key, value in vars(settings).items() if isinstance(value, int | float)}


@pytest.mark.parametrize("name", of_engines(*(name for name in ALL if name != "derived")))
@for_all(few=1, many=6, size=SIZES)
def test_natural_frequencies_fit_the_size(name: str, size: Size) -> None:
    asked, scene = engine(name), machine(name)
    settings = asked.settings_for(asked.default_accuracy, scene)
    expected = asked.natural_frequencies(scene, 1.0, 3, settings)
    found = asked.natural_frequencies(size.scene(scene), 1.0, 3, size.settings(settings) if name != "exudyn" else settings)
    # round-off is relative to the stiffest: a spring of 1e7 N/m has left 2e-8 of the beam's
    np.testing.assert_allclose(found * size.time, expected, rtol=2e-7 if name == "stiff-spring" else 1e-8)


@pytest.mark.parametrize("name", of_engines("reference", "mujoco"))
@for_all(few=1, many=3, size=SIZES.filter(lambda size: size.time <= 50.0))
def test_claims_and_settings_that_reach_an_accuracy_fit_the_size(name: str, size: Size) -> None:
    """The same rungs are tried, and claim the same error.

    To 3 %, because two runs of a claim differ by other last digits; to 30 % where an error of the integration is all that is claimed. Where
    it is claimed beside others, each difference of two runs may contain it: steps of a loose tolerance fall elsewhere in another size.
    """
    asked, scene = engine(name), machine(name)
    expected, found = (
        simulate(asked, each, standard_start(each), 0.1 * time, 1e-3 * time, accuracy=asked.default_accuracy)
        for each, time in ((scene, 1.0), (size.scene(scene), size.time))
    )
    if name == "exudyn":  # its steps are in seconds
        assert found.error_estimate <= asked.default_accuracy
        return
    assert numbers(found.delivered) == pytest.approx(numbers(size.settings(expected.delivered)), rel=0.11)
    parts = expected.error_parts["tip"]
    in_time = 0.0 if asked.estimates == "integration" else sum(part.error for part in parts if part.of == "time")
    relative = 0.3 if asked.estimates == "integration" else 0.03
    unsure = relative * expected.error_estimate + in_time * sum(part.counted for part in parts)
    assert found.error_estimate == pytest.approx(expected.error_estimate, abs=unsure)
