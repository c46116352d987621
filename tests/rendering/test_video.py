"""Videos show the recorded walk, frame by frame, and fail with words where nothing can be drawn."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.errors import InputError, RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering import ELEMENTS, look
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.scene import Moments
from mjbiped.rendering.stage import Film, Stage, caption
from mjbiped.rendering.video import render_frame, render_video
from mjbiped.terrain.terrain import Terrain

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")

Pixels = NDArray[np.uint8]


@pytest.fixture(scope="session")
def walk() -> Walk:
    return mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=5)


def decoded(path: Path, width: int, height: int) -> Pixels:
    """All frames of a video, shape (frames, height, width, 3)."""
    command = [
        imageio_ffmpeg.get_ffmpeg_exe(),
        "-v",
        "error",
        "-i",
        str(path),
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    raw = subprocess.run(command, capture_output=True, check=True).stdout
    return np.frombuffer(raw, dtype=np.uint8).reshape(-1, height, width, 3)


def share_of_legs(frame: Pixels) -> tuple[float, float]:
    """Shares of the frame that are as blue as the left leg and as orange as the right one."""
    red, _, blue = (frame[..., channel].astype(int) for channel in range(3))
    saturated = np.ptp(frame.astype(int), axis=-1) > 60
    return float((saturated & (blue > 2 * red)).mean()), float((saturated & (red > 2 * blue)).mean())


def middle_of_legs(frame: Pixels) -> float:
    """Column of the legs' middle, 0 to 1."""
    columns = np.flatnonzero((np.ptp(frame.astype(int), axis=-1) > 60).any(axis=0))
    return float(np.mean(columns) / frame.shape[1])


@needs_gl
def test_a_video_shows_the_whole_walk(walk: Walk, tmp_path: Path) -> None:
    path = tmp_path / "walk.mp4"
    render_video(walk, path, width=160, height=128, fps=5, slow_motion=1.5)
    frames = decoded(path, 160, 128)
    moving = int(walk.end[0] * 1.5 * 5) + 1
    assert len(frames) == moving + 5
    for frame in frames:
        assert share_of_legs(frame)[1] > 0.001  # the near leg, which hides the other when they pass
        assert 0.2 < middle_of_legs(frame) < 0.8
    assert np.mean([share_of_legs(frame)[0] > 0.001 for frame in frames]) > 0.8
    assert np.abs(frames[0].astype(int) - frames[3]).max() > 60
    assert sorted(tmp_path.iterdir()) == [path]


@needs_gl
@pytest.mark.parametrize("camera", ["track", "side", "overview"])
def test_every_camera_has_the_robot_and_the_ground_in_view_until_the_end(walk: Walk, camera: str) -> None:
    for time in (0.0, walk.end[0]):
        frame = render_frame(walk, time, width=160, height=120, camera=camera, hide="all")
        assert frame.shape == (120, 160, 3)
        assert frame.dtype == np.uint8
        assert all(share > 0.0005 for share in share_of_legs(frame))
        below, above = frame[110].astype(int), frame[4].astype(int)
        assert (below[:, 0] > below[:, 2] + 10).mean() > 0.9  # ground is brownish, the sky a pale blue
        assert (above[:, 2] >= above[:, 0]).mean() > 0.9


@needs_gl
def test_small_and_large_robots_look_alike() -> None:
    shares = []
    for length in (0.05, 0.5, 4.0):
        robot = mjbiped.Compass(lower_length=length, upper_length=length)
        ground, initial = Terrain.incline(2.0), (-0.2, 0.2, 0.1, 0.1)
        walked = mjbiped.walk(PassiveController(), ground, engine="hybrid", robot=robot, initial=initial)
        frame = render_frame(walked, 0.0, width=160, height=120, hide="all").astype(int)
        shares.append((frame[..., 0] > frame[..., 2] + 10).mean())  # of ground and the orange leg
    assert np.ptp(shares) < 0.01


