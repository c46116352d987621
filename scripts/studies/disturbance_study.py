"""How much delay, noise, torque limit and pushing the adaptive controller bears on rough ground, in both engines.

python -m scripts.studies.disturbance_study --figure docs/images/disturbances.png
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from mjbiped import Disturbances
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.panels import legend_below
from scripts.pages import show_table
from scripts.studies.gallery import ADAPTIVE

ENGINES: Mapping[str, Mapping[str, Any]] = {
    "mujoco": {**plot_style.MUJOCO, "linewidth": 3.0, "marker": "s", "label": "MuJoCo"},
    "hybrid": {**plot_style.HYBRID, "marker": "o", "markersize": 3.5, "label": "hybrid"},
}


class Scan(NamedTuple):
    """A disturbance that is varied.

    Attributes:
        label: Beside its axis.
        factor: From its unit to the axis's.
        values: It takes.
        made: Disturbances of a value and a seed.
    """

    label: str
    factor: float
    values: Sequence[float]
    made: Callable[[float, int], Disturbances]


SCANS = (
    Scan(
        "delay (ms)",
        1e3,
        (0.0, 0.02, 0.03, 0.04, 0.05, 0.055, 0.06, 0.065, 0.07, 0.08),
        lambda value, _: Disturbances(control_period=1e-3, delay=value),
    ),
    Scan(
        "noise of angles (mrad)",
        1e3,
        (0.0, 5e-3, 0.01, 0.02, 0.04, 0.07, 0.1),
        lambda value, seed: Disturbances(control_period=1e-3, angle_noise=value, seed=seed),
    ),
    Scan(
        "torque limit (N m)",
        1.0,
        (3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0),
        lambda value, _: Disturbances(torque_limit=value),
    ),
    Scan(
        "random pushes, every 2 s (N s)",
        1.0,
        (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0),
        lambda value, seed: Disturbances(push_impulse=value, push_interval=2.0 if value else None, seed=seed),
    ),
)


class Point(NamedTuple):
    """What came of a value.

    Attributes:
        finished: Share of the walks that did all their steps.
        cost: Median c_mt of these; NaN where there are none.
    """

    finished: float
    cost: float


def measure(scan: Scan, engine: str, walks: int, steps: int) -> list[Point]:
    """Walk all values of a scan, each on the same grounds, with a seed of its own on each."""
    grounds = [mjbiped.Terrain.random(seed=seed, slope_deg=(-2.0, 2.0), rise=(-0.01, 0.01)) for seed in range(walks)]
    points = []
    for value in tqdm(scan.values, desc=f"{scan.label}, {engine}", disable=None):
        disturbances = [scan.made(value, seed) for seed in range(walks)]
        done = mjbiped.walk_many(
            ADAPTIVE, grounds, engine=engine, steps=steps, summaries=True, sample_period=None, disturbances=disturbances
        )
        costs = [walk["cost_of_transport"] for walk in done if walk["outcome"] == "finished"]
        points.append(Point(len(costs) / walks, float(np.median(costs)) if costs else math.nan))
    return points


def draw(found: Mapping[str, Sequence[Sequence[Point]]], path: Path) -> None:
    """Share of walks that finished, and cost, over each disturbance."""
    with plot_style.drawn(path) as figure:
        figure.set_figheight(4.9)
        rows = figure.subplots(2, len(SCANS), sharex="col", sharey="row")
        for engine, look in ENGINES.items():
            for scan, points, share, cost in zip(SCANS, found[engine], *rows, strict=True):
                x = [scan.factor * value for value in scan.values]
                share.plot(x, [100.0 * point.finished for point in points], **look)
                cost.plot(x, [point.cost for point in points], **look)
                cost.set_xlabel(scan.label)
        for letter, axes in zip("ABCDEFGH", (*rows[0], *rows[1]), strict=True):
            axes.set_title(letter)
        rows[0][0].set_ylabel("walks that finished (%)")
        rows[0][0].set_ylim(-5.0, 105.0)
        rows[1][0].set_ylabel(f"{plot_style.C_MT} of these, median")
        rows[1][0].set_ylim(0.0, None)
        legend_below(figure, *rows[0][0].get_legend_handles_labels())
    if path.suffix == ".png":
        plot_style.make_small(path)


@click.command(help=__doc__)
@click.option("--figure", default="out/disturbances.png", show_default=True, type=click.Path(path_type=Path))
@click.option("--walks", default=12, show_default=True, type=click.IntRange(min=1), help="Grounds for each value.")
@click.option("--steps", default=40, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
def main(figure: Path, walks: int, steps: int) -> None:
    """Walk, draw and tabulate."""
    figure.parent.mkdir(parents=True, exist_ok=True)
    found = {engine: [measure(scan, engine, walks, steps) for scan in SCANS] for engine in ENGINES}
    draw(found, figure)
    rows = []
    for number, scan in enumerate(SCANS):
        for place, value in enumerate(scan.values):
            points = [found[engine][number][place] for engine in ENGINES]
            said = [f"{100 * point.finished:.0f} %, {point.cost:.4f}" for point in points]
            rows.append([scan.label, f"{scan.factor * value:g}", *said])
    title = f"adaptive controller, {walks} grounds of {steps} steps: finished, c_mt"
    show_table(title, ("disturbance", "value", *ENGINES), rows)


if __name__ == "__main__":
    main()
