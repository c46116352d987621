"""Search for the mixed ground behind Table III; some six minutes.

python -m scripts.paper.search_table_3

The paper's own ground is in Fig. 4(a), not in its text. This program looks for a ground of slopes and steps on which
the adaptive controller, from rest, comes nearest to the eleven torques and eleven c_mt of Table III. It shows that such
a ground exists; it need not be the paper's. The result stands in mjbiped/studies/reproduction/section_5.toml.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import click
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, OptimizeResult, differential_evolution

from mjbiped.studies.cell import Row, attempt
from mjbiped.studies.reproduction.cell import measures_of
from mjbiped.studies.reproduction.section_5 import TABLE_3, Segments
from mjbiped.utils.parallel import progress_bar
from scripts.paper.placebo import bounds, cells, segments_of

_FALL = 10.0  # distance of a ground on which the robot falls, more the earlier it does


@dataclass(frozen=True)
class Found:
    """The nearest ground.

    Attributes:
        segments: (length, slope in degrees, step) each, as `Terrain.from_segments` takes them.
        distance: See `distance`.
        evaluations: Number of grounds that were walked.
    """

    segments: tuple[tuple[float, float, float], ...]
    distance: float
    evaluations: int


def distance(results: Sequence[Row]) -> float:
    """Compute how far walks are from Table III: root mean square of ln(ours / paper's) of torques and c_mt.

    Args:
        results: One per zeta, in the table's order.

    Returns:
        The distance; above 10 where a walk did not reach the ground's end.
    """
    logs = []
    for result, (torque, cost) in zip(results, TABLE_3.values(), strict=True):
        if result["outcome"] != "finished":
            steps = int(result.get("steps", 0))
            return _FALL + 1.0 / (1.0 + steps)
        logs += [math.log(max(result["ankle"], result["hip"]) / torque), math.log(result["absolute_end"] / cost)]
    return math.sqrt(float(np.mean(np.square(logs))))


def walked(segments: Segments) -> list[Row]:
    """Walk a ground to its end from rest, once for each zeta of Table III; the hybrid engine."""
    results: list[Row] = []
    for cell in cells(segments):
        results.append(attempt(cell.walk, measures_of))
        if results[-1]["outcome"] != "finished":
            # the rest cannot bring it back
            return results + [results[-1]] * (len(TABLE_3) - len(results))
    return results


def search(seed: int = 0, generations: int = 160, population: int = 6, *, progress: bool = False) -> Found:
    """Find the ground nearest to Table III with SciPy's differential evolution, in the hybrid engine.

    Args:
        seed: Of the generator; the same arguments find the same ground.
        generations: Greatest number of generations.
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

    with progress_bar(total=generations, desc="generations", progress=progress) as bar:
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


@click.command(help=__doc__)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0), help="Of the generator.")
@click.option("--generations", default=160, show_default=True, type=click.IntRange(min=1), help="At most so many.")
def main(seed: int, generations: int) -> None:
    """Search, and print the ground as the file of section V has it."""
    found = search(seed, generations, progress=True)
    click.echo(f"# distance {100 * found.distance:.2f} %, {found.evaluations} grounds walked")
    click.echo("found = [")
    for segment in found.segments:
        click.echo(f"    {list(segment)},")
    click.echo("]")


if __name__ == "__main__":
    main()
