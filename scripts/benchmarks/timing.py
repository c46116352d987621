"""Paired timings: the cases of a comparison run in turn, so that a machine that slows down slows all of them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

PAGE = Path("docs/tables/performance.md")

Case = Callable[[], float]
"""Runs something and returns the seconds that it took."""


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
        """Median per second, with the slowest and the fastest repetition."""
        low, middle, high = (self.work / np.percentile(self.seconds, part) for part in (100, 50, 0))
        return f"{middle:,.0f} ({low:,.0f} to {high:,.0f})"

    def each(self, unit: float = 1.0, digits: int = 2) -> str:
        """Time for one of what is counted, in units of so many seconds: median, least and greatest."""
        low, middle, high = (np.percentile(self.seconds, part) / self.work / unit for part in (0, 50, 100))
        return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"

    def ratio(self, other: Timing) -> str:
        """How many times as fast as another, from paired repetitions: median, least and greatest."""
        ratios = (other.seconds / other.work) / (self.seconds / self.work)
        return f"{np.median(ratios):.3g} ({ratios.min():.3g} to {ratios.max():.3g})"


def interleaved(cases: Mapping[str, tuple[Case, int]], repeats: int, title: str) -> dict[str, Timing]:
    """Time cases in turn, after one run of each that does not count (compilation, caches)."""
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
    """Seconds by the clock on the wall in which so many threads each do the same."""
    working = [threading.Thread(target=case) for _ in range(threads)]
    started = time.perf_counter()
    for thread in working:
        thread.start()
    for thread in working:
        thread.join()
    return time.perf_counter() - started
