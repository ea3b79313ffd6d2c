"""Translates the instructions of a CasADi function to LLVM and compiles them with llvmlite; this needs no C compiler."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any, Final

import casadi as ca
import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray
from scipy import special

from quickreturn.plugins.derive.units import DescriptionError

Array = NDArray[np.float64]

#: Number of evaluations.
SAMPLES: Final = 16
_OF_ONE: Final = {
    "assign": lambda a: a, "neg": np.negative, "inv": lambda a: 1.0 / a, "sq": np.square, "twice": lambda a: 2.0 * a,
    "not": lambda a: 1.0 * (a == 0.0), "sign": np.sign, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh,
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "fabs": np.abs, "floor": np.floor, "ceil": np.ceil, "erf": special.erf,
    "log1p": np.log1p, "expm1": np.expm1,
}  # fmt: skip
_OF_TWO: Final = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "lt": lambda a, b: 1.0 * (a < b),
    "le": lambda a, b: 1.0 * (a <= b),
    "eq": lambda a, b: 1.0 * (a == b), "ne": lambda a, b: 1.0 * (a != b), "and": np.multiply,
    "if_else_zero": lambda a, b: np.where(a != 0.0, b, 0.0), "constpow": np.power, "fmin": np.fmin, "fmax": np.fmax, "atan2": np.arctan2,
    "pow": np.power, "fmod": np.fmod, "copysign": np.copysign, "hypot": np.hypot,
}  # fmt: skip
#: CasADi's number of an operation -> the function.
_OPERATIONS: Final[dict[int, Callable[..., Any]]] = {getattr(ca, f"OP_{name.upper()}"): each for name, each in (_OF_ONE | _OF_TWO).items()}


def rounding(function: Any, x: Array) -> Array:
    """The spread of each output of a function of one dense vector at x, over evaluations that round differently."""
    random, unit = np.random.default_rng(0), np.finfo(float).eps
    values: dict[int, Array] = {}
    spread = np.zeros(function.numel_out())
    with np.errstate(all="ignore"):
        for k in range(function.n_instructions()):
            operation, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_OUTPUT:
                spread[outputs[1]] = np.ptp(values[inputs[0]])
            elif operation == ca.OP_INPUT:
                values[outputs[0]] = np.full(SAMPLES, x[inputs[1]])
            elif operation == ca.OP_CONST:
                values[outputs[0]] = np.full(SAMPLES, function.instruction_constant(k))
            else:
                value = _OPERATIONS[operation](*(values[i] for i in inputs))
                values[outputs[0]] = value * (1.0 + unit * random.uniform(-1.0, 1.0, SAMPLES))
    return spread


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

#: Largest relative difference between machine code and CasADi's interpreter that needs no explanation.
AGREEMENT: Final = 1e-12
#: Largest difference over the spread that roundings alone make (`rounding`). Fused operations round differently; a spread of sixteen
#: evaluations is some four standard deviations, and a wrong operation changes an output by very much more.
ROUNDED: Final = 10.0
#: Optimization level of the compiler, 0 to 3. At level 0 a function of 30,000 instructions compiles in half the time and runs three to
#: fifteen times as long.
EFFORT: Final = 2


class MachineCode:
    """A compiled function from one vector to another.

    Args:
        inputs: column of symbols.
        outputs: column of expressions.
        names: names of the outputs, for messages.
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

    def check(self, x: Array) -> None:
        """Compare machine code and interpreter for the inputs `x`.

        Raises:
            DescriptionError: an output is not a number, or the two differ by more than rounding explains.
        """
        compiled, expected = self(x), np.array(self.interpreter(x)).ravel()
        refuse_nan(self.names, expected)
        difference = np.abs(compiled - expected)
        if np.all(difference <= AGREEMENT * np.abs(expected)):
            return
        excess = difference - np.maximum(AGREEMENT * np.abs(expected), ROUNDED * rounding(self.interpreter, x))
        worst = int(np.argmax(excess))
        if not excess[worst] <= 0.0:
            raise DescriptionError(
                f"the machine code of this processor gives {compiled[worst]} for {self.names[worst]}, the interpreter {expected[worst]},"
                " and rounding does not explain it; please report it"
            )


def refuse_nan(names: Sequence[str], values: Array) -> None:
    """Raise DescriptionError if a value is not finite; the message names the first such value."""
    for name, value in zip(names, values, strict=True):
        if not np.isfinite(value):
            raise DescriptionError(f"{name} is {value} at the start; look for a root of a negative number or a division by zero there")


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
            raise DescriptionError(f"operation {operation} of CasADi is not translated to machine code; write it with other functions")
        operands[outputs[0]] = r
    return "\n".join([*lines, "ret void", "}"])