@needs_gl
def test_a_frame_shows_the_recorded_posture(walk: Walk) -> None:
    """Rendering depends on the record alone: a moment is drawn as such, whatever was drawn before."""
    early, late = (render_frame(walk, time, width=96, height=64) for time in (0.1, 0.5))
    assert not np.array_equal(early, late)
    assert np.array_equal(early, render_frame(walk, 0.1, width=96, height=64))
    assert np.array_equal(render_frame(walk, [0.5, 0.1], width=96, height=64), [late, early])


@needs_gl
def test_frames_are_the_same_each_time(adaptive: Walk) -> None:
    one, other = (render_frame(adaptive, 0.7, width=320, height=240) for _ in range(2))
    assert np.array_equal(one, other)


@needs_gl
def test_the_camera_does_not_bob(walk: Walk) -> None:
    with Stage.open(walk, Film(64, 64, "track", look("all"), 0.0, walk.end[0])) as stage:
        heights = []
        for time in np.linspace(1.1, walk.end[0] - 1.1, 20):
            stage.frame(time)
            x, _, z = stage._posed.data.cam_xpos[stage._eye.fixedcamid]
            heights.append(z - walk.terrain.height_at(x))
    bob = np.ptp(walk.samples["qpos"][:, 1] - walk.terrain.height(walk.samples["qpos"][:, 0]))
    assert np.ptp(heights) < 0.4 * bob


@pytest.fixture(scope="session")
def adaptive(controller: AdaptiveController) -> Walk:
    """A walk with all that can be shown: on a step whose estimate is wrong, with torques and labels in view."""
    ground = Terrain.from_segments([(0.5, 0.0, 0.0), (9.0, 3.0, -0.02)])
    return mjbiped.walk(controller, ground, steps=5)


# where in a picture of 480 x 360 with a chart of 97 rows an element is seen, as (rows, columns)
REGIONS = {
    "torque": (slice(0, 263), slice(100, 330)),
    "force": (slice(150, 263), slice(100, 330)),
    "ghost": (slice(0, 240), slice(100, 330)),
    "estimate": (slice(150, 263), slice(50, 400)),
    "traces": (slice(150, 263), slice(0, 330)),
    "shadows": (slice(150, 263), slice(100, 330)),
    "scale": (slice(30, 110), slice(0, 110)),
    "labels": (slice(230, 263), slice(0, 480)),
    "caption": (slice(0, 110), slice(0, 480)),
}


@pytest.fixture(scope="session")
def shown(adaptive: Walk) -> Pixels:
    """Everything, in the haste after a step."""
    return render_frame(adaptive, float(adaptive.touchdowns["time"][2]) + 0.15, width=480, height=360)


@needs_gl
@pytest.mark.parametrize("element", REGIONS)
def test_each_element_is_seen_where_it_belongs_and_can_be_hidden(adaptive: Walk, shown: Pixels, element: str) -> None:
    time = float(adaptive.touchdowns["time"][2]) + 0.15
    hidden = render_frame(adaptive, time, width=480, height=360, hide=[element])
    changed = (shown != hidden).any(axis=2)
    assert changed[REGIONS[element]].sum() > 30
    if element in ("scale", "caption"):
        changed[:110] = False  # without a caption the scale moves up
    changed[REGIONS[element]] = False
    if element in ("torque", "force", "ghost", "estimate"):
        changed[:110, 300:] = False  # its line in the legend
    assert not changed.any()


@needs_gl
def test_the_chart_gives_its_room_back(adaptive: Walk) -> None:
    with_chart = render_frame(adaptive, 1.0, width=480, height=360)
    lower = with_chart[-97:]
    assert (lower == 255).all(axis=2).mean() > 0.6  # paper
    without = render_frame(adaptive, 1.0, width=480, height=360, hide="chart")
    assert (without[-40:, :, 0].astype(int) > without[-40:, :, 2] + 10).mean() > 0.8  # earth
    assert (render_frame(adaptive, 1.0, width=480, height=200)[-20:] == 255).all(axis=2).mean() < 0.1  # no room


