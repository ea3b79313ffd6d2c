"""How outputs change with parameters: the equations of motion differentiated, and integrated along with the motion."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

from quickreturn.derive.machine_code import MachineCode
from quickreturn.derive.model import Model, Values
from quickreturn.derive.units import DescriptionError, in_si, per


def sensitivities(
    model: Model,
    to: Sequence[str],
    start: Values,
    duration: float,
    step: float,
    *,
    tolerance: float = 1e-9,
    parameters: Values | None = None,
) -> pd.DataFrame:
    """Derivatives of all outputs by parameters on a uniform grid of time, exact but for the integration.

    Args:
        model: in the form "projection", without tables.
        to: names of the parameters.
        start: see `Model.simulate`; coordinates that the loops give change with the parameters.
        duration: s.
        step: s, of the output.
        tolerance: see `Model.simulate`.
        parameters: changed values, in their units.

    Returns:
        Columns "OUTPUT by PARAMETER", units in `attrs["units"]`.
    """
    e, system = model.equations, model.system
    if system.tables or len(e.free) + e.gap.numel() != e.q.numel():
        raise DescriptionError(f"sensitivities of {system.name!r} need the form 'projection', and no tables: nothing tells what those depend on")
    p, y = model.values(parameters), model.start(start, parameters)
    chosen = [list(model.parameters).index(name) for name in to]
    size, n = len(y), e.q.numel()
    S = ca.SX.sym("S", size, len(chosen))
    along = [ca.vertcat(0, S[:, k], np.eye(len(p))[:, which]) for k, which in enumerate(chosen)]
    rates = ca.vertcat(e.rates, *(ca.jtimes(e.rates, model.inputs, direction) for direction in along))
    outputs = ca.vertcat(*(each for each, _ in e.outputs.values()))
    changes = ca.horzcat(*(ca.jtimes(outputs, model.inputs, direction) for direction in along))
    inputs = ca.vertcat(model.inputs, ca.vec(S))
    code = MachineCode(inputs, rates, [f"rate {k}" for k in range(rates.numel())])
    # the loops at the start: G dq + d gap/dp = 0 in the coordinates that they give
    begin = np.zeros((size, len(chosen)))
    given = [k for loop in system.loops for k in loop.gives if system.coordinates[k].name not in start]
    if given:
        by_q, by_p = ca.Function("loops", [model.inputs], [e.G, ca.jacobian(e.gap, model.constants)])(np.concatenate([[0.0], y, p]))
        begin[given] = -np.linalg.lstsq(np.array(by_q)[:, given], np.array(by_p)[:, chosen], rcond=None)[0]

    def rate(time: float, Y: np.ndarray) -> np.ndarray:
        return code(np.concatenate([[time], Y[:size], p, Y[size:]]))

    times = np.linspace(0.0, duration, round(duration / step) + 1)
    absolute = np.concatenate([model.error_sizes() * tolerance, np.full(size * len(chosen), np.inf)])
    found = solve_ivp(rate, (0.0, duration), np.concatenate([y, begin.T.ravel()]), "DOP853", times, rtol=tolerance, atol=absolute)
    columns = np.column_stack([found.t, found.y[:size].T, np.tile(p, (len(found.t), 1)), found.y[size:].T]).T
    values = np.array(ca.Function("changes", [inputs], [ca.densify(ca.vec(changes))])(columns)).T
    names, units = ["time"], ["s"]
    for name in to:
        for output, (_, unit) in e.outputs.items():
            names.append(f"{output} by {name}")
            units.append(per(unit, system.parameters[name][2]))
    factors = [in_si(unit)[0] for unit in units[1:]]
    frame = pd.DataFrame(np.column_stack([found.t, values / factors]), columns=names)
    frame.attrs["units"] = dict(zip(names, units, strict=True))
    return frame
