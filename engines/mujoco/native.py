"""MuJoCo's C functions for compiled Python, without a C compiler.

The bundled library is loaded into numba's linker, so that compiled code calls `mj_forward` and other functions by name. Names stay valid in
numba's cache on disk, addresses would not. All pointers are whole numbers here (`intp`); those of model and data are `MjModel._address`
and `MjData._address`.
"""

from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def _library() -> str:
    """Path of MuJoCo's library on Linux, macOS or Windows."""
    folder = Path(mujoco.__file__).parent
    names = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
    libraries = [path for name in names for path in sorted(folder.glob(name))]
    if not libraries:
        raise ImportError(f"MuJoCo's library is not in {folder}")
    return str(libraries[0])


llvmlite.binding.load_library_permanently(_library())

_address = types.intp

#: Advance the rates by the accelerations of the last `mj_forward` over one time step, and the coordinates by the new rates.
mj_euler: Any = types.ExternalFunction("mj_Euler", types.void(_address, _address))
#: Accelerations and all derived quantities of the present state.
mj_forward: Any = types.ExternalFunction("mj_forward", types.void(_address, _address))
#: x = M⁻¹ y for n vectors, with the mass matrix factorised last: model, data, x, y, n.
mj_solve_mass: Any = types.ExternalFunction("mj_solveM", types.void(_address, _address, _address, _address, types.intc))
#: Potential energy of gravity and springs into `data.energy[0]`.
mj_energy_position: Any = types.ExternalFunction("mj_energyPos", types.void(_address, _address))
#: Kinetic energy into `data.energy[1]`.
mj_energy_velocity: Any = types.ExternalFunction("mj_energyVel", types.void(_address, _address))
#: The parts of the state named by a bit mask, into a vector: model, data, vector, mask.
mj_get_state: Any = types.ExternalFunction("mj_getState", types.void(_address, _address, _address, types.intc))


def _pointer_at(typingctx: Any, address: Any) -> Any:
    def convert(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), convert


#: The whole number `address` as an untyped pointer, for `numba.carray`.
pointer: Any = intrinsic(_pointer_at)
