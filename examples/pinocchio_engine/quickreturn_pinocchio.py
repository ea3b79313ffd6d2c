"""Engine `pinocchio`: the follower as a chain of rigid links, whose dynamics are Pinocchio's.

N hinges of stiffness EI/h stand at (j - 1/2) h, h = L/N, between half a link at the pivot, N - 1
links and half a link at the end. The slider sits on a smooth line through the chain: its tangent
at x = i h is the direction of link i, less a 24th of that direction's second difference, and is
interpolated between. Places, seen from P, are complex numbers.

The crank and the chain are two open chains for Pinocchio. What closes the loop is written here:
one equation, which says that the crank's end stays on the line, with the slider's force as its
multiplier.
"""

import numpy as np
import pinocchio as pin
from scipy.interpolate import CubicSpline

import quickreturn as qr


class Chain(qr.Model):
    """The closed mechanism with a chain for its follower.

    Coordinates q: the angles of the crank and of the hinges. The angle of the base link follows
    from them, because the slider sits where the crank ends.
    """

    def __init__(self, scene, start, resolution):
        self.scene, beam, n = scene, scene.follower, resolution
        self.h, self.i = beam.length / n, np.arange(n + 1)
        x = self.h * self.i

        # A link's direction is the sum of the angles of the base and of all hinges before it.
        self.turns = np.tri(n + 1)
        # The line's tangents at x, by the directions of the links. Its ends go on as if mirrored.
        neighbours = np.eye(n + 1, k=1) + np.eye(n + 1, k=-1)
        self.smooth = 13 / 12 * np.eye(n + 1) - neighbours / 24
        self.smooth[0, 1] = self.smooth[n, n - 1] = -1 / 12

        # The beam's damping acts at the nodes, with half a link's share at either end.
        self.lines = np.array([self.line(each)[0] for each in x])
        self.drag = beam.damping * self.h * np.where(x % beam.length, 1.0, 0.5)
        # Curvatures at the gauges, by those of the hinges.
        self.gauges = CubicSpline(self.h * (self.i[1:] - 0.5), np.eye(n))(beam.strain_gauges)
        self.build(scene, [self.h / 2, *(n - 1) * [self.h], self.h / 2])

        # The start is told as a bent beam in motion; the hinges take up the turn between nodes.
        bent = qr.reconstruct(scene, start)
        hinges = np.diff(self.smooth @ bent.tangent(x))
        rates = np.diff(self.smooth @ bent.tangent_rate(x))
        self.state = np.concatenate([[start.crank_angle], hinges, [start.crank_speed], rates])

    def build(self, scene, pieces):
        """Pinocchio's model: the crank about O, and the pieces one behind the other from P."""
        crank, tip, base = scene.crank, scene.tip_body, scene.base
        self.pin = pin.Model()
        self.pin.gravity.linear = np.array([*scene.gravity, 0.0])

        # The slider's mass sits at the crank's end.
        joint = self.pin.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
        self.add(joint, crank.mass, crank.center_of_mass, crank.inertia)
        self.add(joint, scene.slider.mass, crank.length, 0.0)

        # Each link is a slender rod. The base block turns with the first, the tip with the last.
        joint, place = 0, scene.pivot_distance
        for number, piece in enumerate(pieces):
            there = pin.SE3(np.eye(3), np.array([place, 0.0, 0.0]))
            joint = self.pin.addJoint(joint, pin.JointModelRZ(), there, f"link {number}")
            place = piece
            mass = scene.follower.mass_per_length * piece
            self.add(joint, mass, piece / 2, mass * piece**2 / 12 + base.inertia * (number == 0))
        self.add(joint, tip.mass, place + tip.center_of_mass, tip.inertia)
        self.data = self.pin.createData()

    def add(self, joint, mass, place, inertia):
        """Fix a body to a joint.

        `place`: of its centre, along the joint's first axis; `inertia`: about that centre.
        """
        body = pin.Inertia(mass, np.array([place, 0.0, 0.0]), inertia * np.eye(3))
        self.pin.appendBodyToJoint(joint, body, pin.SE3.Identity())

    def line(self, x):
        """The place x on the line, its tangent and the tangent's change with x.

        Each is a row of weights: times the directions of the links it is the vector.
        """
        u = np.clip(x / self.h - self.i, -1.0, 1.0)
        place = self.h * (u - u * np.abs(u) / 2 + np.where(self.i, 0.5, 0.0))
        change = -np.sign(u) * (np.abs(u) < 1) / self.h
        return np.array([place, 1 - np.abs(u), change]) @ self.smooth

    def closed(self, q):
        """The crank's end seen from O, the slider's place s on the line, and the base's angle."""
        bent = np.exp(1j * (self.turns[:, 1:] @ q[1:]))
        arm = self.scene.crank.length * np.exp(1j * q[0])
        # s is where the line is as far from P as the crank's end is.
        chord, p = arm - self.scene.pivot_distance, 0.0
        s = abs(chord)
        while abs(abs(chord) - abs(p)) > 1e-12 * s and s < 2 * self.scene.follower.length:
            p = self.line(s)[0] @ bent
            s += abs(chord) - abs(p)
        # The base turns the line onto the crank's end.
        base = np.pi + np.angle(-chord / p)
        return arm, s, base, bent * np.exp(1j * base)

    def motion(self, q, v):
        """The equations of motion, solved.

        Returns the place s of the slider, the directions of the links and their rates, the
        accelerations of crank, base and hinges with the slider's force behind them, the angle of
        the base, and the weights of the place s.
        """
        scene, hinges, drive = self.scene, q[1:], self.scene.crank.drive
        arm, s, base, e = self.closed(q)
        place, tangent, change = self.line(s)
        t = tangent @ e
        normal, along = 1j * t / abs(t), 1j * (place * e) @ self.turns

        # The crank's end and the line's place s move alike across the line:
        # row @ velocities of (crank, base, hinges) = 0, which gives the base's speed.
        row = (np.conj(normal) * np.append(1j * arm, -along)).real
        u = np.concatenate([v[:1], [-(row[0] * v[0] + row[2:] @ v[1:]) / row[1]], v[1:]])
        rates = self.turns @ u[1:]

        # The rate of that equation: row @ accelerations = left. Centripetal accelerations are in
        # it, and that of Coriolis, because the slider slides.
        sliding = (np.conj(t) * (1j * arm * v[0] - along @ u[1:])).real / abs(t) ** 2
        coriolis = 2j * sliding * (tangent @ (e * rates))
        inner = coriolis + sliding**2 * (change @ e) - place @ (e * rates**2)
        left = (np.conj(normal) * (arm * v[0] ** 2 + inner)).real

        # The beam's damping acts on the velocities of the nodes relative to the base.
        relative = 1j * (self.lines * e) @ self.turns[:, 1:]
        drag = (np.conj(relative).T @ (self.drag * (relative @ v[1:]))).real
        stiffness = scene.follower.bending_stiffness / self.h
        crank_torque = drive.torque - drive.damping * v[0]
        torques = [crank_torque, -scene.base.damping * u[1], *(-stiffness * hinges - drag)]

        # Pinocchio gives the mass matrix and the loads of motion and gravity. The slider's force
        # stands behind the accelerations, with `row` as its arms.
        angles = np.concatenate([q[:1], [base], hinges])
        A = np.zeros((len(u) + 1, len(u) + 1))
        A[:-1, :-1] = pin.crba(self.pin, self.data, angles)
        A[-1, :-1], A[:-1, -1] = row, row
        loads = torques - pin.nonLinearEffects(self.pin, self.data, angles, u)
        return s, e, rates, np.linalg.solve(A, np.append(loads, left)), base, place

    def accelerations(self, time, q, v):
        # Without those of the base, which follows, and without the force.
        return np.delete(self.motion(q, v)[3], [1, -1])

    def row(self, time, q, v):
        s, e, rates, a, base, place = self.motion(q, v)
        beam, force = self.scene.follower, a[-1]
        # The beam's tangent at the base lies beside the first link.
        base += (q[2] - q[1]) / 24

        reach, normal = self.lines[-1] * e, 1j * e[-1]
        tip, acceleration = reach.sum(), reach @ (1j * self.turns @ a[1:-1] - rates**2)

        # The slider's force gives the curvature a kink at s, which no spline has: it is taken out
        # of the hinges' curvatures and put back at the gauges.
        kink = force / beam.bending_stiffness
        levers = np.cumsum(place[::-1])[::-1][1:]
        smooth = self.gauges @ (q[1:] / self.h - kink * levers)
        beyond = np.maximum(0.0, s - np.array(beam.strain_gauges))
        strains = beam.extreme_fibre * (smooth + kink * beyond)
        return {
            "crank_angle": q[0],
            "crank_speed": v[0],
            "follower_angle": base,
            "slider_position": s,
            "slider_force": force,
            "tip_x": self.scene.pivot_distance + tip.real,
            "tip_y": tip.imag,
            "tip_deflection": (tip * np.exp(-1j * base)).imag,
            "tip_acceleration": (np.conj(normal) * acceleration).real,
            **{f"strain_{number}": strain for number, strain in enumerate(strains, start=1)},
        }


class PinocchioEngine(qr.SimpleEngine):
    """A chain of links by Pinocchio."""

    name, library, model = "pinocchio", "pin", Chain
    method = "Pinocchio chain of rigid links, the slider eliminated"
    # Number of links -> measured error of the tip deflection in run 24; it falls with its square.
    errors, order = {4: 0.075, 6: 0.015, 8: 0.0094, 12: 0.0053, 16: 0.0025, 24: 0.001}, 2.0
    # What the model has of all that a scene may have; a scene with anything else is refused.
    quantities = (
        "crank.torque",
        "mechanism.gravity",
        "base.damping",
        "follower.damping",
        "tip.center_of_mass",
        "slider.mass",
    )
