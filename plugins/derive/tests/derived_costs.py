"""The table of docs/methods.md, "By hand and by computer": `taskset -c 0 python -m quickreturn.plugins.derive.tests.derived_costs`."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from quickreturn.derive import Model
from quickreturn.plugins import derive
from quickreturn.plugins.derive import witness
from quickreturn.plugins.derive.equations import Equations
from quickreturn.plugins.derive.tests.reference.by_hand import by_hand, sizes
from quickreturn.plugins.derive.tests.reference.derived_beam import TERMS, DerivedBeam
from quickreturn.plugins.derive.witness.description import constants, quick_return
from quickreturn.reference_model import motion
from quickreturn.reference_model.joint import CLOSED
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_states import rates
from tests.test_structure import lines_of_code

EVALUATIONS = 300
REPETITIONS = 15


def fastest(calls: Sequence[Callable[[], Any]]) -> list[float]:
    """Microseconds a call, the least of several turns; the functions take turns."""
    best = [np.inf] * len(calls)
    for _ in range(REPETITIONS):
        for k, call in enumerate(calls):
            began = time.process_time()
            for _ in range(EVALUATIONS):
                call()
            best[k] = min(best[k], (time.process_time() - began) / EVALUATIONS * 1e6)
    return best


def main() -> None:
    """Print lines, processor time to derive and compile, times of an evaluation, and the largest difference of a term."""
    (written,), (kit,), (described,) = (list(package.__path__) for package in (motion, derive, witness))
    files = {
        "by hand": [*Path(written).glob("*.py")],
        "description": [Path(described) / "description.py"],
        "kit": [*Path(kit).glob("*.py")],
    }
    print("lines of code:", {name: sum(lines_of_code(each.read_text("utf-8")) for each in paths) for name, paths in files.items()})
    for modes in (1, 2, 5, 7, 11):
        scene = run_24()
        hand = BeamModel.following(scene, modes)
        began = time.process_time()
        system = quick_return(hand.parameters.tables, modes)
        Equations(system)
        derived = time.process_time() - began
        began = time.process_time()
        model = Model(system)
        compiled = time.process_time() - began
        state = DerivedBeam(hand, CLOSED).random_state(1)
        y, size = state.y, sizes(state)
        found = by_hand(hand, hand.workspace, rates(hand, y), {})
        terms = {name: value for name, value in state.expected.items() if name in TERMS}
        error = max(float(np.max(np.abs(found[name] - value))) / size[name] for name, value in terms.items())
        x = model.input(0.0, model.state(state.q, state.v), model.values(constants(scene)))
        code, interpreter, out = model._rates, model._rates.interpreter, np.empty_like(y)
        p, w = hand._at
        from quickreturn.reference_model.entries import KERNEL

        arguments = p.address, w.address, y.ctypes.data, out.ctypes.data, 0
        hand_time, code_time, interpreted = fastest([
            lambda: KERNEL(*arguments),  # noqa: B023
            lambda: code._call(*code._at),  # noqa: B023
            lambda: interpreter(x),  # noqa: B023
        ])  # fmt: skip
        print(
            f"{modes} shapes: derive {derived:.2f} s, derive and compile {compiled:.2f} s, {interpreter.n_instructions()} instructions;"
            f" by hand {hand_time:.2f} us, machine code {code_time:.2f} us, interpreter {interpreted:.1f} us; terms {error:.0e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
