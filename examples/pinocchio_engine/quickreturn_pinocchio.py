"""Engine `pinocchio`: the follower as a chain of rigid links, whose dynamics are Pinocchio's.

N hinges of stiffness EI/h stand at (j - 1/2) h, h = L/N, between half a link at the pivot, N - 1 links and half a link at the end. The
slider sits on a smooth line through the chain: its tangent at x = i h is the direction of link i, less a 24th of that direction's second
difference, and is interpolated between. Places, seen from P, are complex numbers.
"""

import numpy as np
import pinocchio as pin
from scipy.interpolate import CubicSpline

import quickreturn as qr


class Chain(qr.Model):
    """Coordinates q: the angles of the crank and of the hinges; the base's follows from them, for the slider sits where the crank ends."""

    def __init__(self, scene, start, resolution):
        self.scene, beam, n = scene, scene.follower, resolution
        self.h, self.i = beam.length / n, np.arange(n + 1)
        self.turns = np.tri(n + 1)  # of the links, by the angles of base and hinges
        self.smooth = 13 / 12 * np.eye(n + 1) - (np.eye(n + 1, k=1) + np.eye(n + 1, k=-1)) / 24
        self.smooth[0, 1] = self.smooth[n, n - 1] = -1 / 12  # the line goes on beyond its ends as if mirrored
        x = self.h * self.i
        self.lines = np.array([self.line(each)[0] for each in x])
        self.drag = beam.damping * self.h * np.where(x % beam.length, 1.0, 0.5)
        self.gauges = CubicSpline(self.h * (self.i[1:] - 0.5), np.eye(n))(beam.strain_gauges)
        self.build(scene, [self.h / 2, *(n - 1) * [self.h], self.h / 2])
        bent = qr.reconstruct(scene, start)
        hinges, rates = np.diff(self.smooth @ bent.tangent(x)), np.diff(self.smooth @ bent.tangent_rate(x))
        self.state = np.concatenate([[start.crank_angle], hinges, [start.crank_speed], rates])

    def build(self, scene, pieces):
        """Pinocchio's model: the crank about O, and the pieces one behind the other from P."""
        crank, tip, base = scene.crank, scene.tip_body, scene.base
        self.pin = pin.Model()
        self.pin.gravity.linear = np.array([*scene.gravity, 0.0])
        joint = self.pin.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
        self.add(joint, crank.mass, crank.center_of_mass, crank.inertia)
        self.add(joint, scene.slider.mass, crank.length, 0.0)
        joint, place = 0, scene.pivot_distance
        for number, piece in enumerate(pieces):
            there = pin.SE3(np.eye(3), np.array([place, 0.0, 0.0]))
            joint, place = self.pin.addJoint(joint, pin.JointModelRZ(), there, f"link {number}"), piece
            mass = scene.follower.mass_per_length * piece
            self.add(joint, mass, piece / 2, mass * piece**2 / 12 + base.inertia * (number == 0))
        self.add(joint, tip.mass, place + tip.center_of_mass, tip.inertia)
        self.data = self.pin.createData()

    def add(self, joint, mass, place, inertia):
        """Fix a body to a joint: its mass, its centre's place along the joint's first axis, its inertia about that centre."""
        body = pin.Inertia(mass, np.array([place, 0.0, 0.0]), inertia * np.eye(3))
        self.pin.appendBodyToJoint(joint, body, pin.SE3.Identity())

    def line(self, x):
        """The place x on the line, its tangent and the tangent's change with x, each times the links' directions."""
        u = np.clip(x / self.h - self.i, -1.0, 1.0)
        place = self.h * (u - u * np.abs(u) / 2 + np.where(self.i, 0.5, 0.0))
        return np.array([place, 1 - np.abs(u), -np.sign(u) * (np.abs(u) < 1) / self.h]) @ self.smooth

    def motion(self, q, v):
        """Place s of the slider; directions of the links, their rates; accelerations of crank, base, hinges; the slider's force."""
        scene, hinges, drive = self.scene, q[1:], self.scene.crank.drive
        arm, bent = scene.crank.length * np.exp(1j * q[0]), np.exp(1j * (self.turns[:, 1:] @ hinges))
        chord, s, p = arm - scene.pivot_distance, abs(arm - scene.pivot_distance), 0.0
        while abs(abs(chord) - abs(p)) > 1e-12 * s and s < 2 * scene.follower.length:
            p = self.line(s)[0] @ bent
            s += abs(chord) - abs(p)  # until that place is as far from P as the crank's end
        base = np.pi + np.angle(-chord / p)
        e, (place, tangent, change) = bent * np.exp(1j * base), self.line(s)
        t = tangent @ e
        normal, along = 1j * t / abs(t), 1j * (place * e) @ self.turns
        row = (np.conj(normal) * np.append(1j * arm, -along)).real  # row @ velocities of (crank, base, hinges) = 0
        u = np.concatenate([v[:1], [-(row[0] * v[0] + row[2:] @ v[1:]) / row[1]], v[1:]])
        rates = self.turns @ u[1:]
        sliding = (np.conj(t) * (1j * arm * v[0] - along @ u[1:])).real / abs(t) ** 2
        inner = 2j * sliding * (tangent @ (e * rates)) + sliding**2 * (change @ e) - place @ (e * rates**2)
        left = (np.conj(normal) * (arm * v[0] ** 2 + inner)).real
        relative = 1j * (self.lines * e) @ self.turns[:, 1:]
        drag = (np.conj(relative).T @ (self.drag * (relative @ v[1:]))).real
        stiffness = scene.follower.bending_stiffness / self.h
        torques = [drive.torque - drive.damping * v[0], -scene.base.damping * u[1], *(-stiffness * hinges - drag)]
        angles = np.concatenate([q[:1], [base], hinges])
        A = np.zeros((len(u) + 1, len(u) + 1))
        A[:-1, :-1], A[-1, :-1], A[:-1, -1] = pin.crba(self.pin, self.data, angles), row, row
        loads = torques - pin.nonLinearEffects(self.pin, self.data, angles, u)
        return s, e, rates, np.linalg.solve(A, np.append(loads, left)), base, place

    def accelerations(self, time, q, v):
        return np.delete(self.motion(q, v)[3], [1, -1])

    def row(self, time, q, v):
        (s, e, rates, a, base, place), beam = self.motion(q, v), self.scene.follower
        base += (q[2] - q[1]) / 24  # the beam's tangent is beside the link's
        reach, normal = self.lines[-1] * e, 1j * e[-1]
        tip, acceleration = reach.sum(), reach @ (1j * self.turns @ a[1:-1] - rates**2)
        kink = a[-1] / beam.bending_stiffness  # of the curvature's slope at the slider
        levers = np.cumsum(place[::-1])[::-1][1:]
        smooth = self.gauges @ (q[1:] / self.h - kink * levers)
        strains = beam.thickness / 2 * (smooth + kink * np.maximum(0.0, s - np.array(beam.strain_gauges)))
        return {
            "crank_angle": q[0],
            "crank_speed": v[0],
            "follower_angle": base,
            "slider_position": s,
            "slider_force": a[-1],
            "tip_x": self.scene.pivot_distance + tip.real,
            "tip_y": tip.imag,
            "tip_deflection": (tip * np.exp(-1j * base)).imag,
            "tip_acceleration": (np.conj(normal) * acceleration).real,
            **{f"strain_{number}": strain for number, strain in enumerate(strains, start=1)},
        }


class PinocchioEngine(qr.SimpleEngine):
    """A chain of links by Pinocchio."""

    name, method, library, model = "pinocchio", "Pinocchio chain of rigid links, the slider eliminated", "pin", Chain
    errors, order = {4: 0.075, 6: 0.015, 8: 0.0094, 12: 0.0053, 16: 0.0025, 24: 0.001}, 2.0
    quantities = ("crank.torque", "mechanism.gravity", "base.damping", "follower.damping", "tip.center_of_mass", "slider.mass")