@needs_gl
def test_slopes_and_small_steps_are_seen(controller: AdaptiveController) -> None:
    """The ground's edge, a dark line, falls by 3 degrees, and at a step by 20 mm, at the picture's own scale."""

    def edge(ground: Terrain) -> NDArray[np.int64]:
        walked = mjbiped.walk(controller, ground, engine="hybrid", steps=2)
        frame = render_frame(walked, 0.3, width=1280, height=526, hide="all", camera="side").astype(int)
        dark = frame.max(axis=2) < 70
        dark[:330] = False  # the hip is dark, too
        return np.array([np.argmax(column) if column.any() else -1 for column in dark.T])

    slope = edge(Terrain.incline(3.0))
    fall = np.polyfit(np.flatnonzero(slope > 0), slope[slope > 0], 1)[0]
    assert fall == pytest.approx(np.tan(np.radians(3.0)), abs=2e-3)  # a pixel in 500
    step = edge(Terrain.from_segments([(0.8, 0.0, 0.0), (9.0, 0.0, -0.02)]))
    pixels = 526 / 1.67  # per m: what the camera `side` sees is 1.67 m high
    assert step[-5] - step[5] == pytest.approx(0.02 * pixels, abs=1.0)


@needs_gl
def test_captions_and_the_outcome(walk: Walk) -> None:
    only_caption = [name for name in ELEMENTS if name != "caption"]
    plain = render_frame(walk, 1.0, width=320, height=200, hide="all")
    captioned = render_frame(walk, 1.0, width=320, height=200, hide=only_caption)
    changed = (plain != captioned).any(axis=2)
    assert changed[:40, :140].mean() > 0.2
    assert not changed[60:].any()
    assert (captioned[:40, :140].max(axis=2) < 90).sum() > 60  # dark letters
    with Stage.open(walk, Film(320, 200, "track", look(only_caption), 0.0, walk.end[0])) as stage:
        ended = stage.frame(1.0, with_outcome=True)
        assert not (ended != captioned).any(axis=2)[60:].any()
    assert (ended != captioned).any(axis=2)[:60, 200:].mean() > 0.05


def test_what_a_caption_says(walk: Walk) -> None:
    moments = Moments(walk)
    assert caption(moments.at(0.25), 1.0) == ["t = 0.25 s   step 1", "slope +2.0°"]
    assert caption(moments.at(walk.end[0]), 4.0) == [
        f"t = {walk.end[0]:.2f} s   step 5",
        "slope +2.0°",
        "slow motion 4×",
    ]
    estimating = {**walk.samples, "slope_estimate": np.full_like(walk.samples["slope"], np.deg2rad(-1.25))}
    moment = Moments(dataclasses.replace(walk, samples=estimating)).at(0.25)
    assert caption(moment, 0.5)[1:] == ["slope +2.0°   estimate −1.2°", "time lapse 2×"]


@pytest.mark.slow
@needs_gl
def test_visual_flags_of_mujoco(adaptive: Walk) -> None:
    time = float(adaptive.touchdowns["time"][2]) + 0.3
    size = {"width": 320, "height": 200, "hide": "all"}
    plain = render_frame(adaptive, time, **size)  # type: ignore[arg-type]
    for flag in (
        "contactpoint",
        "contactforce",
        "com",
        "inertia",
        "joint",
        "wireframe",
        "skybox",
        "no-shadow",
        "no-static",
    ):
        flagged = render_frame(adaptive, time, flags=[flag], **size)  # type: ignore[arg-type]
        assert (flagged != plain).any(axis=2).sum() > 20, flag


@needs_gl
def test_a_part_of_a_walk(walk: Walk, tmp_path: Path) -> None:
    path = tmp_path / "part.mp4"
    render_video(walk, path, width=160, height=128, fps=10, start=1.0, stop=2.0, hide="all")
    frames = decoded(path, 160, 128)
    assert len(frames) == 11 + 10  # and the last one held for a second
    first = render_frame(walk, 1.0, width=160, height=128, hide="all")
    assert np.abs(frames[0].astype(int) - first).mean() < 4.0  # H.264's losses


