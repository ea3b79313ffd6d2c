"""Equations of planar mechanisms, derived and simulated by the computer from a description (docs/describe.md).

    from quickreturn.derive import Model, System, turned

A `System` describes coordinates, bodies, beams, loads and loops; a `Model` derives its equations of motion, compiles and integrates them.
Nothing here knows a particular mechanism.
"""

from typing import TYPE_CHECKING, Any

try:
    import casadi as _casadi  # noqa: F401
except ImportError as error:
    raise ImportError("quickreturn.derive needs CasADi and sympy: pip install 'quickreturn[derive]'") from error

from quickreturn.derive.beam import Beam, natural_shapes
from quickreturn.derive.model import Model
from quickreturn.derive.sensitivity import sensitivities
from quickreturn.derive.statics import Linear, Statics, natural_frequencies
from quickreturn.derive.system import System, turned, vector
from quickreturn.derive.units import DescriptionError

if TYPE_CHECKING:
    from quickreturn.derive.latex_by_sympy import latex

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


def __getattr__(name: str) -> Any:
    """Import `latex` on its first use, for sympy takes a second."""
    if name != "latex":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from quickreturn.derive.latex_by_sympy import latex

    return latex
