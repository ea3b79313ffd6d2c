"""What the description of an FMU says of it: versions and kinds, instances, steps, types of parameters, units."""

import re
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.files.errors import CaseError
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal, Simulation
from quickreturn.engines.registry import engine, usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.conform.bench import Motion
from quickreturn.plugins.conform.scenes import ALONE as SCENE
from quickreturn.plugins.conform.scenes import BASE
from quickreturn.plugins.fmu.tests.build import CHAIN, MACHINE, Make, described


def begun(one: AnyEngine, step: float = 1e-3) -> Simulation:
    scene = qr.case("case.toml").scene
    return one.prepare(scene, standard_start(scene), one.settings_type(step=step))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("<CoSimulation", "<ModelExchange")], "machine.fmu is for model exchange; export it for co-simulation"),
        ([('fmiVersion="2.0"', 'fmiVersion="1.0" numberOfContinuousStates="0"')], "machine.fmu is of FMI 1.0; FMI 2 and 3 are accepted"),
    ],
)
def test_fmus_of_another_kind_or_version_are_refused_by_name(make: Make, changes: list[tuple[str, str]], words: str) -> None:
    described(*changes)
    with pytest.raises(Refusal, match=re.escape(f"engine my.toml is not available: {words}")):
        usable_engine(make())


def test_an_fmu_that_allows_one_instance_takes_turns(make_plain: Make) -> None:
    """A second simulation takes the only instance; the first goes on all the same, by its steps from the start on."""
    one = engine(make_plain(once=True))
    whole = begun(one).advance(0.2, 1e-3)
    first, second = begun(one), begun(one, 5e-4)
    pieces = [first.advance(0.1, 1e-3), second.advance(0.1, 1e-3), first.advance(0.1, 1e-3), second.advance(0.1, 1e-3)]
    for begin, end in (pieces[0::2], pieces[1::2]):
        assert np.array_equal(np.concatenate([begin["tip_x"], end["tip_x"][1:]]), whole["tip_x"])


def test_a_simulation_keeps_to_one_step_if_the_fmu_has_no_other(make_plain: Make) -> None:
    simulation = begun(engine(make_plain()))
    simulation.advance(0.01, 1e-3)
    words = "the FMU takes no step of 0.0005 s, but steps as long as the first, 0.001 s; choose the output step and engine.step"
    with pytest.raises(EngineFailure, match=re.escape(words)):
        simulation.advance(0.01, 5e-4)
    described(("<CoSimulation ", '<CoSimulation canHandleVariableCommunicationStepSize="true" '), fmu="plain.fmu")
    simulation = begun(engine("my.toml"))
    simulation.advance(0.01, 1e-3)
    with pytest.raises(EngineFailure, match="in the FMU, fmi2DoStep failed"):  # which says that it can, and cannot
        simulation.advance(0.01, 5e-4)


def test_steps_are_multiples_of_the_fixed_step_inside(make: Make) -> None:
    described(('modelIdentifier="Chain"', 'modelIdentifier="Chain" fixedInternalStepSize="0.0004"'), fmu="Chain.fmu")
    one = engine(make(CHAIN))
    assert len(Motion(SCENE, 0.004, 2e-3).by(one, one.settings_type(step=4e-4))) == 3
    words = (
        "the FMU takes no step of 0.001 s, but whole multiples of 0.0004 s; choose the output step and engine.step by what the FMU takes"
    )
    with pytest.raises(EngineFailure, match=re.escape(words)):
        Motion(SCENE, 0.004, 1e-3).by(one, one.settings_type(step=1e-3))


def test_the_step_that_an_fmu_suggests_is_the_default(make: Make) -> None:
    described(("<ModelVariables>", '<DefaultExperiment stepSize="0.002"/><ModelVariables>'))
    begin, end = MACHINE.index("[resolution]"), MACHINE.index("[parameters]")
    one = engine(make(MACHINE, (MACHINE[begin:end], "")))
    assert [settings.step for settings in one.ladder(BASE)] == [2e-3]