def test_a_part_outside_of_the_record_is_refused(walk: Walk, tmp_path: Path) -> None:
    for arguments, words in (
        ({"start": -0.1}, r"start = -0.1: must be from 0 to .* s of the record"),
        ({"stop": walk.end[0] + 1.0}, r"stop = .*: must be from 0 to .* s of the record"),
        ({"start": 2.0, "stop": 1.0}, r"start = 2 s comes after stop = 1 s: swap them"),
    ):
        with pytest.raises(InputError, match=words):
            render_video(walk, tmp_path / "walk.mp4", **arguments)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


@needs_gl
def test_a_gif_is_as_long_as_the_walk(walk: Walk, tmp_path: Path) -> None:
    path = tmp_path / "walk.gif"
    render_video(walk, path, width=161, height=121, fps=15, start=0.5, stop=1.5)
    with Image.open(path) as picture:
        assert picture.format == "GIF"
        assert picture.size == (161, 121)
        assert picture.info["loop"] == 0
        durations, colours = 0.0, set()
        for number in range(picture.n_frames):  # type: ignore[attr-defined]
            picture.seek(number)
            durations += picture.info["duration"]
            colours |= set(map(tuple, np.asarray(picture.convert("RGB"))[::7, ::7].reshape(-1, 3)))
    # a second of walking, 16 frames, and one held; GIF counts in hundredths of a second
    assert durations / 1e3 == pytest.approx(16 / 15 + 1.0, abs=0.05)
    assert 10 < len(colours) <= 256
    assert sorted(tmp_path.iterdir()) == [path]


@needs_gl
def test_a_walk_on_knees_that_diverged_is_shown_to_its_end(tmp_path: Path) -> None:
    robot = mjbiped.KneedBiped()
    walked = mjbiped.walk(PassiveController(), Terrain.incline(2.5), robot=robot, engine="hybrid", steps=1)
    samples = {name: column.copy() for name, column in walked.samples.items()}
    samples["q"][-1], samples["dq"][-1], samples["torque"][-1] = 1e6, 1e9, np.nan
    diverged = dataclasses.replace(walked, samples=samples, outcome="diverged")
    render_video(diverged, tmp_path / "walk.mp4", width=160, height=240, fps=2)
    assert len(decoded(tmp_path / "walk.mp4", 160, 240)) == int(walked.end[0] * 2) + 1 + 2


@needs_gl
def test_a_suffix_may_be_in_large_letters(walk: Walk, tmp_path: Path) -> None:
    for name in ("walk.GIF", "walk.MP4"):
        render_video(walk, tmp_path / name, width=64, height=64, fps=2, stop=1.0)
    with Image.open(tmp_path / "walk.GIF") as picture:
        assert picture.format == "GIF"
    assert len(decoded(tmp_path / "walk.MP4", 64, 64)) == 3 + 2


@needs_gl
def test_without_a_path_a_notebook_shows_it(walk: Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Any] = []
    monkeypatch.setattr("IPython.display.display", shown.append)
    walk.video(width=96, height=64, fps=5, stop=1.0)
    [video] = shown
    assert "data:video/mp4;base64," in video._repr_html_()
    with pytest.raises(InputError, match="even"):
        walk.video(width=97, height=64)


