"""A rod of rigid links on a base that turns as prescribed: the model of the FMU in docs/engine.md."""

import math

import numpy as np
from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave, Fmi3StepResult, Fmi3Variability

PARAMETERS = ("L", "mu", "EI", "c", "e", "g1", "g2", "g3", "gx", "gy", "mt", "Jt", "speed")
PARAMETERS += ("spin", "links")
OUTPUTS = ("q2", "xt", "yt", "u", "a", "eps1", "eps2", "eps3")


class Chain(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = 0.0
        clock = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        self.register_variable(Float64("time", **clock))
        free = {"causality": Fmi3Causality.parameter, "variability": Fmi3Variability.tunable}
        for name in PARAMETERS:
            setattr(self, name, 1.0)
            self.register_variable(Float64(name, **free))
        for name in OUTPUTS:
            setattr(self, name, 0.0)
            self.register_variable(Float64(name, causality=Fmi3Causality.output))

    def exit_initialization_mode(self):
        n = self.n = int(self.links)
        self.h = self.L / n
        # half a link is fixed to the base, half a link is free at the end
        self.lengths = np.full(n + 1, self.h)
        self.lengths[[0, -1]] /= 2.0
        middles = np.tril(np.tile(self.lengths, (n + 1, 1)), -1) + np.diag(self.lengths / 2.0)
        lines = middles.T * self.lengths @ middles + np.diag(self.lengths**3 / 12.0)
        self.mass = self.mu * lines + self.mt * np.outer(self.lengths, self.lengths)
        self.mass[-1, -1] += self.Jt
        self.moments = self.mu * self.lengths @ middles + self.mt * self.lengths
        self.drag = self.c * lines
        self.state = np.zeros(2 * n)  # angles of the links against the base, and their rates
        self.observe(0.0)

    def base(self, t):
        """Angle, rate and acceleration of the base."""
        speed, T, k = self.speed, self.spin, 2.0 * math.pi / self.spin
        if t >= T:
            return speed * (t - T / 2.0), speed, 0.0
        angle = speed / T * (t * t / 2.0 - (1.0 - math.cos(k * t)) / k**2)
        rate = speed / T * (t - math.sin(k * t) / k)
        return angle, rate, speed / T * (1.0 - math.cos(k * t))

    def accelerations(self, t, state):
        angle, rate, change = self.base(t)
        turned, bending = (np.concatenate([[0.0], part]) for part in np.split(state, 2))
        rates = rate + bending
        difference = turned[:, None] - turned
        springs = self.EI / self.h * np.diff(turned)
        gravity = (self.gx + 1j * self.gy) * np.exp(-1j * (angle + turned))
        loads = -self.mass * np.sin(difference) @ rates**2 + self.moments * gravity.imag
        loads -= self.drag * np.cos(difference) @ bending
        loads[:-1] += springs
        loads[1:] -= springs
        mass = self.mass * np.cos(difference)
        return np.linalg.solve(mass[1:, 1:], loads[1:] - mass[1:, 0] * change) - change

    def rates(self, t, state):
        return np.concatenate([state[self.n :], self.accelerations(t, state)])

    def do_step(self, current_time, step_size):
        t, y = current_time, self.state
        parts = max(1, math.ceil(step_size / 1e-4))
        h = step_size / parts
        for _ in range(parts):
            k1 = self.rates(t, y)
            k2 = self.rates(t + h / 2.0, y + h / 2.0 * k1)
            k3 = self.rates(t + h / 2.0, y + h / 2.0 * k2)
            y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + self.rates(t + h, y + h * k3))
            t += h
        self.state = y
        self.observe(current_time + step_size)
        return Fmi3StepResult()

    def observe(self, t):
        angle, rate, change = self.base(t)
        turned, bending = (np.concatenate([[0.0], part]) for part in np.split(self.state, 2))
        changes = change + np.concatenate([[0.0], self.accelerations(t, self.state)])
        links = self.lengths * np.exp(1j * turned)
        acceleration = (links * (1j * changes - (rate + bending) ** 2)).sum()
        tip = links.sum()
        out = tip * np.exp(1j * angle)
        self.q2, self.xt, self.yt, self.u = angle, float(out.real), float(out.imag), float(tip.imag)
        self.a = float((acceleration * np.exp(-1j * turned[-1])).imag)
        hinges = self.h * (np.arange(self.n) + 0.5)
        gauges = [self.g1, self.g2, self.g3]
        strains = self.e * np.interp(gauges, hinges, np.diff(turned) / self.h)
        self.eps1, self.eps2, self.eps3 = map(float, strains)
