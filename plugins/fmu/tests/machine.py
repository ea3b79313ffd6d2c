"""A model of the mechanism that `pythonfmu` makes an FMU of (FMI 2): plain numpy that shares nothing with the project.

The follower is a beam of a few bending shapes in the frame of its base, small in bending. Coordinates are the angles q1, q2 and the shapes'
amplitudes; Lagrange's multiplier of "the crank's end is on the follower" is the slider's force. Lengths go in and out in mm.
"""

import math
import os

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

#: Parameter -> value at the start.
PARAMETERS = {
    "d": 420.0, "r": 110.0, "m1": 1.2, "c1": 0.03, "J1": 2e-3, "phi0": 3.14159, "w0": 12.0, "T": 0.6, "b": 0.05, "J2": 2e-5,
    "L": 0.6, "mu": 0.33, "EI": 20.0, "e": 1.5e-3, "g1": 0.14, "g2": 0.29, "g3": 0.46, "mt": 0.05, "Jt": 2e-6, "c": 0.0, "mode": 0.0,
}  # fmt: skip
OUTPUTS = ("phi", "omega", "q2", "s", "xt", "yt", "u", "a", "eps1", "eps2", "eps3", "F")
SHAPES = 7  # polynomials from which the bending modes are made
MODES = 3


class Machine(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for name, value in PARAMETERS.items():
            setattr(self, name, value)
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))
        for name in OUTPUTS:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        if self.mode == 3.0:
            raise RuntimeError("the licence has run out")
        if self.mode == 1.0:  # a planted mistake: the body at the tip has no mass
            self.mt = 0.0
        L, self.rd, self.rr = self.L, self.d / 1e3, self.r / 1e3
        x, weight = np.polynomial.legendre.leggauss(16)
        x, weight = 0.5 * L * (x + 1.0), 0.5 * L * weight * self.mu

        def shapes(at, derivative):
            """Values of x^2, x^3, ... over powers of L, or of their derivatives, shape (len(at), SHAPES)."""
            powers = np.arange(2, 2 + SHAPES)
            factor = [math.prod(range(p - derivative + 1, p + 1)) for p in powers]
            return np.array(factor) * (np.asarray(at)[:, None] / L) ** (powers - derivative) / L**derivative

        def matrices(values, slopes):
            mass = values(x).T * weight @ values(x)
            mass += self.mt * np.outer(values([L])[0], values([L])[0]) + self.Jt * np.outer(slopes([L])[0], slopes([L])[0])
            turning = (weight * x) @ values(x) + self.mt * L * values([L])[0] + self.Jt * slopes([L])[0]
            return mass, turning

        curved = shapes(x, 2)
        stiffness = curved.T * (weight / self.mu * self.EI) @ curved
        mass, _ = matrices(lambda at: shapes(at, 0), lambda at: shapes(at, 1))
        lower = np.linalg.cholesky(mass)
        inverse = np.linalg.inv(lower)
        squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
        self.to_shapes = (inverse.T @ vectors)[:, :MODES]
        self.shape = lambda at, derivative: (shapes([at], derivative) @ self.to_shapes)[0]
        self.squares, self.all_shapes = squares[:MODES], shapes
        _, self.turning = matrices(lambda at: shapes(at, 0) @ self.to_shapes, lambda at: shapes(at, 1) @ self.to_shapes)
        plain = shapes(x, 0) @ self.to_shapes
        self.drag = self.c / self.mu * (plain.T * weight) @ plain  # on velocities against the base
        self.heavy = self.J2 + weight @ x**2 + self.mt * L**2 + self.Jt
        self.J_crank = self.J1 + self.m1 * self.c1**2
        q1 = self.phi0
        end = self.rr * np.array([math.cos(q1), math.sin(q1)]) - [self.rd, 0.0]
        q2 = math.pi + math.atan2(-end[1], -end[0])
        along = self.rr * self.w0 * (-math.sin(q1) * -math.sin(q2) + math.cos(q1) * math.cos(q2))
        self.state = np.concatenate([[q1, q2], np.zeros(MODES), [self.w0, along / np.hypot(*end)], np.zeros(MODES)])
        self.observe()

    def accelerations(self, state):
        """Accelerations of all coordinates, the slider's force and its place."""
        n = MODES + 2
        (q1, q2), eta, (w1, w2), rate = state[:2], state[2:n], state[n : n + 2], state[n + 2 :]
        b1, b2 = np.array([math.cos(q2), math.sin(q2)]), np.array([-math.sin(q2), math.cos(q2)])
        crank = self.rr * np.array([math.cos(q1), math.sin(q1)])
        moves = np.array([-crank[1], crank[0]])
        end = crank - [self.rd, 0.0]
        s = b1 @ end
        W, slope, bend = self.shape(s, 0), self.shape(s, 1), self.shape(s, 2)
        tangent, curvature = slope @ eta, bend @ eta
        # g = b2.end - w(s) = 0, with s = b1.end: ds = b1.moves dq1 + (b2.end) dq2
        across = b2 @ end
        jacobian = np.concatenate([[b2 @ moves - tangent * (b1 @ moves), -s - tangent * across], -W])
        s_rate = (b1 @ moves) * w1 + across * w2
        # what remains of the second derivative of g without accelerations
        s_left = -(b1 @ crank) * w1**2 + 2.0 * (b2 @ moves) * w1 * w2 - s * w2**2
        g_left = -(b2 @ crank) * w1**2 - 2.0 * (b1 @ moves) * w1 * w2 - across * w2**2
        g_left -= tangent * s_left + curvature * s_rate**2 + 2.0 * (slope @ rate) * s_rate
        mass = np.zeros((n + 1, n + 1))
        mass[0, 0], mass[1, 1] = self.J_crank, self.heavy + eta @ eta
        mass[1, 2:n] = mass[2:n, 1] = self.turning
        mass[range(2, n), range(2, n)] = 1.0
        mass[n, :n] = mass[:n, n] = jacobian
        on_shapes = eta * w2**2 - self.squares * eta - self.drag @ rate
        loads = np.concatenate([[self.T - self.b * w1, -2.0 * (eta @ rate) * w2], on_shapes, [-g_left]])
        solution = np.linalg.solve(mass, loads)
        return solution[:n], solution[n], s, tangent

    def rates(self, state):
        return np.concatenate([state[MODES + 2 :], self.accelerations(state)[0]])

    def do_step(self, current_time, step_size):
        if current_time > 0.05 and self.mode == 2.0:
            os._exit(7)
        if current_time > 0.05 and self.mode == 4.0:
            return False
        if current_time > 0.05 and self.mode == 5.0:
            self.state[:] = math.nan
        y, h = self.state, step_size
        k1 = self.rates(y)
        k2 = self.rates(y + 0.5 * h * k1)
        k3 = self.rates(y + 0.5 * h * k2)
        self.state = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + self.rates(y + h * k3))
        self.observe()
        return True

    def observe(self):
        n, L = MODES + 2, self.L
        accelerations, multiplier, s, tangent = self.accelerations(self.state)
        q2, eta, w2, rate = self.state[1], self.state[2:n], self.state[n + 1], self.state[n + 2 :]
        u, du, ddu = (self.shape(L, 0) @ each for each in (eta, rate, accelerations[2:]))
        self.phi, self.omega, self.q2, self.s = math.degrees(self.state[0]), float(self.state[n]), float(q2), 1e3 * float(s)
        self.xt = 1e3 * (self.rd + L * math.cos(q2) - u * math.sin(q2))
        self.yt = 1e3 * (L * math.sin(q2) + u * math.cos(q2))
        self.u = 1e3 * float(u)
        along, across = -L * w2**2 - 2.0 * w2 * du - u * accelerations[1], L * accelerations[1] + ddu - u * w2**2
        turn = self.shape(L, 1) @ eta
        self.a = float(across * math.cos(turn) - along * math.sin(turn))
        # the force on the follower along its normal
        force = multiplier
        self.F = float(force * math.hypot(1.0, tangent))
        gauges = np.array([self.g1, self.g2, self.g3])
        # the force kinks the curvature, which no polynomial does: its static part is exact, the rest by shapes
        x, weight = np.polynomial.legendre.leggauss(60)
        x, weight = 0.5 * L * (x + 1.0), 0.5 * L * weight
        kink = self.all_shapes(x, 2).T @ (weight * force * np.maximum(0.0, s - x))
        smooth = self.to_shapes @ (eta - self.to_shapes.T @ kink / self.squares)
        curvature = self.all_shapes(gauges, 2) @ smooth + force / self.EI * np.maximum(0.0, s - gauges)
        self.eps1, self.eps2, self.eps3 = (-self.e * float(each) for each in curvature)  # in another sign
