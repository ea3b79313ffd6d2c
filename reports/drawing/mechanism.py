"""Draws the mechanism: O, P, crank, slider, bent follower, tip; any number of engines over each other.

A moving picture shows the last turn of the crank, slowed down.
"""

import io
import math
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from PIL import Image
from scipy.interpolate import CubicSpline

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError, UnknownColumn, shortened
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import PLACES, SHAPE
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import mean_crank_speed, rigid_motion
from quickreturn.reference_model.tip import tip_force
from quickreturn.reports.drawing.curves import WIDE
from quickreturn.reports.drawing.style import FONT_SIZE, GREY, QUICK, SAMPLE, SMALL, Drawing, look, new_figure
from quickreturn.reports.words import angle_text

LARGEST: Final = 0.15  # of the follower's length, largest magnified deflection
STRAIGHT: Final = 1e-6  # of the follower's length, deflection below which the follower counts as straight
STEPS: Final = (1.0, 2.0, 5.0)  # factors of magnification are these times a power of ten
POINTS: Final = 61  # along the follower
BESIDE: Final = np.array([18.0, 11.0])  # points: distance of a name from the point that it names, to the side and up
DARK: Final = "#333333"  # of names and of the force
CLEAR: Final = math.radians(120.0)  # rad, a crank angle at which no part covers another
MARGIN: Final = 0.07  # of the follower's length, around everything
COILS: Final = 8  # of a drawn spring
COIL: Final = 0.012  # of the follower's length, half the width of a drawn spring
ARROW: Final = 0.13  # of the follower's length, an arrow of the force on the tip
TURNING: Final = math.radians(225.0), math.radians(15.0)  # rad, crank angle of the arrow for the way of turning, and its length


@dataclass(frozen=True)
class Positions:
    """Places of all parts at n instants, in the frame of O, m.

    Attributes:
        time: s, shape (n,).
        crank_angle: rad, shape (n,); None where there is no crank.
        follower: coordinates along the line from the pivot through the slider and across it, shape (n, POINTS, 2); for a follower alone
            along its base tangent.
        direction: of that line, rad, shape (n,).
    """

    time: Array
    crank_angle: Array | None
    follower: Array
    direction: Array

    def placed(self, pivot: Array, factor: float) -> Array:
        """The follower's points, the deflection times a factor, shape (n, POINTS, 2). The loop stays closed."""
        along, across = self.follower[..., 0], factor * self.follower[..., 1]
        c, s = np.cos(self.direction)[:, None], np.sin(self.direction)[:, None]
        return pivot + np.stack([along * c - across * s, along * s + across * c], axis=-1)


def check_shape(trajectory: Trajectory) -> None:
    """UnknownColumn: the trajectory does not give the follower's shape."""
    if missing := [name for name in SHAPE if name not in trajectory.columns]:
        accepted = f"an engine with the columns {SHAPE[0]} to {SHAPE[-1]}"
        raise UnknownColumn(
            f'"{missing[0]}": this trajectory does not tell the shape of the follower, so it cannot be drawn; use {accepted}'
        )


def positions_of(scene: Scene, trajectory: Trajectory, times: Array) -> Positions:
    """The places from a trajectory at `times` (s, shape (n,)), interpolated between its rows.

    Raises:
        UnknownColumn: the trajectory does not give the follower's shape.
    """
    check_shape(trajectory)
    sampled = {name: np.interp(times, trajectory["time"], values) for name, values in trajectory.columns.items()}
    length = scene.follower.length
    deflections = np.stack([np.zeros_like(times), *(sampled[name] for name in SHAPE), sampled["tip_deflection"]], axis=1)
    clamped_free: Any = ((1, np.zeros_like(times)), (2, np.zeros_like(times)))
    shape = CubicSpline(np.linspace(0.0, length, PLACES + 2), deflections, axis=1, bc_type=clamped_free)
    x = np.linspace(0.0, length, POINTS)
    W, base = shape(x), sampled["follower_angle"]
    crank_angle = sampled.get("crank_angle")
    chord = rigid_motion(scene, crank_angle, 0.0).follower_angle if scene.crank is not None and crank_angle is not None else base
    turn = (base - chord)[:, None]
    bent = np.stack([np.cos(turn) * x - np.sin(turn) * W, np.sin(turn) * x + np.cos(turn) * W], axis=-1)
    return Positions(times, crank_angle, bent, chord)


