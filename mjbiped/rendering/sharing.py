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
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rendering.overlay import Pixels
from mjbiped.rendering.stage import Film, Stage
from mjbiped.utils.parallel import cores

_WORTH_A_PROCESS = 200
"""Frames that are drawn in three times the time that a process takes to begin."""

_MOST = 4  # processes; more than these are faster than the encoder


def processes_for(frames: int) -> int:
    """Number of processes that draw a film, including this one."""
    return max(1, min(cores(), _MOST, frames // _WORTH_A_PROCESS))


@contextmanager
def drawn(walk: Walk, film: Film, processes: int) -> Iterator[tuple[Stage, Iterator[Pixels]]]:
    """Open the stage of this process, and draw the frames of a film; they do not depend on the number of processes.

    Args:
        walk: A record with samples.
        film: What is drawn of it.
        processes: Number of processes, including this one, which also draws what another one fails to draw.

    Raises:
        InputError: There is no such camera.
        RenderError: No OpenGL platform works.
    """
    shape = (film.height, film.width, 3)
    with ExitStack() as stack:
        others: list[subprocess.Popen[bytes]] = []
        if processes > 1:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="mjbiped-")))
            walk.save(folder / "walk.npz")
            (folder / "film").write_bytes(pickle.dumps(film))
            others = [stack.enter_context(_painter(folder, turn, processes)) for turn in range(1, processes)]
        stage = stack.enter_context(Stage.open(walk, film))

        def frame(number: int) -> Pixels:
            turn = number % processes
            sent = _received(others[turn - 1], 1 + int(np.prod(shape))) if turn else b""
            if sent and sent[0] == stage.tracks:  # with the reference that is drawn here, if there is one
                return np.frombuffer(sent, dtype=np.uint8, offset=1).reshape(shape)
            return stage.frame(film.time(number))

        yield stage, map(frame, range(film.frames))


@contextmanager
def _painter(folder: Path, turn: int, turns: int) -> Iterator[subprocess.Popen[bytes]]:
    """Run another process in a block, which draws a frame and each `turns`-th one after it, and sends them in order.

    Args:
        folder: Folder with the record and the film.
        turn: Number of its first frame.
        turns: Number of processes.
    """
    paths = [str(Path(path).absolute()) for path in sys.path]  # a controller's file is found as it is here
    with subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import main; main()", str(folder), str(turn), str(turns)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "MUJOCO_GL": ensure_gl()},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for the process that the user has started
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def _received(process: subprocess.Popen[bytes], size: int) -> bytes:
    """Return the next bytes that a process sends; none if it has ended before."""
    assert process.stdout is not None
    sent = process.stdout.read(size)
    return sent if len(sent) == size else b""


def main() -> None:
    """Draw frames of the film in the folder that the command line names, beginning with the frame that it names."""
    folder, turn, turns = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is not part of a frame
    film: Film = pickle.loads((folder / "film").read_bytes())
    walk = Walk.load(folder / "walk.npz")
    with Stage.open(walk, film) as stage:
        for number in range(turn, film.frames, turns):
            frame = stage.frame(film.time(number))
            output.write(bytes([stage.tracks]))
            output.write(frame.data)  # not joined into new bytes, which took longer than to send it
            output.flush()
