"""Gains of the lateral foot placement: a search along one gain after the other, on grounds and pushes of its own.

A law is judged by the steps that it makes before it falls on bumps of 12 mm rms (eight seeds) and after lateral pushes
of 1.2 N s at eight times of a step, none of which is in the table of `scripts.studies.three_d_study`; of laws that make
the same number of steps the one with the least cost of transport is best. Each gain in turn is tried greater and
smaller, and kept where the law gets better. The table lists each trial; trials that it has are not walked again. At the
end the first and the best gains walk on forty grounds that the search has not seen.

    python -m scripts.studies.placement_gains --table docs/tables/three_dimensions/placement_gains.csv

With `--sole-share 0 --factor 1.2` and a `--start` for each gain of `scripts.studies.three_d_study.ALONE` the search is
that of the rival.
"""

from __future__ import annotations

import csv
import math
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import click

import mjbiped
from controllers import PlacementController
from mjbiped.control.registry import make_controller

STEPS, SEEDS, TIMES, RMS, IMPULSE = 12, range(2, 10), [0.6 + 0.1 * k for k in range(8)], 0.012, 1.2
GAINS = ("margin", "timing_share", "placement_gain", "lead", "pace", "capture_gain", "closest")
FURTHER = range(100, 140)
START: dict[str, float] = {name: getattr(PlacementController, name) for name in GAINS}


def walked(gains: dict[str, float], terrain: mjbiped.Terrain, steps: int, push: float | None = None) -> mjbiped.Walk:
    """A walk under gains, with a lateral push at a time (s)."""
    robot = mjbiped.Abducting3D(sole=(0.12, 0.12), sole_width=0.08)
    law = make_controller("bounded-ankle", robot, dict(gains))
    pushes = None if push is None else mjbiped.Disturbances(pushes=[(push, IMPULSE)], push_direction=math.pi / 2)
    return mjbiped.walk(law, terrain, engine="mujoco", steps=steps, sample_period=None, disturbances=pushes)


def trial(gains: dict[str, float], number: int) -> tuple[int, float]:
    """Steps of one walk, and its cost of transport."""
    if number < len(SEEDS):
        walk = walked(gains, mjbiped.Terrain.bumps(rms=RMS, seed=SEEDS[number]), STEPS)
    else:
        walk = walked(gains, mjbiped.Terrain.level(), STEPS, TIMES[number - len(SEEDS)])
    cost = walk.cost_of_transport
    return walk.steps, cost if cost is not None and math.isfinite(cost) else math.inf


def finishes(gains: dict[str, float], seed: int) -> bool:
    """Whether a walk of 30 steps on bumps of 10 mm is finished."""
    return walked(gains, mjbiped.Terrain.bumps(rms=0.01, seed=seed), 30).outcome == "finished"


def judged(gains: dict[str, float], pool: ProcessPoolExecutor) -> tuple[int, float]:
    """Steps of all walks, and their mean cost with its sign changed: the greater, the better."""
    count = len(SEEDS) + len(TIMES)
    walks = list(pool.map(trial, [gains] * count, range(count)))
    return sum(steps for steps, _ in walks), -sum(cost for _, cost in walks) / count


@click.command(help=__doc__)
@click.option("--table", type=click.Path(path_type=Path), required=True, help="CSV file that grows.")
@click.option("--sole-share", type=float, default=1.0, help="0: the rival, which balances by the feet's places alone.")
@click.option("--jobs", type=int, default=2, help="Walks at a time.")
@click.option("--factor", type=float, default=1.4, help="By which a gain is tried greater and smaller.")
@click.option("--start", type=(str, float), multiple=True, help="A gain to begin at, and its value.")
def main(table: Path, sole_share: float, jobs: int, factor: float, start: tuple[tuple[str, float], ...]) -> None:
    """Search once along each gain."""
    known: dict[tuple[float, ...], tuple[int, float]] = {}
    if table.exists():
        with table.open() as file:
            for row in csv.DictReader(file):
                known[*(float(row[name]) for name in ("sole_share", *START))] = int(row["steps"]), -float(row["c_mt"])

    def value(gains: dict[str, float]) -> tuple[int, float]:
        key = (sole_share, *(gains[name] for name in START))
        if key not in known:
            known[key] = judged({**gains, "sole_share": sole_share}, pool)
            steps, cost = known[key]
            row = {"sole_share": sole_share, **gains, "steps": steps, "c_mt": f"{-cost:.5f}"}
            fresh = not table.exists()
            with table.open("a", newline="") as file:
                writer = csv.DictWriter(file, row, lineterminator="\n")
                if fresh:
                    writer.writeheader()
                writer.writerow(row)
            click.echo(row)
        return known[key]

    best = {**START, **dict(start)}
    with ProcessPoolExecutor(jobs) as pool:
        for name in START:
            for share in (factor, 1.0 / factor):
                tried = {**best, name: float(f"{best[name] * share:.3g}")}
                if value(tried) > value(best):
                    best = tried
                    break
        for gains in ({**START, **dict(start)}, best):
            done = sum(pool.map(finishes, [{**gains, "sole_share": sole_share}] * len(FURTHER), FURTHER))
            click.echo(f"{done} of {len(FURTHER)} further grounds finished with {gains}")


if __name__ == "__main__":
    main()
