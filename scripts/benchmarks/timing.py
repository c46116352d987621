"""Paired timings: the cases of a comparison run in turn, so that a machine that slows down slows all of them.

A time is the CPU time of the one thread that works, unless threads are compared: then it is wall-clock time.
"""

from __future__ import annotations

import os
import platform
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

Case = Callable[[], float]
"""Runs something and returns the seconds that it took."""

Rows = list[list[str]]
"""Rows of a table, each a list of cells."""


@dataclass(frozen=True)
class Timing:
    """Repeated timings of one case.

    Attributes:
        seconds: One per repetition, in the order of the run.
        work: What is counted (gait steps) in one repetition.
    """

    seconds: NDArray[np.float64]
    work: int = 1

    @property
    def rate(self) -> str:
        """Median of work per second, with the slowest and the fastest repetition."""
        low, middle, high = (self.work / np.percentile(self.seconds, part) for part in (100, 50, 0))
        return f"{middle:,.0f} ({low:,.0f} to {high:,.0f})"

    def each(self, unit: float = 1.0, digits: int = 2) -> str:
        """Time per unit of work, as a multiple of `unit` (s): median, least and greatest."""
        low, middle, high = (np.percentile(self.seconds, part) / self.work / unit for part in (0, 50, 100))
        return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"

    def median(self, unit: float = 1.0) -> str:
        """Median time per unit of work, as a multiple of `unit` (s)."""
        return f"{np.median(self.seconds) / self.work / unit:.1f}"

    def ratio(self, other: Timing) -> str:
        """Speed as a multiple of another's, from paired repetitions: median, least and greatest."""
        ratios = (other.seconds / other.work) / (self.seconds / self.work)
        return f"{np.median(ratios):.3g} ({ratios.min():.3g} to {ratios.max():.3g})"


def interleaved(cases: Mapping[str, tuple[Case, int]], repeats: int, title: str) -> dict[str, Timing]:
    """Time cases in turn, after one uncounted run of each (compilation, caches).

    Args:
        cases: Each case with the work of one repetition.
        repeats: Repetitions that count.
        title: Title of the progress bar.
    """
    seconds: dict[str, list[float]] = {name: [] for name in cases}
    with tqdm(total=len(cases) * (repeats + 1), desc=title, disable=None) as bar:
        for repeat in range(repeats + 1):
            for name, (case, _) in cases.items():
                taken = case()
                bar.update()
                if repeat:
                    seconds[name].append(taken)
    return {name: Timing(np.array(seconds[name]), work) for name, (_, work) in cases.items()}


def side_by_side(case: Callable[[], object], threads: int) -> float:
    """Wall-clock time in which so many threads each run the case, s."""
    working = [threading.Thread(target=case) for _ in range(threads)]
    started = time.perf_counter()
    for thread in working:
        thread.start()
    for thread in working:
        thread.join()
    return time.perf_counter() - started


def machine(_repeats: int = 1) -> Rows:
    """Describe the machine: processor, system, load and date."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    model = models[0] if models else platform.processor() or platform.machine()
    versions = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "numba", "numpy", "scipy"))
    return [
        ["processor", f"{model}, {os.cpu_count()} cores"],
        ["system", f"{platform.system()}, Python {platform.python_version()}, {versions}"],
        ["load in the last 1, 5, 15 minutes", ", ".join(f"{value:.1f}" for value in os.getloadavg())],
        ["date", time.strftime("%Y-%m-%d")],
    ]
