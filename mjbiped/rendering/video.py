"""Videos and stills of recorded walks; nothing is simulated here.

The scene is built from the record, the recorded postures are interpolated to the times of the frames, and MuJoCo draws
them together with the elements of `mjbiped.rendering.ELEMENTS`. OpenGL is chosen in `mjbiped.rendering.gl`.
"""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError, RenderError, shown
from mjbiped.records.record import Walk
from mjbiped.rendering import SUFFIXES, look
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.space import open_stage
from mjbiped.rendering.stage import Film
from mjbiped.utils import domains
from mjbiped.utils.files import saved
from mjbiped.utils.parallel import progress_bar

WIDTH, HEIGHT = 1280, 720
"""Default size of a picture, pixels."""

LAST_FRAME_HELD = 1.0
"""Time for which a video shows its last frame, with the walk's outcome, s."""

FASTEST_GIF = 50
"""Greatest frame rate of a .gif, 1/s: the format counts hundredths of a second, and viewers show one as a tenth."""

_TYPICAL = 8  # frames from which a palette is made
_X264 = "mbtree=1:rc-lookahead=10:b-adapt=0:subme=0"
_H264 = ["-vcodec", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-preset", "superfast", "-x264-params", _X264]
_H264 += ["-sws_flags", "fast_bilinear", "-movflags", "+faststart"]
"""Files of these pictures are as small as with the preset "veryfast", in two thirds of the time."""
_PALETTE = (
    "split[first][all];[first]trim=end_frame={0},palettegen=max_colors=96:reserve_transparent=0[palette];"
    "[all]trim=start_frame={0},setpts=PTS-STARTPTS[shown];[shown][palette]paletteuse=dither=none:diff_mode=rectangle"
)
"""Filter that makes the palette of a .gif from its first frames, and drops these."""
_PIPE = 1 << 19  # bytes that wait for the encoder, where the system can choose; with few, frames go in many parts
_LAST_WORDS = 300  # characters of an encoder's complaint


def render_video(
    walk: Walk,
    path: str | Path | None = None,
    *,
    width: int = WIDTH,
    height: int = HEIGHT,
    fps: int = 30,
    camera: str = "track",
    slow_motion: float = 1.0,
    start: float | None = None,
    stop: float | None = None,
    hide: str | Iterable[str] = (),
    flags: str | Iterable[str] = (),
    progress: bool = False,
) -> None:
    """Render a walk's record as a video, to a file that appears whole or not at all, or into a notebook.

    Every frame shows the record's posture at its time; the last one is held for a second, with the outcome where it is
    the walk's end.

    Args:
        walk: The record.
        path: File to write: `.mp4` (H.264) or `.gif`; None shows the video in a notebook.
        width: Width in pixels, 64 to 4096; even but for `.gif`.
        height: Height in pixels, 64 to 4096; even but for `.gif`.
        fps: Frames per second of the video, 1 to 120.
        camera: Camera: "track", "side" or "overview".
        slow_motion: Seconds of video per second of the walk, 0.01 to 100; below 1 time passes faster.
        start: Time of the record at which the video begins, s; its first unless given.
        stop: Time of the record at which the video ends, s; its last unless given.
        hide: Names of `mjbiped.rendering.ELEMENTS` to hide, or "all".
        flags: MuJoCo's visual flags to set, such as "contactpoint", or to clear, such as "no-static".
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: An argument is outside its domain; nothing has been drawn then.
        RenderError: No OpenGL platform or no encoder works, or the file cannot be written.
    """
    path = None if path is None else Path(path)
    if path is not None and path.suffix.lower() not in SUFFIXES:
        raise InputError(f"a video is a file of {' or '.join(SUFFIXES)}; cannot render to {shown(path.name)}")
    gif = path is not None and path.suffix.lower() == ".gif"
    first, last = _checked(walk, width, height)
    if not gif and (width % 2 or height % 2):
        raise InputError(f"H.264 needs an even width and height in pixels, got {width} x {height}")
    fps = domains.FPS.check("fps", fps)
    if gif and fps > FASTEST_GIF:
        raise InputError(f"a .gif shows at most {FASTEST_GIF} frames per second, got fps = {fps}")
    slow_motion = domains.SLOW_MOTION.check("slow_motion", slow_motion)
    inside = domains.Domain(first, last, "s of the record")
    begin = first if start is None else inside.check("start", start)
    end = last if stop is None else inside.check("stop", stop)
    if begin > end:
        raise InputError(f"start = {begin:g} s comes after stop = {end:g} s: swap them")
    frames = math.floor((end - begin) * slow_motion * fps + 1e-9) + 1
    film = Film(width, height, camera, look(hide, flags), begin, end, slow_motion, frames)
    with open_stage(walk, film) as stage:

        def write(file: Path) -> None:
            typical = [stage.frame(time).copy() for time in np.linspace(begin, end, _TYPICAL)] if gif else []
            with encoder(file, width, height, fps, typical) as add:
                for number in progress_bar(range(frames), desc="video", total=frames, unit="frame", progress=progress):
                    add(stage.frame(begin + number / (slow_motion * fps)))
                held = stage.frame(end, with_outcome=end == last)
                for _ in range(round(LAST_FRAME_HELD * fps)):
                    add(held)

        if path is not None:
            with saved(path, RenderError) as unfinished:
                write(unfinished)
            return
        import mediapy  # when needed, because this takes long
        from IPython.display import HTML, display  # a notebook has it

        with TemporaryDirectory() as folder:
            write(file := Path(folder) / "walk.mp4")
            content = file.read_bytes()
        display(HTML(mediapy.html_from_compressed_video(content, width, height)))  # type: ignore[no-untyped-call]


def render_frame(
    walk: Walk,
    time: ArrayLike,
    *,
    width: int = WIDTH,
    height: int = HEIGHT,
    camera: str = "track",
    hide: str | Iterable[str] = (),
    flags: str | Iterable[str] = (),
) -> Pixels:
    """Render one moment of a walk's record, or several in a scene that is built once.

    Args:
        walk: The record.
        time: Time within the record, s; or a sequence of times.
        width: Width in pixels, 64 to 4096.
        height: Height in pixels, 64 to 4096.
        camera: Camera: "track", "side" or "overview".
        hide: Names of `mjbiped.rendering.ELEMENTS` to hide, or "all".
        flags: MuJoCo's visual flags to set, such as "contactpoint", or to clear, such as "no-static".

    Returns:
        RGB, shape (height, width, 3); of a sequence of times shape (times, height, width, 3).

    Raises:
        InputError: An argument is outside its domain.
        RenderError: No OpenGL platform works.
    """
    begin, end = _checked(walk, width, height)
    times = domains.Domain(begin, end, "s of the record").array("time", time, None)
    with open_stage(walk, Film(width, height, camera, look(hide, flags), begin, end)) as stage:
        frames = np.empty((times.size, height, width, 3), dtype=np.uint8)
        for place, each in zip(frames, times.ravel().tolist(), strict=True):
            place[...] = stage.frame(each)
    return frames.reshape(*times.shape, height, width, 3)


def _checked(walk: Walk, width: int, height: int) -> tuple[float, float]:
    """Check the size of a frame, and return the first and the last time of a record, s.

    Raises:
        InputError: A size is not a whole number of pixels from 64 to 4096.
        RenderError: The record holds no samples.
    """
    domains.PIXELS.check("width", width)
    domains.PIXELS.check("height", height)
    time = walk.samples["time"]
    if not len(time):
        raise RenderError("the record holds no samples: there is nothing to show")
    return float(time[0]), float(time[-1])


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
    import imageio_ffmpeg  # when needed, because this takes long

    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps), "-i", "-"]
    output = ["-vf", _PALETTE.format(len(typical))] if path.suffix == ".gif" else _H264
    try:
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y", *given, *output, str(path)]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, pipesize=_PIPE)
    except (RuntimeError, OSError) as error:
        raise RenderError(f"the video encoder failed: {error}") from error

    pipe = process.stdin
    assert pipe is not None  # mypy cannot tell

    def failed() -> RenderError:  # once the encoder has ended
        said = process.communicate()[1].decode(errors="replace").strip()[-_LAST_WORDS:]
        return RenderError(f"the video encoder failed: {said or f'it ended with status {process.returncode}'}")

    def add(frame: Pixels) -> None:
        try:
            pipe.write(frame.data)
        except BrokenPipeError:
            raise failed() from None

    try:
        for frame in typical:
            add(frame)
        yield add
        failure = failed()
        if process.returncode or not path.exists():
            raise failure
    finally:
        process.kill()
        process.communicate()
