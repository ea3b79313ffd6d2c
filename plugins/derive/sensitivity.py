"""Derivatives of outputs by parameters: the differentiated equations of motion are integrated along with the motion."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
import pandas as pd

from quickreturn.plugins.derive.compiled import Values
from quickreturn.plugins.derive.machine_code import MachineCode
from quickreturn.plugins.derive.model import OPENS, Model, grid
from quickreturn.plugins.derive.system import column
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si, per


def sensitivities(
    model: Model, to: Sequence[str], start: Values, duration: float, step: float, tolerance: float = 1e-9, parameters: Values | None = None
) -> pd.DataFrame:
    """Derivatives of all outputs by parameters on a uniform grid of time, exact except for the integration error.

    Args:
        model: in the form "projection", without tables.
        to: names of the parameters.
        start: see `Model.simulate`; coordinates that the loops give change with the parameters.
        duration: s.
        step: time between two rows, s.
        tolerance: see `Model.simulate`.
        parameters: name -> changed value, in the parameter's unit.

    Returns:
        Columns "OUTPUT by PARAMETER", units in `attrs["units"]`.
    """
    e, system = model.equations, model.system
    if system.tables or len(e.free) + e.gap.numel() != e.q.numel():
        raise DescriptionError(
            f"sensitivities of {system.name!r} need the form 'projection', and no tables: nothing tells what those depend on"
        )
    model.refuse_unknown(to, "parameter", model.parameters)
    times, p, y = grid(duration, step), model.values(parameters), model.start(start, parameters)
    chosen, size = [list(model.parameters).index(name) for name in to], len(y)
    # y' = f(y, p) and S = dy/dp: S' = df/dy S + df/dp, a derivative along (S, dp)
    S = ca.SX.sym("S", size, len(chosen))
    along = [column(0, S[:, k], ca.SX(np.eye(len(p))[:, which])) for k, which in enumerate(chosen)]
    rates, shown = (
        column(*(ca.jtimes(f, model.inputs, each) for each in along)) for f in (e.rates, column(*(f for f, _ in e.outputs.values())))
    )
    inputs = column(model.inputs, ca.vec(S))
    code = MachineCode(inputs, column(e.rates, rates), [f"rate {k}" for k in range(size * (1 + len(chosen)))])
    # at the start G dq + d gap/dp = 0 in the coordinates that the loops give
    begin = np.zeros((size, len(chosen)))
    if given := [k for loop in system.loops for k in loop.gives if system.coordinates[k].name not in start]:
        loops = ca.Function("loops", [model.inputs], [e.G[:, given], ca.jacobian(e.gap, model.constants)[:, chosen]])
        by_q, by_p = (np.array(each) for each in loops(model.input(0.0, y, p)))
        begin[given] = np.linalg.lstsq(by_q, -by_p, rcond=None)[0]
        if np.max(np.abs(by_q @ begin[given] + by_p)) > OPENS * np.max(np.abs(by_p)):
            named = [coordinate.name for loop in system.loops for k in loop.gives if (coordinate := system.coordinates[k]).name in start]
            raise DescriptionError(
                f"with other parameters the loops of {system.name!r} do not close at the start, because {', '.join(named)} stays as given;"
                " leave it out, for the loops to give it"
            )

    def rate(time: float, Y: Array, p: Array) -> Array:
        return code(np.concatenate([[time], Y[:size], p, Y[size:]]))

    sizes = np.append(model.error_sizes(), np.full(begin.size, np.inf))
    states, steps = model.integrate(rate, np.concatenate([y, begin.T.ravel()]), times, p, tolerance, sizes)
    model.check_drives(times, states[:, :size], p)
    model.check_motion(model.observe(times, states[:, :size], p), y, p, tolerance, steps)
    every = np.vstack([times, states.T[:size], np.tile(p[:, None], len(times)), states.T[size:]])
    values = np.array(ca.Function("changes", [inputs], [ca.densify(shown)])(every)).T
    units = {f"{output} by {name}": per(unit, system.parameters[name][2]) for name in to for output, (_, unit) in e.outputs.items()}
    frame = pd.DataFrame(values, columns=list(units)) / [in_si(unit)[0] for unit in units.values()]
    frame.insert(0, "time", times)
    frame.attrs["units"] = {"time": "s"} | units
    return frame
