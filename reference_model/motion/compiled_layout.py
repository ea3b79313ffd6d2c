"""The types by which compiled code knows the tuples of `layout`, and how it reads them by address."""

from typing import Final

import numba

from quickreturn.reference_model.machine.pointers import reader, tuple_type
from quickreturn.reference_model.motion.layout import FACTS, Parameters, Tables, Workspace

TABLES_TYPE: Final = tuple_type(Tables)
PARAMETERS_TYPE: Final = tuple_type(Parameters, tables=TABLES_TYPE)
WORKSPACE_TYPE: Final = tuple_type(Workspace, facts=numba.from_dtype(FACTS))
parameters_at = reader(PARAMETERS_TYPE)
workspace_at = reader(WORKSPACE_TYPE)