@needs_gl
def test_sizes_beyond_the_models_own_are_drawn(walk: Walk) -> None:
    assert render_frame(walk, 0.0, width=2000, height=64).shape == (64, 2000, 3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"width": 97}, "even"),
        ({"height": 63}, "64 to 4096"),
        ({"width": 32}, "64 to 4096"),
        ({"width": 100_000}, "64 to 4096"),
        ({"width": 96.0}, "whole number"),
        ({"fps": 0}, "fps"),
        ({"fps": 121}, "fps"),
        ({"fps": 29.97}, "fps"),
        ({"slow_motion": 0.0}, "slow_motion"),
        ({"slow_motion": float("nan")}, "slow_motion"),
        ({"slow_motion": "half"}, "slow_motion"),
        ({"camera": "drone"}, "track, side, overview"),
        ({"hide": "ghosts"}, "did you mean 'ghost'"),
        ({"hide": 3}, "must be names"),
        ({"flags": ["contactpoints"]}, "did you mean 'contactpoint'"),
        ({"start": "soon"}, "start"),
        ({"stop": float("nan")}, "stop"),
    ],
)
def test_refused_arguments(walk: Walk, tmp_path: Path, arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        render_video(walk, tmp_path / "walk.mp4", **{"width": 96, "height": 64, **arguments})  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_refused_paths_times_and_records(walk: Walk, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.mp4 or \.gif"):
        render_video(walk, tmp_path / "walk.avi")
    with pytest.raises(InputError, match="at most 50 frames per second"):
        render_video(walk, tmp_path / "walk.gif", fps=60)
    for time in (-0.1, walk.end[0] + 0.1, float("nan")):
        with pytest.raises(InputError, match=r"time = .*: must be .*from 0 to .* s of the record"):
            render_frame(walk, time)
    empty = dataclasses.replace(walk, samples={name: array[:0] for name, array in walk.samples.items()})
    with pytest.raises(RenderError, match="no samples"):
        render_video(empty, tmp_path / "walk.mp4")


@needs_gl
def test_a_file_that_cannot_be_written(walk: Walk, tmp_path: Path) -> None:
    with pytest.raises(RenderError, match=r"cannot write .*No such file"):
        render_video(walk, tmp_path / "missing" / "walk.mp4", width=96, height=64)


@needs_gl
def test_no_half_of_a_video_is_left(walk: Walk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "walk.mp4"
    path.write_bytes(b"an older one")

    def failing(*_: object, **__: object) -> Pixels:
        raise KeyboardInterrupt

    monkeypatch.setattr(Stage, "frame", failing)
    with pytest.raises(KeyboardInterrupt):
        render_video(walk, path, width=96, height=64)
    monkeypatch.undo()
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: "/bin/false")
    with pytest.raises(RenderError, match="encoder failed"):
        render_video(walk, path, width=96, height=64)
    assert path.read_bytes() == b"an older one"
    assert sorted(tmp_path.iterdir()) == [path]


REFUSED = """
import os
from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl, gl_available
os.environ.update({changes!r})
assert gl_available() is None
try:
    ensure_gl()
except RenderError as error:
    print(error)
"""

WITHOUT_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent", "DISPLAY": "", "WAYLAND_DISPLAY": ""}


def refusal(script: str, **environment: str) -> str:
    """What a script prints where it ends well and complains of nothing."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other platforms")
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"MUJOCO_GL": "disable"}, "MUJOCO_GL=disable switches drawing off"),
        ({"MUJOCO_GL": "nonsense"}, "valid are egl, glfw, osmesa"),
        ({"MUJOCO_GL": "egl", **WITHOUT_EGL}, "libegl1 and libgl1-mesa-dri"),
        ({"MUJOCO_GL": "egl", "PYOPENGL_PLATFORM": "osmesa"}, "PYOPENGL_PLATFORM environment variable is set"),
    ],
)
def test_a_missing_platform_is_told_in_words(changes: dict[str, str], words: str) -> None:
    message = refusal(REFUSED.format(changes=changes))
    assert words in message
    assert "records and figures need no OpenGL" in message


IMPORTED = """
import mjbiped
from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl
assert mjbiped.find_passive_gait(mjbiped.Compass(), 0.03).stable
try:
    ensure_gl()
except RenderError:
    print("refused")
"""


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["nonsense", "egl"])
def test_a_bad_platform_hinders_no_walk(platform: str) -> None:
    """MuJoCo itself cannot be imported where MUJOCO_GL is nonsense or its library is missing."""
    assert refusal(IMPORTED, MUJOCO_GL=platform, **WITHOUT_EGL) == "refused\n"
