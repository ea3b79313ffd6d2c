"""What compiled code works with: MuJoCo's C functions, without a C compiler; the record of a simulation; and decorators that compile.

The bundled library is loaded into numba's linker, so that compiled code calls `mj_forward` and other functions by name. Names stay valid in
numba's cache on disk, addresses would not. All pointers are whole numbers here (`intp`); those of model and data are `MjModel._address`
and `MjData._address`.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import llvmlite.binding
import mujoco
import numba
import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.native.compilation import Function, jitted
from quickreturn.reference_model.spring import SpringLaw


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


#: The constants of a spring's law.
LAW = np.dtype([(name, "f8") for name in SpringLaw._fields])
#: Record of a simulation. Units of length, mass and time are those of `engines.units`, named here by the SI units that they stand for.
CONTEXT = np.dtype(
    [
        # addresses of arrays of MjData, and the number of its coordinates
        ("qpos", "i8"),
        ("qvel", "i8"),
        ("qacc", "i8"),
        ("force_bias", "i8"),
        ("force_passive", "i8"),
        ("force_applied", "i8"),
        ("energy", "i8"),
        ("coordinates", "i8"),
        # the scene
        ("hinges", "i8"),
        ("link_length", "f8"),
        ("follower_length", "f8"),
        ("bending_stiffness", "f8"),  # N m^2, 0 for a rigid follower
        ("extreme_fibre", "f8"),
        ("beam_damping", "f8"),  # N s/m^2
        ("material_damping", "f8"),  # s
        ("base_inertia", "f8"),  # kg m^2
        ("base_damping", "f8"),  # N m s/rad
        ("base_friction", "f8"),  # N m
        ("base_friction_rate", "f8"),  # rad/s
        ("pivot_distance", "f8"),
        ("crank_length", "f8"),
        ("crank_is_free", "i8"),
        ("crank_torque", "f8"),  # N m
        ("crank_damping", "f8"),  # N m s/rad
        ("prescribed_angle", "f8"),  # at time 0, or at present if the speed varies
        ("prescribed_speed", "f8"),
        ("drive_begin", "f8"),  # this and the next two: see `constants.drive_constants`
        ("drive_way", "f8"),
        ("drive_period", "f8"),
        ("drive_table", "i8"),  # address of its rows, and their number
        ("drive_points", "i8"),
        ("prescribed_inertia", "f8"),  # kg m^2 about O, crank and slider
        ("prescribed_weight_1", "f8"),  # N m, gravity's potential energy of crank and slider is w1 cos q1 + w2 sin q1
        ("prescribed_weight_2", "f8"),
        ("crank_mass", "f8"),  # kg, with the slider
        ("crank_moment", "f8"),  # kg m, first moment of that mass about O
        ("mass_per_length", "f8"),  # kg/m
        ("tip_mass", "f8"),
        ("tip_inertia", "f8"),  # kg m^2, about its centre
        ("tip_offset", "f8"),  # of its centre beyond the end
        ("gravity", "c16"),  # m/s^2, along n1 + i n2
        ("force_1", "f8"),  # this and the next four: see `tip.tool_force`
        ("force_2", "f8"),
        ("force_begin", "f8"),
        ("force_span", "f8"),
        ("force_ramp", "f8"),
        ("force_table", "i8"),  # address of its rows, and their number
        ("force_points", "i8"),
        ("force_follows", "i8"),  # whether the force turns with the last link
        ("slide_friction", "f8"),  # N, of the tool's slide
        ("slide_speed", "f8"),  # m/s, over which that changes its sign
        ("is_held", "i8"),  # by a spring
        ("anchor", "c16"),  # its fixed point from P, m
        ("spring_place", "f8"),
        ("spring", LAW),
        ("base_is_prescribed", "i8"),  # then there is neither crank nor slider
        ("spin_up_speed", "f8"),
        ("spin_up_time", "f8"),  # s
        ("joint_is_compliant", "i8"),
        ("plus", "f8"),  # this and the next five: see `joint.Rollers`
        ("minus", "f8"),
        ("plus_from", "f8"),
        ("minus_from", "f8"),
        ("contact_loss", "f8"),
        ("joint_damping", "f8"),
        ("friction", "f8"),  # 1
        ("friction_force", "f8"),  # N
        ("friction_speed", "f8"),  # m/s
        # the slider at present
        ("slider_position", "f8"),
        ("slider_speed", "f8"),
        ("slider_force", "f8"),  # N, on the follower
        ("tangential_force", "f8"),  # N, on the follower
        ("slider_couple", "f8"),  # N m, on the follower: friction acts at the crank tip, which is off the line by the gap
        ("gap", "f8"),
        ("spring_length", "f8"),
        ("tension", "f8"),  # N, of the spring
        ("spring_force", "c16"),  # N, on the follower
        # the drive and the dampings at present, and their work so far
        ("drive_torque", "f8"),
        ("drive_power", "f8"),
        ("dissipation", "f8"),
        ("drive_work", "f8"),
        ("dissipated", "f8"),
        ("step", "f8"),  # the last one, 0 before the first
    ]
)

Context = Any  # a record of CONTEXT: numba gives its fields as attributes
Points = NDArray[np.complex128]

ADDRESS, VECTOR, CONTEXTS = types.intp, types.float64[::1], numba.from_dtype(CONTEXT)[::1]
#: Bits of mjtState: the time, and the user's data, which are bit 11 up to MuJoCo 3.3 and bit 12 in later versions; the other one of these
#: two stands for parts that the models here do not have.
TIME_AND_USERDATA = (1 << 0) | (1 << 11) | (1 << 12)


def compiled(function: Function) -> Function:
    """Compile for callers that are compiled themselves."""
    return jitted(function, kept=False)


def entry(signature: Any) -> Callable[[Function], Function]:
    """Compile at import, or load what an earlier process compiled, so that no first call is slower than the next."""
    return partial(jitted, signature=signature)


@compiled
def numbers(address: int, length: int) -> Array:
    """The `length` numbers at an address of MuJoCo's, as an array without a copy."""
    return carray(pointer(address), length, np.float64)


@compiled
def dot(a: complex, b: complex) -> float:
    """Scalar product."""
    return a.real * b.real + a.imag * b.imag
