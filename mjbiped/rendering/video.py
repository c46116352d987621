"""Videos and stills of recorded walks; nothing is stepped here, and nothing else draws with OpenGL.

The scene is built anew from the record, the recorded postures are interpolated to the frames' times, and MuJoCo draws
them. See `mjbiped.rendering.gl` for the OpenGL platform.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows
from mjbiped.errors import InputError, RenderError, shown
from mjbiped.records.record import Walk
from mjbiped.rendering.camera import smooth_offsets
from mjbiped.rendering.gl import ensure_gl, gl_available
from mjbiped.rendering.overlay import Pixels, draw_caption
from mjbiped.utils import domains
from mjbiped.utils.files import saved

__all__ = ["ensure_gl", "gl_available", "render_frame", "render_frames", "render_video"]

LAST_FRAME_HELD = 1.0
"""How long a video shows its last frame, with the walk's outcome, s."""

_SIGHT = 4.0  # ground built beyond what the record or a frame needs, m
_QUALITY = 20  # H.264's constant rate factor
_ONE_AT_A_TIME = threading.Lock()


def render_video(
    walk: Walk,
    path: str | Path,
    *,
    width: int = 640,
    height: int = 480,
    fps: int = 30,
    camera: str = "track",
    slow_motion: float = 1.0,
    caption: bool = True,
    shadows: bool = True,
    progress: bool = False,
) -> None:
    """Render a walk's record as an MP4 video (H.264); the file appears whole or not at all.

    Every frame shows the record's posture at its time; the last one is held for a second, with the outcome.

    Args:
        walk: The record.
        path: File to write; its name must end in `.mp4`.
        width: Pixels, even, 64 to 4096.
        height: Pixels, even, 64 to 4096.
        fps: Frames per second of the video, 1 to 120.
        camera: Name of a camera of the scene: "track", "side" or "overview".
        slow_motion: How many seconds of video show a second of the walk, 0.01 to 100; below 1 time passes faster.
        caption: Write time, step, slope, its estimate and slow motion on the frames.
        shadows: Draw shadows; without them a software renderer is about three times as fast.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: An argument is outside its domain; nothing has been drawn then.
        RenderError: No OpenGL platform or no encoder works, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".mp4":
        raise InputError(f"a video is an .mp4 file; cannot render to {shown(path.name)}")
    _check_size(width, height)
    if width % 2 or height % 2:
        raise InputError(f"H.264 needs an even width and height in pixels, got {width} x {height}")
    fps = domains.FPS.check("fps", fps)
    slow_motion = domains.SLOW_MOTION.check("slow_motion", slow_motion)
    begin, end = _span(walk)
    frames = math.floor((end - begin) * slow_motion * fps + 1e-9) + 1
    with (
        _Stage.open(walk, width, height, camera, shadows) as stage,
        saved(path, RenderError) as unfinished,
        _encoder(unfinished, width, height, fps) as add,
    ):
        for number in tqdm(range(frames), desc="video", unit="frame", disable=None if progress else True):
            add(stage.frame(begin + number / (slow_motion * fps), caption, slow_motion))
        last = stage.frame(end, caption, slow_motion, with_outcome=True)
        for _ in range(round(LAST_FRAME_HELD * fps)):
            add(last)


def render_frame(
    walk: Walk,
    time: float,
    *,
    width: int = 640,
    height: int = 480,
    camera: str = "track",
    caption: bool = False,
    shadows: bool = True,
) -> Pixels:
    """Render one moment of a walk's record.

    Args:
        walk: The record.
        time: Within the record, s.
        width: Pixels, 64 to 4096.
        height: Pixels, 64 to 4096.
        camera: Name of a camera of the scene: "track", "side" or "overview".
        caption: Write time, step, slope and its estimate on the frame.
        shadows: Draw shadows.

    Returns:
        RGB, shape (height, width, 3).

    Raises:
        InputError: An argument is outside its domain; nothing has been drawn then.
        RenderError: No OpenGL platform works.
    """
    [frame] = render_frames(walk, [time], width=width, height=height, camera=camera, caption=caption, shadows=shadows)
    return frame


def render_frames(
    walk: Walk,
    times: Iterable[float],
    *,
    width: int = 640,
    height: int = 480,
    camera: str = "track",
    caption: bool = False,
    shadows: bool = True,
) -> list[Pixels]:
    """Render some moments of a walk's record, the scene being built once.

    Args:
        walk: The record.
        times: Within the record, s.
        width: Pixels, 64 to 4096.
        height: Pixels, 64 to 4096.
        camera: Name of a camera of the scene: "track", "side" or "overview".
        caption: Write time, step, slope and its estimate on the frames.
        shadows: Draw shadows.

    Returns:
        RGB of each moment, shape (height, width, 3).

    Raises:
        InputError: An argument is outside its domain; nothing has been drawn then.
        RenderError: No OpenGL platform works.
    """
    _check_size(width, height)
    begin, end = _span(walk)
    moments = domains.Domain(begin, end, "s of the record").array("times", [*times], (None,)).tolist()
    with _Stage.open(walk, width, height, camera, shadows) as stage:
        return [stage.frame(time, caption) for time in moments]


def _check_size(width: int, height: int) -> None:
    """Refuse sizes that no frame can have.

    Raises:
        InputError: A size is not a whole number of pixels from 64 to 4096.
    """
    for name, size in (("width", width), ("height", height)):
        domains.PIXELS.check(name, size)


def _span(walk: Walk) -> tuple[float, float]:
    """First and last time of a record, s.

    Raises:
        RenderError: It holds no samples.
    """
    time = walk.samples["time"]
    if not len(time):
        raise RenderError("the record holds no samples: there is nothing to show")
    return float(time[0]), float(time[-1])


class _Stage:
    """A scene with a renderer, on which the postures of a walk are drawn; on a long terrain, one about each place."""

    def __init__(self, walk: Walk, width: int, height: int, camera: str, shadows: bool, open_now: ExitStack) -> None:
        self._walk = walk
        self._size = height, width
        self._name = camera
        self._shadows = shadows
        self._open = open_now
        self._smooth = smooth_offsets(walk)
        self._windows = GroundWindows(
            walk.robot,
            walk.terrain,
            timestep=1e-4,  # any: nothing is stepped
            reach=float(np.max(walk.samples["qpos"][:, 0])) + _SIGHT,
            ground=walk.settings.get("ground", "auto"),
            scenery=True,
            margin=max(_SIGHT, MARGIN * walk.robot.leg_length),
        )
        self._go_to(float(walk.samples["qpos"][0, 0]))

    @classmethod
    @contextmanager
    def open(cls, walk: Walk, width: int, height: int, camera: str, shadows: bool) -> Iterator[_Stage]:
        """Build the scene and a renderer for it; one at a time per process.

        Raises:
            InputError: There is no such camera.
            RenderError: No OpenGL platform works.
        """
        with _ONE_AT_A_TIME, ExitStack() as stack:
            yield cls(walk, width, height, camera, shadows, stack)

    def _go_to(self, x: float) -> None:
        """Build the scene about a place, m, in place of the one before."""
        import mujoco

        scene = self._windows.about(x)
        model, (height, width) = scene.model, self._size
        names = [model.camera(index).name for index in range(model.ncam)]
        if self._name not in names:
            raise InputError(f"unknown camera {shown(self._name)}; valid are {', '.join(names)}")
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        platform = ensure_gl()
        self._open.close()
        try:
            renderer = mujoco.Renderer(model, height, width, max_geom=model.ngeom + 100)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            raise RenderError(f"OpenGL platform {platform} cannot draw {width} x {height} pixels: {error}") from error
        self._renderer = self._open.enter_context(renderer)
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = self._shadows
        self._model, self._data, self._inside = model, mujoco.MjData(model), self._windows.inside(scene)
        tracking = mujoco.mjtCamLight.mjCAMLIGHT_TRACK, mujoco.mjtCamLight.mjCAMLIGHT_TRACKCOM
        self._camera = names.index(self._name)
        self._tracked = mujoco.mjtCamLight(int(model.cam_mode[self._camera])) in tracking

    def frame(self, time: float, caption: bool, slow_motion: float = 1.0, *, with_outcome: bool = False) -> Pixels:
        """The posture at a time (s) of the record, RGB."""
        import mujoco

        samples = self._walk.samples
        qpos = [float(np.interp(time, samples["time"], column)) for column in samples["qpos"].T]
        low, high = self._inside
        if math.isfinite(qpos[0]) and not low < qpos[0] < high:
            self._go_to(qpos[0])
        data = self._data
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)
        mujoco.mj_camlight(self._model, data)
        if self._tracked:
            for axis, offsets in zip((0, 2), self._smooth.T, strict=True):
                data.cam_xpos[self._camera, axis] += np.interp(time, samples["time"], offsets)
        self._renderer.update_scene(data, self._camera)
        pixels: Pixels = self._renderer.render()
        if not caption:
            return pixels
        outcome = self._walk.outcome if with_outcome else ""
        return draw_caption(pixels, _caption(self._walk, time, slow_motion), outcome)


def _caption(walk: Walk, time: float, slow_motion: float) -> list[str]:
    """What a caption says of a moment (s)."""
    samples = walk.samples
    latest = max(0, int(np.searchsorted(samples["time"], time + 1e-9, side="right")) - 1)
    steps = int(np.searchsorted(walk.touchdowns["time"], time + 1e-9, side="right"))
    slope, estimate = (math.degrees(samples[name][latest]) for name in ("slope", "slope_estimate"))
    lines = [f"t = {time:.2f} s   step {steps}", f"slope {_degrees(slope)}"]
    if not math.isnan(estimate):
        lines[1] += f"   estimate {_degrees(estimate)}"
    if slow_motion > 1.0:
        lines.append(f"slow motion {slow_motion:g}×")
    elif slow_motion < 1.0:
        lines.append(f"time lapse {1.0 / slow_motion:.3g}×")
    return lines


def _degrees(angle: float) -> str:
    """An angle with its sign, but no zero below zero."""
    return f"{round(angle, 1) + 0.0:+.1f}°".replace("-", "−")


@contextmanager
def _encoder(path: Path, width: int, height: int, fps: int) -> Iterator[Any]:
    """A function that adds a frame to the video; the file is complete when the block ends.

    Raises:
        RenderError: There is no encoder, or it fails.
    """
    import imageio_ffmpeg
    import mediapy

    writer = None
    try:
        mediapy.set_ffmpeg(imageio_ffmpeg.get_ffmpeg_exe())
        writer = mediapy.VideoWriter(
            path, (height, width), fps=fps, crf=_QUALITY, ffmpeg_args=["-movflags", "+faststart"]
        )
        with writer:
            yield writer.add_image
    except (RuntimeError, OSError) as error:
        if isinstance(error.__context__, KeyboardInterrupt):
            raise error.__context__ from None  # Ctrl-C reaches the encoder, too
        raise RenderError(f"the video encoder failed: {error}") from error
    finally:
        encoder = writer and writer._popen
        for pipe in (encoder.stdin, encoder.stderr) if encoder else ():  # mediapy leaves them open where it fails
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
