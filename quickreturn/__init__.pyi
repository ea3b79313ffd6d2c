"""The public names, each once: `quickreturn/__init__.py` reads them here, as type checkers do."""

from quickreturn.cases.case import Case as Case
from quickreturn.cases.columns import UnknownColumn as UnknownColumn
from quickreturn.cases.conformance import conform as conform
from quickreturn.cases.errors import CaseError as CaseError
from quickreturn.catalogue import case as case
from quickreturn.catalogue import list_cases as list_cases
from quickreturn.cross_validation import CrossValidation as CrossValidation
from quickreturn.cross_validation import report as report
from quickreturn.cross_validation import run as run
from quickreturn.engines.base import Comparison as Comparison
from quickreturn.engines.base import Engine as Engine
from quickreturn.engines.base import EngineFailure as EngineFailure
from quickreturn.engines.base import ModelDescription as ModelDescription
from quickreturn.engines.base import Refusal as Refusal
from quickreturn.engines.base import Simulation as Simulation
from quickreturn.engines.registry import UnknownEngine as UnknownEngine
from quickreturn.engines.registry import engine as engine
from quickreturn.engines.settings import SettingError as SettingError
from quickreturn.engines.settings import Settings as Settings
from quickreturn.engines.settings import setting as setting
from quickreturn.engines.simple import Model as Model
from quickreturn.engines.simple import SimpleEngine as SimpleEngine
from quickreturn.engines.start import Start as Start
from quickreturn.engines.start_state import reconstruct as reconstruct
from quickreturn.engines.trajectory import Trajectory as Trajectory
from quickreturn.frequencies import modes as modes
from quickreturn.questions import list_engines as list_engines
from quickreturn.solution import Solution as Solution
from quickreturn.solution import simulate as simulate
from quickreturn.studies.advice import Advice as Advice
from quickreturn.studies.advice import advise as advise
from quickreturn.studies.calibration import calibrate as calibrate
from quickreturn.studies.explanation import Explanation as Explanation
from quickreturn.studies.explanation import explain as explain
from quickreturn.studies.resonance_curves import Resonance as Resonance
from quickreturn.studies.resonance_curves import resonance as resonance
from quickreturn.studies.sweeping import case_at as case_at
from quickreturn.studies.sweeping import measures as measures
from quickreturn.studies.sweeping import sweep as sweep
from quickreturn.studies.uncertainty import uncertainty as uncertainty
from quickreturn.table_comparison import Differences as Differences
from quickreturn.table_comparison import TableComparison as TableComparison
from quickreturn.table_comparison import compare as compare
from quickreturn.table_comparison import difference as difference

__version__: str
