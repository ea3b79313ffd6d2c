"""Run 24 as users of MuJoCo build it, an XML model each, simulated by `mj_step` alone.

    python as_built.py [NAME ...]  # all constructions, or some

The follower is a chain of equal links on hinges of stiffness EI/h, damped by its material. The
crank's pin runs in a slot between two walls. Each construction is held beside a converged solution,
as JSON, one line each: error: RMS of the difference of the tip deflection over its RMS; peak,
frequency: over the true ones, less 1; damping: ratio of the first mode; gap: the largest, m;
seconds: processor time of the solve; end: when MuJoCo lost the motion, s.
"""

import json
import math
import sys
import time
from dataclasses import dataclass, replace
from typing import Final

import mujoco
import numpy as np

import quickreturn as qr

#: Run 24, SI, with material damping (s) in place of damping against the base.
SCENE: Final = {
    "pivot_distance": 0.4572,
    "crank_length": 0.1016,
    "crank_mass": 17.5126835,
    "crank_center": 0.0762,
    "crank_inertia": 4.51939316e-05,
    "torque": 1.12984829,
    "crank_damping": 0.0679903552,
    "crank_speed": 16.617773,
    "base_inertia": 1.69477244e-05,
    "base_damping": 2.25969658e-06,
    "length": 0.635,
    "mass_per_length": 0.328181484,
    "bending_stiffness": 6.10759695,
    "thickness": 0.003175,
    "width": 0.0381,
    "material_damping": 1e-4,
    "tip_mass": 0.0507867822,
    "tip_inertia": 2.21450265e-06,
}
#: From P to the crank's pin at the start, m.
REACH: Final = SCENE["pivot_distance"] + SCENE["crank_length"]
#: Angular speed of the follower at the start, rad/s.
TURNING: Final = SCENE["crank_speed"] * SCENE["crank_length"] / REACH


RADIUS: Final = 0.005  # of the pin, m


@dataclass(frozen=True)
class Machine:
    """A construction."""

    links: int = 13
    step: float = 1e-4  # s
    solref: float | None = None  # time constant of the contact, s; None: MuJoCo's default, 0.02
    rubs: bool = False  # whether the pin rubs, with MuJoCo's default friction, 1
    integrator: str = "implicitfast"
    armature: float = 0.0  # kg m^2
    stiffness: float = 1.0  # of a hinge, over EI/h


STIFF: Final = Machine(solref=2e-4)
MACHINES: Final = {
    "slot, all defaults, 2 ms": Machine(step=2e-3, rubs=True, integrator="Euler"),
    "slot, default contact, 0.1 ms": Machine(),
    "slot, contact 5 ms": replace(STIFF, solref=5e-3),
    "slot, contact 2 steps": STIFF,
    "slot, contact 2 steps, 26 links, 0.025 ms": replace(STIFF, links=26, step=2.5e-5, solref=5e-5),
    "slot, contact 2 steps, armature, 0.25 ms": replace(STIFF, step=2.5e-4, solref=5e-4, armature=1e-5),
    "slot, contact 2 steps, default friction": replace(STIFF, rubs=True),
    "slot, contact 2 steps, hinges 3 EI/h": replace(STIFF, stiffness=3.0),
    "slot, contact 2 steps, discrete, 0.5 ms": replace(STIFF, integrator="discrete", step=5e-4, solref=1e-3),
}


