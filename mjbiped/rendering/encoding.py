"""Video files by mediapy: .mp4 in H.264, and .gif with one palette for all frames."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from mjbiped.errors import RenderError
from mjbiped.rendering.overlay import Pixels

_QUALITY = 20  # H.264's constant rate factor
_FAST = "-movflags +faststart -sws_flags fast_bilinear -preset superfast -x264-params mbtree=1:rc-lookahead=10"
"""Files of these pictures are as small as with the preset "veryfast", in two thirds of the time."""
_PALETTE = (
    "split[first][all];[first]trim=end_frame={0},palettegen=reserve_transparent=0[palette];"
    "[all]trim=start_frame={0},setpts=PTS-STARTPTS[shown];[shown][palette]paletteuse=dither=none:diff_mode=rectangle"
)
"""Filter that makes a palette from the first frames and drops them; mediapy's own keeps all frames in memory."""
_LAST_WORDS = 300  # characters of an encoder's complaint


@contextmanager
def encoder(
    path: Path, width: int, height: int, fps: int, typical: Sequence[Pixels] = ()
) -> Iterator[Callable[[Pixels], None]]:
    """Open a video for a block, which gets a function that adds a frame.

    Args:
        path: File to write, `.mp4` or `.gif`.
        width: Width, pixels.
        height: Height, pixels.
        fps: Frames per second.
        typical: Frames with the colours of all frames, for the palette of a `.gif`.

    Raises:
        RenderError: There is no encoder, or it fails.
    """
    kind: dict[str, Any] = {"crf": _QUALITY, "ffmpeg_args": _FAST}
    if path.suffix == ".gif":
        kind = {"codec": "gif", "ffmpeg_args": ["-vf", _PALETTE.format(len(typical))]}
    try:
        writer = _mediapy().VideoWriter(path, (height, width), fps=fps, **kind)
        process: subprocess.Popen[bytes] = writer.__enter__()._popen
    except (RuntimeError, OSError) as error:
        raise RenderError(f"the video encoder failed: {error}") from error

    def add(frame: Pixels) -> None:
        with _told(process):
            process.stdin.write(frame.data)  # type: ignore[union-attr]  # as `writer.add_image` does, without its copy

    try:
        for frame in typical:
            add(frame)
        yield add
        with _told(process):
            writer.close()
    finally:  # mediapy leaves a process that failed, or is not needed any more, as it is
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stderr):
            with suppress(OSError):
                pipe.close()  # type: ignore[union-attr]  # there are both


def show(frames: Iterable[Pixels], fps: int) -> None:
    """Show a video in a notebook.

    Raises:
        RenderError: There is no encoder, or it fails.
    """
    try:
        _mediapy().show_video(frames, fps=fps)
    except (RuntimeError, OSError) as error:
        raise RenderError(f"the video encoder failed: {error}") from error


def _mediapy() -> Any:
    """Import mediapy and tell it where FFmpeg is; imported when needed, because this takes long.

    Raises:
        RuntimeError: There is no FFmpeg.
    """
    import imageio_ffmpeg
    import mediapy

    mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
    return mediapy


@contextmanager
def _told(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Turn a failure of the encoder's process in a block into an error with its own words.

    Raises:
        RenderError: It has.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        unread = process.stderr.read().decode(errors="replace")  # type: ignore[union-attr]  # a pipe
        said = (unread or str(error).partition("': ")[2]).strip()[-_LAST_WORDS:]
        said = said or f"it ended with status {process.wait()}"
        raise RenderError(f"the video encoder failed: {said}") from error
