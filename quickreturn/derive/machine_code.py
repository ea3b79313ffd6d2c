"""Compiled equations: CasADi's list of instructions as LLVM's, compiled by the library that numba brings; no C compiler is needed."""

import ctypes
from collections.abc import Sequence
from typing import Any, Final

import casadi as ca
import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from quickreturn.derive.units import DescriptionError

Array = NDArray[np.float64]

#: LLVM's instructions for one of CasADi's, `a` and `b` its operands and `r` its result.
_COMPARED: Final = "{r}c = fcmp %s double {a}, {b}\n{r} = uitofp i1 {r}c to double"
_TEMPLATES: Final = {
    ca.OP_ASSIGN: "{r} = fadd double {a}, -0.0",
    ca.OP_ADD: "{r} = fadd contract double {a}, {b}",
    ca.OP_SUB: "{r} = fsub contract double {a}, {b}",
    ca.OP_MUL: "{r} = fmul contract double {a}, {b}",
    ca.OP_DIV: "{r} = fdiv double {a}, {b}",
    ca.OP_NEG: "{r} = fneg double {a}",
    ca.OP_INV: "{r} = fdiv double 1.0, {a}",
    ca.OP_SQ: "{r} = fmul contract double {a}, {a}",
    ca.OP_TWICE: "{r} = fadd double {a}, {a}",
    ca.OP_LT: _COMPARED % "olt",
    ca.OP_LE: _COMPARED % "ole",
    ca.OP_EQ: _COMPARED % "oeq",
    ca.OP_NE: _COMPARED % "une",
    ca.OP_NOT: "{r}c = fcmp oeq double {a}, 0.0\n{r} = uitofp i1 {r}c to double",
    ca.OP_AND: "{r} = fmul double {a}, {b}",
    ca.OP_IF_ELSE_ZERO: "{r}c = fcmp une double {a}, 0.0\n{r} = select i1 {r}c, double {b}, double 0.0",
    ca.OP_SIGN: "{r}p = fcmp ogt double {a}, 0.0\n{r}n = fcmp olt double {a}, 0.0\n{r}u = uitofp i1 {r}p to double\n"
    "{r}v = uitofp i1 {r}n to double\n{r} = fsub double {r}u, {r}v",
}
_ONE_ARGUMENT: Final = "sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt fabs floor ceil erf log1p expm1".split()
_FUNCTIONS: Final = {getattr(ca, f"OP_{name.upper()}"): (name, 1) for name in _ONE_ARGUMENT} | {
    getattr(ca, f"OP_{name.upper()}"): (name, 2) for name in ("fmin", "fmax", "atan2", "pow", "fmod", "copysign", "hypot")
}
_FUNCTIONS[ca.OP_CONSTPOW] = ("pow", 2)

#: Largest difference between machine code and interpreter, relative to an output or to a thousandth of the largest: fused operations.
AGREEMENT: Final = 1e-9


class MachineCode:
    """A function of one vector to one vector, compiled.

    Args:
        inputs: symbols, a column.
        outputs: expressions, a column.
        names: of the outputs, for messages.
    """

    def __init__(self, inputs: ca.SX, outputs: ca.SX, names: Sequence[str]) -> None:
        self.names = list(names)
        self.interpreter = ca.Function("equations", [inputs], [ca.densify(ca.cse(outputs))])
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        module = llvm.parse_assembly(_assembly(self.interpreter))
        features = llvm.get_host_cpu_features().flatten()
        machine = llvm.Target.from_default_triple().create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=2)
        self._engine = llvm.create_mcjit_compiler(module, machine)
        self._engine.finalize_object()
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(self._engine.get_function_address("equations"))
        self._in, self._out = np.zeros(inputs.numel()), np.zeros(len(self.names))
        self._at = self._in.ctypes.data, self._out.ctypes.data

    def __call__(self, x: Array) -> Array:
        """Outputs of the inputs `x`."""
        self._in[:] = x
        self._call(*self._at)
        return self._out.copy()

    def check(self, x: Array) -> None:
        """Compare machine code and interpreter once.

        Raises:
            DescriptionError: an output is not a number, or the two differ.
        """
        found, expected = self(x), np.array(self.interpreter(x)).ravel()
        for name, value in zip(self.names, expected, strict=True):
            if not np.isfinite(value):
                raise DescriptionError(f"{name} is {value} at the start; look for a root of a negative number or a division by zero there")
        excess = np.abs(found - expected) - AGREEMENT * np.maximum(np.abs(expected), 1e-3 * np.max(np.abs(expected)))
        worst = int(np.argmax(excess))
        if not excess[worst] <= 0.0:
            raise DescriptionError(f"machine code gives {found[worst]} for {self.names[worst]}, the interpreter {expected[worst]}")


def _assembly(function: Any) -> str:
    """LLVM's text of a CasADi function of one dense vector."""
    lines, held = ["define void @equations(ptr %in, ptr %out) {"], {}
    for k in range(function.n_instructions()):
        operation, r = function.instruction_id(k), f"%r{k}"
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            lines += [f"%p{k} = getelementptr double, ptr %out, i64 {outputs[1]}", f"store double {held[inputs[0]]}, ptr %p{k}"]
            continue
        if operation == ca.OP_CONST:
            r = f"0x{np.float64(function.instruction_constant(k)).view(np.uint64):016X}"
        elif operation == ca.OP_INPUT:
            lines += [f"%p{k} = getelementptr double, ptr %in, i64 {inputs[1]}", f"{r} = load double, ptr %p{k}"]
        elif operation in _FUNCTIONS:
            name, count = _FUNCTIONS[operation]
            arguments = ", ".join(f"double {held[i]}" for i in inputs[:count])
            lines.append(f"{r} = call double @{name}({arguments})")
        elif operation in _TEMPLATES:
            a, b = (held[inputs[0]], held[inputs[-1]])
            lines.append(_TEMPLATES[operation].format(r=r, a=a, b=b))
        else:
            raise DescriptionError(f"operation {operation} of CasADi is not translated to machine code; write it with other functions")
        held[outputs[0]] = r
    declared = [f"declare double @{name}({', '.join(['double'] * count)})" for name, count in dict.fromkeys(_FUNCTIONS.values())]
    return "\n".join([*declared, *lines, "ret void", "}"])
