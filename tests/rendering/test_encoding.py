"""Frames become files; a failing encoder is told in words, and hangs nobody."""

import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from mjbiped.errors import RenderError
from mjbiped.rendering.encoding import encoder
from mjbiped.rendering.overlay import Pixels


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
    with encoder(path, 96, 64, 25, lambda: shown) as add:
        for frame in shown:
            add(frame)
    with Image.open(path) as picture:
        for number, frame in enumerate(shown):
            picture.seek(number)
            # few colours: each has its own place in the palette
            assert np.abs(np.asarray(picture.convert("RGB")).astype(int) - frame).max() <= 3
            assert picture.info["duration"] == 40


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
    with encoder(path, 96, 64, 25, list) as add:
        for frame in frames(12) * 1000:
            add(frame)
            sent.append(1)


def test_an_encoder_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(tmp_path / "missing"))
    with pytest.raises(RenderError, match="the video encoder failed"), encoder(tmp_path / "a.mp4", 96, 64, 25, list):
        raise AssertionError("nothing is drawn")