def xml(machine: Machine, held: bool = False) -> str:
    """The model. With the crank `held` it has no coordinate of its own."""
    s, h = SCENE, SCENE["length"] / machine.links
    contact = "" if machine.solref is None else f'solref="{machine.solref} 1"'
    contact += "" if machine.rubs else ' condim="1"'
    size = f"{h / 2} {RADIUS / 2} {s['width'] / 2}"
    walls = "".join(
        f'<geom type="box" size="{size}" pos="{h / 2} {side * 1.5 * RADIUS} 0" contype="1" conaffinity="2" {contact}/>' for side in (1, -1)
    )
    follower = _inertial("tip", h, s["tip_mass"], s["tip_inertia"]) + "</body>"
    mass = s["mass_per_length"] * h
    for k in reversed(range(machine.links)):
        place = h if k else s["pivot_distance"]
        link = _inertial(f"link{k}", place, mass, mass * h**2 / 12.0, h / 2.0)
        follower = f"{link}{_hinge(machine, k)}{walls}{follower}</body>"
    crank = _inertial("crank", 0.0, s["crank_mass"], s["crank_inertia"], s["crank_center"], held)
    if not held:
        crank += f'<joint axis="0 0 1" damping="{s["crank_damping"]}"/>'
    pin = f'type="sphere" size="{RADIUS}" mass="0" pos="{s["crank_length"]} 0 0"'
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option timestep="{machine.step}" gravity="0 0 0" integrator="{machine.integrator}"
          jacobian="dense"/>
  <worldbody>
    {crank}<geom {pin} contype="2" conaffinity="1" {contact}/></body>
    {follower}
  </worldbody>
</mujoco>"""


def _inertial(name: str, place: float, mass: float, inertia: float, center: float = 0.0, turned: bool = False) -> str:
    """The head of a body."""
    about = f'diaginertia="{inertia} {inertia} {inertia}"'
    turn = 'quat="0 0 0 1"' if turned else ""
    return f'<body name="{name}" pos="{place} 0 0" {turn}><inertial pos="{center} 0 0" mass="{mass}" {about}/>'


def _hinge(machine: Machine, k: int) -> str:
    """Hinge of link k; that of the first one is the base, with the base's inertia and damping."""
    s = SCENE
    if k == 0:
        return f'<joint axis="0 0 1" damping="{s["base_damping"]}" armature="{s["base_inertia"]}"/>'
    spring = machine.stiffness * s["bending_stiffness"] * machine.links / s["length"]
    damping = f'damping="{spring * s["material_damping"]}"'
    return f'<joint axis="0 0 1" stiffness="{spring}" {damping} armature="{machine.armature}"/>'


