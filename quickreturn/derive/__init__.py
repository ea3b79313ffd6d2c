"""Equations of planar mechanisms, derived and simulated by the computer from a description (docs/describe.md).

    from quickreturn.derive import Model, System, turned

A `System` describes coordinates, bodies, beams, loads and loops; a `Model` derives its equations of motion, compiles and integrates them.
Nothing here knows a particular mechanism.
"""

try:
    import casadi as _casadi  # noqa: F401
except ImportError as error:
    raise ImportError("quickreturn.derive needs CasADi and sympy: pip install 'quickreturn[derive]'") from error

from quickreturn.derive.beam import Beam, natural_shapes
from quickreturn.derive.latex import latex
from quickreturn.derive.model import Model
from quickreturn.derive.sensitivity import sensitivities
from quickreturn.derive.statics import Linear, Statics, natural_frequencies
from quickreturn.derive.system import System, turned, vector
from quickreturn.derive.units import DescriptionError

__all__ = [
    "Beam",
    "DescriptionError",
    "Linear",
    "Model",
    "Statics",
    "System",
    "latex",
    "natural_frequencies",
    "natural_shapes",
    "sensitivities",
    "turned",
    "vector",
]
