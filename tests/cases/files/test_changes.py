"""Every way to give a machine another value leads to the same machine, and copies are what their file would describe."""

import itertools
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import PATHS, si_text, unit_given
from quickreturn.cases.files.reading import changes_of
from quickreturn.cases.files.units import DIMENSIONS
from quickreturn.cases.library import load_case, with_times
from quickreturn.cases.running.key import key_of
from quickreturn.engines.base import Refusal
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.plugins.studies.resonance_curve.curve import range_of
from quickreturn.plugins.studies.resonance_curve.search import checked_scenes, job
from quickreturn.plugins.studies.sweep.grid import OF_START, Grid, axis, scenes_of
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.uncertainty.calibration import Search, frees_of
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes
from quickreturn.plugins.studies.uncertainty.study import planned
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import values_of
from quickreturn.reference_model.slider import Slider
from tests.cases.files.scene_texts import SCENE, parse_case

_STIFFNESS, _MASS = 'bending_stiffness = "2128.22 lbf*in^2"', 'mass_per_length = "4.75987e-5 lbf*s^2/in^2"'
_RIGID_JOINT = SCENE.replace('joint_stiffness = "100 lbf/in"\njoint_damping = "0.1 lbf*s/in"\n', "")
_NO_START = _RIGID_JOINT.replace('initial_speed = "16.617773 rad/s"\n', "")
_OF_MATERIAL = _NO_START.replace(_STIFFNESS, 'elastic_modulus = "10.3e6 psi"').replace(_MASS, 'density = "2700 kg/m^3"')
_TORQUE = 'torque = "10 lbf*in"\ndamping = "0.60176535 lbf*in*s/rad"\n'
FILES = {
    "stiffness": _RIGID_JOINT,
    "material": _OF_MATERIAL,
    "prescribed speed": _OF_MATERIAL.replace(_TORQUE, 'prescribed_speed = "165 rpm"\n'),
}
#: Keys that can vary continuously, and values where the scene has none of which a part could be taken.
KEYS = [path for path, about in PATHS.items() if about.count is None and about.moves and path not in OF_START and "spin_up" not in path]
OTHER = {dimension.si_unit: other for dimension in DIMENSIONS.values() for other in dimension.examples if other != dimension.si_unit}
VALUES = {"crank.prescribed_speed": 11.0, "follower.elastic_modulus": 6.9e10, "follower.density": 2500.0}

#: Keys of lists, with values; the SI value of the second text is that of the first one.
LISTS = {
    "mechanism.gravity": (["0.254 m/s^2", "-9.8044 m/s^2"], ["10 in/s^2", "-386 in/s^2"]),
    "follower.strain_gauges": (["0.127 m", "0.254 m", "0.508 m"], ["5 in", "254 mm", "20 in"]),
    "tip.force": (["0 N", "4.4482216152605 N"], ["0 lbf", "1 lbf"]),
}


def by_file(text: str, key: str, value: str) -> Mechanism:
    return parse_case(text, "scene.toml", {key: value}).mechanism


def by_copy(case: Case, key: str, value: str) -> Mechanism:
    return case.with_({key: value}).mechanism


def by_written_copy(case: Case, key: str, value: str) -> Mechanism:
    return by_file(case.to_toml(), key, value)


def by_sweep(case: Case, key: str, value: str) -> Mechanism:
    (scene,) = scenes_of(case, [{key: axis(f"{key} = {value}").numbers[0]}])
    assert isinstance(scene, Mechanism)
    return scene


def by_resonance(case: Case, key: str, value: str) -> Mechanism:
    varied = range_of(key, f"{value} .. {si_text(key, 1.01 * _si(key, value))}", "range")
    return checked_scenes(case, varied, None, ())(varied.low)


def by_calibration(case: Case, key: str, value: str) -> Mechanism:
    ends = " .. ".join(si_text(key, factor * _si(key, value)) for factor in (0.5, 1.5))
    (free,) = frees_of([f"{key} = {ends}"], case)
    scenes: list[Mechanism] = []

    def simulated(scene: Mechanism, *_: object) -> np.ndarray:
        scenes.append(scene)
        return np.zeros((1, 1))

    model = SimpleNamespace(engine=ReferenceEngine(), simulated=simulated)
    search = Search(case, model, [SimpleNamespace(parameter=free.parameter, bounds=free.bounds, value=lambda _: _si(key, value))])  # type: ignore[arg-type, list-item]
    search.simulated(np.zeros(1), search.usual, 1)
    return scenes[0]


