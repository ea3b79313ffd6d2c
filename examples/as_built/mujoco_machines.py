"""Run 24 as users of MuJoCo build it: an XML model each, simulated by `mj_step` alone.

    python mujoco_machines.py            # the names
    python mujoco_machines.py NAME FILE  # 2 s of that construction as a CSV table

The follower is a chain of equal links on hinges of stiffness EI/h, damped by its material. A
construction says how the crank's pin rides along it, with which parameters of the contact, and how
MuJoCo integrates.
"""

import math
import time
from dataclasses import dataclass, replace
from typing import Final

import mujoco
import numpy as np

from run_24 import (
    COLUMNS,
    RADIUS,
    REACH,
    SCENE,
    aside,
    bent_chain,
    chain_row,
    ring,
    write_table,
)


@dataclass(frozen=True)
class Machine:
    """A construction.

    `joint`: "slot", a pin between two walls; "rollers", two spheres about the arm; "carriage", a
    slide joint on the middle link, tied to the pin.
    """

    joint: str = "slot"
    links: int = 13
    step: float = 1e-4  # s
    solref: float | None = None  # time constant of the contact, s; None: MuJoCo's default, 0.02
    friction: float | None = 0.0  # of the contact; None: MuJoCo's default, 1
    integrator: str = "implicitfast"
    armature: float = 0.0  # kg m^2
    stiffness: float = 1.0  # of a hinge, over EI/h
    output: float = 1e-3  # s, of the table


STIFF: Final = Machine(solref=2e-4)
MACHINES: Final = {
    "slot, all defaults, 2 ms": Machine(step=2e-3, friction=None, integrator="Euler", output=2e-3),
    "slot, all defaults, 0.5 ms": Machine(step=5e-4, friction=None, integrator="Euler"),
    "slot, default contact, 0.1 ms": Machine(),
    "slot, contact 5 ms": replace(STIFF, solref=5e-3),
    "slot, contact 1 ms": replace(STIFF, solref=1e-3),
    "slot, contact 2 steps": STIFF,
    "slot, contact 2 steps, 26 links, 0.025 ms": replace(STIFF, links=26, step=2.5e-5, solref=5e-5),
    "slot, contact 2 steps, armature, 0.25 ms": replace(
        STIFF, step=2.5e-4, solref=5e-4, armature=1e-5
    ),
    "slot, contact 2 steps, default friction": replace(STIFF, friction=None),
    "slot, contact 2 steps, hinges 3 EI/h": replace(STIFF, stiffness=3.0),
    "slot, contact 2 steps, discrete, 0.5 ms": replace(
        STIFF, integrator="discrete", step=5e-4, solref=1e-3
    ),
    "slot, contact 2 steps, discrete, 0.1 ms": replace(STIFF, integrator="discrete"),
    "rollers, contact 2 steps": replace(STIFF, joint="rollers"),
    "slide on the middle link and connect": replace(STIFF, joint="carriage"),
}
PROGRAM: Final = f"MuJoCo {mujoco.__version__}"


def xml(machine: Machine, held: bool = False) -> str:
    """The model. With the crank `held` it has no coordinate of its own."""
    s, n, option = SCENE, machine.links, f'integrator="{machine.integrator}" jacobian="dense"'
    contact = _contact(machine)
    follower = ""
    for k in reversed(range(n)):
        place = s["length"] / n if k else s["pivot_distance"]
        parts = _link(machine, k) + _guide(machine, k, contact)
        follower = f'<body name="link{k}" pos="{place} 0 0">{parts}{follower}</body>'
    crank = _inertial(s["crank_mass"], s["crank_inertia"], s["crank_center"])
    if not held:
        crank += f'<joint name="crank" axis="0 0 1" damping="{s["crank_damping"]}"/>'
    turned = 'quat="0 0 0 1"' if held else ""
    tied = ""
    if machine.joint == "carriage":
        ends = 'body1="carriage" body2="crank" anchor="0 0 0"'
        tied = f'<equality><connect {ends} solref="{2 * machine.step} 1"/></equality>'
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option timestep="{machine.step}" gravity="0 0 0" {option}/>
  <worldbody>
    <body name="crank" {turned}>{crank}{_pin(machine, contact)}</body>
    {follower}
  </worldbody>
  {tied}
