"""d'Alembert's principle (Kane's method): partial velocities are Jacobians, bias accelerations second derivatives along the velocity.

Time is one more coordinate, whose rate is 1: z = (q, t), w = (v, 1). With e any place or angle,

    partial velocity   V = de/dz                         rate               e' = V w
    bias acceleration  A = the second derivative of e along w, which is e'' without q''
    mass matrix        M = sum m V^T V                   forces             Q = sum V^T F - sum m V^T (A - gravity)
    loops gap(z) = 0   G = d gap/dz,  G (q'', 0) = -b    equations          M (q'', 0) = Q + C^T force

as in the thesis, equation 4.5. The row of time is the power of prescribed motions. C is the Jacobian of what the forces of loops act on. It
is that of the gap, G, unless a force acts elsewhere than the motion that it makes (inverse dynamics).
"""

from typing import Any, Literal, get_args

import casadi as ca
import numpy as np

from quickreturn.plugins.derive.system import COMMON_COLUMNS, Points, System, column, turned
from quickreturn.plugins.derive.units import DescriptionError, per

Form = Literal["projection", "multipliers"]


class Equations:
    """A system's equations of motion as expressions in time, coordinates, speeds, parameters and rows of tables.

    Args:
        system: the description.
        form: "projection" on the free speeds, with the loops solved for the coordinates that they give; or Lagrange "multipliers".
        feedback: 1/s, rate at which the gap of a loop, due to integration errors, decays; 0: it does not.

    Attributes:
        M, Q: mass matrix and forces, with the row of time last.
        gap, G, bias: of all loops.
        C: Jacobian of what their forces act on.
        elsewhere: rows of loops whose forces act elsewhere.
        q, v, a: coordinates, their rates and accelerations.
        free: indices of the speeds that the state contains.
        forces, lost, done: symbols of the loops' forces, the dissipated energy and the work.
        acceleration, force: q'' and the loops' forces.
        state, rates: coordinates, speeds, dissipated energy and work; their rates.
        outputs: name -> expression and unit.
        stated: the same, with accelerations and forces of loops as symbols.
    """

    def __init__(self, system: System, form: Form = "projection", feedback: float = 100.0) -> None:
        if form not in get_args(Form) or not system.coordinates:
            wrong = f"the form {form!r} is not known; take one of {', '.join(get_args(Form))}"
            raise DescriptionError(wrong if system.coordinates else f"{system.name!r} has no coordinate")
        if not 0.0 <= feedback < np.inf:
            raise DescriptionError(f"a feedback of {feedback:g} 1/s opens the loops of {system.name!r}; give 0 or more")
        each, loops, self.feedback = system.coordinates, system.loops, feedback
        self.q, self.v, self.a = (column(*(getattr(c, kind) for c in each)) for kind in "qva")
        self._z, self._w = column(self.q, system.time), column(self.v, 1)
        n, gravity = len(each), system.gravity
        M, Q, potential, work, heat = ca.SX(n + 1, n + 1), ca.SX(n + 1, 1), ca.SX(0), ca.SX(0), ca.SX(0)
        for points in system.points:
            more_M, more_Q, place = self._moving(points, gravity)
            M, Q, potential = M + more_M, Q + more_Q, potential - ca.dot(gravity, place)
        for inertia, angle in system.turning:
            V = ca.jacobian(angle, self._z)
            M, Q = M + inertia * (V.T @ V), Q - inertia * V.T * self._bias(angle)
        for value in system.energies:
            potential, Q = potential + value, Q - ca.jacobian(value, self._z).T
        for on, value in system.loads:
            work, Q = work + ca.dot(value, self._rate(on)), Q + ca.jacobian(on, self._z).T @ value
        for on, coefficient in system.dampers:
            drag = coefficient * self._rate(on)
            heat, Q = heat + ca.dot(drag, self._rate(on)), Q - ca.jacobian(on, self._z).T @ drag
        if ca.depends_on(Q, column(self.a, *(loop.force for loop in loops))):
            raise DescriptionError(f"a load of {system.name!r} depends on an acceleration or on a loop's force; only outputs may")
        gap, forces = column(*(loop.gap for loop in loops)), column(*(loop.force for loop in loops))
        on, rows = column(*(loop.by for loop in loops)), [loop.elsewhere for loop in loops for _ in range(loop.gap.numel())]
        self.elsewhere = [k for k, elsewhere in enumerate(rows) if elsewhere]
        G, C = ca.jacobian(gap, self._z), ca.jacobian(on, self._z)
        expressions = [M, Q, gap, G, C, self._bias(gap), 0.5 * ca.bilin(M, self._w, self._w), potential, work, heat]
        # after all derivatives: frozen values become present ones
        present = column(*system.frozen.values()), column(*(self.q[k] for k in system.frozen))
        expressions = _replaced([*expressions, *(e for e, _ in system.outputs.values())], *present)
        self.M, self.Q, self.gap, self.G, self.C, self.bias, kinetic, potential, work, heat, *results = expressions

        self._given = [k for loop in loops for k in loop.gives]
        if form == "projection":
            if len(self._given) != gap.numel() or len(set(self._given)) != gap.numel():
                raise DescriptionError(
                    f"the loops of {system.name!r} have {gap.numel()} rows and give {[each[k].name for k in self._given]}: projection needs"
                    " as many coordinates, each once; name them by gives=[...], or take the form 'multipliers'"
                )
            names = [each[k].name for k in self._given]
            if ca.sprank(self.G[:, self._given]) < gap.numel():
                raise DescriptionError(
                    f"the loops of {system.name!r} do not contain all that they give, {names}; name others by gives=[...]"
                )
            if ca.sprank(self.C[:, self._given]) < gap.numel():
                raise DescriptionError(
                    f"the forces of the loops of {system.name!r} do not act on all that these give, {names}; name by gives=[...] those"
                    " on which they act, or take the form 'multipliers'"
                )
            self.free = [k for k in range(n) if k not in self._given]
            self.acceleration, self.force, velocity, q_rate = self._projected(feedback)
        else:
            self.free, velocity, q_rate = list(range(n)), self.v, self.v
            self.acceleration, self.force = self._with_multipliers(feedback)
        driven = self.M[n, :n] @ self.acceleration - self.Q[n] - ca.dot(self.C[:, n], self.force)
        driven += ca.dot(self.force[self.elsewhere], (self.C @ self._w)[self.elsewhere])
        lost, done = ca.SX.sym("dissipated"), ca.SX.sym("work")
        self.state = column(self.q, self.v[self.free, :], lost, done)
        self.rates = column(q_rate, self.acceleration[self.free, :], heat, work + driven)
        shown = {c.name: (c.q, c.unit) for c in each} | {c.rate_name: (c.v, per(c.unit, "s")) for c in each}
        shown |= {force.name(): (force, per("J", loop.by_unit)) for loop in loops for force in ca.vertsplit(loop.force)}
        shown |= {name: (e, unit) for (name, (_, unit)), e in zip(system.outputs.items(), results, strict=True)}
        energies = (kinetic, potential, lost, done, kinetic + potential + lost - done)
        shown |= {name: (e, "J") for name, e in zip(COMMON_COLUMNS[1:], energies, strict=True)}
        self.forces, self.lost, self.done, self.stated = forces, lost, done, shown
        # substitute accelerations and forces, then the speeds that the loops give
        values = _replaced([self.rates, *(e for e, _ in shown.values())], column(self.a, forces), column(self.acceleration, self.force))
        self.acceleration, self.force, self.rates, *values = _replaced([self.acceleration, self.force, *values], self.v, velocity)
        self.outputs = {name: (e, unit) for (name, (_, unit)), e in zip(shown.items(), values, strict=True)}

    def _rate(self, expression: ca.SX) -> ca.SX:
        return ca.jtimes(expression, self._z, self._w)

    def _bias(self, expression: ca.SX) -> ca.SX:
        return self._rate(self._rate(expression))

    def _moving(self, points: Points, gravity: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Mass matrix, forces and first moment of mass points, in components of their own frame: these are the shortest."""
        m, x, y, origin, angle = points
        frame = ca.horzcat(turned(angle, 1.0), turned(angle, 0.0, 1.0))
        ones, turn, spin, spin_up = ca.SX.ones(x.numel()), ca.jacobian(angle, self._z), self._rate(angle), self._bias(angle)
        V0, A0 = frame.T @ ca.jacobian(origin, self._z), frame.T @ (self._bias(origin) - gravity)
        Vx = ones @ V0[0, :] - y @ turn + ca.jacobian(x, self._z)
        Vy = ones @ V0[1, :] + x @ turn + ca.jacobian(y, self._z)
        Ax = A0[0] - spin_up * y - spin**2 * x - 2.0 * spin * self._rate(y) + self._bias(x)
        Ay = A0[1] + spin_up * x - spin**2 * y + 2.0 * spin * self._rate(x) + self._bias(y)
        M = Vx.T @ (ca.diag(m) @ Vx) + Vy.T @ (ca.diag(m) @ Vy)
        moment = ca.sum1(m) * origin + frame @ column(ca.dot(m, x), ca.dot(m, y))
        return _symmetric(M), -Vx.T @ (m * Ax) - Vy.T @ (m * Ay), moment

    def _projected(self, feedback: float) -> tuple[ca.SX, ...]:
        """The equations projected on the free speeds u: v = B u + c, q'' = B u' + c0, and A^T (M q'' - Q) = 0 has no force of a loop.

        G B = 0 and C A = 0, so A is B unless a force acts elsewhere.
        """
        n, free, given = self.q.numel(), self.free, self._given
        inverse = ca.inv_minor(self.G[:, given]) if given else ca.SX(0, 0)
        lever = ca.inv_minor(self.C[:, given]) if self.elsewhere else inverse
        B, c, c0, back = ca.SX(n, len(free)), ca.SX(n, 1), ca.SX(n, 1), ca.SX(n, 1)
        B[free, :] = ca.SX.eye(len(free))
        if given:
            B[given, :], c[given] = -inverse @ self.G[:, free], -inverse @ self.G[:, n]
            c0[given], back[given] = -inverse @ self.bias, -feedback * (inverse @ self.gap)
        M, Q = self.M[:n, :n], self.Q[:n]
        if self.elsewhere and free:
            A = ca.SX(B)
            A[given, :] = -lever @ self.C[:, free]
            acceleration = B @ ca.solve(A.T @ (M @ B), A.T @ (Q - M @ c0)) + c0
        else:
            acceleration = B @ _solved(_symmetric(B.T @ (M @ B)), B.T @ (Q - M @ c0)) + c0
        velocity = B @ column(*(self.v[k] for k in free)) + c
        force = lever.T @ (M @ acceleration - Q)[given] if given else ca.SX(0, 1)
        return acceleration, force, velocity, velocity + back

    def _with_multipliers(self, feedback: float) -> tuple[ca.SX, ca.SX]:
        """The equations with the loops' forces as unknowns; the mass matrix may be singular if loops give coordinates without inertia."""
        n = self.q.numel()
        M, Q, G, C = self.M[:n, :n], self.Q[:n], self.G[:, :n], self.C[:, :n]
        if not G.size1():
            return _solved(M, Q), ca.SX(0, 1)
        wanted = -self.bias - 2.0 * feedback * (self.G @ self._w) - feedback**2 * self.gap
        # adding G^T G times a positive weight on both sides changes no solution and makes the matrix positive definite
        weight = ca.trace(M) / ca.trace(G.T @ G)
        held = _solved(M + weight * (G.T @ G), ca.horzcat(Q + weight * (G.T @ wanted), C.T))
        solved = ca.solve if self.elsewhere else _solved
        force = solved(G @ held[:, 1:], wanted - G @ held[:, 0])
        return held[:, 0] + held[:, 1:] @ force, force


def _solved(A: ca.SX, b: ca.SX) -> ca.SX:
    """The solution x of A x = b with a symmetric positive definite matrix, by L D L^T without pivots or roots."""
    n = A.size1()
    L, D, x = ca.SX.eye(n), [ca.SX(0)] * n, [b[i, :] for i in range(n)]
    for i in range(n):
        for j in range(i):
            L[i, j] = (A[i, j] - sum((L[i, k] * L[j, k] * D[k] for k in range(j)), ca.SX(0))) / D[j]
        D[i] = A[i, i] - sum((L[i, k] ** 2 * D[k] for k in range(i)), ca.SX(0))
        x[i] -= sum((L[i, k] * x[k] for k in range(i)), ca.SX(1, b.size2()))
    for i in reversed(range(n)):
        x[i] = x[i] / D[i] - sum((L[k, i] * x[k] for k in range(i + 1, n)), ca.SX(1, b.size2()))
    return ca.vertcat(ca.SX(0, b.size2()), *x)


def _symmetric(M: ca.SX) -> ca.SX:
    """The matrix from its lower half: equal elements are computed once."""
    return ca.tril2symm(ca.tril(M))


def _replaced(expressions: list[ca.SX], old: ca.SX, new: ca.SX) -> list[Any]:
    return list(ca.substitute(expressions, [old], [ca.densify(new)]))
