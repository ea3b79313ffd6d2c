"""The ladders of all engines, and how one is climbed."""

from typing import Any

import pytest

from quickreturn.engines.exudyn import settings as exudyn
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.mujoco import settings as mujoco
from quickreturn.engines.own import reference
from quickreturn.plugins.methods.rivals import nodal_load, staying_shapes, stiff_spring

LADDERS: dict[str, Ladder[Any]] = {
    "reference, slowed": reference.SLOWED,
    "reference": reference.AS_THEY_ARE,
    "mujoco": mujoco.LADDER,
    "staying shapes": staying_shapes.LADDER,
    "stiff-spring": stiff_spring.LADDER,
    "nodal-load": nodal_load.LADDER,
    "exudyn": exudyn.LADDER,
}


def sizes(ladder: Ladder[Any]) -> list[int]:
    return [getattr(rung, ladder.size) for rung, _ in ladder.rungs]


@pytest.mark.parametrize("ladder", LADDERS.values(), ids=LADDERS)
def test_rungs_get_finer_and_claim_less(ladder: Ladder[Any]) -> None:
    claims = [claim for _, claim in ladder.rungs]
    assert sizes(ladder) == sorted(sizes(ladder))
    assert claims == sorted(claims, reverse=True)
    for rung, claim in ladder.rungs:
        picked = ladder.pick(claim)  # the coarsest that claims as much
        assert dict(ladder.rungs)[picked] == claim
        assert getattr(picked, ladder.size) <= getattr(rung, ladder.size)
        assert ladder.pick(claim / 4.0, gain=0.25) == picked
    assert ladder.pick(1e-9) == ladder.rungs[-1][0]


@pytest.mark.parametrize("name", [name for name in LADDERS if name != "exudyn"])  # which climbs in three directions
@pytest.mark.parametrize("excess", [{}, {"modes": 1.1}, {"modes": 0.7, "spring": 0.6}, {"modes": 40.0}])
def test_climbing_ends_at_the_finest_rung(name: str, excess: dict[str, float]) -> None:
    ladder = LADDERS[name]
    rung, climbed = ladder.rungs[0][0], []
    while (finer := ladder.finer(rung, excess)) is not None:
        present, next_one = getattr(rung, ladder.size), getattr(finer, ladder.size)
        assert next_one > present
        between = [size for size in sizes(ladder) if present < size < next_one]
        assert not between or between[-1] < 2 * present  # no rung is passed over that is at least twice as fine
        if ladder.tolerance:
            assert getattr(finer, ladder.tolerance) <= getattr(rung, ladder.tolerance)
        rung, climbed = finer, [*climbed, next_one]
    assert climbed[-1] == sizes(ladder)[-1]


def test_a_size_brings_the_tolerance_that_fits_it_unless_it_is_tighter_already() -> None:
    ladder = reference.AS_THEY_ARE
    coarse = reference.ReferenceSettings(modes=2, tolerance=1e-5)
    assert ladder.sized(coarse, 10).tolerance == {rung.modes: rung.tolerance for rung, _ in ladder.rungs}[11]
    assert ladder.sized(coarse.replaced(tolerance=1e-12), 10).tolerance == 1e-12
    assert ladder.claim(10) == ladder.claim(11)
    assert ladder.claim(99) == ladder.rungs[-1][1]