@pytest.mark.parametrize(
    ("attributes", "refused"),
    [
        ('causality="parameter" variability="fixed"', ""),
        ('causality="local" variability="tunable" initial="exact"', ""),
        ('causality="calculatedParameter" variability="fixed" initial="calculated"', "calculatedParameter, fixed"),
        ('causality="local" variability="constant" initial="exact"', "local, constant"),
    ],
)
def test_what_can_be_set_depends_on_causality_and_variability(make: Make, attributes: str, refused: str) -> None:
    described(('name="m1" valueReference="2" causality="parameter" variability="tunable"', f'name="m1" valueReference="2" {attributes}'))
    if not refused:
        assert len(begun(engine(make())).advance(2e-3, 1e-3)) == 3
        return
    words = f'my.toml: parameters.crank.mass: "m1" is {refused}, Real in the FMU; a single real number that is a'
    with pytest.raises(CaseError, match=re.escape(words)):
        engine(make())


def first_row(one: AnyEngine) -> Trajectory:
    return begun(one).advance(1e-3, 1e-3)


def test_parameters_of_every_type_are_set(make_plain: Make) -> None:
    """The FMU adds the number, 100 for the flag and 1000 for each letter to the acceleration, which is -1 at the start."""
    before = first_row(engine(make_plain()))["tip_acceleration"][0]
    path = make_plain(("mode = 0", 'mode = 0\ncount = 7\nflag = true\nlabel = "steel"\nunused = 2.5'))
    assert first_row(engine(path))["tip_acceleration"][0] - before == pytest.approx(5107.0)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("count = 7.5", "set.count: 7.5 cannot be set; write a whole number, for the FMU's type is Integer"),
        ("flag = 1", "set.flag: 1 cannot be set; write true or false, for the FMU's type is Boolean"),
        ("u = 1.0", 'set.u: "u" is output, continuous, Real in the FMU; a single value that is a parameter or an input'),
    ],
)
def test_a_parameter_takes_values_of_its_type(make_plain: Make, line: str, words: str) -> None:
    with pytest.raises(CaseError, match=re.escape(f"my.toml: {words}")):
        engine(make_plain(("mode = 0", line)))


def test_units_are_those_that_the_fmu_defines(make_plain: Make) -> None:
    """The FMU gives the deflection in thousandths of a metre by a unit that only its own definition explains."""
    row = begun(engine(make_plain())).advance(0.1, 1e-3)
    assert row["tip_deflection"] == pytest.approx(1e-3 * 0.6 * np.sin(row["crank_angle"]), abs=1e-12)
    described(('<BaseUnit m="1" factor="0.001"/>', '<BaseUnit kg="1"/>'), fmu="plain.fmu")
    words = 'outputs.tip_deflection: "u" has the unit "thou" in the FMU, which does not define it as a length; write the name of a variable'
    with pytest.raises(CaseError, match=re.escape(words)):
        engine("my.toml")
    described(('<BaseUnit kg="1"/>', '<BaseUnit m="1" factor="0.01"/>'), fmu="plain.fmu")
    assert begun(engine("my.toml")).advance(0.1, 1e-3)["tip_deflection"] == pytest.approx(10.0 * row["tip_deflection"])


def test_factor_unit_and_offset_of_a_column(make_plain: Make) -> None:
    """The offset is in the unit that stands before it, as in the mappings of tables."""
    plain = first_row(engine(make_plain()))["follower_angle"]
    in_degrees = np.radians(plain)
    for text, expected in (
        ("-q2 [deg] + 180", np.pi - in_degrees),
        ("q2 [deg] - 90", in_degrees - np.pi / 2.0),
        ("-2 * q2", -2.0 * plain),
        ("q2 - .5", plain - 0.5),
    ):
        one = engine(make_plain(('follower_angle = "q2"', f'follower_angle = "{text}"')))
        assert first_row(one)["follower_angle"] == pytest.approx(expected, rel=1e-12)
    with pytest.raises(CaseError, match=re.escape('outputs.follower_angle: "0 * q2" has the factor 0')):
        engine(make_plain(('follower_angle = "q2"', 'follower_angle = "0 * q2"')))


def test_an_fmu_is_unpacked_once_however_its_file_is_edited(make_plain: Make) -> None:
    first = engine(make_plain())
    second = engine(make_plain(("1.2 kg", "1.20 kg")))
    assert first.version() != second.version()
    assert first.fmu.digest == second.fmu.digest  # type: ignore[attr-defined]
    Path("plain.fmu").write_bytes(Path("plain.fmu").read_bytes() + b" ")
    third = engine("my.toml")
    assert third.version() != second.version()
    assert third.fmu.digest != second.fmu.digest  # type: ignore[attr-defined]
