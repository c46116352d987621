"""Frames become files; a failing encoder is told in words, and hangs nobody."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from mjbiped.errors import RenderError
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.video import encoder


def frames(count: int) -> list[Pixels]:
    """A red band that rises on blue."""
    found = []
    for number in range(count):
        frame = np.full((64, 96, 3), (20, 40, 200), dtype=np.uint8)
        frame[4 * number : 4 * number + 8] = (220, 30, 30)
        found.append(frame)
    return found


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
            assert picture.info["duration"] == 40
        assert picture.n_frames == len(shown)  # type: ignore[attr-defined]  # those of the palette are not among them


@pytest.mark.parametrize(
    "script",
    [
        "import sys; sys.stdin.buffer.read(9)",
        "raise SystemExit('no such codec')",
        "import sys; sys.stdin.buffer.read(9); raise SystemExit(3)",
    ],
)
def test_a_failing_encoder_is_told_in_words(script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text(f"#!{sys.executable}\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(program))
    told = r"the video encoder failed: (no such codec|it ended with status [03])"
    sent: list[int] = []
    with pytest.raises(RenderError, match=told):
        send(tmp_path / "a.mp4", sent)
    assert len(sent) < 1000  # nobody draws the rest of a video that is lost


def send(path: Path, sent: list[int]) -> None:
    with encoder(path, 96, 64, 25) as add:
        for frame in frames(12) * 1000:
            add(frame)
            sent.append(1)


def test_an_encoder_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(tmp_path / "missing"))
    with pytest.raises(RenderError, match="the video encoder failed"), encoder(tmp_path / "a.mp4", 96, 64, 25):
        raise AssertionError("nothing is drawn")


class Interrupted(BaseException):
    """As KeyboardInterrupt, which ends pytest."""


def interrupted(path: Path, sent: list[Pixels]) -> None:
    with encoder(path, 96, 64, 25, frames(3)) as add:
        for frame in sent:
            add(frame)
        raise Interrupted


@pytest.mark.parametrize("suffix", ["mp4", "gif"])
@pytest.mark.parametrize("sent", [0, 5])
def test_an_interrupted_video_leaves_no_process(
    suffix: str, sent: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[subprocess.Popen[bytes]] = []

    class Kept(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *arguments: Any, **settings: Any) -> None:
            super().__init__(*arguments, **settings)
            started.append(self)

    imageio_ffmpeg.get_ffmpeg_exe()  # which runs FFmpeg when it is first asked
    monkeypatch.setattr(subprocess, "Popen", Kept)
    with pytest.raises(Interrupted):
        interrupted(tmp_path / f"a.{suffix}", frames(sent))
    [process] = started
    assert process.returncode is not None  # waited for
    assert all(pipe.closed for pipe in (process.stdin, process.stderr) if pipe)


def test_an_error_of_who_draws_is_not_the_encoders(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="of the disk"), encoder(tmp_path / "a.mp4", 96, 64, 25):
        raise OSError("of the disk")
