"""Translates the instructions of a CasADi function to LLVM and compiles them with llvmlite; this needs no C compiler."""

import ctypes
from collections.abc import Sequence
from typing import Any, Final

import casadi as ca
import llvmlite.binding as llvm
import numpy as np

from quickreturn.plugins.derive.units import Array, DescriptionError

_COMPARED: Final = "{r}c = fcmp %s double {a}, %s\n{r} = uitofp i1 {r}c to double"
#: CasADi's operation -> its LLVM instructions, with operands `a` and `b` and result `r`.
_TEMPLATES: Final = {
    "assign": "{r} = fadd double {a}, -0.0",
    "add": "{r} = fadd contract double {a}, {b}",
    "sub": "{r} = fsub contract double {a}, {b}",
    "mul": "{r} = fmul contract double {a}, {b}",
    "div": "{r} = fdiv double {a}, {b}",
    "neg": "{r} = fneg double {a}",
    "inv": "{r} = fdiv double 1.0, {a}",
    "sq": "{r} = fmul contract double {a}, {a}",
    "twice": "{r} = fadd double {a}, {a}",
    "lt": _COMPARED % ("olt", "{b}"),
    "le": _COMPARED % ("ole", "{b}"),
    "eq": _COMPARED % ("oeq", "{b}"),
    "ne": _COMPARED % ("une", "{b}"),
    "not": _COMPARED % ("oeq", "0.0"),
    "and": "{r} = fmul double {a}, {b}",
    "if_else_zero": "{r}c = fcmp une double {a}, 0.0\n{r} = select i1 {r}c, double {b}, double 0.0",
    "sign": "{r}z = fcmp oeq double {a}, 0.0\n{r}s = call double @copysign(double 1.0, double {a})\n"
    "{r} = select i1 {r}z, double 0.0, double {r}s",
    "constpow": "{r} = call double @pow(double {a}, double {b})",
}
_ONE: Final = "sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt fabs floor ceil erf log1p expm1"
_TWO: Final = "fmin fmax atan2 pow fmod copysign hypot"
_FUNCTIONS: Final = dict.fromkeys(_ONE.split(), "double {a}") | dict.fromkeys(_TWO.split(), "double {a}, double {b}")
_CALLS: Final = {name: "{r} = call double @" + name + f"({arguments})" for name, arguments in _FUNCTIONS.items()}
#: CasADi's number of an operation -> its LLVM instructions.
_LINES: Final = {getattr(ca, f"OP_{name.upper()}"): line for name, line in (_TEMPLATES | _CALLS).items()}

#: CasADi's number of an operation -> its name, such as "erfinv", or "call" for a function that is no expression.
OPERATIONS: Final = {getattr(ca, name): name.removeprefix("OP_").lower() for name in dir(ca) if name.startswith("OP_")}

#: Optimization level of the compiler, 0 to 3. At level 0 a function of 30,000 instructions compiles in half the time and runs three to
#: fifteen times as long.
EFFORT: Final = 2


class MachineCode:
    """A compiled function from one vector to another.

    Args:
        inputs: column of symbols.
        outputs: column of expressions.
        names: names of the outputs.
    """

    def __init__(self, inputs: ca.SX, outputs: ca.SX, names: Sequence[str]) -> None:
        self.names, self.interpreter = list(names), ca.Function("equations", [inputs], [ca.densify(ca.cse(outputs))])
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        host = {"cpu": llvm.get_host_cpu_name(), "features": llvm.get_host_cpu_features().flatten()}
        machine = llvm.Target.from_default_triple().create_target_machine(**host, opt=EFFORT)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(_assembly(self.interpreter)), machine)
        self._engine.finalize_object()
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(self._engine.get_function_address("equations"))
        self._in, self._out = np.zeros(inputs.numel()), np.zeros(len(self.names))
        self._at = self._in.ctypes.data, self._out.ctypes.data

    def __call__(self, x: Array) -> Array:
        """The outputs for the inputs `x`."""
        self._in[:] = x
        self._call(*self._at)
        return self._out.copy()


def _assembly(function: Any) -> str:
    """The LLVM assembly of a CasADi function of one dense vector."""
    lines = [f"declare double @{name}({arguments.format(a='', b='')})" for name, arguments in _FUNCTIONS.items()]
    lines.append("define void @equations(ptr %in, ptr %out) {")
    operands: dict[int, str] = {}
    for k in range(function.n_instructions()):
        operation, r = function.instruction_id(k), f"%r{k}"
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            lines += [f"%p{k} = getelementptr double, ptr %out, i64 {outputs[1]}", f"store double {operands[inputs[0]]}, ptr %p{k}"]
            continue
        if operation == ca.OP_CONST:
            r = f"0x{np.float64(function.instruction_constant(k)).view(np.uint64):016X}"
        elif operation == ca.OP_INPUT:
            lines += [f"%p{k} = getelementptr double, ptr %in, i64 {inputs[1]}", f"{r} = load double, ptr %p{k}"]
        elif operation in _LINES:
            lines.append(_LINES[operation].format(r=r, a=operands[inputs[0]], b=operands[inputs[-1]]))
        else:
            raise DescriptionError(
                f"CasADi's operation {OPERATIONS[operation]!r} is not translated to machine code; write it with other functions, and an"
                " `interpolant` as System.table"
            )
        operands[outputs[0]] = r
    return "\n".join([*lines, "ret void", "}"])
