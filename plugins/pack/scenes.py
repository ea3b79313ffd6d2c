"""The problems that are scenes of the project, by its engines."""

from typing import Any, Final, NamedTuple

import quickreturn as qr
from quickreturn.plugins.pack.values import Columns, times


class Scene(NamedTuple):
    """A case of the library with changes, and settings of engine `exudyn`."""

    case: str
    duration: float
    exudyn: dict[str, Any]
    changes: dict[str, str]


_FINE: Final = {"elements": 64, "step": 1e-4, "extrapolated": True, "newton_tolerance": 1e-7, "axial_factor": 4.0}
_ALONE: Final = _FINE | {"step": 1e-3, "axial_factor": 64.0}
_ROLLERS: Final = _FINE | {"step": 2.5e-5, "extrapolated": False}  # rollers lift off: no order in the step to extrapolate by
SCENES: Final = {
    "spin-up": Scene("spin-up", 20.0, _ALONE, {}),
    "thesis-24": Scene("thesis-24", 0.8, _FINE, {}),
    "thesis-17": Scene("thesis-17", 0.8, _FINE, {}),
    "example": Scene("example", 0.5, _FINE, {"tip.force": '["3 N", "-2 N"]'}),
    "two-rollers": Scene("thesis-24", 0.6, _ROLLERS, {"slider.joint_stiffness_plus": "40 kN/m", "slider.joint_stiffness_minus": "20 kN/m"}),
}


def moved(name: str, engine: str, rows: int, fine: bool = False) -> Columns:
    """All columns of a scene by an engine: `reference` with 13 modes, or 16 if `fine`; `mujoco` to 1e-4."""
    scene = SCENES[name]
    case = qr.case(scene.case, scene.changes, duration=scene.duration, output_step=scene.duration / rows)
    settings = {"exudyn": scene.exudyn, "reference": {"modes": 16 if fine else 13, "tolerance": 1e-10 if fine else 1e-9}}.get(engine)
    accuracy = None if settings else 1e-4
    found = qr.simulate(case, engine, accuracy=accuracy, settings=settings, estimate=accuracy is not None, store=False, quiet=True)
    return {**found.trajectory.columns, "time": times(scene.duration, rows)}