def by_uncertainty(case: Case, key: str, value: str) -> Mechanism:
    ends = " .. ".join(si_text(key, factor * _si(key, value)) for factor in (0.99, 1.01))
    points = planned(case, {key: f"uniform {ends}"}, MeasureRequest(measures=("multiplier",), engine="reference"), 8, "study.toml")
    points.inputs[0, 0] = _si(key, value)
    case_of_job, changes, _ = points.jobs[0].arguments
    (scene,) = scenes_of(case_of_job, changes[:1])
    assert isinstance(scene, Mechanism)
    return scene


WAYS = (by_copy, by_written_copy, by_sweep, by_resonance, by_calibration, by_uncertainty)


def _si(key: str, value: str) -> float:
    found = axis(f"{key} = {value}").values[0]
    assert isinstance(found, float)
    return found


def _value(case: Case, key: str, unit: str) -> str:
    """A value a little off the one of the case, in SI or in a unit of another system."""
    section, _, name = key.partition(".")
    present = case.values.get(section, {}).get(name, VALUES.get(key, PATHS[key].default))
    present = present if isinstance(present, float) and np.isfinite(present) and present else 0.3
    value = 0.97 * VALUES.get(key, present)
    if unit == "SI" or PATHS[key].unit == "1":
        return si_text(key, value)
    other = OTHER[PATHS[key].unit]
    return f"{value / unit_given(key, [f'1 {other}'])[1]:.9g} {other}"


#: The quick tests take either unit once.
QUICK = (("stiffness", "SI"), ("prescribed speed", "other"))


@pytest.mark.parametrize(
    ("name", "unit"),
    [pytest.param(*pair, marks=[] if pair in QUICK else pytest.mark.verify) for pair in itertools.product(FILES, ("SI", "other"))],
)
def test_every_way_to_change_a_value_gives_the_same_machine(name: str, unit: str) -> None:
    """For every key, in SI and other units: of a follower given by its stiffness or by its material, with a torque or a speed."""
    case = parse_case(FILES[name], "scene.toml")
    compared = dict.fromkeys((way.__name__ for way in WAYS), 0)
    for key in KEYS:
        value = _value(case, key, unit)
        try:
            expected = by_file(FILES[name], key, value)
        except CaseError:
            for way in WAYS:
                with pytest.raises((CaseError, AssertionError)):
                    way(case, key, value)
            continue
        for way in WAYS:
            try:
                scene = way(case, key, value)
            except Refusal:  # a resonance curve needs a joint that is rigid and frictionless
                assert way is by_resonance
                assert key.startswith("slider.")
                continue
            assert values_of(scene) == values_of(expected), (key, way)
            compared[way.__name__] += 1
    assert min(compared.values()) >= 20, compared


@pytest.mark.parametrize("key", LISTS)
@pytest.mark.parametrize("name", FILES)
def test_every_way_to_change_a_list_gives_the_same_machine(name: str, key: str) -> None:
    """A sweep takes it as a whole, a parameter is one number of it."""
    case, (in_si, in_other) = parse_case(FILES[name], "scene.toml"), LISTS[key]
    expected = parse_case(FILES[name], "scene.toml", {key: str(in_si).replace("'", '"')}).mechanism
    numbers = changes_of({key: in_other}, "test")[key]
    assert isinstance(numbers, tuple)
    parameters = {Parameter.of_key(f"{key}[{place}]", "test"): value for place, value in enumerate(numbers, start=1)}
    (swept,) = scenes_of(case, [{key: axis(f"{key} = {in_other!s}").numbers[0]}])
    for scene in (swept, case.with_({key: in_other}).mechanism, case.mechanism_with(changes(case.mechanism, parameters))):
        assert isinstance(scene, Mechanism)
        assert values_of(scene) == values_of(expected)


def test_a_mistake_in_a_change_shows_the_value_as_it_was_given() -> None:
    case = parse_case(FILES["material"], "scene.toml")
    (swept,) = scenes_of(case, [Grid(case, (axis("crank.length = 20.0 in"),)).changes((0,))])
    assert swept.sentence.startswith('crank.length: "20.0 in" cannot be: the slider leaves the follower')
    for changed, told in (
        ({"crank.length": 0.508}, 'scene: crank.length: "0.508 m" cannot be: the slider leaves the follower'),
        ({"tip.mass": -1e-3}, 'scene: tip.mass: "-0.001 kg" is negative; a mass of zero or more is accepted'),
        ({"tip.mass": 1e99}, 'scene: tip.mass: "1e+99 kg" is out of range; magnitudes from 1e-60 to 1e+60'),
        ({"tip.mass": math.inf}, 'scene: tip.mass: "inf" is out of range; magnitudes from 1e-60 to 1e+60'),
        ({"follower.bending_stiffness": 2.0, "follower.elastic_modulus": 1e9}, 'elastic_modulus: "1000000000 Pa" conflicts'),
        ({"crank.prescribed_speed": 0.1, "crank.damping": 1.0}, 'prescribed_speed: "0.1 rad/s" conflicts with crank.damping; give either'),
    ):
        with pytest.raises(CaseError, match=re.escape(told)):
            case.mechanism_with(changed)


