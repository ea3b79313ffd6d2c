"""Tables of two runs or with rows between steps: their order, their rows where a step passes an output, and where a run ends."""

import numpy as np
import pytest

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import join, relative_error
from tests.engines.exudyn.runs import simulate
from tests.engines.exudyn.test_engine import ENGINE, INCH, standard_start
from tests.engines.scenes import run_24


@pytest.fixture(scope="module")
def fine() -> dict[str, np.ndarray]:
    """Run 24 with an eighth of the step of the others, so that its error is a sixtieth of theirs."""
    return dict(simulate(run_24(), 0.3, elements=12, step=6.25e-5).columns)


@pytest.mark.verify
@pytest.mark.parametrize(("step", "gain"), [(5e-4, 5.0), (1e-3, 4.0)])
def test_an_extrapolated_table_is_better_than_the_finer_one_of_its_two(fine, step, gain):
    """Measured 6.3 times with 0.5 ms; with 1 ms the coarser run passes every other row."""
    plain, extrapolated = (simulate(run_24(), 0.3, elements=12, step=step, extrapolated=each) for each in (False, True))
    before, after = (relative_error(each["tip_deflection"], fine["tip_deflection"]) for each in (plain, extrapolated))
    assert after < before / gain
    odd = relative_error(extrapolated["tip_deflection"][1::2], fine["tip_deflection"][1::2])
    assert odd < 1.5 * after + 1e-4
    assert np.array_equal(plain["time"], extrapolated["time"])
    assert extrapolated["constraint_gap"].min() >= 0.0


def test_a_table_is_what_the_two_runs_say():
    """Richardson's formula on two runs that are made apart, whose steps have the ratio of 5 and 2."""
    scene, names = run_24(), ("tip_x", "slider_force", "dissipated_energy")
    coarse, finer = (simulate(scene, 0.02, elements=8, step=step) for step in (5e-4, 2e-4))
    found = simulate(scene, 0.02, elements=8, step=2e-4, extrapolated=True)
    for name in names:
        assert found[name] == pytest.approx((6.25 * finer[name] - coarse[name]) / 5.25, rel=1e-9, abs=1e-12), name


@pytest.mark.parametrize("pieces", [(0.05, 0.1), (0.051, 0.099)])
def test_pieces_equal_one_run_also_where_a_step_passes_an_output(pieces):
    """With an odd number of rows the last step of a piece is half as long."""
    scene, settings = run_24(), {"elements": 8, "step": 1e-3, "extrapolated": True}
    whole = simulate(scene, sum(pieces), **settings)
    simulation = ENGINE.prepare(scene, standard_start(scene), ENGINE.settings_type(newton_tolerance=1e-5, **settings))
    found = join([simulation.advance(piece, 1e-3) for piece in pieces])
    assert len(found) == len(whole)
    assert simulation.time == pytest.approx(0.15)
    for name in ("tip_deflection", "dissipated_energy", "crank_angle"):
        assert relative_error(found[name], whole[name]) < (1e-9 if pieces[0] == 0.05 else 2e-3), name


@pytest.mark.parametrize("rows", [{}, {"rows": 4, "step": 2e-3}, {"extrapolated": False}])
def test_a_table_ends_where_a_slider_leaves_one_of_its_runs(rows):
    gauges = (5.5 * INCH, 11.0 * INCH, 16.5 * INCH)
    soft = {"length": 22.001 * INCH, "strain_gauges": gauges, "bending_stiffness": 0.1 * run_24().follower.bending_stiffness}
    with pytest.raises(EngineFailure, match="left the follower") as failure:
        simulate(run_24(follower=soft), 2.0, output_step=5e-4, **{"elements": 8, "step": 5e-4, "extrapolated": True, **rows})
    partial = failure.value.partial
    assert partial["time"][-1] == failure.value.time < 2.0
    assert partial["slider_position"].max() <= 22.01 * INCH


@pytest.mark.parametrize("extrapolated", [False, True])
def test_rows_that_a_step_passes_are_interpolated(fine, extrapolated):
    """Every fourth row is that of a table with these rows alone, the last one too; those between are hardly farther from a fine run."""
    scene, settings = run_24(), {"elements": 12, "step": 2e-3, "extrapolated": extrapolated}
    found = simulate(scene, 0.3, output_step=5e-4, rows=4, **settings)
    stepped = simulate(scene, 0.3, output_step=2e-3, **settings)
    assert found["time"] == pytest.approx(5e-4 * np.arange(601))
    for name, values in stepped.columns.items():
        assert found[name][::4] == pytest.approx(values, rel=1e-9, abs=1e-12), name
    for name in ("tip_deflection", "tip_acceleration", "slider_force"):
        error, between = (relative_error(found[name][at::4], fine[name][at // 2 :: 2]) for at in (0, 2))
        assert between < 1.1 * error + 1e-4, name


def test_rows_that_are_left_are_a_step_of_their_own():
    scene, settings = run_24(), {"elements": 8, "step": 2e-3, "rows": 4}
    whole = simulate(scene, 0.1, output_step=5e-4, **settings)
    simulation = ENGINE.prepare(scene, standard_start(scene), ENGINE.settings_type(newton_tolerance=1e-5, **settings))
    found = join([simulation.advance(piece, 5e-4) for piece in (0.0005, 0.0515, 0.048)])
    assert simulation.time == pytest.approx(0.1)
    assert found["time"] == pytest.approx(whole["time"])
    assert relative_error(found["tip_deflection"], whole["tip_deflection"]) < 2e-2  # three steps are shorter
