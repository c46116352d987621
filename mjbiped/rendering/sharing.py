"""Frames of a video drawn by several processes in turn, each with a core to itself.

MuJoCo's renderer holds Python's lock and a software OpenGL gains little from threads, so that one process draws hardly
faster on two cores than on one.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from mjbiped.errors import RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.stage import Film, Stage
from mjbiped.utils.parallel import cores

_WORTH_A_PROCESS = 200
"""Frames that are drawn in three times the time that a process takes to begin."""

_MOST = 4  # processes; more than these are faster than the encoder
_READY = {False: b"n", True: b"y"}  # a process's answer once it has built the scene, by whether a reference is drawn
_LAST_WORDS = 300  # characters of a complaint


def processes_for(frames: int) -> int:
    """Number of processes that draw a film, including this one."""
    return max(1, min(cores(), _MOST, frames // _WORTH_A_PROCESS))


@contextmanager
def drawn(walk: Walk, film: Film, processes: int) -> Iterator[tuple[Stage, Iterator[Pixels]]]:
    """Open the stage of this process, and draw the frames of a film; they do not depend on the number of processes.

    Args:
        walk: A record with samples.
        film: What is drawn of it.
        processes: Number of processes, including this one.

    Raises:
        InputError: There is no such camera.
        RenderError: No OpenGL platform works; or, when its frame is asked for, another process has ended too early.
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
        stage = stack.enter_context(Stage.open(walk, film))
        # one that could not begin, or does not find the reference that is drawn here, leaves all to this process
        if not all(other.answer() == _READY[stage.tracks] for other in others):
            others = []
        for turn, other in enumerate(others, start=1):
            other.begin(turn, len(others) + 1)
        draw: list[Callable[[int], Pixels]] = [lambda number: stage.frame(film.time(number))]
        draw += [other.receive for other in others]
        yield stage, (draw[number % len(draw)](number) for number in range(film.frames))


class _Painter:
    """Another process that draws some of the frames."""

    def __init__(self, folder: Path, film: Film, number: int) -> None:
        """Start the process.

        Args:
            folder: Folder with the record and the film, where the process writes its errors.
            film: What is drawn.
            number: Number of the process.
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
                start_new_session=True,  # Ctrl-C is for the process that the user has started
            )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._orders, self._frames = self._process.stdin, self._process.stdout

    def answer(self) -> bytes:
        """Wait until the process has built the scene, or failed; see `_READY`."""
        return self._frames.read(1)

    def begin(self, number: int, turns: int) -> None:
        """Have the process draw a frame and each `turns`-th one after it."""
        self._orders.write(f"{number} {turns}\n".encode())
        self._orders.flush()

    def receive(self, number: int) -> Pixels:
        """Return the next frame of the process, which has a number.

        Raises:
            RenderError: The process has ended.
        """
        pixels = self._frames.read(int(np.prod(self._shape)))
        if len(pixels) < np.prod(self._shape):
            status = self._process.wait()
            said = self._complaints.read_text(errors="replace").strip()[-_LAST_WORDS:]
            raise RenderError(f"a process that drew frame {number} ended with status {status}: {said or 'no word'}")
        return np.frombuffer(pixels, dtype=np.uint8).reshape(self._shape)

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._process.kill()
        self._process.wait()
        self._orders.close()
        self._frames.close()


def main() -> None:
    """Draw frames of the film in the folder that the command line names, as `_Painter` asks for them."""
    folder = Path(sys.argv[1])
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is not part of a frame
    film: Film = pickle.loads((folder / "film").read_bytes())
    walk = Walk.load(folder / "walk.npz")
    with Stage.open(walk, film) as stage:
        output.write(_READY[stage.tracks])
        words = sys.stdin.readline().split()
        if not words:
            return
        first, turns = map(int, words)
        for number in range(first, film.frames, turns):
            view = stage.frame(film.time(number)).reshape(-1).data
            while len(view):
                view = view[output.write(view) :]