def test_what_is_left_out_has_its_default() -> None:
    case = parse_case(FILES["stiffness"], "scene.toml")
    assert case.mechanism_with({"tip": None}).tip is None
    assert case.mechanism_with({"crank.initial_speed": None}).crank.drive.initial_speed == pytest.approx(16.617773, rel=1e-6)
    assert case.mechanism_with({"slider": None, "slider.mass": 0.5}).slider == Slider(mass=0.5)


def test_stored_curves_of_equal_scenes_differ_where_their_files_answer_a_change_differently() -> None:
    of_material = parse_case(FILES["material"], "scene.toml")
    of_numbers = replace(of_material, document=None)
    thickness, tip = (range_of(key, text, "range") for key, text in (("follower.thickness", "2 mm .. 3 mm"), ("tip.mass", "0 g .. 9 g")))
    assert key_of(job(of_material, tip)) == key_of(job(of_numbers, tip)) == key_of(job(replace(of_material, name="other"), tip))
    assert key_of(job(of_material, thickness)) != key_of(job(of_numbers, thickness))


@pytest.mark.parametrize("name", ["material", "prescribed speed"])
def test_stiffness_and_mass_follow_the_section_of_a_given_material(name: str) -> None:
    """EI = E w t³ / 12 and m = rho w t: half the thickness gives an eighth of EI and half of m."""
    case = parse_case(FILES[name], "scene.toml")
    whole, half = case.mechanism.follower, si_text("follower.thickness", 0.5 * case.mechanism.follower.thickness)
    for way in WAYS:
        follower = way(case, "follower.thickness", half).follower
        assert follower.bending_stiffness == pytest.approx(whole.bending_stiffness / 8.0, rel=1e-12)
        assert follower.mass_per_length == pytest.approx(whole.mass_per_length / 2.0, rel=1e-12)


def test_a_copy_tells_its_changes_in_name_and_title() -> None:
    run = load_case("thesis-24")
    copy = run.with_({"crank.length": "5 in"})
    assert (copy.name, copy.title) == ("thesis-24-crank.length-5-in", f"{run.title}, with crank.length = 5 in")
    assert copy.mechanism.crank.length == pytest.approx(0.127)
    assert copy.notes == run.notes
    assert run.name == "thesis-24"
    assert run.mechanism.crank.length == pytest.approx(0.1016)
    speeds = [run.with_({"crank.initial_speed": f"{speed} rpm"}) for speed in range(150, 160)]
    assert len({speed.name for speed in speeds}) == len({speed.title for speed in speeds}) == 10


def test_a_copy_is_what_the_file_with_these_values_describes() -> None:
    """Not what its numbers in SI would give: stiffness and mass follow from material and section, the start from the torque."""
    for name, values in (("shaper-cutting", {"follower.thickness": "30 mm"}), ("example", {"crank.torque": "2 N*m"})):
        assert load_case(name).with_(values).scene == load_case(name, values).scene
    text = SCENE.replace('initial_speed = "16.617773 rad/s"\n', "")
    whole = parse_case(text, "scene.toml")
    speeds = [case.values["crank"]["initial_speed"] for case in (whole, whole.with_({"crank.torque": "5 lbf*in"}))]
    assert speeds[1] == pytest.approx(0.5 * speeds[0])


def test_copies_of_copies_tell_what_holds_at_last() -> None:
    run = load_case("thesis-24")
    again = run.with_({"crank.length": "5 in"}).with_({"crank.length": "3 in"})
    assert (again.name, again.title) == ("thesis-24-crank.length-3-in", f"{run.title}, with crank.length = 3 in")
    driven = again.with_({"crank.damping": "1 N*m*s"}).with_({"crank.prescribed_speed": "90 rpm"})
    assert driven.title == f"{run.title}, with crank.length = 3 in and crank.prescribed_speed = 90 rpm"
    assert driven.scene == load_case("thesis-24", {"crank.length": "3 in", "crank.prescribed_speed": "90 rpm"}).scene


def test_a_name_and_changes_from_elsewhere_are_kept() -> None:
    run = with_times(load_case("thesis-24"), 0.5)
    named = run.with_(name="short")
    assert (named.name, named.title, named.scene, named.duration) == ("short", run.title, run.scene, 0.5)
    heavier = replace(run, title="Mine", scene=replace(run.mechanism, gravity=(0.0, -1.0))).with_({"crank.length": "5 in"})
    assert (heavier.title, heavier.mechanism.gravity, heavier.duration) == ("Mine, with crank.length = 5 in", (0.0, -1.0), 0.5)
