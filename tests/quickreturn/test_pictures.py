"""Pictures of cases and trajectories, and the moving one."""

import io
import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Annotation
from PIL import Image

import quickreturn as qr
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reports.drawing.mechanism import (
    FRAMES,
    LARGEST,
    POINTS,
    SLOWED,
    factor_for,
    last_turn,
    mechanisms,
    moving,
    positions_of,
    unbent,
)
from quickreturn.reports.output import MOVING, MissingExtra, OutputError, check_writable
from tests.quickreturn.conftest import Call
from tests.quickreturn.scene_file import SCENE

CASE = load_case("thesis-24")


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    """Half a second of run 24: more than one turn."""
    return simulate(
        engine("reference"), CASE.scene, standard_start(CASE.scene), 0.5, 1e-3, {"modes": "3", "tolerance": "1e-6"}, estimate=False
    ).trajectory


def test_the_drawn_follower_passes_through_the_slider_and_ends_at_the_tip(trajectory: Trajectory) -> None:
    mechanism, rows = CASE.mechanism, slice(0, None, 50)
    times = trajectory["time"][rows]
    motion = positions_of(mechanism, trajectory, times)
    pivot = np.array([mechanism.pivot_distance, 0.0])
    largest = np.abs(trajectory["tip_deflection"]).max()
    placed = motion.placed(pivot, 1.0)
    # arc length is drawn as distance: what foreshortening makes of it is a few percent of the deflection
    tip = np.stack([trajectory["tip_x"][rows], trajectory["tip_y"][rows]], axis=1)
    assert np.abs(placed[:, -1] - tip).max() < 0.05 * largest
    for factor in (1.0, 5.0):  # whatever it is magnified by, the loop stays closed
        for instant, angle in enumerate(trajectory["crank_angle"][rows]):
            slider = mechanism.crank.length * np.array([np.cos(angle), np.sin(angle)])
            off = np.hypot(*(motion.placed(pivot, factor)[instant] - slider).T).min()
            spacing = mechanism.follower.length / (POINTS - 1)
            assert off < 0.5 * spacing + 0.05 * factor * largest


def test_the_deflection_is_magnified_by_a_round_factor(trajectory: Trajectory) -> None:
    motion, length = positions_of(CASE.scene, trajectory, trajectory["time"]), CASE.scene.follower.length
    largest, factor = np.abs(motion.follower[..., 1]).max(), factor_for([motion], length)
    assert 0.4 * LARGEST * length < factor * largest <= LARGEST * length
    assert factor in (1.0, 2.0, 5.0, 10.0)
    assert factor_for([unbent(CASE)], length) == 1.0


def test_a_spring_is_drawn_from_its_fixed_point_to_its_place_on_the_follower() -> None:
    case = load_case("return-spring")
    spring, length = case.mechanism.acting_spring, case.mechanism.follower.length
    axes = mechanisms([case]).axes[0]
    anchor, place = np.array(spring.anchor), spring.place_on(length)
    (coil,) = (line for line in axes.lines if len(line.get_xdata()) > 2 and np.allclose(line.get_xydata()[0], anchor))
    follower = unbent(case).placed(np.array([case.mechanism.pivot_distance, 0.0]), 1.0)[0]
    end = follower[0] + place / length * (follower[-1] - follower[0])
    assert coil.get_xydata()[-1] == pytest.approx(end, abs=0.5 * length / (POINTS - 1))


def test_the_last_whole_turn_is_shown(trajectory: Trajectory) -> None:
    times = last_turn(trajectory)
    angle = np.interp(times, trajectory["time"], trajectory["crank_angle"])
    assert len(times) == FRAMES + 1
    assert angle[-1] - angle[0] == pytest.approx(2.0 * np.pi, abs=0.02)


@pytest.mark.verify
def test_the_moving_picture_moves_and_is_small(trajectory: Trajectory) -> None:
    content = moving(CASE, {"reference": trajectory}, ".webp")
    assert len(content) < 500_000
    image = Image.open(io.BytesIO(content))
    frames = []
    for number in range(image.n_frames):  # type: ignore[attr-defined]
        image.seek(number)
        frames.append(np.asarray(image.convert("L"), dtype=float))
    assert len(frames) == FRAMES
    assert all(np.abs(one - other).max() > 100.0 for one, other in itertools.pairwise(frames))


def test_a_trajectory_that_does_not_tell_its_shape_is_refused(trajectory: Trajectory) -> None:
    columns = {name: values for name, values in trajectory.columns.items() if name != SHAPE[3]}
    with pytest.raises(qr.UnknownColumn, match=SHAPE[3]):
        positions_of(CASE.scene, Trajectory(columns, 0.0), trajectory["time"])


@pytest.fixture
def few_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """A turn in few pictures: each takes some hundredths of a second."""
    monkeypatch.setattr("quickreturn.reports.drawing.mechanism.FRAMES", 6)


