"""Search for the mixed ground behind Table III.

The paper's own ground is in Fig. 4(a), not in its text. A ground of slopes and steps is looked for on which the
adaptive controller, from rest, comes nearest to the eleven torques and eleven c_mt of Table III. It shows that such a
ground exists; it need not be the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, OptimizeResult, differential_evolution
from tqdm.auto import tqdm

from mjbiped.reproduction.cell import Cell, Result, measured
from mjbiped.reproduction.grounds import Segments, end_of
from mjbiped.reproduction.methods import adaptive
from mjbiped.reproduction.published import TABLE_3
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.progress import hidden

SEGMENTS = 6
"""Of the grounds that are searched."""

LENGTHS = (1.0, 3.0)
"""Of a segment, m."""

SLOPES = (-5.0, 5.0)
"""Degrees, downhill positive."""

RISES = (-0.12, 0.02)
"""Steps at the starts of the segments but the first, m, up positive."""

_FALL = 10.0  # distance of a ground on which the robot falls, more the earlier it does


@dataclass(frozen=True)
class Found:
    """The nearest ground.

    Attributes:
        segments: (length, slope in degrees, step) each, as `Terrain.from_segments` takes them.
        distance: See `distance`.
        evaluations: Grounds that were walked.
    """

    segments: tuple[tuple[float, float, float], ...]
    distance: float
    evaluations: int


def distance(results: Sequence[Result]) -> float:
    """How far walks are from Table III: root mean square of ln(ours / paper's) of torques and c_mt.

    Args:
        results: One per zeta, in the table's order.

    Returns:
        The distance; above 10 where a walk did not reach the ground's end.
    """
    logs = []
    for result, (torque, cost) in zip(results, TABLE_3.values(), strict=True):
        if result.outcome != "finished":
            return _FALL + 1.0 / (1.0 + result.steps)
        logs += [math.log(max(result.peak_torque) / torque), math.log(result.cost_of_transport("absolute") / cost)]
    return math.sqrt(float(np.mean(np.square(logs))))


def cells(segments: Segments, engine: str = "hybrid") -> list[Cell]:
    """The walks of a ground: to its end from rest, one for each zeta of Table III."""
    terrain, end = Terrain.from_segments(segments), end_of(segments)
    return [Cell(engine, adaptive(delay), terrain, initial="rest", steps=None, distance=end) for delay in TABLE_3]


def walked(segments: Segments, engine: str = "hybrid") -> list[Result]:
    """Walk a ground to its end from rest, once for each zeta of Table III."""
    results: list[Result] = []
    for cell in cells(segments, engine):
        results.append(measured(cell)[0])
        if results[-1].outcome != "finished":
            # the rest cannot bring it back
            return results + [results[-1]] * (len(TABLE_3) - len(results))
    return results


def bounds() -> list[tuple[float, float]]:
    """Least and greatest of every number of a ground of the family: of each segment length, slope and, later, step."""
    return [bound for place in range(SEGMENTS) for bound in (LENGTHS, SLOPES, RISES)[: 3 if place else 2]]


def search(seed: int = 0, generations: int = 160, population: int = 6, *, progress: bool = False) -> Found:
    """Look for the ground nearest to Table III with SciPy's differential evolution, in the hybrid engine.

    Args:
        seed: Of the generator; the same arguments find the same ground.
        generations: At most so many.
        population: Grounds per generation, in multiples of the number of parameters (17), rounded up to
            a power of two.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The nearest ground, its numbers rounded to 0.01 m, 0.1 degrees and 1 mm.
    """

    def cost(parameters: NDArray[np.float64]) -> float:
        return distance(walked(segments_of(parameters)))

    def show(intermediate_result: OptimizeResult) -> None:
        bar.set_postfix(distance=float(intermediate_result.fun))
        bar.update()

    with tqdm(total=generations, desc="generations", disable=hidden(progress)) as bar:
        best = differential_evolution(
            cost,
            Bounds(*np.transpose(bounds())),
            rng=np.random.default_rng(seed),
            maxiter=generations,
            popsize=population,
            init="sobol",
            polish=False,
            tol=0.0,
            callback=show,
        )
    segments = segments_of(best.x)
    return Found(segments, distance(walked(segments)), int(best.nfev))


def segments_of(parameters: NDArray[np.float64]) -> tuple[tuple[float, float, float], ...]:
    """Parameters as segments, rounded as a page can print them; the first has no step."""
    table = np.insert(parameters, 2, 0.0).reshape(SEGMENTS, 3)
    return tuple(
        (round(length, 2), round(slope, 1) + 0.0, round(step, 3) + 0.0) for length, slope, step in table.tolist()
    )
