"""Flexible-multibody engines on a quick-return mechanism.

    import quickreturn as qr
    case = qr.case("thesis-24", {"crank.length": "5 in"})
    print(qr.simulate(case, "reference", accuracy=1e-3))

Notebooks, engine authors and the command line use the names below. Each is imported on its first use.
"""

from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from quickreturn.advice import Advice, advise
    from quickreturn.calibration import calibrate, uncertainty
    from quickreturn.cases.case import Case
    from quickreturn.cases.columns import UnknownColumn
    from quickreturn.cases.conformance import conform
    from quickreturn.cases.errors import CaseError
    from quickreturn.catalogue import case, list_cases
    from quickreturn.cross_validation import CrossValidation, report, run
    from quickreturn.differences import Differences, difference
    from quickreturn.engines.base import Comparison, Engine, EngineFailure, ModelDescription, Refusal, Simulation
    from quickreturn.engines.registry import UnknownEngine, engine
    from quickreturn.engines.settings import SettingError, Settings, setting
    from quickreturn.engines.simple import Model, SimpleEngine
    from quickreturn.engines.start import Start
    from quickreturn.engines.start_state import reconstruct
    from quickreturn.engines.trajectory import Trajectory
    from quickreturn.frequencies import modes
    from quickreturn.questions import list_engines
    from quickreturn.resonance_curves import Resonance, resonance
    from quickreturn.solution import Solution, simulate
    from quickreturn.sweeping import case_at, measures, sweep
    from quickreturn.table_comparison import TableComparison, compare

__all__ = [
    "Advice",
    "Case",
    "CaseError",
    "Comparison",
    "CrossValidation",
    "Differences",
    "Engine",
    "EngineFailure",
    "Model",
    "ModelDescription",
    "Refusal",
    "Resonance",
    "SettingError",
    "Settings",
    "SimpleEngine",
    "Simulation",
    "Solution",
    "Start",
    "TableComparison",
    "Trajectory",
    "UnknownColumn",
    "UnknownEngine",
    "advise",
    "calibrate",
    "case",
    "case_at",
    "compare",
    "conform",
    "difference",
    "engine",
    "list_cases",
    "list_engines",
    "measures",
    "modes",
    "reconstruct",
    "report",
    "resonance",
    "run",
    "setting",
    "simulate",
    "sweep",
    "uncertainty",
]

#: Module -> the names that this one imports from it.
_HOMES: Final = {
    "quickreturn.cases.case": ("Case",),
    "quickreturn.cases.columns": ("UnknownColumn",),
    "quickreturn.cases.conformance": ("conform",),
    "quickreturn.cases.errors": ("CaseError",),
    "quickreturn.engines.base": ("Comparison", "Engine", "EngineFailure", "ModelDescription", "Refusal", "Simulation"),
    "quickreturn.engines.registry": ("UnknownEngine", "engine"),
    "quickreturn.engines.settings": ("SettingError", "Settings", "setting"),
    "quickreturn.engines.simple": ("Model", "SimpleEngine"),
    "quickreturn.engines.start": ("Start",),
    "quickreturn.engines.start_state": ("reconstruct",),
    "quickreturn.engines.trajectory": ("Trajectory",),
    "quickreturn.calibration": ("calibrate", "uncertainty"),
    "quickreturn.advice": ("Advice", "advise"),
    "quickreturn.catalogue": ("case", "list_cases"),
    "quickreturn.cross_validation": ("CrossValidation", "report", "run"),
    "quickreturn.differences": ("Differences", "difference"),
    "quickreturn.frequencies": ("modes",),
    "quickreturn.questions": ("list_engines",),
    "quickreturn.resonance_curves": ("Resonance", "resonance"),
    "quickreturn.solution": ("Solution", "simulate"),
    "quickreturn.sweeping": ("case_at", "measures", "sweep"),
    "quickreturn.table_comparison": ("TableComparison", "compare"),
}
_HOME_OF: Final = {name: home for home, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("quickreturn")
    if name not in _HOME_OF:
        near = get_close_matches(name, __all__, 1)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}" + "".join(f"; the nearest one is {each}" for each in near))
    value = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
