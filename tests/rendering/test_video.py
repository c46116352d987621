"""Videos show the recorded walk, frame by frame, and fail with words where nothing can be drawn."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from mjbiped.errors import InputError, RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import gl_available
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.video import encoder, render_frame, render_video

needs_gl = pytest.mark.skipif(gl_available() is None, reason="no OpenGL platform")


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
    for number, frame in enumerate(frames[:-5:4]):
        time = 0.5 + 4 * number / 7.5
        assert np.abs(frame.astype(int) - render_frame(walk, time, **size)).mean() < 4.0  # H.264's losses
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
        ({"width": 97}, "even"),
        ({"fps": 121}, "fps"),
        ({"slow_motion": float("nan")}, "slow_motion"),
        ({"camera": "drone"}, "track, side, overview"),
        ({"hide": "ghosts"}, "did you mean 'ghost'"),
        ({"start": -0.1}, r"start = -0.1: must be from 0 to .* s of the record"),
        ({"start": 2.0, "stop": 1.0}, "swap them"),
        ({"path": "walk.avi"}, r"\.mp4 or \.gif"),
        ({"path": "walk.gif", "fps": 60}, "at most 50"),
    ],
)
def test_refused_arguments(walk: Walk, tmp_path: Path, arguments: dict[str, Any], words: str) -> None:
    settings = {"width": 96, "height": 64, "path": "walk.mp4", **arguments}
    with pytest.raises(InputError, match=words):
        render_video(walk, tmp_path / settings.pop("path"), **settings)
    assert not list(tmp_path.iterdir())


def test_refused_times_and_records(walk: Walk) -> None:
    for time in (-0.1, walk.end[0] + 0.1, float("nan")):
        with pytest.raises(InputError, match="of the record"):
            render_frame(walk, time)
    empty = dataclasses.replace(walk, samples={name: array[:0] for name, array in walk.samples.items()})
    with pytest.raises(RenderError):
        render_frame(empty, 0.0)


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


def frames(count: int) -> list[Pixels]:
    """A red band that rises on blue."""
    found = np.full((count, 64, 96, 3), (20, 40, 200), dtype=np.uint8)
    for number, frame in enumerate(found):
        frame[4 * number % 60 : 4 * number % 60 + 8] = (220, 30, 30)
    return list(found)


def test_a_gif_keeps_colours_and_order(tmp_path: Path) -> None:
    path, shown = tmp_path / "a.gif", frames(10)
    with encoder(path, 96, 64, 25, shown) as add:
        for frame in shown:
            add(frame)
    with Image.open(path) as picture:
        for number, frame in enumerate(shown):
            picture.seek(number)
            # few colours: each has its own place in the palette
            assert np.abs(np.asarray(picture.convert("RGB")).astype(int) - frame).max() <= 3
        assert picture.n_frames == len(shown)  # type: ignore[attr-defined]  # those of the palette are not among them


SCRIPT = """
import mjbiped
from mjbiped.errors import RenderError
from mjbiped.rendering.gl import ensure_gl, gl_available
assert mjbiped.find_passive_gait(mjbiped.Compass(), 0.03).stable  # which needs no OpenGL
assert gl_available() is None
try:
    ensure_gl()
except RenderError as error:
    print(error)
"""
WITHOUT_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent", "DISPLAY": "", "WAYLAND_DISPLAY": ""}


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
def test_a_missing_platform_is_told_in_words_and_hinders_no_walk(changes: dict[str, str], words: str) -> None:
    command = [sys.executable, "-W", "error", "-c", SCRIPT]
    done = subprocess.run(command, env={**os.environ, **changes}, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert words in done.stdout
    assert "records and figures need no OpenGL" in done.stdout
