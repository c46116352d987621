"""How far both engines agree on long walks: footholds and c_mt after 1, 10, 30 and 60 steps, as distributions.

Both engines walk each ground by themselves. Where a foothold differs by more than 0.2 mm, or c_mt by more than 0.1 %,
the first thing in the records that explains it is named. The seeds served nothing else. Two minutes. The result stands
in `docs/tables/convergence.md`.

    python -m scripts.studies.long_walks_study --tables docs/tables/convergence
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from mjbiped.analysis import divergence
from mjbiped.robots.compass import Array
from scripts.pages import TABLES, show_table
from scripts.studies.gallery import ADAPTIVE

FIRST_SEED = 40_000
LENGTH = 60.0
"""Of each ground, m: longer than any of the walks."""
AFTER = (1, 10, 30, 60)
FOOTHOLD, COST = 2e-4, 1e-3
"""What two walks of 60 steps shall differ by at most, m and as a share of c_mt."""
HEADINGS = (
    "steps",
    *(f"{of}, {which}" for of in ("foothold µm", "c_mt %") for which in ("median", "99 %", "worst")),
)


@dataclass(frozen=True)
class Pair:
    """One ground walked by both engines.

    Attributes:
        footholds: Distance of the two at each touchdown, m.
        costs: Relative difference of c_mt up to each touchdown.
        cause: Why they are further apart than wanted; None where they are not.
    """

    footholds: Array
    costs: Array
    cause: str | None


def costs_so_far(walk: mjbiped.Walk) -> Array:
    """c_mt of the walk up to each touchdown."""
    work, x = walk.touchdowns["work_absolute"], walk.touchdowns["x"]
    return work / (walk.robot.weight * x)


def walked(seed: int, steps: int) -> Pair:
    """Walk one ground in both engines, roughness 0 to 3 mm by seed."""
    terrain = mjbiped.Terrain.random(seed=seed, roughness=0.001 * (seed % 4), length=LENGTH)
    pair = mjbiped.compare(ADAPTIVE, terrain, steps=steps)
    there, here = pair.mujoco, pair.hybrid
    n = min(there.steps, here.steps)
    footholds = np.abs(there.touchdowns["x"][:n] - here.touchdowns["x"][:n])
    costs = np.abs(costs_so_far(there)[:n] / costs_so_far(here)[:n] - 1.0)
    cause = None
    if n < steps or footholds.max() > FOOTHOLD or costs[-1] > COST:
        explained = (kind for k in range(n) for kind in divergence.explanations(there, here, k, ADAPTIVE))
        cause = next(explained, "none found").split(":")[0]
    return Pair(footholds, costs, cause)


def distribution(pairs: list[Pair], steps: int) -> list[str]:
    """One line of the table: pairs that made so many steps, the greatest distance of any foothold until then."""
    there = [pair for pair in pairs if len(pair.costs) >= steps]
    footholds = [1e6 * pair.footholds[:steps].max() for pair in there]
    costs = [100.0 * pair.costs[steps - 1] for pair in there]
    figures = [(np.median(each), np.percentile(each, 99), np.max(each)) for each in (footholds, costs)]
    first, second = (
        [form.format(value) for value in each] for form, each in zip(("{:.0f}", "{:.3f}"), figures, strict=True)
    )
    return [str(steps), *first, *second]


@click.command(help=__doc__)
@click.option("--grounds", default=200, show_default=True, type=click.IntRange(min=1), help="Random grounds.")
@TABLES
def main(grounds: int, tables: Path | None) -> None:
    """Walk on all grounds and print the tables."""
    seeds = range(FIRST_SEED, FIRST_SEED + grounds)
    pairs = [walked(seed, AFTER[-1]) for seed in tqdm(seeds, desc="grounds", disable=None)]
    rows = [distribution(pairs, steps) for steps in AFTER]
    apart = Counter(pair.cause for pair in pairs if pair.cause is not None)
    causes = [[cause, str(count)] for cause, count in apart.most_common()]
    causes.append(["none: they agree", str(sum(pair.cause is None for pair in pairs))])
    show_table(f"MuJoCo - hybrid engine, {grounds} grounds", HEADINGS, rows, tables, "long")
    title = f"Further apart than {1e3 * FOOTHOLD:g} mm or {COST:.1%}"
    show_table(title, ("first cause", "grounds"), causes, tables, "apart")


if __name__ == "__main__":
    main()