def unbent(case: Case) -> Positions:
    """The mechanism with its crank at `CLEAR`, the follower straight."""
    scene, x = case.scene, np.linspace(0.0, case.scene.follower.length, POINTS)
    straight = np.stack([x, np.zeros_like(x)], axis=-1)[None]
    if scene.crank is None:
        return Positions(np.zeros(1), None, straight, np.zeros(1))
    angle = np.array([CLEAR])
    return Positions(np.zeros(1), angle, straight, rigid_motion(scene, angle, 0.0).follower_angle)


def factor_for(motions: Sequence[Positions], length: float) -> float:
    """A round factor, at least 1, that magnifies the largest deflection to at most `LARGEST` of `length` (m); 1 where nothing bends."""
    largest = max(float(np.max(np.abs(motion.follower[..., 1]))) for motion in motions)
    if largest <= STRAIGHT * length:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(LARGEST * length / largest))
    return max(1.0, max(step * decade for step in STEPS if step * decade <= LARGEST * length / largest))


class Scenery:
    """A drawing of one case on some axes; `show` moves its parts to an instant. Deflections are magnified by `factor`."""

    def __init__(self, axes: Axes, case: Case, motions: Mapping[str, Positions], factor: float) -> None:
        scene = case.scene
        self._crank_length = 0.0 if scene.crank is None else scene.crank.length
        self._pivot, self._length = np.array([scene.pivot_distance, 0.0]), scene.follower.length
        self._spring = getattr(scene, "acting_spring", None)
        self._motions, self._has_tip = motions, getattr(scene, "tip", None) is not None
        self._placed = {label: motion.placed(self._pivot, factor) for label, motion in motions.items()}
        self._frame(axes, scene.follower.length)
        self._fixed(axes, case)
        looks = {label: look(label) for label in motions}
        wide = {label: style | {"linewidth": 2.2 * style["linewidth"]} for label, style in looks.items()}
        self._followers = {label: axes.plot([], [], **style)[0] for label, style in wide.items()}
        marker: dict[str, Any] = {"markeredgecolor": "black", "markersize": 7.0}
        self._tips = {label: axes.plot([], [], "o", color=style["color"], zorder=3.5, **marker)[0] for label, style in looks.items()}
        self._straight = axes.plot([], [], color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), zorder=1.6)[0]
        self._crank = axes.plot([], [], color="black", linewidth=3.0, solid_capstyle="round", zorder=4.0)[0]
        self._coil = axes.plot([], [], color=GREY, linewidth=1.2, zorder=2.5)[0]
        self._slider = axes.plot([], [], "s", color=QUICK, zorder=6.0, **marker)[0]
        self._said = axes.text(0.012, 0.02, "", transform=axes.transAxes, fontsize=FONT_SIZE, family="monospace", va="bottom")
        named = [*(("crank", "slider") if self._crank_length else ()), "follower", *(("tip",) if self._has_tip else ())]
        self._tool = scene.tip_body if isinstance(scene, Mechanism) and scene.tip_body.is_forced else None
        arrow = {"arrowstyle": "-|>", "color": DARK, "linewidth": 1.4}
        name = "" if self._tool is None else "force"
        self._force = axes.annotate(name, (0.0, 0.0), (0.0, 0.0), fontsize=SMALL, color=DARK, arrowprops=arrow, visible=False)
        self._names = {name: _beside(axes, name, 10.0, fontsize=SMALL, color=DARK, zorder=7.0, va="center") for name in named}

    def _frame(self, axes: Axes, length: float) -> None:
        """Set equal scales, and limits that contain all parts at every instant."""
        points = np.concatenate([placed.reshape(-1, 2) for placed in self._placed.values()])
        turn = self._crank_length * np.array([[-1.0, -1.0], [1.0, 1.0]])
        anchor = [] if self._spring is None else [np.array([self._spring.anchor])]
        everything = np.concatenate([points, turn, self._pivot[None], np.zeros((1, 2)), *anchor])
        low, high = everything.min(axis=0) - MARGIN * length, everything.max(axis=0) + MARGIN * length
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1] - MARGIN * length, high[1])
        axes.set_aspect("equal")
        axes.set_axis_off()

    def _fixed(self, axes: Axes, case: Case) -> None:
        """Draw the fixed parts: the pivots with their names, the crank's circle with the quick return marked."""
        LA, d = self._crank_length, self._pivot[0]
        if isinstance(case.scene, Mechanism):
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(LA * np.cos(turn), LA * np.sin(turn), color="#BBBBBB", linewidth=0.8, zorder=1.0)
            back = np.linspace(-case.scene.half_return, case.scene.half_return, 61)
            axes.plot(LA * np.cos(back), LA * np.sin(back), color=QUICK, linewidth=2.0, alpha=0.6, zorder=1.1)
            if speed := mean_crank_speed(case.scene):
                (at, far), way = TURNING, math.copysign(1.0, speed)
                head, tail = ((LA * math.cos(each), LA * math.sin(each)) for each in (at + way * far, at))
                axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": GREY, "shrinkA": 0.0, "shrinkB": 0.0})
            axes.plot(0.0, 0.0, "o", color="black", markersize=5.0, zorder=5.0)
            _beside(axes, "O", -14.0, fontsize=FONT_SIZE)
        axes.plot(*self._pivot, "^", color="black", markersize=8.0, zorder=5.0)
        _beside(axes, "P", -16.0, x=d, fontsize=FONT_SIZE)
        if self._spring is not None:
            axes.plot(*self._spring.anchor, "^", color=GREY, markersize=7.0, zorder=5.0)

    def show(self, instant: int, text: str) -> None:
        """Move all parts to an instant, with a text below."""
        first = next(iter(self._motions.values()))
        along = np.array([math.cos(first.direction[instant]), math.sin(first.direction[instant])])
        end = self._pivot + first.follower[instant, -1, 0] * along
        self._straight.set_data([self._pivot[0], end[0]], [self._pivot[1], end[1]])
        for label, placed in self._placed.items():
            self._followers[label].set_data(*placed[instant].T)
            if self._has_tip:
                self._tips[label].set_data(*placed[instant, -1:].T)
        shown = next(iter(self._placed.values()))[instant]
        where = {"follower": shown[POINTS // 5], "tip": shown[-1]}
        if self._has_tip:
            self._names["tip"].xyann = tuple(along * BESIDE)  # beyond the end, where no spring is
        if self._spring is not None:
            held = shown[round(self._spring.place_on(self._length) / self._length * (POINTS - 1))]
            self._coil.set_data(*_coil(np.array(self._spring.anchor), held, COIL * self._length).T)
        if first.crank_angle is not None:
            slider = self._crank_length * np.array([math.cos(first.crank_angle[instant]), math.sin(first.crank_angle[instant])])
            self._crank.set_data([0.0, slider[0]], [0.0, slider[1]])
            self._slider.set_data(slider[:1], slider[1:])
            where |= {"crank": 0.5 * slider, "slider": slider}
            # the crank's name on the side away from the follower, the slider's on the other side
            across = np.array([-along[1], along[0]])
            away = across if slider @ across < 0.0 else -across  # from the follower to O
            beside_crank = np.array([-slider[1], slider[0]]) / self._crank_length
            sides = {"crank": beside_crank if beside_crank @ away > 0.0 else -beside_crank, "slider": -away}
            for name, side in sides.items():
                self._names[name].xyann = tuple(side * BESIDE)
            if self._tool is not None:
                force = complex(tip_force(self._tool, first.crank_angle[instant], first.direction[instant]))
                self._force.set_visible(force != 0.0)
                if force:
                    way = np.array([force.real, force.imag]) / abs(force)
                    self._force.xy = tuple(shown[-1])
                    self._force.set_position(tuple(shown[-1] - ARROW * self._length * way))
        for name, annotation in self._names.items():
            annotation.xy = (float(where[name][0]), float(where[name][1]))
        self._said.set_text(text)


def _coil(start: Array, end: Array, half_width: float) -> Array:
    """A spring's zigzag between two points, a tenth of it straight at either end, shape (points, 2)."""
    way = end - start
    across = half_width * np.array([-way[1], way[0]]) / max(float(np.hypot(*way)), 1e-12)
    part = np.concatenate([[0.0], np.linspace(0.1, 0.9, 2 * COILS + 1), [1.0]])
    side = np.zeros(part.size)
    side[2:-2] = np.where(np.arange(part.size - 4) % 2 == 0, 1.0, -1.0)
    return np.asarray(start + part[:, None] * way + side[:, None] * across)


def _beside(axes: Axes, name: str, up: float, x: float = 0.0, **look: Any) -> Any:
    """Write a name `up` points above a place on the x axis."""
    return axes.annotate(name, (x, 0.0), (0.0, up), textcoords="offset points", ha="center", **look)


def legend(motions: Mapping[str, Positions], factor: float) -> list[Line2D]:
    """Samples of the engines' lines and of the quick return, and the factor of the deflection."""
    deflection = "deflection as it is" if factor == 1.0 else f"deflection × {factor:g}"
    samples = [Line2D([], [], label=label, **look(label)) for label in motions]
    samples.append(Line2D([], [], color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), label=f"straight follower; {deflection}"))
    if any(motion.crank_angle is not None for motion in motions.values()):
        samples.append(Line2D([], [], color=QUICK, linewidth=2.0, alpha=0.6, label="quick return"))
    return samples


def mechanisms(cases: Sequence[Case]) -> Drawing:
    """Draw cases with straight followers, one below the other."""
    motions = [unbent(case) for case in cases]
    figure = new_figure(0.3 + 3.2 * len(cases), WIDE)
    for axes, case, motion in zip(figure.subplots(len(cases), 1, squeeze=False)[:, 0], cases, motions, strict=True):
        text = "" if motion.crank_angle is None else f"crank at {angle_text(math.degrees(float(motion.crank_angle[0])))}"
        Scenery(axes, case, {"reference": motion}, 1.0).show(0, text)
        axes.set_title(f"{case.name}: {case.title}", fontsize=FONT_SIZE, loc="left")
    figure.legend(handles=legend({"follower": motions[0]}, 1.0)[2:], loc="outside lower center", fontsize=SMALL, frameon=False)
    return figure


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
        ending: one of `reports.output.MOVING`; an .mp4 is encoded by ffmpeg.
        magnify: factor of the deflection in a picture; None: a round factor that makes the deflection visible.

    Raises:
        UnknownColumn: an engine does not give the follower's shape.
        CaseError: a page was asked for, and the case has no crank; or ffmpeg fails.
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
    pause = slowed * float(times[1] - times[0])
    if ending == ".mp4":
        return _encoded(frames, 1.0 / pause)
    unit = 10 if ending == ".gif" else 1  # ms, in which the file counts; rounding does not add up
    pauses = unit * np.diff(np.rint(1000.0 / unit * pause * np.arange(len(frames) + 1))).astype(int)
    options = {"append_images": frames[1:], "duration": pauses.tolist(), "loop": 0, "lossless": True, "method": 4}
    file = io.BytesIO()
    frames[0].save(file, ending.removeprefix("."), save_all=True, **options)
    return file.getvalue()


def _encoded(frames: Sequence[Image.Image], rate: float) -> bytes:
    """Pictures as H.264 in an .mp4, `rate` a second. CaseError: ffmpeg cannot do this."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "moving.mp4"  # an .mp4 is not written to a pipe
        given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{frames[0].width}x{frames[0].height}", "-r", f"{rate}", "-i", "-"]
        command = ["ffmpeg", "-loglevel", "error", *given, "-pix_fmt", "yuv420p", str(file)]
        content = b"".join(each.tobytes() for each in frames)
        told = subprocess.run(command, input=content, capture_output=True, check=False).stderr.decode(errors="replace").strip()
        if not file.exists():
            accepted = "install it with its encoder libx264, or choose .webp, .gif or .html"
            raise CaseError(".mp4", None, None, f"ffmpeg does not encode it ({shortened(told)})", accepted)
        return file.read_bytes()


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
