"""A moving picture of a case: the last turn of the crank, slowed down, engines over each other."""

import io
import math
from collections.abc import Mapping
from typing import Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from quickreturn.cases.files.case import Case
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reports.drawing.mechanism import Positions, Scenery, check_shape, factor_for, legend, positions_of
from quickreturn.reports.drawing.style import FONT_SIZE, SAMPLE, Array, new_figure

FRAMES: Final = 72  # pictures in a turn
WIDTH, HEIGHT, DENSITY = 7.2, 3.9, 100  # in, in, dots per inch
SLOWED: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # factors of slow motion; the least that makes a turn last `TURN` is used
TURN: Final = 4.0  # s, least duration of a turn in the picture
COLOURS: Final = 64  # in a picture: enough for lines and their smoothed edges; more make the file larger


def moving(case: Case, trajectories: Mapping[str, Trajectory], ending: str, magnify: float | None = None) -> bytes:
    """The content of a file: the moving picture, or a page that shows it and opens from disk.

    Args:
        case: what was simulated.
        trajectories: of the engines by name, on one output grid.
        ending: ".webp" or ".html".
        magnify: factor of the deflection in a picture; None: a round factor that makes the deflection visible.

    Raises:
        UnknownColumn: an engine does not give the follower's shape.
        CaseError: a page was asked for, and the case has no crank.
    """
    for trajectory in trajectories.values():
        check_shape(trajectory)
    if ending == ".html":
        from quickreturn.reports.page.render import animation_page

        return animation_page(case, trajectories).encode()
    times = last_turn(next(iter(trajectories.values())))
    slowed = next((factor for factor in SLOWED if factor * (times[-1] - times[0]) >= TURN), SLOWED[-1])
    motions = {name: positions_of(case.scene, trajectory, times[:-1]) for name, trajectory in trajectories.items()}
    factor = magnify or factor_for(list(motions.values()), case.scene.follower.length)
    frames = _frames(case, motions, factor, slowed)
    file = io.BytesIO()
    pause = round(1000.0 * slowed * float(times[1] - times[0]))
    options = {"save_all": True, "append_images": frames[1:], "duration": pause, "loop": 0, "lossless": True, "method": 4}
    frames[0].save(file, "WEBP", **options)
    return file.getvalue()


def last_turn(trajectory: Trajectory) -> Array:
    """`FRAMES` + 1 evenly spaced times (s) over the last whole turn of the crank, or over the trajectory if it has none."""
    time, end = trajectory["time"], float(trajectory["time"][-1])
    angle = trajectory.columns.get("crank_angle")
    begin = float(time[0])
    if angle is not None and abs(angle[-1] - angle[0]) > 2.0 * math.pi:
        turned = np.abs(angle - angle[0])
        begin = float(time[np.searchsorted(np.maximum.accumulate(turned), turned[-1] - 2.0 * math.pi)])
    return np.linspace(begin, end, FRAMES + 1)


def _frames(case: Case, motions: Mapping[str, Positions], factor: float, slowed: int) -> list[Image.Image]:
    figure = new_figure(HEIGHT, WIDTH)
    axes = figure.subplots()
    scenery = Scenery(axes, case, motions, factor)
    speed = "" if slowed == 1 else f"; shown {slowed} times slower"
    figure.suptitle(f"{case.name}: {case.title}{speed}", fontsize=FONT_SIZE)
    samples = {"handlelength": SAMPLE, "ncols": 4, "fontsize": FONT_SIZE - 1.0, "frameon": False}
    figure.legend(handles=legend(motions, factor), loc="outside lower center", **samples)
    figure.set_dpi(DENSITY)
    canvas, images = FigureCanvasAgg(figure), []
    first = next(iter(motions.values()))
    scenery.show(0, " ")
    canvas.draw()
    figure.set_layout_engine("none")  # so that nothing moves but the mechanism
    for instant, time in enumerate(first.time):
        angle = "" if first.crank_angle is None else f"  crank at {math.degrees(float(first.crank_angle[instant])) % 360.0:3.0f}°"
        scenery.show(instant, f"{time:6.3f} s{angle}")
        canvas.draw()
        image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        images.append(image.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).convert("RGB"))
    return images
