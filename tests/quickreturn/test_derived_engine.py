"""The engine `derived` against `reference`: equations of motion term by term, and motions with all their columns."""

from dataclasses import replace
from typing import Final

import numpy as np
import pytest

pytest.importorskip("casadi")

from quickreturn.engines.base import Refusal
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.mechanism import Base, Mechanism, PrescribedSpeed, Slider
from quickreturn.witness.engine import DerivedEngine, DerivedSettings
from tests.engines.scenes import run_24

#: Everything that both engines have, with a rigid joint.
LOADED: Final = run_24(
    gravity=(3.0, -9.81),
    slider=Slider(mass=0.1, inertia=3e-4),
    tip={"center_of_mass": 0.0127, "force": (8.0, -5.0), "force_from": 0.7, "force_to": 5.2, "force_ramp": 1.1},
    follower={"damping": 2.0, "material_damping": 3e-4},
    base={"damping": 0.02, "friction_torque": 0.2},
)
SCENES: Final[dict[str, Mechanism]] = {
    "run 24": run_24(),
    "loaded": LOADED,
    "prescribed speed": replace(LOADED, crank=replace(LOADED.crank, drive=PrescribedSpeed(speed=14.0))),
    "compliant": replace(LOADED, slider=replace(LOADED.slider, joint_stiffness=2e4, joint_damping=5.0)),
    "without tip and base": run_24(tip=None, base=Base()),
}
#: Part of a column's RMS by which motions with the same two shapes differ: both integrate to some 1e-8, and the tables are the same.
SAME: Final = 1e-5


@pytest.mark.parametrize("name", SCENES)
def test_all_columns_are_those_of_reference_with_the_same_shapes(name: str) -> None:
    scene = SCENES[name]
    start = standard_start(scene)
    ours = DerivedEngine().prepare(scene, start, DerivedSettings(modes=2, tolerance=1e-10)).advance(0.2, 0.002)
    theirs = ReferenceEngine().prepare(scene, start, ReferenceSettings(modes=2, tolerance=1e-10)).advance(0.2, 0.002)
    assert set(ours.columns) == set(theirs.columns)
    for column, expected in theirs.columns.items():
        size = 1.0 if column == "constraint_gap" else float(np.sqrt(np.mean(expected**2)))
        np.testing.assert_allclose(ours[column], expected, rtol=0.0, atol=10 * SAME * max(size, 1e-6), err_msg=column)


@pytest.mark.parametrize("slider", [Slider(friction=0.1), Slider(joint_stiffness=2e4, clearance=1e-3)], ids=["friction", "clearance"])
def test_what_is_not_described_is_refused(slider: Slider) -> None:
    with pytest.raises(Refusal, match=r"slider\."):
        DerivedEngine().check(run_24(slider=slider))
