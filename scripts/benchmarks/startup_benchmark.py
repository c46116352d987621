"""What one waits for: imports, the first walk, a walk after a law was changed, and video frames.

    python -m scripts.benchmarks.startup_benchmark        (part of: make bench)

Processes of their own, in turn; CPU times with those of their threads. Cold: with an empty cache of machine code.
"""

from __future__ import annotations

import itertools
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import click

import mjbiped
from controllers import PassiveController
from mjbiped.errors import RenderError
from mjbiped.rendering.video import render_frames
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.timing import PAGE, Case, Timing, interleaved
from scripts.pages import write_table

FRAMES = 30
SIZE = (1280, 720)
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


def edited(repeats: int) -> list[list[str]]:
    """Rows of a program with a law of its own: a constant of it just changed, and as it was in the run before."""
    source = Path(__file__).with_name("edited_law.py").read_text()
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "edited_law.py"
        counter = itertools.count(1)

        def changed(engine: str) -> Case:
            def run() -> float:
                program.write_text(
                    source.replace("FACTOR = 1.0", f"FACTOR = {1.0 + 1e-9 * (os.getpid() + next(counter))!r}")
                )
                return process((str(program), engine))()

            return run

        cases: dict[str, tuple[Case, int]] = {}
        for engine in ("hybrid", "mujoco"):
            cases[f"{engine}, changed"] = (changed(engine), 1)
            cases[f"{engine}, the same again"] = (process((str(program), engine)), 1)
        timings = interleaved(cases, repeats, "changed law")
    rows = []
    for engine in ("hybrid", "mujoco"):
        new, old = timings[f"{engine}, changed"], timings[f"{engine}, the same again"]
        compiling = Timing(new.seconds - old.seconds)
        rows.append([engine, new.each(), old.each(), compiling.each()])
    return rows


def frames(repeats: int) -> list[list[str]]:
    """Rows of frames per second, by the clock on the wall: the renderer has threads."""
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=4)
    times = [walk.end[0] * index / FRAMES for index in range(FRAMES)]

    def drawing(hide: str) -> Case:
        def run() -> float:
            started = time.perf_counter()
            for _ in render_frames(walk, times, width=SIZE[0], height=SIZE[1], hide=hide):
                pass
            return time.perf_counter() - started

        return run

    timings = interleaved(
        {name: (drawing(hide), FRAMES) for name, hide in (("everything shown", ""), ("robot and ground alone", "all"))},
        repeats,
        "frames",
    )
    return [[name, timing.rate] for name, timing in timings.items()]


@click.command()
@click.option("--repeats", default=7, show_default=True, type=click.IntRange(3), help="Repetitions of each case.")
def main(repeats: int) -> None:
    """Measure, and write the tables of docs/tables/performance.md."""
    write_table(PAGE, "startup", ("process", "CPU time, s", "the first time"), startup(repeats))
    headings = ("60 steps in", "a constant changed, s", "the same again, s", "compiling the law, s")
    write_table(PAGE, "edited", headings, edited(repeats))
    try:
        rows = frames(repeats)
    except RenderError as error:
        click.echo(f"the table of frames stays as it is: {error}")
    else:
        write_table(PAGE, "frames", (f"{SIZE[0]} × {SIZE[1]}", "frames/s"), rows)


if __name__ == "__main__":
    main()
