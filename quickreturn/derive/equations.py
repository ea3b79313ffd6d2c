"""d'Alembert's principle (Kane's method): partial velocities are Jacobians, bias accelerations second derivatives along the velocity.

With coordinates q, speeds v and places r(q, t), time is one more coordinate whose rate is 1: z = (q, t), w = (v, 1). Then, with e any
place or angle,

    partial velocity   V = de/dz                         rate               e' = V w
    bias acceleration  A = the part of e'' without q'' = the second derivative of e along w
    mass matrix        M = sum m V^T V                   forces             Q = sum V^T F - sum m V^T (A - gravity)
    loops gap(z) = 0   G = d gap/dz,  G (q'', 0) = -b    equations          M (q'', 0) = Q + G^T force

as in the thesis, equation 4.5. The row of time is the power that prescribed motions take.
"""

from typing import Literal

import casadi as ca

from quickreturn.derive.system import Points, System
from quickreturn.derive.units import DescriptionError

Form = Literal["projection", "multipliers"]

class Equations:
    """A system's equations of motion as expressions in time, coordinates, speeds, parameters and rows of tables.

    Args:
        system: as described.
        form: "projection" on the free speeds, the loops solved for the coordinates that they give; or with Lagrange "multipliers".
        feedback: 1/s, rate at which a gap that the integration's error leaves decays; 0: none.

    Attributes:
        M, Q: mass matrix and forces, with the row of time last.
        gap, G, bias: of all loops.
        q, v, speeds: coordinates, their rates, and those of them that the state contains.
        free: indices of the speeds.
        acceleration, force: q'' and the loops' forces.
        state_rates: of coordinates, speeds, dissipated energy and work.
        outputs: name -> expression and unit.
    """

    def __init__(self, system: System, form: Form = "projection", feedback: float = 100.0) -> None:
        each = system.coordinates
        self.q, self.v = ca.vertcat(*(c.q for c in each)), ca.vertcat(*(c.v for c in each))
        self._z, self._w = ca.vertcat(self.q, system.time), ca.vertcat(self.v, 1)
        n = len(each)
        M, Q = ca.SX(n + 1, n + 1), ca.SX(n + 1, 1)
        for points in system.points:
            more_M, more_Q = self._turning(points) if points.y is None else self._moving(points, system.gravity)
            M, Q = M + more_M, Q + more_Q
        potential, work, heat = ca.SX(0), ca.SX(0), ca.SX(0)
        for _, value in system.energies:
            potential, Q = potential + value, Q - ca.jacobian(value, self._z).T
        for points in system.points:
            if points.y is not None:
                x, y = _turned(points.angle, points.x, points.y)
                potential -= ca.dot(points.mass, system.gravity[0] * (points.origin[0] + x) + system.gravity[1] * (points.origin[1] + y))
        for _, on, value in system.loads:
            Q, work = Q + ca.mtimes(ca.jacobian(on, self._z).T, value), work + ca.dot(value, self._rate(on))
        for _, on, coefficient in system.dampers:
            force = coefficient * self._rate(on)
            Q, heat = Q - ca.mtimes(ca.jacobian(on, self._z).T, force), heat + ca.dot(force, self._rate(on))
        gap = ca.vertcat(*(loop.gap for loop in system.loops))
        forces = ca.vertcat(*(loop.force for loop in system.loops))
        G, bias = ca.jacobian(gap, self._z), self._bias(gap)
        gaps_rate = ca.mtimes(G, self._w)
        kinetic = 0.5 * ca.bilin(M, self._w, self._w)
        named = {name: expression for name, (expression, _) in system.outputs.items()}

        # all derivatives are taken: frozen values become present ones
        now = list(system.frozen.values()), [self.q[k] for k in system.frozen]
        found = ca.substitute([M, Q, gap, G, bias, gaps_rate, kinetic, potential, work, heat, *named.values()], *map(list, _columns(*now)))
        self.M, self.Q, self.gap, self.G, self.bias, gaps_rate, kinetic, potential, work, heat, *expressions = found

        given = [k for loop in system.loops for k in loop.gives]
        self.free, self._given = list(range(n)), given
        if form == "projection":
            if len(given) != self.gap.numel() or len(set(given)) != len(given):
                names = ", ".join(each[k].name for k in given) or "none"
                raise DescriptionError(
                    f"the loops of {system.name!r} have {self.gap.numel()} rows and give {len(given)} coordinates ({names}): projection needs"
                    " as many, each once; name them by gives=[...] or use form='multipliers'"
                )
            self.free = [k for k in range(n) if k not in given]
            velocity, q_rate = self._project(feedback)
        else:
            velocity, q_rate = self.v, self.v
            self._multiply(feedback, gaps_rate)
        self.speeds = self.v[self.free]
        # the row of time: power that prescribed motions take
        driven = ca.mtimes(self.M[n, :n], self.acceleration) - self.Q[n] - ca.dot(self.G[:, n], self.force)
        energies = {
            "kinetic_energy": kinetic,
            "potential_energy": potential,
            "dissipated_energy": ca.SX.sym("dissipated"),
            "work": ca.SX.sym("work"),
        }
        self.integrals = ca.vertcat(energies["dissipated_energy"], energies["work"])
        energies["energy_balance"] = kinetic + potential + self.integrals[0] - self.integrals[1]
        shown = {c.name: (c.q, c.unit) for c in each} | {c.rate_name: (c.v, f"({c.unit})/s") for c in each}
        for loop in system.loops:
            shown |= {force.name(): (force, f"J/({loop.unit})") for force in ca.vertsplit(loop.force)}
        shown |= {name: (e, system.outputs[name][1]) for name, e in zip(named, expressions, strict=True)}
        shown |= {name: (e, "J") for name, e in energies.items()}
        rates = ca.vertcat(q_rate, self.acceleration[self.free], heat, work + driven)
        # what outputs and powers say of accelerations and forces, then of the rates that the loops give
        accelerations = ca.vertcat(*(c.a for c in each))
        solved = ca.substitute(
            [rates, *(e for e, _ in shown.values())], [ca.vertcat(accelerations, forces)], [ca.vertcat(self.acceleration, self.force)]
        )
        self.velocity = velocity
        solved = ca.substitute([self.acceleration, self.force, *solved], [self.v], [velocity])
        self.acceleration, self.force, self.state_rates, *values = solved
        self.outputs = {name: (e, unit) for (name, (_, unit)), e in zip(shown.items(), values, strict=True)}
        self.state = ca.vertcat(self.q, self.speeds, self.integrals)

    def _rate(self, expression: ca.SX) -> ca.SX:
        return ca.jtimes(expression, self._z, self._w)

    def _bias(self, expression: ca.SX) -> ca.SX:
        return self._rate(self._rate(expression))

    def _turning(self, body: Points) -> tuple[ca.SX, ca.SX]:
        V = ca.jacobian(body.x, self._z)
        return body.mass * ca.mtimes(V.T, V), -body.mass * V.T * self._bias(body.x)

    def _moving(self, points: Points, gravity: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Of mass points, in the components of their own frame, which are shorter than those along n1 and n2."""
        x, y, m, angle = points.x, points.y, points.mass, points.angle
        ones = ca.SX.ones(x.numel())
        origin = _turned(-angle, *ca.vertsplit(ca.jacobian(points.origin, self._z)))
        pull = _turned(-angle, *ca.vertsplit(self._bias(points.origin) - gravity))
        turn, spin, spin_up = ca.jacobian(angle, self._z), self._rate(angle), self._bias(angle)
        Vx = ca.mtimes(ones, origin[0]) - ca.mtimes(y, turn) + ca.jacobian(x, self._z)
        Vy = ca.mtimes(ones, origin[1]) + ca.mtimes(x, turn) + ca.jacobian(y, self._z)
        Ax = pull[0] - spin_up * y - spin**2 * x - 2.0 * spin * self._rate(y) + self._bias(x)
        Ay = pull[1] + spin_up * x - spin**2 * y + 2.0 * spin * self._rate(x) + self._bias(y)
        M = ca.mtimes(Vx.T, ca.mtimes(ca.diag(m), Vx)) + ca.mtimes(Vy.T, ca.mtimes(ca.diag(m), Vy))
        return M, -ca.mtimes(Vx.T, m * Ax) - ca.mtimes(Vy.T, m * Ay)

    def _project(self, feedback: float) -> tuple[ca.SX, ca.SX]:
        """On the free speeds u: v = B u + c and q'' = B u' + c0, so that B^T (M q'' - Q) = 0 contains no force of a loop."""
        n, free, given = self.q.numel(), self.free, self._given
        inverse = ca.inv_minor(self.G[:, given]) if given else ca.SX(0, 0)
        B, c, c0, back = ca.SX(n, len(free)), ca.SX(n, 1), ca.SX(n, 1), ca.SX(n, 1)
        B[free, :] = ca.SX.eye(len(free))
        if given:
            B[given, :] = -ca.mtimes(inverse, self.G[:, free])
            c[given], c0[given] = -ca.mtimes(inverse, self.G[:, n]), -ca.mtimes(inverse, self.bias)
            back[given] = -feedback * ca.mtimes(inverse, self.gap)
        M = self.M[:n, :n]
        self.reduced = ca.mtimes(B.T, ca.mtimes(M, B))
        rest = ca.mtimes(B.T, self.Q[:n] - ca.mtimes(M, c0))
        self.acceleration = ca.mtimes(B, solved(self.reduced, rest)) + c0
        lacking = (ca.mtimes(M, self.acceleration) - self.Q[:n])[given]
        self.force = ca.mtimes(inverse.T, lacking) if given else ca.SX(0, 1)
        velocity = ca.mtimes(B, self.v[free]) + c
        return velocity, velocity + back

    def _multiply(self, feedback: float, gaps_rate: ca.SX) -> None:
        """With the loops' forces as unknowns; the mass matrix may be singular where loops hold what has no inertia."""
        n = self.q.numel()
        M, Q, G = self.M[:n, :n], self.Q[:n], self.G[:, :n]
        wanted = -self.bias - 2.0 * feedback * gaps_rate - feedback**2 * self.gap
        # G^T G times any positive weight, with the same on the right side, changes no solution and makes the matrix positive definite
        weight = ca.trace(M) / ca.trace(ca.mtimes(G.T, G)) if G.size1() else 0.0
        held = solved(M + weight * ca.mtimes(G.T, G), ca.horzcat(Q + weight * ca.mtimes(G.T, wanted), G.T))
        by_force = held[:, 1:]
        self.force = solved(ca.mtimes(G, by_force), wanted - ca.mtimes(G, held[:, 0])) if G.size1() else ca.SX(0, 1)
        self.acceleration = held[:, 0] + ca.mtimes(by_force, self.force)
        self.reduced = M


def solved(A: ca.SX, b: ca.SX) -> ca.SX:
    """The solution x of A x = b with a symmetric positive definite matrix, by L D L^T without pivots or roots."""
    n = A.size1()
    L, D, x = [[ca.SX(0)] * n for _ in range(n)], [ca.SX(0)] * n, [b[i, :] for i in range(n)]
    for i in range(n):
        for j in range(i):
            L[i][j] = A[i, j] - sum((L[i][k] * L[j][k] * D[k] for k in range(j)), ca.SX(0))
            L[i][j] = L[i][j] / D[j]
        D[i] = A[i, i] - sum((L[i][k] ** 2 * D[k] for k in range(i)), ca.SX(0))
        x[i] = x[i] - sum((L[i][k] * x[k] for k in range(i)), ca.SX.zeros(1, b.size2()))
    for i in reversed(range(n)):
        x[i] = x[i] / D[i] - sum((L[k][i] * x[k] for k in range(i + 1, n)), ca.SX.zeros(1, b.size2()))
    return ca.vertcat(*x)


def _turned(angle: ca.SX, x: ca.SX, y: ca.SX) -> tuple[ca.SX, ca.SX]:
    c, s = ca.cos(angle), ca.sin(angle)
    return c * x - s * y, s * x + c * y


def _columns(symbols: list[ca.SX], values: list[ca.SX]) -> tuple[list[ca.SX], list[ca.SX]]:
    return ([ca.vertcat(*symbols)], [ca.vertcat(*values)]) if symbols else ([], [])
