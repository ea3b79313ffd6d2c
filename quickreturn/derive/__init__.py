"""Equations of planar mechanisms, derived and simulated by the computer from a description (docs/describe.md).

    from quickreturn.derive import Model, System, turned

A `System` is described by its coordinates, bodies, beams, loads and loops; a `Model` derives its equations of motion, compiles them and
moves them. Nothing here knows a particular mechanism.
"""

from quickreturn.derive.beam import Beam
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
    "sensitivities",
    "turned",
    "vector",
]
