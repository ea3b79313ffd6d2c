"""Two constructions of MuJoCo beside the true motion, moving.

python picture.py FILE.webp
"""

import io
import sys
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
import quickreturn as qr
from PIL import Image

import measure
import mujoco_machines
from run_24 import SCENE

SHOWN: Final = {
    "slot, default contact, 0.1 ms": "default contact:\nthe pin falls through the wall",
    "slot, contact 2 steps, default friction": (
        "default friction: the pin sticks,\nwith a gap below 0.1 mm"
    ),
}
DURATION, EVERY, SLOWED = 0.76, 10, 10  # s; rows between two pictures; factor of slow motion
TRUE, BUILT = "#9aa0a8", "#d95f02"


def true_motion() -> tuple[np.ndarray, np.ndarray]:
    """Crank angle and the follower's points, as complex numbers, row by row."""
    run = qr.simulate(measure.CASE, "reference", estimate=False).trajectory
    shape = [run[f"shape_{k:02}"] for k in range(1, 12)]
    across = np.stack([np.zeros_like(run["time"]), *shape, run["tip_deflection"]], axis=1)
    along = np.linspace(0.0, SCENE["length"], 13)
    points = (along + 1j * across) * np.exp(1j * run["follower_angle"])[:, None]
    return run["crank_angle"], SCENE["pivot_distance"] + points


def built_motion(name: str) -> tuple[np.ndarray, np.ndarray]:
    """The same of a construction."""
    directions: list[np.ndarray] = []
    machine = mujoco_machines.MACHINES[name]
    columns, _ = mujoco_machines.simulate(machine, DURATION, directions)
    steps = SCENE["length"] / machine.links * np.exp(1j * np.array(directions))
    corners = np.cumsum(steps, axis=1)
    start = np.zeros((len(corners), 1))
    return columns["crank_angle"], SCENE["pivot_distance"] + np.hstack([start, corners])


def panel(axes: Any, title: str) -> list[Any]:
    """The fixed parts; lines of both motions, cranks and followers."""
    axes.set(xlim=(-0.28, 0.50), ylim=(-0.22, 0.29), aspect="equal")
    axes.set_axis_off()
    axes.set_title(title, fontsize=10)
    circle = SCENE["crank_length"] * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 91))
    axes.plot(circle.real, circle.imag, color="#dddddd", linewidth=0.8)
    for name, x in (("O", 0.0), ("P", SCENE["pivot_distance"])):
        axes.plot(x, 0.0, "^", color="black", markersize=6, zorder=3)
        axes.annotate(name, (x, 0.0), (0, -14), textcoords="offset points", ha="center", fontsize=9)
    looks = [(color, width) for color in (TRUE, BUILT) for width in (2.5, 2.0)]
    return [
        axes.plot([], [], "o-", color=color, linewidth=width, markevery=[-1])[0]
        for color, width in looks
    ]


def pictures() -> list[Image.Image]:
    """The frames."""
    truth, built = true_motion(), [built_motion(name) for name in SHOWN]
    figure, all_axes = plt.subplots(1, 2, figsize=(7.2, 3.2), dpi=100)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.16, top=0.86, wspace=0.02)
    lines = [panel(*each) for each in zip(all_axes, SHOWN.values(), strict=True)]
    figure.legend(
        lines[0][::2],
        ("true", "MuJoCo"),
        loc="lower center",
        ncols=2,
        frameon=False,
        fontsize=9,
    )
    said, frames = figure.text(0.5, 0.1, " ", ha="center", family="monospace", fontsize=9), []
    for row in range(0, round(1e3 * DURATION) + 1, EVERY):
        for drawn, (crank, follower) in zip(lines, built, strict=True):
            for k, (angle, points) in enumerate((truth, (crank, follower))):
                pin = SCENE["crank_length"] * np.exp(1j * angle[row])
                drawn[2 * k].set_data([0.0, pin.real], [0.0, pin.imag])
                drawn[2 * k + 1].set_data(points[row].real, points[row].imag)
        said.set_text(f"{1e-3 * row:5.3f} s, shown {SLOWED} times slower")
        file = io.BytesIO()
        figure.savefig(file, format="png")
        frames.append(Image.open(file).convert("RGB"))
    return frames


if __name__ == "__main__":
    first, *others = pictures()
    first.save(
        sys.argv[1],
        "WEBP",
        save_all=True,
        append_images=others,
        duration=EVERY * SLOWED,
        loop=0,
        quality=60,
        method=6,
    )
