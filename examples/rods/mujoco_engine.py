"""Links on hinges of MuJoCo as an engine, `MyRod()`; the clamp's hinge stands for half a piece."""

import mujoco
import numpy as np
import quickreturn as qr


class Chain(qr.Rod):
    """N links on hinges; x and z of MuJoCo are n1 and n2 of the scene."""

    def __init__(self, scene, links):
        rod, tip, h = scene.follower, scene.tip_body, scene.follower.length / links
        beyond = f'<body name="end" pos="{h} 0 0">{inertial(tip.mass, tip.inertia)}</body>'
        for k in reversed(range(links)):
            spring, mass = (1 if k else 2) * rod.bending_stiffness / h, rod.mass_per_length * h
            beyond = f"""<body pos="{h if k else 0} 0 0">
                <joint axis="0 -1 0" stiffness="{spring}"
                       damping="{rod.material_damping * spring}"/>
                {inertial(mass, mass * h**2 / 12, h / 2)} {beyond}</body>"""
        self.model = mujoco.MjModel.from_xml_string(f"""<mujoco>
            <option gravity="{scene.gravity[0]} 0 {scene.gravity[1]}" integrator="implicitfast"/>
            <worldbody>{beyond}</worldbody>
            <sensor><framelinacc objtype="xbody" objname="end"/></sensor></mujoco>""")
        self.data = mujoco.MjData(self.model)
        self.step = 0.05 * h**2 * np.sqrt(rod.mass_per_length / rod.bending_stiffness)

    def advance(self, duration):
        steps = int(np.ceil(duration / self.step))
        self.model.opt.timestep = duration / steps
        mujoco.mj_step(self.model, self.data, steps)

    def points(self):
        mujoco.mj_forward(self.model, self.data)
        return self.data.xpos[1:, [0, 2]]

    def acceleration(self):
        # the sensor counts a body that falls freely as at rest
        return (self.data.sensordata + self.model.opt.gravity)[[0, 2]]


def inertial(mass, inertia, x=0):
    about = f"1e-12 {inertia + 1e-12} {inertia + 1e-12}"
    return f'<inertial pos="{x} 0 0" mass="{mass + 1e-12}" diaginertia="{about}"/>'


class MyRod(qr.RodEngine):
    """Its errors are those of the sag, which fall with the square of the links."""

    name, method, library, rod = "my-rod", "links on hinges", "mujoco", Chain
    quantities = ("mechanism.gravity", "follower.material_damping")
    errors, order = {4: 0.0625, 8: 0.0156, 16: 0.0039, 32: 0.00098}, 2
