"""The 24 runs are what the thesis' tables say, and where these contradict each other it is told."""

import math
from dataclasses import replace
from decimal import Decimal

import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.library.hard import SCENES
from quickreturn.cases.library.thesis import RUNS, run_name, tip_body
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies


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


def test_run_1_turns_once_a_second() -> None:
    assert float(RUNS[1].crank_speed) == pytest.approx(2.0 * math.pi, rel=1e-6)  # T/c = 6.28318 is 2 pi to 6 digits


@pytest.mark.parametrize("run", range(2, 25))
def test_an_edit_of_either_table_is_noticed(run: int) -> None:
    assert RUNS[run].damping_is_consistent == (run != 24)
    other_damping = f"{float(RUNS[run].published_damping) * 1.00001:.9f}"
    assert not replace(RUNS[run], published_damping=other_damping).damping_is_consistent
    assert not replace(RUNS[run], simulated_speed=f"{float(RUNS[run].measured_speed or 0.0) + 1e-4}").damping_is_consistent


def test_the_copied_columns_add_up_as_in_the_thesis() -> None:
    # sums taken from the printed tables: they notice a digit that torque / damping = speed is too coarse to notice
    runs = RUNS.values()
    assert sum(Decimal(run.published_damping) for run in runs) == Decimal("20.099386173")
    assert sum(Decimal(run.measured_speed or 0) for run in runs) == Decimal("298.035426")
    assert all(run.measured_speed == run.simulated_speed for run in runs)  # table 5.2 repeats table 3.1


def test_hard_scenes_without_plates_have_the_printed_tip() -> None:
    assert tip_body(0).items() <= SCENES["hard-crank-6in"].given.items()
