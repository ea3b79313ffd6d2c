"""Equations of planar mechanisms, derived and simulated by the computer from a description (docs/describe.md).

    from quickreturn.derive import Model, System, turned

A `System` describes coordinates, bodies, beams, loads and loops; a `Model` derives its equations of motion, compiles and integrates them.
Nothing here knows a particular mechanism.
"""

try:
    import casadi as _casadi  # noqa: F401
except ImportError as error:
    raise ImportError("quickreturn.derive needs CasADi and sympy: pip install 'quickreturn[derive]'") from error

from quickreturn.plugins.derive.beam import Beam, natural_shapes
from quickreturn.plugins.derive.model import Model
from quickreturn.plugins.derive.state_space import StateSpace, state_space
from quickreturn.plugins.derive.statics import Linear, Statics, natural_frequencies
from quickreturn.plugins.derive.system import System, turned, vector
from quickreturn.plugins.derive.units import DescriptionError

__all__ = [
    "Beam",
    "DescriptionError",
    "Linear",
    "Model",
    "StateSpace",
    "Statics",
    "System",
    "latex",
    "natural_frequencies",
    "natural_shapes",
    "state_space",
    "turned",
    "vector",
]


def latex(system: System) -> str:
    """One equation for each coordinate, M q'' = Q + C^T force, and one for each loop, as lines of LaTeX.

    Raises:
        DescriptionError: the system is too large.
    """
    from quickreturn.plugins.derive.latex_by_sympy import lines_of  # sympy takes a second to load

    return " \\\\\n".join(lines_of(system))
