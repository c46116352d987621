"""Pictures and videos of a walk show the recorded posture, the ground and what explains them."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest
from PIL import Image

from mjbiped import InputError, RenderError, Walk, render_frame, render_video
from mjbiped.rendering import ELEMENTS, look
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.overlay import Pixels

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


def shares_of_legs(frame: Pixels) -> np.ndarray:
    """Shares of the frame that are as blue as the left leg and as orange as the right one."""
    red, _, blue = np.moveaxis(frame.astype(int), -1, 0)
    saturated = np.ptp(frame.astype(int), axis=-1) > 60
    return np.array([(saturated & (one > 2 * other)).mean() for one, other in ((blue, red), (red, blue))])


@needs_gl
@pytest.mark.parametrize("camera", ["track", "side", "overview"])
def test_every_camera_has_the_robot_and_the_ground_in_view_until_the_end(walk: Walk, camera: str) -> None:
    for frame in render_frame(walk, [0.0, walk.end[0]], width=160, height=120, camera=camera, hide="all"):
        assert (shares_of_legs(frame) > 0.0005).all()
        below, above = frame[110].astype(int), frame[4].astype(int)
        assert (below[:, 0] > below[:, 2] + 10).mean() > 0.9  # ground is brownish, the sky a pale blue
        assert (above[:, 2] >= above[:, 0]).mean() > 0.9


@needs_gl
def test_a_frame_depends_on_the_record_alone(adaptive: Walk) -> None:
    """Whatever was drawn before."""
    early, late = (render_frame(adaptive, time, width=320, height=260) for time in (0.1, 0.5))
    assert not np.array_equal(early, late)
    assert np.array_equal(render_frame(adaptive, [[0.5], [0.1]], width=320, height=260), [[late], [early]])


# where in a picture of 480 x 263 an element is seen, as (rows, columns)
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


@needs_gl
def test_each_element_is_seen_where_it_belongs_and_can_be_hidden(adaptive: Walk) -> None:
    time = float(adaptive.touchdowns["time"][2]) + 0.15  # in the haste after a step
    charted, bare = (render_frame(adaptive, time, width=480, height=360, hide=hidden) for hidden in ((), ["chart"]))
    assert (charted[-97:] == 255).all(axis=2).mean() > 0.6  # paper
    assert (charted != bare)[-97:].any(axis=2).sum() > 30  # the picture takes the chart's room
    size: dict[str, Any] = {"width": 480, "height": 263}
    shown = render_frame(adaptive, time, hide=["chart"], **size)
    assert [*REGIONS, "chart"] == [*ELEMENTS]
    for element, region in REGIONS.items():
        changed = (shown != render_frame(adaptive, time, hide=["chart", element], **size)).any(axis=2)
        assert changed[region].sum() > 30, element
        if element in ("scale", "caption"):
            changed[:110] = False  # without a caption the scale moves up
        changed[region] = False
        if element in ("torque", "force", "ghost", "estimate"):
            changed[:110, 300:] = False  # its line in the legend
        assert not changed.any(), element
    for flag in ("contactforce", "wireframe", "no-static"):
        flagged = render_frame(adaptive, time, hide=["chart"], flags=[flag], **size)
        assert (shown != flagged).any(axis=2).sum() > 20, flag
    low = render_frame(adaptive, time, width=480, height=200)
    assert (low[-20:] == 255).all(axis=2).mean() < 0.1  # there is no room for a chart


def test_elements_and_flags_by_name() -> None:
    assert look().elements == {*ELEMENTS}
    assert look(["ghost", "chart, force"]).elements == {*ELEMENTS} - {"ghost", "chart", "force"}
    assert look("all").elements == set()
    chosen = look(flags=["contactpoint", "no-static,WIREFRAME"])
    assert chosen.visual == {mujoco.mjtVisFlag.mjVIS_CONTACTPOINT: True, mujoco.mjtVisFlag.mjVIS_STATIC: False}
    assert chosen.rendering == {mujoco.mjtRndFlag.mjRND_WIREFRAME: True}


# ---- videos ---------------------------------------------------------------------------------------------------------


def decoded(path: Path, width: int, height: int) -> Pixels:
    """All frames of a video, shape (frames, height, width, 3)."""
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(path), *raw]
    return np.frombuffer(subprocess.check_output(command), dtype=np.uint8).reshape(-1, height, width, 3)


@needs_gl
def test_a_video_shows_the_part_that_is_asked_for(walk: Walk, tmp_path: Path) -> None:
    path = tmp_path / "walk.MP4"
    size: dict[str, Any] = {"width": 160, "height": 128, "hide": "all"}
    render_video(walk, path, fps=5, slow_motion=1.5, start=0.5, **size)
    frames = decoded(path, 160, 128)
    assert len(frames) == int((walk.end[0] - 0.5) * 1.5 * 5) + 1 + 5  # the last one is held for a second
    shown = frames[:-5:4]
    expected = render_frame(walk, 0.5 + 4 * np.arange(len(shown)) / 7.5, **size)
    assert (np.abs(shown.astype(int) - expected).mean(axis=(1, 2, 3)) < 4.0).all()  # H.264's losses
    assert sorted(tmp_path.iterdir()) == [path]


@needs_gl
def test_a_gif_keeps_size_and_time(walk: Walk, tmp_path: Path) -> None:
    render_video(walk, tmp_path / "walk.GIF", width=161, height=121, fps=15, start=0.5, stop=1.5)
    with Image.open(tmp_path / "walk.GIF") as picture:
        assert (picture.format, picture.size, picture.info["loop"]) == ("GIF", (161, 121), 0)
        durations = 0.0
        for number in range(picture.n_frames):  # type: ignore[attr-defined]
            picture.seek(number)
            durations += picture.info["duration"]
    # a second of walking, 16 frames, and one held; GIF counts in hundredths of a second
    assert durations / 1e3 == pytest.approx(16 / 15 + 1.0, abs=0.05)


@needs_gl
def test_a_walk_that_diverged_is_shown_to_its_end(walk: Walk, tmp_path: Path) -> None:
    samples = {name: column.copy() for name, column in walk.samples.items()}
    samples["q"][-1], samples["dq"][-1], samples["torque"][-1] = 1e6, 1e9, np.nan
    diverged = dataclasses.replace(walk, samples=samples, outcome="diverged")
    render_video(diverged, tmp_path / "walk.mp4", width=160, height=240, fps=2)
    assert len(decoded(tmp_path / "walk.mp4", 160, 240)) == int(walk.end[0] * 2) + 1 + 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"fps": 121}, "fps"),
        ({"slow_motion": float("nan")}, "slow_motion"),
        ({"camera": "drone"}, "track, side, overview"),
        ({"start": -0.1}, r"start = -0.1: must be from 0 to .* s of the record"),
        ({"path": "walk.avi"}, r"\.mp4 or \.gif"),
        ({"path": "walk.gif", "fps": 60}, "at most 50"),
    ],
)
def test_refused_arguments(walk: Walk, tmp_path: Path, arguments: dict[str, Any], words: str) -> None:
    settings = {"width": 96, "height": 64, "path": "walk.mp4", **arguments}
    with pytest.raises(InputError, match=words):
        render_video(walk, tmp_path / settings.pop("path"), **settings)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="of the record"):
        render_frame(walk, walk.end[0] + 0.1)


@needs_gl
def test_no_half_of_a_video_is_left(walk: Walk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "walk.mp4"
    path.write_bytes(b"an older one")
    with pytest.raises(RenderError, match=r"cannot write .*No such file"):
        render_video(walk, tmp_path / "missing" / "walk.mp4", width=96, height=64)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: "/bin/false")
    with pytest.raises(RenderError, match="encoder failed"):
        render_video(walk, path, width=96, height=64)
    assert path.read_bytes() == b"an older one"
    assert sorted(tmp_path.iterdir()) == [path]


SCRIPT = """
from mjbiped.rendering.gl import ensure_gl, gl_available
assert gl_available() is None
ensure_gl()
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other platforms")
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"MUJOCO_GL": "nonsense"}, "valid are egl, glfw, osmesa"),
        (
            {"MUJOCO_GL": "egl", "__EGL_VENDOR_LIBRARY_FILENAMES": "/", "DISPLAY": "", "WAYLAND_DISPLAY": ""},
            "libegl1 and libgl1-mesa-dri",
        ),
    ],
)
def test_a_missing_platform_is_told_in_words(changes: dict[str, str], words: str) -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], env={**os.environ, **changes}, capture_output=True, text=True)
    assert words in done.stderr
    assert "RenderError" in done.stderr
    assert "records and figures need no OpenGL" in done.stderr