@pytest.mark.usefixtures("few_frames")
@pytest.mark.verify
def test_a_solution_is_drawn_moving_to_a_picture_or_a_page(tmp_path: Path) -> None:
    solution = qr.simulate(qr.case("thesis-24", duration=0.1), "reference", settings={"modes": 3, "tolerance": 1e-6}, store=False)
    solution.animate(tmp_path / "out.html")
    page = (tmp_path / "out.html").read_text()
    assert "<canvas" in page
    assert "Run 24" in page
    assert not re.search(r"(src|href)=.https?:", page), "it opens without a network"
    solution.animate(tmp_path / "out.webp", magnify=2.0)
    assert (tmp_path / "out.webp").read_bytes().startswith(b"RIFF")
    with pytest.raises(OutputError, match="avi"):
        solution.animate(tmp_path / "out.avi")


@pytest.mark.usefixtures("few_frames")
def test_a_gif_keeps_time_and_ffmpeg_is_given_every_picture(
    trajectory: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gif = Image.open(io.BytesIO(moving(CASE, {"reference": trajectory}, ".gif")))
    shown = []
    for number in range(gif.n_frames):  # type: ignore[attr-defined]
        gif.seek(number)
        shown.append(gif.info["duration"])
    assert len(shown) == 6
    turn = float(np.ptp(last_turn(trajectory)))
    assert min(abs(sum(shown) / 1e3 - slowed * turn) for slowed in SLOWED) < 0.006  # s, half of the unit in which a GIF counts
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingExtra, match="needs ffmpeg, which is not installed"):
        check_writable(tmp_path / "film.mp4", "", *MOVING)
    (tmp_path / "ffmpeg").write_text("#!/bin/sh\necho no libx264 >&2\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    with pytest.raises(CaseError, match=r"ffmpeg does not encode it \(no libx264\)"):
        moving(CASE, {"reference": trajectory}, ".mp4")
    # a stand-in that keeps what it is given, where there is no ffmpeg
    (tmp_path / "ffmpeg").write_text('#!/bin/sh\nfor last; do :; done\nexec /bin/cat > "$last"\n')
    assert len(moving(CASE, {"reference": trajectory}, ".mp4")) == 6 * 720 * 390 * 3


@pytest.mark.usefixtures("few_frames")
def test_a_case_without_a_crank_can_be_drawn() -> None:
    case = load_case("spin-up")
    assert not isinstance(case.scene, Mechanism)
    found = simulate(
        engine("reference"), case.scene, standard_start(case.scene), 1.0, 0.05, {"modes": "3", "tolerance": "1e-6"}, estimate=False
    ).trajectory
    assert Image.open(io.BytesIO(moving(case, {"reference": found}, ".webp"))).size == (720, 390)


@pytest.mark.parametrize(("ending", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF"), ("webp", b"RIFF")])
def test_plot_writes_what_the_ending_says(call: Call, tmp_path: Path, ending: str, begins: bytes) -> None:
    answer = call("plot", "thesis-24", "--output", f"out.{ending}")
    assert answer == (0, f"out.{ending}\n", "")
    assert (tmp_path / f"out.{ending}").read_bytes().startswith(begins)


def test_plot_draws_engines_and_files(call: Call, tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SCENE)
    assert call("simulate", "small.toml", "--engine", "fake", "--output", "run.csv", "--set", "engine.step=0.1").code == 0
    both = ("plot", "small.toml", "run.csv", "--engine", "fake", "--column", "tip_x", "--column", "strain_1", "--output", "out.svg")
    assert call(*both).code == 0
    assert call("plot", "small.toml", "run.csv", "--output", "other.svg").code == 2
    (tmp_path / "bad.csv").write_text("time,tip_x\n0,much\n")
    for file, word in (("bad.csv", "tip_x"), ("small.toml.csv", "no such file")):
        answer = call("plot", file, "--output", "other.svg")
        assert (answer.code, word in answer.errors, answer.errors.count("\n")) == (2, True, 1)
    assert not (tmp_path / "other.svg").exists()


@pytest.mark.parametrize("way", [1, -1])
def test_arrows_show_the_way_of_turning_and_the_force_on_the_tip(way: int) -> None:
    """The crank's arrow has positive moment about O where it turns counterclockwise; the force comes to the tip from its own direction."""
    case = load_case("shaper-cutting", {"crank.prescribed_speed": f"{90 * way} rpm"})
    (axes,) = mechanisms([case]).axes
    arrows = [each for each in axes.texts if isinstance(each, Annotation) and each.arrow_patch is not None]
    turning = next(each for each in arrows if each.get_text() == "")
    (x, y), (u, v) = turning.xyann, np.subtract(turning.xy, turning.xyann)
    assert math.copysign(1.0, x * v - y * u) == way
    force = next(each for each in arrows if each.get_text() == "force")
    assert force.get_visible()
    tip = case.mechanism.tip_body
    along = np.subtract(force.xy, force.get_position())
    end = np.subtract(force.xy, (case.mechanism.pivot_distance, 0.0))
    angle = math.atan2(end[1], end[0]) if tip.follows else 0.0
    expected = complex(*tip.components) * np.exp(1j * angle)
    assert complex(*along) / abs(complex(*along)) == pytest.approx(expected / abs(expected), abs=1e-9)
