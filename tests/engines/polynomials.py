"""An engine of another method than that of docs/engine.md: the tangent's angle is a polynomial of arc length.

The angle is q2 + sum of psi_k(x) eta_k, psi_k being the Chebyshev polynomial of degree k less its value at P. All integrals use Gauss's
rule, so the tangents are needed only at its points: one polynomial passes through them, and its integral gives every place. q2 closes the
loop, the slider's constraint is one row, and its force is an unknown. Nothing but the shape is approximated.
"""

import numpy as np
from numpy.polynomial import chebyshev, legendre

import quickreturn as qr


def dot(a, b):
    """The scalar product of vectors of the plane, which are complex numbers."""
    return (np.conj(a) * b).real


class Fields:
    """Values along the arm of what is given by its values at the Gauss points x."""

    def __init__(self, length, shapes):
        n = 2 * shapes + 10
        z, weights = legendre.leggauss(n)
        self.length, self.x, self.weights = length, length / 2 * (1 + z), length / 2 * weights
        through_points = np.linalg.inv(chebyshev.chebvander(z, n - 1))
        self._place = length / 2 * chebyshev.chebint(through_points, lbnd=-1)
        self._angle = np.eye(n + 1, shapes, -1)
        self._angle[0] = (-1.0) ** np.arange(shapes)  # psi(0) = 0
        bend = chebyshev.chebder(self._angle)
        self._curvature = 2 / length * np.vstack([bend, np.zeros((n + 1 - len(bend), shapes))])

    def _at(self, x):
        turned = np.arccos(np.clip(2 * np.asarray(x) / self.length - 1, -1, 1))
        return np.cos(np.multiply.outer(turned, np.arange(len(self._place))))

    def place(self, x):
        """Factors of the tangents at the Gauss points."""
        return self._at(x) @ self._place

    def angle(self, x):
        """psi_k(x)."""
        return self._at(x) @ self._angle

    def curvature(self, x):
        """The derivatives of psi_k."""
        return self._at(x) @ self._curvature


