"""Frames of a video drawn by several processes in turn, each of which has a core to itself.

MuJoCo's renderer holds Python's lock and a software OpenGL gains little from threads, so that one process draws hardly
faster on two cores than on one. This process draws alone until the others have built the scene.
"""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mjbiped.errors import RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rendering.look import Look
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.stage import Stage
from mjbiped.utils.parallel import cores

_WORTH_A_PROCESS = 200
"""Frames: those that are drawn in the time that a process takes to begin, three times over."""

_MOST = 4  # processes; then the encoder is slower than they are
_PIPE = 1 << 20  # bytes on the way, where the system can be asked for so many
_READY = {False: b"n", True: b"y"}  # what a process says that has built the scene, by whether a reference is drawn
_AHEAD = 2  # frames of a process that wait for their turn
_LAST_WORDS = 300  # characters of a complaint


class Film(NamedTuple):
    """What is drawn of a record.

    Attributes:
        width: Pixels.
        height: Pixels.
        camera: Its name.
        look: What is shown.
        start: Time of the record at the first frame, s.
        stop: Time of the record at the end, s.
        slow_motion: Seconds of video per second of the walk.
        fps: Frames per second of the video.
        frames: Their number.
    """

    width: int
    height: int
    camera: str
    look: Look
    start: float
    stop: float
    slow_motion: float
    fps: int
    frames: int

    def time(self, number: int) -> float:
        """Time of the record that a frame shows, s."""
        return self.start + number / (self.slow_motion * self.fps)

    @contextmanager
    def stage(self, walk: Walk) -> Iterator[Stage]:
        """The scene and canvas of it, of a record with samples.

        Raises:
            InputError: There is no such camera.
            RenderError: No OpenGL platform works.
        """
        with Stage.open(
            walk,
            self.width,
            self.height,
            self.camera,
            self.look,
            part=(self.start, self.stop),
            slow_motion=self.slow_motion,
        ) as stage:
            yield stage


def processes_for(frames: int) -> int:
    """Number of processes that draw so many frames, this one included."""
    return max(1, min(cores(), _MOST, frames // _WORTH_A_PROCESS))


@contextmanager
def drawn(walk: Walk, film: Film, processes: int) -> Iterator[tuple[Stage, Iterator[Pixels]]]:
    """The stage of this process, and the frames of a film, in their order and the same for any number of processes.

    Args:
        walk: A record with samples.
        film: What is drawn of it.
        processes: Number of them, this one included.

    Raises:
        InputError: There is no such camera.
        RenderError: No OpenGL platform works; or, where its frame is asked for, another process has ended too early.
    """
    with ExitStack() as stack:
        others: list[_Painter] = []
        if processes > 1:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="mjbiped-")))
            walk.save(folder / "walk.npz")
            (folder / "film").write_bytes(pickle.dumps(film))
            for number in range(1, processes):
                others.append(_Painter(folder, film, number))
                stack.callback(others[-1].end)
        stage = stack.enter_context(film.stage(walk))
        yield stage, _frames(film, stage, others)


def _frames(film: Film, stage: Stage, others: list[_Painter]) -> Iterator[Pixels]:
    drawing: list[Callable[[int], Pixels]] = [lambda number: stage.frame(film.time(number))]
    first = 0
    for number in range(film.frames):
        if others and all(other.answered.is_set() for other in others):
            # one that could not begin, or does not find the reference that is drawn here, leaves all to this process
            if all(other.answer == _READY[stage.tracks] for other in others):
                for turn, other in enumerate(others, start=1):
                    other.begin(number + turn, len(others) + 1)
                first, drawing = number, [drawing[0], *(other.receive for other in others)]
            others = []
        yield drawing[(number - first) % len(drawing)](number)


class _Painter:
    """Another process that draws some of the frames."""

    def __init__(self, folder: Path, film: Film, number: int) -> None:
        """Start it.

        Args:
            folder: Where record and film are, and where it can complain.
            film: What is drawn.
            number: Its own.
        """
        self._shape = (film.height, film.width, 3)
        self._complaints = folder / f"complaints_{number}"
        paths = [str(Path(path).absolute()) for path in sys.path]  # a controller's file is found as it is here
        with self._complaints.open("wb") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-c", f"from {__name__} import main; main()", str(folder)],
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "MUJOCO_GL": ensure_gl()},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                pipesize=_PIPE,
                start_new_session=True,  # Ctrl-C is for the process that the user has started
            )
        self.answer, self.answered = b"", threading.Event()  # which is set when it has built the scene, or failed
        self._frames: queue.Queue[Pixels | None] = queue.Queue(_AHEAD)
        self._reader = threading.Thread(target=self._read, name="frames of a process", daemon=True)
        self._reader.start()

    def _read(self) -> None:
        """Take its frames, so that it need not wait with them; None after the last."""
        stream = self._process.stdout
        assert stream is not None
        self.answer = stream.read(1)
        self.answered.set()
        while self.answer:
            frame = np.empty(self._shape, dtype=np.uint8)
            if stream.readinto(frame.reshape(-1).data) < frame.size:  # type: ignore[attr-defined]  # a buffered reader's
                break
            self._frames.put(frame)
        self._frames.put(None)

    def begin(self, number: int, turns: int) -> None:
        """Have it draw a frame and, from then on, each that follows after so many turns."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{number} {turns}\n".encode())
        self._process.stdin.flush()

    def receive(self, number: int) -> Pixels:
        """Its next frame.

        Raises:
            RenderError: It has ended.
        """
        frame = self._frames.get()
        if frame is None:
            said = self._complaints.read_text(errors="replace").strip()[-_LAST_WORDS:]
            status = self._process.wait()
            raise RenderError(f"a process that drew frame {number} ended with status {status}: {said or 'no word'}")
        return frame

    def end(self) -> None:
        """End it, whatever it is doing."""
        self._process.kill()
        self._process.wait()
        while self._reader.is_alive():
            with suppress(queue.Empty):
                self._frames.get(timeout=0.01)
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            stream.close()


def main() -> None:
    """Draw frames of the film in the folder that the command line names, as `_Painter` asks for them."""
    folder = Path(sys.argv[1])
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is no part of a frame
    film: Film = pickle.loads((folder / "film").read_bytes())
    walk = Walk.load(folder / "walk.npz")
    with film.stage(walk) as stage:
        output.write(_READY[stage.tracks])
        words = sys.stdin.readline().split()
        if not words:
            return
        first, turns = map(int, words)
        for number in range(first, film.frames, turns):
            view = stage.frame(film.time(number)).reshape(-1).data
            while len(view):
                view = view[output.write(view) :]
