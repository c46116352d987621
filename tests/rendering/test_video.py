"""Videos show the recorded walk, frame by frame, and fail with words where nothing can be drawn."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from controllers import PassiveController
from mjbiped.errors import InputError, RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering import video
from mjbiped.rendering.video import gl_available, render_frame, render_frames, render_video
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
        frame = render_frame(walk, time, width=160, height=120, camera=camera, shadows=False)
        assert frame.shape == (120, 160, 3)
        assert frame.dtype == np.uint8
        assert all(share > 0.0005 for share in share_of_legs(frame))
        below = frame[int(0.93 * 120) if camera != "overview" else 90].astype(int)
        assert (below[:, 0] >= below[:, 2]).mean() > 0.8  # ground is brownish, the sky blue


@needs_gl
def test_a_frame_shows_the_recorded_posture(walk: Walk) -> None:
    """Rendering depends on the record alone: a moment is drawn as such, whatever was drawn before."""
    early, late = (render_frame(walk, time, width=96, height=64) for time in (0.1, 0.5))
    assert not np.array_equal(early, late)
    assert np.array_equal(early, render_frame(walk, 0.1, width=96, height=64))
    assert np.array_equal(render_frames(walk, [0.5, 0.1], width=96, height=64), [late, early])


@needs_gl
def test_the_camera_does_not_bob(walk: Walk) -> None:
    with video._Stage.open(walk, 64, 64, "track", shadows=False) as stage:
        heights = []
        for time in np.linspace(1.1, walk.end[0] - 1.1, 20):
            stage.frame(time, caption=False)
            x, _, z = stage._data.cam_xpos[stage._camera]
            heights.append(z - walk.terrain.height_at(x))
    bob = np.ptp(walk.samples["qpos"][:, 1] - walk.terrain.height(walk.samples["qpos"][:, 0]))
    assert np.ptp(heights) < 0.4 * bob


@needs_gl
def test_captions_and_the_outcome(walk: Walk) -> None:
    plain = render_frame(walk, 1.0, width=320, height=240)
    captioned = render_frame(walk, 1.0, width=320, height=240, caption=True)
    changed = (plain != captioned).any(axis=2)
    assert changed[:60, :160].mean() > 0.2
    assert not changed[80:].any()
    assert (captioned[:60, :160] > 200).all(axis=2).sum() > 100  # white letters
    with video._Stage.open(walk, 320, 240, "track", shadows=True) as stage:
        ended = stage.frame(1.0, caption=True, with_outcome=True)
        assert not (ended != captioned).any(axis=2)[60:].any()
    assert (ended != captioned).any(axis=2)[:60, 160:].mean() > 0.1


def test_what_a_caption_says(walk: Walk) -> None:
    assert video._caption(walk, 0.25, 1.0) == ["t = 0.25 s   step 0", "slope +2.0°"]
    assert video._caption(walk, walk.end[0], 4.0) == [
        f"t = {walk.end[0]:.2f} s   step 5",
        "slope +2.0°",
        "slow motion 4×",
    ]
    estimating = {**walk.samples, "slope_estimate": np.full_like(walk.samples["slope"], np.deg2rad(-1.25))}
    message = video._caption(dataclasses.replace(walk, samples=estimating), 0.25, 0.5)
    assert message[1:] == ["slope +2.0°   estimate −1.2°", "time lapse 2×"]


@needs_gl
def test_sizes_beyond_the_models_own_are_drawn(walk: Walk) -> None:
    assert render_frame(walk, 0.0, width=2000, height=64, shadows=False).shape == (64, 2000, 3)


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
    ],
)
def test_refused_arguments(walk: Walk, tmp_path: Path, arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        render_video(walk, tmp_path / "walk.mp4", **{"width": 96, "height": 64, **arguments})  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_refused_paths_times_and_records(walk: Walk, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.mp4"):
        render_video(walk, tmp_path / "walk.gif")
    for time in (-0.1, walk.end[0] + 0.1, float("nan")):
        with pytest.raises(InputError, match=r"must be .*numbers from 0 to .* s of the record"):
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

    monkeypatch.setattr(video._Stage, "frame", failing)
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
from mjbiped.rendering.video import ensure_gl, gl_available
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
from mjbiped.rendering.video import ensure_gl
assert mjbiped.find_passive_gait(mjbiped.Compass(), 0.03).stable
try:
    ensure_gl()
except RenderError:
    print("refused")
"""


@pytest.mark.parametrize("platform", ["nonsense", "egl"])
def test_a_bad_platform_hinders_no_walk(platform: str) -> None:
    """MuJoCo itself cannot be imported where MUJOCO_GL is nonsense or its library is missing."""
    assert refusal(IMPORTED, MUJOCO_GL=platform, **WITHOUT_EGL) == "refused\n"
