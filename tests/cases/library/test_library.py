"""The library's cases, their catalogue, and the 24 runs as the thesis' tables have them, contradictions included."""

import tomllib
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import pytest

from quickreturn.cases import library
from quickreturn.cases.files.case import case_of, document_of
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import case_names, catalogue, load_case
from quickreturn.cases.library.hard import IMPOSSIBLE, SCENES
from quickreturn.cases.library.thesis import RUNS, run_name
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies
from tests.cases.files.scene_texts import SCENE, parse_case

# Run 24 as anyone would write it down from sections 3.2 and 5.3, with the crank damping mended.
RUN_24 = (
    SCENE[: SCENE.index("[tip]")]
    .replace('name = "scene"', 'name = "thesis-24"')
    .replace('"A scene"', '"Run 24: crank 4 in, six plates, 16.6 rad/s"')
    .replace('["test"]', '["thesis"]')
    .replace("-386 in/s^2", "0 in/s^2")
    + """\
[tip]
mass = "2.90e-4 lbf*s^2/in"
inertia = "1.96e-5 lbf*s^2*in"
center_of_mass = "0 in"

[slider]
mass = "0 kg"
inertia = "0 kg*m^2"
joint_stiffness = "inf"
joint_damping = "0 N*s/m"

[simulation]
duration = "2 s"
output_step = "1 ms"
"""
)


def test_the_library_holds_the_24_runs_every_file_of_its_folder_and_the_hard_scenes() -> None:
    files = sorted(path.stem for path in Path(library.__file__).parent.glob("*.toml"))
    hard_scenes = (name for name in SCENES if name not in IMPOSSIBLE)
    assert case_names() == (*(f"thesis-{run:02d}" for run in range(1, 25)), *files, *hard_scenes)
    assert {"rigid", "example"} <= set(files)


def test_run_24_is_the_scene_written_by_hand() -> None:
    case, by_hand = load_case("thesis-24"), parse_case(RUN_24, "by hand")
    assert replace(case, notes=(), source="") == replace(by_hand, source="")


@pytest.mark.parametrize("name", case_names())
def test_every_case_can_be_read_and_is_listed_as_it_is(name: str) -> None:
    case = load_case(name)
    assert case.name == name
    assert case.source == "library"
    assert case_of(document_of(case)).scene == case.scene
    (entry,) = (entry for entry in catalogue() if entry.name == name)
    assert (entry.tags, entry.title) == (case.tags, case.title)
    times = {"example": (1.0, 0.001), "hard-undamped": (38.0, 0.001), "spin-up": (30.0, 0.02), "cantilever-sag": (3.0, 0.005)}
    times |= dict.fromkeys(("cantilever-decay", "cantilever-round"), (0.5, 0.001))
    assert (case.duration, case.output_step) == times.get(name, (2.0, 0.001))


def test_a_case_file_dropped_into_the_folder_is_found_without_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def forget() -> None:
        for function in (library.case_names, library.library_case, library._file_names, library._line):
            function.cache_clear()

    monkeypatch.setattr(library, "_FOLDER", tmp_path)
    (tmp_path / "mine.toml").write_text(RUN_24.replace('name = "thesis-24"', 'name = "mine"').replace('["thesis"]', '["mine", "new"]'))
    (tmp_path / "other.toml").write_text(RUN_24)
    forget()
    try:
        assert case_names()[24:26] == ("mine", "other")
        assert load_case("mine").mechanism == parse_case(RUN_24, "by hand").mechanism
        with pytest.raises(CaseError) as refused:
            catalogue()
        assert str(refused.value) == ('other.toml: name: "thesis-24" differs from the file\'s name; in this folder write name = "other"')
        (tmp_path / "other.toml").unlink()
        forget()
        assert [entry.name for entry in catalogue("new")] == ["mine"]
    finally:
        monkeypatch.undo()
        forget()


def test_the_rigid_case_is_run_24_without_bending() -> None:
    rigid, run_24 = load_case("rigid").mechanism, load_case("thesis-24").mechanism
    assert rigid.follower.is_rigid
    assert replace(rigid, follower=replace(rigid.follower, bending_stiffness=run_24.follower.bending_stiffness)) == run_24


def test_the_example_shows_every_key_that_can_stand_together() -> None:
    content = tomllib.loads((Path(library.__file__).parent / "example.toml").read_text("utf-8"))
    assert set(content) == {"name", "title", "tags", "mechanism", "crank", "base", "follower", "tip", "slider", "simulation"}
    assert load_case("example").mechanism.has_gravity


def test_runs_differ_as_the_tables_say() -> None:
    # section 3.4: cranks of 6, 5 and 4 in, in blocks of eight; pairs with 0, 2, 4 and 6 plates
    for run in RUNS:
        scene = load_case(run_name(run)).mechanism
        assert scene.crank.length == pytest.approx(0.0254 * (6, 5, 4)[(run - 1) // 8], rel=1e-15)
        plates = (run - 1) % 8 // 2 * 2
        # table 5.1: 4.1e-5 without plates and 4.15e-5 more per plate, in lbf s^2/in (175.126835 kg, to 9 digits)
        assert scene.tip.mass == pytest.approx((4.1e-5 + 4.15e-5 * plates) * 175.126835, rel=3e-9)
        # J/m = 0.068 in^2 in all four rows, to the digits printed
        assert scene.tip.inertia / scene.tip.mass == pytest.approx(0.068 * 0.0254**2, rel=0.01)
        drive = scene.crank.drive
        # torque over damping is the initial speed, to the digits printed: the worst is run 15 with 4.5e-7
        assert drive.torque / drive.damping == pytest.approx(drive.initial_speed, rel=5e-7)


def test_published_contradictions_are_found_in_the_tables_and_told() -> None:
    assert [(found.runs, found.what) for found in inconsistencies()] == [
        ((1,), "crank speed"),
        ((1,), "experiment"),
        (tuple(range(2, 9)), "measured tip acceleration"),
        ((24,), "crank damping"),
        ((24,), "mode at 132 Hz"),
        (tuple(range(1, 25)), "unit of the printed strain"),
    ]
    damping = next(found for found in inconsistencies() if found.what == "crank damping")
    assert "0.300892729" in damping.published
    assert "33.234436" in damping.published  # 10 / 0.300892729
    assert "16.617773" in damping.published
    assert damping.used.startswith("0.60176535 ")  # 10 / 16.617773
    assert any("0.300892729" in note and "0.60176535" in note for note in load_case("thesis-24").notes)
    assert not any("crank damping" in note for note in load_case("thesis-23").notes)
    assert load_case("rigid").notes == ()


def test_the_copied_columns_add_up_as_in_the_thesis() -> None:
    # sums taken from the printed tables: they notice a digit that torque / damping = speed is too coarse to notice
    runs = RUNS.values()
    assert sum(Decimal(run.published_damping) for run in runs) == Decimal("20.099386173")
    assert sum(Decimal(run.measured_speed or 0) for run in runs) == Decimal("298.035426")
    assert all(run.measured_speed == run.simulated_speed for run in runs)  # table 5.2 repeats table 3.1
