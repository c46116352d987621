"""Benchmarks of what a user waits for: imports, the first walk, a walk with a changed law, and video frames.

Processes are timed with all their threads. "The first time" is with an empty cache of machine code.
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

import mjbiped
from controllers import PassiveController
from mjbiped.rendering.video import render_frame
from mjbiped.terrain.terrain import Terrain
from scripts.benchmarks.timing import Case, Rows, Timing, interleaved

FRAMES = 30
SIZE = (1280, 720)
WALK = ("-m", "mjbiped", "walk", "level", "--steps", "3", "--quiet")
PROCESSES = {
    "`import numpy, mujoco`": ("-c", "import numpy, mujoco"),
    "`import mjbiped`": ("-c", "import mjbiped"),
    "`mjbiped --help`": ("-m", "mjbiped", "--help"),
    "`mjbiped walk --help`": ("-m", "mjbiped", "walk", "--help"),
    "`mjbiped walk level --steps 3`": WALK,
    "the same, `--engine hybrid`": (*WALK, "--engine", "hybrid"),
}
COLD = ("`mjbiped walk level --steps 3`", "the same, `--engine hybrid`")


def process(words: Sequence[str], cache: str | None = None) -> Case:
    """Time a Python process with these arguments, and perhaps a cache folder of its own."""
    environment = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}

    def run() -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], env=environment, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return run


def startup(repeats: int) -> Rows:
    """Time processes with machine code on disk, and the first time."""
    warm = interleaved({name: (process(words), 1) for name, words in PROCESSES.items()}, repeats, "start")
    rows = []
    for name, timing in warm.items():
        cold = ""
        if name in COLD:
            with tempfile.TemporaryDirectory() as cache:
                cold = f"{process(PROCESSES[name], cache)():.1f}"
        rows.append([name, timing.each(), cold])
    return rows


def edited(repeats: int) -> Rows:
    """Time a program with a law of its own, after a constant in it has changed and once more unchanged."""
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


def frames(repeats: int) -> Rows:
    """Time frames by wall-clock time, since the renderer has threads."""
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), steps=4)
    times = [walk.end[0] * index / FRAMES for index in range(FRAMES)]

    def drawing(hide: str) -> Case:
        def run() -> float:
            started = time.perf_counter()
            for _ in render_frame(walk, times, width=SIZE[0], height=SIZE[1], hide=hide):
                pass
            return time.perf_counter() - started

        return run

    timings = interleaved(
        {name: (drawing(hide), FRAMES) for name, hide in (("everything shown", ""), ("robot and ground alone", "all"))},
        repeats,
        "frames",
    )
    return [[name, timing.rate] for name, timing in timings.items()]
