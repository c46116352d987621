"""Video files by FFmpeg: H.264 in .mp4, and .gif of one palette for all frames."""

from __future__ import annotations

import queue
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from PIL import Image

from mjbiped.errors import RenderError
from mjbiped.rendering.overlay import Pixels

_QUALITY = 20  # H.264's constant rate factor
_H264 = ("-an", "-vcodec", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-crf", str(_QUALITY))
_FAST = ("-sws_flags", "fast_bilinear", "-preset", "superfast", "-x264-params", "mbtree=1:rc-lookahead=10")
"""Of these pictures a file as small as that of the preset "veryfast", in two thirds of its time."""
_PIPE = 1 << 20  # bytes on the way, where the system can be asked for so many: fewer turns from process to process
_WAITING = 4  # frames that are drawn and not yet taken by the encoder, at most
_COLOURS = 256
_LAST_WORDS = 300  # characters of an encoder's complaint


@contextmanager
def encoder(
    path: Path, width: int, height: int, fps: int, typical: Callable[[], Iterable[Pixels]]
) -> Iterator[Callable[[Pixels], None]]:
    """A function that adds a frame to a video; the file is complete when the block ends.

    Args:
        path: File to write, whose suffix says its kind.
        width: Pixels.
        height: Pixels.
        fps: Frames per second.
        typical: Gives frames that have the colours of all, for a palette.

    Raises:
        RenderError: There is no encoder, or it fails.
    """
    import imageio_ffmpeg

    with tempfile.TemporaryDirectory(prefix="mjbiped-") as folder:
        if path.suffix.lower() == ".gif":
            palette = Path(folder) / "palette.png"
            _write_palette(palette, typical())
            kind = ["-i", str(palette), "-lavfi", "paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
        else:
            kind = [*_H264, *_FAST]
        complaints = Path(folder) / "complaints"
        with complaints.open("wb") as errors:
            try:
                program = imageio_ffmpeg.get_ffmpeg_exe()
                raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps)]
                process = subprocess.Popen(
                    [program, "-v", "error", *raw, "-i", "-", *kind, "-y", str(path)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                    pipesize=_PIPE,
                )
            except (RuntimeError, OSError) as error:
                raise RenderError(f"the video encoder failed: {error}") from error
        sent = False
        try:
            with suppress(BrokenPipeError), _sender(process) as send:  # its status tells more
                yield send
                sent = True
            status = process.wait()
        except BaseException:
            process.kill()
            process.wait()
            raise
        if status or not sent:
            said = complaints.read_text(errors="replace").strip()[-_LAST_WORDS:] or f"it ended with status {status}"
            raise RenderError(f"the video encoder failed: {said}")


@contextmanager
def _sender(process: subprocess.Popen[bytes]) -> Iterator[Callable[[Pixels], None]]:
    """A function that sends a frame to a process; a thread waits for the process to take it.

    The frame is not to be changed any more. Once the process has ended, the function raises BrokenPipeError.
    """
    stream = process.stdin
    assert stream is not None
    waiting: queue.Queue[Pixels | None] = queue.Queue(_WAITING)

    broken = threading.Event()

    def hand_over() -> None:
        while (frame := waiting.get()) is not None:
            try:
                if not broken.is_set():
                    stream.write(frame.data)
            except OSError:
                broken.set()
        with suppress(OSError):
            stream.close()

    def send(frame: Pixels) -> None:
        if broken.is_set():
            raise BrokenPipeError
        waiting.put(frame)

    thread = threading.Thread(target=hand_over, name="frames to the encoder")
    thread.start()
    try:
        yield send
    except BaseException:
        process.kill()  # so that nothing is waited for
        raise
    finally:
        waiting.put(None)
        thread.join()


def _write_palette(path: Path, frames: Iterable[Pixels]) -> None:
    """Write the palette of some frames as FFmpeg takes it, a picture of 16 × 16 pixels."""
    image = Image.fromarray(np.concatenate([frame[::2, ::2] for frame in frames]))
    small = image.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, kmeans=2, dither=Image.Dither.NONE)
    colours = small.getpalette() or []
    entries = np.zeros((_COLOURS, 3), dtype=np.uint8)
    entries.ravel()[: len(colours)] = colours[: entries.size]
    Image.fromarray(entries.reshape(16, 16, 3)).save(path)
