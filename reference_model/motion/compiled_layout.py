"""The types by which compiled code knows the tuples of `layout` and rows of a trajectory, and how it reads them by address."""

from typing import Final

import numba

from quickreturn.reference_model.columns import ROW
from quickreturn.reference_model.motion.layout import FACTS, BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.native.pointers import array_at, reader, tuple_type
from quickreturn.reference_model.spring import SpringLaw

TABLES_TYPE: Final = tuple_type(BeamTables)
PARAMETERS_TYPE: Final = tuple_type(BeamParameters, spring=tuple_type(SpringLaw), tables=TABLES_TYPE)
WORKSPACE_TYPE: Final = tuple_type(BeamWorkspace, facts=numba.from_dtype(FACTS))
parameters_at = reader(PARAMETERS_TYPE)
workspace_at = reader(WORKSPACE_TYPE)
#: Rows by address, not as numbers seen as records: numba keeps that conversion as the first function that uses it in a process compiles it,
#: and of functions that count references it does not go into an object.
rows_at = array_at(numba.from_dtype(ROW)[::1])