</mujoco>"""


def _contact(machine: Machine) -> str:
    """Attributes of the geometries that touch."""
    contact = "" if machine.solref is None else f' solref="{machine.solref} 1"'
    if machine.friction is None:
        return contact
    rubs = f'condim="3" friction="{machine.friction} 0 0"' if machine.friction else 'condim="1"'
    return f"{contact} {rubs}"


def _inertial(mass: float, inertia: float, place: float = 0.0) -> str:
    turning = f"{inertia} {inertia} {inertia}"
    return f'<inertial pos="{place} 0 0" mass="{mass}" diaginertia="{turning}"/>'


def _link(machine: Machine, k: int) -> str:
    """Mass and hinge of a link; the last one has the tip body."""
    s, h = SCENE, SCENE["length"] / machine.links
    mass = s["mass_per_length"] * h
    spring = machine.stiffness * s["bending_stiffness"] / h
    values = {"damping": s["base_damping"], "armature": s["base_inertia"]}
    if k > 0:
        damping = spring * s["material_damping"]
        values = {"stiffness": spring, "damping": damping, "armature": machine.armature}
    attributes = " ".join(f'{name}="{value}"' for name, value in values.items())
    parts = _inertial(mass, mass * h**2 / 12.0, h / 2.0)
    parts += f'<joint name="link{k}" axis="0 0 1" {attributes}/>'
    if k == machine.links - 1:
        tip = _inertial(s["tip_mass"], s["tip_inertia"])
        parts += f'<body name="tip" pos="{h} 0 0">{tip}</body>'
    return parts


def _guide(machine: Machine, k: int, contact: str) -> str:
    """What the pin, or the rollers, ride on."""
    s, h = SCENE, SCENE["length"] / machine.links
    touches = f'contype="1" conaffinity="2"{contact}'
    if machine.joint == "slot":
        size = f"{h / 2} {RADIUS / 2} {s['width'] / 2}"
        places = [f"{h / 2} {side * 1.5 * RADIUS} 0" for side in (1, -1)]
        return "".join(f'<geom type="box" size="{size}" pos="{at}" {touches}/>' for at in places)
    if machine.joint == "rollers":
        size = f"{h / 2} {s['thickness'] / 2} {s['width'] / 2}"
        return f'<geom type="box" size="{size}" pos="{h / 2} 0 0" {touches}/>'
    if k == machine.links // 2:
        slide = '<joint name="slide" type="slide" axis="1 0 0"/>'
        return f'<body name="carriage">{_inertial(1e-3, 1e-8)}{slide}</body>'
    return ""


def _pin(machine: Machine, contact: str) -> str:
    """What rides along the follower, on the crank's end."""
    s = SCENE
    sphere = f'type="sphere" size="{RADIUS}" mass="0" contype="2" conaffinity="1"{contact}'
    if machine.joint == "slot":
        return f'<geom {sphere} pos="{s["crank_length"]} 0 0"/>'
    if machine.joint == "rollers":
        y = s["thickness"] / 2 + RADIUS
        spheres = "".join(f'<geom {sphere} pos="0 {side * y} 0"/>' for side in (1, -1))
        hinge = '<joint name="slider" axis="0 0 1"/>'
        parts = f"{_inertial(1e-3, 1e-8)}{hinge}{spheres}"
        return f'<body pos="{s["crank_length"]} 0 0">{parts}</body>'
    return ""


def simulate(
    machine: Machine, duration: float = 2.0, directions: list[np.ndarray] | None = None
) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s.

    The table is shorter if MuJoCo lost the motion and began anew. The links' directions (rad) in
    each row are appended to `directions`.
    """
    model = mujoco.MjModel.from_xml_string(xml(machine))
    data = mujoco.MjData(model)
    s, n = SCENE, machine.links
    where = {mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k): k for k in range(model.njnt)}
    crank, first = where["crank"], where["link0"]
    hinges = [where[f"link{k}"] for k in range(n)]
    # the standard start: crank at 180 deg, follower straight, as the rigid mechanism moves
    data.qpos[crank], data.qvel[crank] = math.pi, s["crank_speed"]
    data.qpos[first], data.qvel[first] = math.pi, s["crank_speed"] * s["crank_length"] / REACH
    if "slider" in where:
        data.qvel[where["slider"]] = data.qvel[first] - data.qvel[crank]
    if "slide" in where:
        data.qpos[where["slide"]] = REACH - (n // 2) * s["length"] / n
    data.qfrc_applied[crank] = s["torque"]
    rows, steps, spent = [], round(machine.output / machine.step), 0.0
    for k in range(round(duration / machine.output) + 1):
        if k:
            began = time.process_time()
            mujoco.mj_step(model, data, steps)
            spent += time.process_time() - began
        if (
            data.time < (k - 0.5) * machine.output
        ):  # after a bad acceleration MuJoCo begins anew, with a warning in a log file
            break
        rows.append((k * machine.output, *chain_row(data.qpos[crank], data.qpos[hinges])))
        if directions is not None:
            directions.append(np.cumsum(data.qpos[hinges]))
    return dict(zip(COLUMNS, np.array(rows).T, strict=True)), spent


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg."""
    model = mujoco.MjModel.from_xml_string(xml(machine, held=True))
    data, n = mujoco.MjData(model), machine.links
    hinges = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"link{k}") for k in range(n)]
    data.qpos[hinges] = bent_chain(n, deflection)
    slide = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, "slide")
    if slide >= 0:
        data.qpos[slide] = REACH - (n // 2) * SCENE["length"] / n
    signal, steps = [], max(1, round(1e-3 / machine.step))
    for _ in range(round(duration / (steps * machine.step))):
        mujoco.mj_step(model, data, steps)
        signal.append(aside(data.qpos[hinges]))
    return ring(np.array(signal), steps * machine.step)


if __name__ == "__main__":
    write_table(MACHINES, simulate)
