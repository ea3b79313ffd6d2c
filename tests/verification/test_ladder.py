"""The verification ladder: a short form of each rung here, the full one with `make verify`, which keeps its tables for the report."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.reference_model.mechanism import Base
from tests.verification.ladder.overhung_beam import natural_modes
from tests.verification.ladder.statics_and_modes import mode_rows, rigid_rows, sag_rows, scene_of
from tests.verification.ladder.terms import mean_rows, state_of, term_rows
from tests.verification.ladder.trajectories import ladders, scene, trajectory_rows
from tests.verification.row import Row, chapter_of_rows, failures, smoothed, table

Keep = Callable[[str, object], None]
RUN_24 = load_case("thesis-24").mechanism
STATICS = (
    "Every engine against closed forms: frozen-crank frequencies against the roots of the overhung beam's transcendental determinant, the"
    " sag under a small weight across the follower, and the rigid limit. The thesis' single cubic is held against the closed forms of a"
    " follower that can bend as one cubic only."
)
TRAJECTORIES = (
    "Exudyn, extrapolated in step and elements, and MuJoCo, extrapolated in links, against the converged reference: means over 4 ms, run"
    " from the standard start. Orders are those observed in the tip deflection. Strain at the third gauge converges more slowly in Exudyn:"
    " the slider passes it, and the moment's kink with it."
)
TERMS = (
    "All engines in the same bent and moving state, which run 24 reaches after 0.25 s. Places, rates, energies, entries of the mass matrix"
    " and generalized forces along common motions against quadratures over that state, which no engine is part of; mean accelerations and"
    " forces of the 4 ms from 1 ms on against the reference."
)
#: Label, scene, duration in s, coarsest number of links: near the follower's end the slider asks for more.
SCENES = (
    ("run 24", ("thesis-24",), 0.3, 30),
    ("run 10", ("thesis-10",), 0.3, 30),
    ("run 17", ("thesis-17",), 0.4, 30),
    ("crank of 6 in without plates", ("hard-crank-6in",), 0.3, 40),
    ("run 24 at a prescribed 16.6 rad/s", ("thesis-24", 16.6), 0.3, 30),
)


def check(rows: list[Row]) -> None:
    assert rows
    assert not failures(rows)


def test_frequencies_against_the_determinant() -> None:
    check(list(mode_rows(scene_of(RUN_24), "run 24", 1, (90.0,), 3)))


def test_rigid_limit_against_the_vector_loop() -> None:
    check(list(rigid_rows(scene_of(RUN_24), "run 24")))


def test_a_follower_a_hundredth_too_soft_is_found_out() -> None:
    """The rung is sharp enough: every engine's frequencies miss the stiffer follower's by half a hundredth."""
    rows = list(mode_rows(scene_of(RUN_24), "run 24", 1, (0.0,), 1))
    softer = [Row(**{**vars(row), "value": row.value * math.sqrt(0.99)}) for row in rows]
    assert [row.engine for row in softer if row.passed] == []


@pytest.mark.parametrize(("place", "root"), [(0.5, 3.01183092), (0.7, 3.88535145)])
def test_determinant_of_the_uniform_overhung_beam(place: float, root: float) -> None:
    bare = dataclasses.replace(RUN_24, base=Base(), tip=None)
    mode = natural_modes(bare, place * bare.follower.length, 1)[0]
    assert mode.wave_number * bare.follower.length == pytest.approx(root, abs=6e-9)  # published digits


def test_rows_and_their_chapter() -> None:
    good = Row(scene="a", engine="b", quantity="c", value=1.01, expected=1.0, tolerance=0.02, reason="why")
    bad = Row(scene="a", engine="b", quantity="c", value=math.nan, expected=0.0, scale=2.0, tolerance=0.02, reason="why")
    assert good.passed
    assert not bad.passed
    assert failures([good, bad]).startswith("a, b, c: nan instead of 0")
    found = chapter_of_rows([good, bad], "T", "Text.")
    assert found["text"] == "Text. 1 of 2 comparisons passed."
    assert found["rows"][1][3] is None
    assert list(table([good])) == found["columns"]


def test_smoothing_keeps_a_constant_and_takes_a_vibration_away() -> None:
    t = np.arange(400) / 400.0
    assert smoothed(np.ones(40), 16) == pytest.approx(np.ones(25), abs=1e-15)
    # four periods in the window: the sin^2 window's side lobes are below 2 %
    assert np.abs(smoothed(np.sin(2 * np.pi * 10.0 * t * 10.0), 16)).max() < 0.02


def test_terms_of_a_bent_and_moving_state() -> None:
    check(list(term_rows(RUN_24, "run 24", state_of(RUN_24, 0.25), 1)))


@pytest.mark.verify
def test_statics_and_modes_of_every_engine(record_property: Keep) -> None:
    rows: list[Row] = []
    for name in ("thesis-24", "thesis-10", "thesis-17"):
        mechanism = load_case(name).mechanism
        for fineness in (1, 2):
            rows += mode_rows(mechanism, name, fineness, (180.0, 135.0, 90.0, 45.0, 0.0))
        rows += mode_rows(scene_of(mechanism) if mechanism.tip else mechanism, f"{name}, tip offset", 2, (180.0, 90.0, 0.0))
        rows += sag_rows(mechanism, name, (180.0, 90.0, 0.0))
        rows += rigid_rows(scene_of(mechanism) if mechanism.tip else mechanism, name)
    record_property(
        "chapter", chapter_of_rows(rows, "Verification ladder 1: statics, modes and the rigid limit against closed forms", STATICS)
    )
    check(rows)


@pytest.mark.verify
def test_terms_of_every_engine(record_property: Keep) -> None:
    rows: list[Row] = []
    prescribed = dataclasses.replace(scene_of(RUN_24), crank=scene("thesis-24", 16.6).crank)
    for label, mechanism in (
        ("run 24", RUN_24),
        ("run 24 with gravity, slider's mass and offset tip", scene_of(RUN_24)),
        ("the same at a prescribed 16.6 rad/s", prescribed),
    ):
        state = state_of(mechanism, 0.25)
        for fineness in (1, 2):
            rows += term_rows(mechanism, label, state, fineness)
            rows += mean_rows(mechanism, label, state, fineness)
    record_property("chapter", chapter_of_rows(rows, "Verification ladder 2: terms of the equations of motion in one state", TERMS))
    check(rows)


@pytest.mark.verify
def test_trajectories_converge_to_the_reference(record_property: Keep) -> None:
    rows: list[Row] = []
    for label, which, duration, links in SCENES:
        rows += trajectory_rows(label, scene(*which), duration, ladders(24, 6.25e-5, links))
    record_property("chapter", chapter_of_rows(rows, "Verification ladder 3: trajectories", TRAJECTORIES))
    check(rows)