class Bend(qr.Model):
    """Coordinates: the angle of the crank, and eta."""

    def __init__(self, scene, start, resolution):
        beam, tip = scene.follower, scene.tip_body
        self.scene, self.fields = scene, Fields(beam.length, resolution)
        x, weights = self.fields.x, self.fields.weights

        # Angular velocities of the tangents, and of the tip body, by the speeds of (q2, eta)
        self.turns = np.column_stack([np.ones(len(x)), self.fields.angle(x)])
        tip_turn = np.append(1, self.fields.angle(beam.length))

        self.drag = beam.damping * weights
        self.masses = np.append(beam.mass_per_length * weights, tip.mass)
        self.inertia = tip.inertia * np.outer(tip_turn, tip_turn)
        self.inertia[0, 0] += scene.base.inertia
        self.places = self.fields.place(np.append(x, beam.length))

        curvatures = self.fields.curvature(x)
        self.bending = beam.bending_stiffness * curvatures.T * weights
        self.stiffness = self.bending @ curvatures

        follower = qr.reconstruct(scene, start)
        angles = follower.tangent(x) - follower.follower_angle
        rates = follower.tangent_rate(x) - follower.follower_rate
        fitted = np.linalg.lstsq(self.turns[:, 1:], np.transpose([angles, rates]))[0]
        coordinates = [start.crank_angle, *fitted[:, 0]]
        self.state = np.array([*coordinates, start.crank_speed, *fitted[:, 1]])

    def closed(self, q):
        """The slider's place on the arm, and q2: the slider is where the crank ends."""
        bent = np.exp(1j * (self.turns[:, 1:] @ q[1:]))
        crank_end = self.scene.crank.length * np.exp(1j * q[0]) - self.scene.pivot_distance
        s, missing = abs(crank_end), np.inf
        while abs(missing) > 1e-12 * abs(crank_end) and s < 2 * self.scene.follower.length:
            point = self.fields.place(s) @ bent
            missing = abs(crank_end) - abs(point)
            s += missing
        return s, np.pi + np.angle(-crank_end / point)

    def motion(self, q, v):
        scene, fields, drive, eta = self.scene, self.fields, self.scene.crank.drive, q[1:]
        s, q2 = self.closed(q)
        crank = scene.crank.length * np.exp(1j * q[0])
        tangents = np.exp(1j * (q2 + self.turns[:, 1:] @ eta))
        psi, curvature = fields.angle(s), fields.curvature(s) @ eta
        normal = 1j * np.exp(1j * (q2 + psi @ eta))

        # The constraint, and the speeds that follow from it.
        point = fields.place(s) * tangents
        constraint = np.append(dot(normal, 1j * crank), -dot(normal, 1j * point @ self.turns))
        base = -(constraint[0] * v[0] + constraint[2:] @ v[1:]) / constraint[1]
        u = np.append(base, v[1:])
        rates = self.turns @ u
        sliding = dot(-1j * normal, 1j * crank * v[0] - 1j * point @ rates)
        missing = dot(normal, crank * v[0] ** 2 - point @ rates**2)
        missing += sliding * (2 * (base + psi @ v[1:]) + curvature * sliding)

        # Velocities of the masses by the speeds of (q2, eta), and what the tangents' turning adds.
        moving = 1j * (self.places * tangents) @ self.turns
        centripetal = self.places @ (tangents * rates**2)
        mass_matrix = np.zeros((len(q) + 1, len(q) + 1))
        mass_matrix[0, 0] = scene.crank_inertia
        mass_matrix[1:, 1:] = (moving.conj().T * self.masses @ moving).real + self.inertia

        # The drag is on velocities relative to the base.
        relative = moving[:-1, 1:]
        drag = self.drag * (relative @ v[1:])
        on_arm = (moving.conj().T @ (self.masses * centripetal)).real
        on_arm[0] -= scene.base.damping * base
        on_arm[1:] -= self.stiffness @ eta + (relative.conj().T @ drag).real
        loads = np.append(drive.torque - drive.damping * v[0], on_arm)

        equations = np.block([[mass_matrix, constraint[:, None]], [constraint, np.zeros(1)]])
        solution = np.linalg.solve(equations, np.append(loads, missing))
        return s, q2, tangents, rates, solution[:-1], solution[-1]

    def accelerations(self, time, q, v):
        *_, accelerations, _ = self.motion(q, v)
        return np.delete(accelerations, 1)

    def row(self, time, q, v):
        s, q2, tangents, rates, accelerations, force = self.motion(q, v)
        beam, fields, eta = self.scene.follower, self.fields, q[1:]

        # The slider's force kinks the curvature, which no polynomial does: it is taken apart.
        gauges, jump = np.array(beam.strain_gauges), force / beam.bending_stiffness
        kinked = self.bending @ (jump * np.maximum(0, s - fields.x))
        smooth = eta - np.linalg.solve(self.stiffness, kinked)
        curvatures = fields.curvature(gauges) @ smooth + jump * np.maximum(0, s - gauges)
        strains = beam.extreme_fibre * curvatures

        tip = fields.place(beam.length) * tangents
        tip_normal = 1j * np.exp(1j * (q2 + fields.angle(beam.length) @ eta))
        acceleration = tip @ (1j * self.turns @ accelerations[1:] - rates**2)
        return {
            "crank_angle": q[0],
            "crank_speed": v[0],
            "follower_angle": q2,
            "slider_position": s,
            "slider_force": force,
            "tip_x": self.scene.pivot_distance + tip.sum().real,
            "tip_y": tip.sum().imag,
            "tip_deflection": dot(1j * np.exp(1j * q2), tip.sum()),
            "tip_acceleration": dot(tip_normal, acceleration),
            "strain_1": strains[0],
            "strain_2": strains[1],
            "strain_3": strains[2],
        }


class Ritz(qr.SimpleEngine):
    name, method = "ritz", "polynomials for the tangent's angle, the slider eliminated"
    library, model = "numpy", Bend
    errors, order = {3: 0.14, 4: 0.086, 5: 0.035, 6: 0.02, 8: 0.0077, 10: 0.0038}, 2.5
    quantities = ("crank.torque", "base.damping", "follower.damping", "slider.mass")
