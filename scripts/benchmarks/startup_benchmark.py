"""What one waits for: imports, the first walk, and video frames.

    python -m scripts.benchmarks.startup_benchmark        (part of: make bench)

Processes of their own, in turn; CPU times with those of their threads. Cold: with an empty cache of machine code.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

import click

import mjbiped
from controllers import PassiveController
from mjbiped.errors import RenderError
from mjbiped.rendering.video import render_frames
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.timing import PAGE, Case, interleaved
from scripts.pages import write_table

FRAMES = 30
SIZE = (640, 480)
WALK = ("-m", "mjbiped", "walk", "level", "--steps", "3", "--quiet")
PROCESSES = {
    "`import numpy, mujoco`": ("-c", "import numpy, mujoco"),
    "`import mjbiped`": ("-c", "import mjbiped"),
    "`mjbiped --help`": ("-m", "mjbiped", "--help"),
    "`mjbiped walk level --steps 3`": WALK,
    "the same, `--engine hybrid`": (*WALK, "--engine", "hybrid"),
}
COLD = ("`mjbiped walk level --steps 3`", "the same, `--engine hybrid`")


def process(words: Sequence[str], cache: str | None = None) -> Case:
    """A Python process; its CPU time."""
    environment = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}

    def run() -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], env=environment, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return run


def startup(repeats: int) -> list[list[str]]:
    """Rows of the processes: with machine code on disk, and the first time."""
    warm = interleaved({name: (process(words), 1) for name, words in PROCESSES.items()}, repeats, "start")
    rows = []
    for name, timing in warm.items():
        cold = ""
        if name in COLD:
            with tempfile.TemporaryDirectory() as cache:
                cold = f"{process(PROCESSES[name], cache)():.1f}"
        rows.append([name, timing.each(), cold])
    return rows


def frames(repeats: int) -> list[list[str]]:
    """Rows of frames per second, by the clock on the wall: the renderer has threads."""
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=4)
    times = [walk.end[0] * index / FRAMES for index in range(FRAMES)]

    def drawing(shadows: bool) -> Case:
        def run() -> float:
            started = time.perf_counter()
            for _ in render_frames(walk, times, width=SIZE[0], height=SIZE[1], shadows=shadows):
                pass
            return time.perf_counter() - started

        return run

    timings = interleaved(
        {name: (drawing(shadows), FRAMES) for name, shadows in (("with shadows", True), ("without", False))},
        repeats,
        "frames",
    )
    return [[name, timing.rate] for name, timing in timings.items()]


@click.command()
@click.option("--repeats", default=7, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
def main(repeats: int) -> None:
    """Measure, and write the tables of docs/performance.md."""
    write_table(PAGE, "startup", ("process", "CPU time, s", "the first time"), startup(repeats))
    try:
        rows = frames(repeats)
    except RenderError as error:
        click.echo(f"the table of frames stays as it is: {error}")
    else:
        write_table(PAGE, "frames", (f"{SIZE[0]} × {SIZE[1]}", "frames/s"), rows)


if __name__ == "__main__":
    main()
