"""The chapter on classes says what the map says: who is first, by how much, and by which time."""

from quickreturn.plugins.methods.chapters import classes as tables
from quickreturn.plugins.methods.chapters.classes import finding
from quickreturn.plugins.methods.map import Map
from quickreturn.plugins.methods.tests.made_up_map import made_up_map
from quickreturn.plugins.methods.tests.pages import one_run, plain, read, text_of


def test_the_page_counts_wins_and_names_scenes_without_a_sharp_solution() -> None:
    told = text_of(one_run(classes=made_up_map()))
    # at 0.05 reference takes 2 ms and the next 7 ms; at 0.2 mujoco is first; the third scene has no solution
    assert "in 1 of 3 classes of machines (the next takes 3.5 times as long); by waiting time, fixed-shapes in 1, mujoco in 1" in told
    assert "solve time, to 0.1 %: reference in 1, mujoco in 1; 1 nobody wins" in told
    assert "speed 0.2 and speed 0.5: use the numbers there with care" in told
    assert plain(finding(Map(made_up_map().scenes), [])).startswith("No engine reaches 1 %")


def test_a_cell_has_winner_factor_and_runner_up_and_its_remark_has_everybody() -> None:
    (row,) = tables.map_table(made_up_map(), 1e-2, "solve time").rows
    assert (row["speed 0.05"].value, row["speed 0.05"].text) == ("reference", "reference\n3.5× fixed-shapes")
    note = row["speed 0.05"].note.replace("\N{NO-BREAK SPACE}", " ")
    assert note == "reference 2.0 ms; fixed-shapes 7.0 ms; thesis not reached (60 % left); multiplier refused"
    assert (row["speed 0.5"].text or row["speed 0.5"].value, row["speed 0.5"].mark) == ("no solution", "open")
    (row,) = tables.map_table(made_up_map(), 1e-2, "waiting time").rows
    assert row["speed 0.05"].value == "fixed-shapes"
    assert "exudyn reaches it, but its own estimate does not show it" in row["speed 0.2"].note


def test_without_a_record_there_is_no_chapter() -> None:
    assert "classes" not in read(one_run()).anchors
    assert "classes" in read(one_run(classes=made_up_map())).anchors
