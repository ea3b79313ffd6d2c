"""Run 24 by equations derived by hand (`reference`) and by the computer (`derived`), same shapes: every signal over two seconds."""

import numpy as np
import pytest

pytest.importorskip("casadi")

from quickreturn.engines.base import AnyEngine
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, scale
from quickreturn.plugins.derive.witness.engine import DerivedEngine, DerivedSettings
from tests.engines.scenes import run_24

#: Part of a signal's scale by which the two may differ: of its RMS, for a moment at an end of the largest RMS of moments.
SAME = 1e-6
#: m, by which either loop may be open: no part of an RMS, for that is rounding and what the integration leaves. Found: 1e-12.
OPEN = 1e-10
TOLERANCE = 1e-11


@pytest.mark.verify
@pytest.mark.parametrize("modes", [2, 5, 9])
def test_two_derivations_agree_in_every_signal_of_run_24(modes: int) -> None:
    """Found, over the RMS: 1.1e-9 with two shapes (`shape_01`), 6e-8 with five (`shape_01`), 4e-8 with nine (`tip_acceleration`)."""
    ours = motion(DerivedEngine(), DerivedSettings(modes=modes, tolerance=TOLERANCE))
    theirs = motion(ReferenceEngine(), ReferenceSettings(modes=modes, tolerance=TOLERANCE))
    assert set(ours.columns) == set(theirs.columns)
    away = {name: np.sqrt(np.mean((ours[name] - expected) ** 2)) for name, expected in theirs.columns.items()}
    assert away.pop("constraint_gap") < OPEN
    assert {name: error for name, error in away.items() if error > SAME * scale(name, theirs.columns)} == {}


def motion(engine: AnyEngine, settings: Settings) -> Trajectory:
    scene = run_24()
    return engine.prepare(scene, standard_start(scene), settings).advance(2.0, 1e-3)