def row(q1: float, angles: np.ndarray) -> tuple[float, float]:
    """Tip deflection and gap, from the hinges' angles."""
    h = SCENE["length"] / len(angles)
    e = np.exp(1j * np.cumsum(angles))
    corners = np.concatenate([[0.0], np.cumsum(h * e)])
    pin = SCENE["crank_length"] * np.exp(1j * q1) - SCENE["pivot_distance"]
    local = (pin - corners[:-1]) / e
    nearest = local[np.argmin(np.abs(local.real - h / 2.0))]
    return (corners[-1] / e[0]).imag, abs(nearest.imag)


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns at each millisecond, and the processor time of the solve, s.

    They are shorter if MuJoCo lost the motion and began anew.
    """
    model = mujoco.MjModel.from_xml_string(xml(machine))
    data = mujoco.MjData(model)
    # the standard start: crank at 180 deg, follower straight, as the rigid mechanism moves
    data.qpos[:2], data.qvel[:2] = math.pi, (SCENE["crank_speed"], TURNING)
    data.qfrc_applied[0] = SCENE["torque"]
    output = max(1e-3, machine.step)
    rows, steps, spent = [], round(output / machine.step), 0.0
    for k in range(round(duration / output) + 1):
        if k:
            began = time.process_time()
            mujoco.mj_step(model, data, steps)
            spent += time.process_time() - began
        if data.time < (k - 0.5) * output:
            break  # after a bad acceleration MuJoCo begins anew, with a warning in a log file
        rows.append((k * output, *row(data.qpos[0], data.qpos[1:])))
    names = ("time", "tip_deflection", "constraint_gap")
    return dict(zip(names, np.array(rows).T, strict=True)), spent


def bent(x: np.ndarray) -> np.ndarray:
    """Deflection at arc lengths x of a follower held at P and at the slider.

    A force on the tip bends it, by 1 there.
    """
    inboard, outboard = np.minimum(x, REACH), np.maximum(x - REACH, 0.0)
    over = SCENE["length"] - REACH
    # w'' = over x / REACH up to the slider, length - x beyond it; w = 0 at P and at the slider
    w = over / (6.0 * REACH) * inboard * (inboard**2 - REACH**2)
    w += over * REACH / 3.0 * outboard + over * outboard**2 / 2.0 - outboard**3 / 6.0
    return w / w[-1]


def ring(signal: np.ndarray, step: float) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the spectrum's largest peak.

    Phase and size of the signal about that peak, smoothed by a window, turn and fall with them.
    """
    window, times = np.hanning(len(signal) // 4), step * np.arange(len(signal))
    signal = signal - signal.mean()
    spectrum = np.abs(np.fft.rfft(signal * np.hanning(len(signal))))
    near = np.fft.rfftfreq(len(signal), step)[np.argmax(spectrum)]
    slow = np.convolve(signal * np.exp(-2j * np.pi * near * times), window, "valid")
    middle = times[: len(slow)]
    turning = np.polyfit(middle, np.unwrap(np.angle(slow)), 1)[0]
    rate = -np.polyfit(middle, np.log(np.abs(slow)), 1)[0]
    frequency = near + float(turning) / (2.0 * math.pi)
    return frequency, float(rate) / (2.0 * math.pi * frequency)


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg."""
    model = mujoco.MjModel.from_xml_string(xml(machine, held=True))
    data, corners = mujoco.MjData(model), np.linspace(0.0, SCENE["length"], machine.links + 1)
    w = bent(corners)
    w -= np.interp(REACH, corners, w) / REACH * corners  # the pin is on a link, not on the beam
    data.qpos[:] = np.diff(math.pi + deflection * np.diff(w) / corners[1], prepend=0.0)
    signal, steps = [], max(1, round(1e-3 / machine.step))
    for _ in range(round(duration / (steps * machine.step))):
        mujoco.mj_step(model, data, steps)
        signal.append(row(math.pi, data.qpos)[0])
    return ring(np.array(signal), steps * machine.step)


def truth() -> tuple[np.ndarray, float]:
    """Tip deflection (m) at each millisecond of 2 s; first frequency (Hz) at 180 deg."""
    damping = {"follower.damping": "0 N*s/m^2", "follower.material_damping": "1e-4 s"}
    case = qr.case("thesis-24").with_(damping)
    settings = {"modes": 9, "tolerance": 1e-8}
    run = qr.simulate(case, "reference", settings=settings, estimate=False)
    frequency = float(qr.modes(case, "reference", 180.0, count=1).iloc[0, 0])
    return run.trajectory["tip_deflection"], frequency


def measured(name: str, deflection: np.ndarray, true_frequency: float) -> dict[str, float]:
    """The numbers of one construction; `end` alone if MuJoCo lost the motion."""
    columns, seconds = simulate(MACHINES[name])
    if columns["time"][-1] < 2.0:
        return {"end": float(columns["time"][-1])}
    true = deflection[np.round(1e3 * columns["time"]).astype(int)]
    frequency, damping = pluck(MACHINES[name])
    return {
        "error": math.sqrt(np.mean((columns["tip_deflection"] - true) ** 2) / np.mean(true**2)),
        "peak": float(np.abs(columns["tip_deflection"]).max() / np.abs(true).max()) - 1.0,
        "frequency": frequency / true_frequency - 1.0,
        "damping": damping,
        "gap": float(columns["constraint_gap"].max()),
        "seconds": seconds,
    }


if __name__ == "__main__":
    true = truth()
    for name in sys.argv[1:] or MACHINES:
        found = {key: float(f"{each:.3g}") for key, each in measured(name, *true).items()}
        print(json.dumps({"name": name} | found), flush=True)
