"""Case files that the program writes: they hold the same scene to the last digit, and what is said beside the values is true."""

import re
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quickreturn.cases.files.case import Case, document_of
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import PATHS, SECTIONS
from quickreturn.cases.files.written import as_toml
from quickreturn.cases.library import case_names, load_case
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, SpinUp
from quickreturn.reference_model.scene_values import SPIN_UP
from tests.cases.files.scene_texts import parse_case
from tests.strategies import scenes


def same(ours: Case, theirs: Case) -> bool:
    """Whether two cases are equal to the last bit in everything but where they are from."""
    return replace(ours, source="", notes=()) == replace(theirs, source="", notes=())


@pytest.mark.parametrize("name", case_names())
def test_every_case_of_the_library_is_the_same_when_it_is_written_and_read(name: str) -> None:
    case = load_case(name)
    assert same(parse_case(case.to_toml(), "written"), case)
    assert same(parse_case(as_toml(document_of(case)), "written in SI"), case)


@given(scenes(compliant=True, turning_slider=True), st.floats(0.1, 1e3), st.floats(1e-3, 1e3))
@settings(max_examples=25)
def test_any_scene_is_the_same_when_it_is_written_and_read(scene: object, speed: float, time: float) -> None:
    mechanism: Mechanism = scene.mechanism  # type: ignore[attr-defined]
    case = Case(name="random", title='In "quotes", with a \\', tags=("a", "b"), scene=mechanism, duration=0.3, output_step=0.1)
    assert same(parse_case(case.to_toml(), "written"), case)
    alone = FollowerAlone(
        base=mechanism.base,
        follower=mechanism.follower,
        tip=mechanism.tip and replace(mechanism.tip, force=(0.0, 0.0)),
        gravity=mechanism.gravity,
        spin_up=SpinUp(speed=speed, time=time),
    )
    assert same(parse_case(replace(case, scene=alone).to_toml(), "written"), replace(case, scene=alone))


def test_values_stay_as_a_person_wrote_them() -> None:
    text = load_case("thesis-24", {"crank.length": "4.50 in"}).to_toml()
    for written in ('length = "4.50 in"', 'damping = "0.60176535 lbf*in*s/rad"', 'strain_gauges = ["6.25 in", "12.5 in", "18.75 in"]'):
        assert written in text


@pytest.mark.parametrize("name", ["example", "thesis-24", "hard-no-tip", "shaper-cutting", "spin-up"])
def test_every_key_that_could_be_there_is_explained(name: str) -> None:
    case = load_case(name)
    alone = isinstance(case.scene, FollowerAlone)
    possible = {path for path in PATHS if alone or path not in SPIN_UP}
    if alone:
        possible -= {path for path in PATHS if path.startswith(("crank.", "slider.", "spring.", "tip.force", "tip.friction"))} | {
            "mechanism.pivot_distance"
        }
    told, section = set(), ""
    for line in load_case(name).to_toml().splitlines():
        if head := re.fullmatch(r"(?:# )?\[(\w+)\]", line):
            section = head[1]
        elif (key := re.match(r"(?:# )?(\w+) = ", line)) and section:
            told.add(path := f"{section}.{key[1]}")
            meaning = PATHS[path].meaning
            assert meaning in line or meaning == key[1].replace("_", " "), line
            assert ("  # optional" in line) == PATHS[path].optional, line
    assert told == possible


@pytest.mark.parametrize("name", ["thesis-24", "rigid", "hard-no-tip", "shaper-cutting"])
def test_a_value_that_stands_as_a_comment_is_the_one_that_holds(name: str) -> None:
    text, case = load_case(name).to_toml(), load_case(name)
    # Every commented key that has a number, and its section: what the file says is then written out, and changes nothing.
    written = re.sub(r'^# (\w+ = ("[^."][^"]*"|\["[^."].*?\]))', r"\1", text, flags=re.MULTILINE)
    start, end = written.index("# [spring]"), written.index("\n[simulation]")  # it needs an anchor, for which dots stand there
    written = written[:start] + written[end:]
    if name != "hard-no-tip":  # [tip] needs a mass and an inertia, for which dots stand there
        written = written.replace("# [", "[")
    else:
        written = written.replace("# [slider]", "[slider]")
        start, end = written.index("# [tip]"), written.index("# Optional. The coupler")
        written = written[:start] + written[end:]
    assert written.count("\n[") > text.count("\n[")
    found, expected = (flat(each) for each in (parse_case(written, "written"), case))
    assert found == pytest.approx(expected, rel=3e-16, abs=0.0)  # degrees of the force become rad with one rounding


def flat(case: Case) -> list[float]:
    values = [value for section in SECTIONS for value in case.values.get(section, {}).values()]
    return [number for value in values for number in (value if isinstance(value, tuple) else (value,))]


def test_what_no_file_can_hold_is_refused() -> None:
    case = load_case("thesis-24")
    follower = replace(case.scene.follower, strain_gauges=(float("nan"),) * 3)
    with pytest.raises(CaseError, match=r"thesis-24: follower.strain_gauges: nan .*finite"):
        replace(case, scene=replace(case.scene, follower=follower)).to_toml()
