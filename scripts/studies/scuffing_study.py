"""What the scuffing rule hides: straight legs under it, straight legs whose foot collides early, and legs with knees.

Straight legs must scuff, so the rule lets their swing foot pass through the ground until it is ahead. This walks sixty
steps in MuJoCo on the grounds of `kneed_study`, counts the steps in which the swing foot passes through the ground or a
riser, and measures how deep. Ten minutes. The result stands in `docs/tables/kneed_walks.md`.

    python -m scripts.studies.scuffing_study --tables docs/tables/kneed_walks
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from mjbiped import ScuffingRule, Terrain
from mjbiped.records.columns import flat_samples
from mjbiped.terrain.profile import height_over_ground
from scripts.pages import TABLES, show_table
from scripts.studies.kneed_study import grounds, share_and_cost, walk_everywhere, walkers, with_torques

RULE = ScuffingRule()
EARLY = ScuffingRule(reach=0.05, delay=0.0, name="as early as all grounds bear")
"""With less reach straight legs make steps of a few centimetres before a riser, and slide under it."""

LEGS: Mapping[str, tuple[str, ScuffingRule | None]] = {
    "straight legs, the rule": ("straight legs, reference of 8 cm", RULE),
    "straight legs, foot early": ("straight legs, reference of 8 cm", EARLY),
    "light shanks": ("light shanks, reference of 8 cm", None),
    "halved rods": ("halved rods, reference of 8 cm", None),
}
"""Walkers of `kneed_study`, and the rule that lets their swing foot collide; with knees there is none."""

SAMPLE_PERIOD = 2e-3  # s: two physics steps
TOUCHED = 1e-4  # m: contacts of standing feet are 20 times less deep
THROUGH = 1e-2  # m: deeper than straight legs scuff on a plane


class Passed(NamedTuple):
    """How the swing foot of a walk passes through the ground.

    Attributes:
        depth: The greatest depth of each whole step, m, shape (steps,); zero where it stays above the ground.
        part: The first and the last moment in any step at which it is deeper than `TOUCHED`, as parts of the step
            from 0 to 1; NaN without any.
    """

    depth: NDArray[np.float64]
    part: tuple[float, float]


def passed_through(walk: mjbiped.Walk) -> Passed:
    """Measure a walk's swing foot in its samples.

    A foot no further than 1 mm inside a riser lies beside it, not in it: `mjbiped.terrain.profile.BESIDE`.
    """
    terrain, step, ends = walk.terrain, flat_samples(walk)["step"] - 1, walk.touchdowns["time"]
    whole = step < walk.steps
    step, time, stance = step[whole], walk.samples["time"][whole], walk.samples["stance"][whole]
    x, z = walk.robot.limbs(walk.samples["qpos"][whole])[np.arange(len(time)), 1 - stance, -1].T
    depth = np.maximum(terrain.height(x) - z, 0.0)
    for k in np.flatnonzero(depth > TOUCHED):
        depth[k] = max(0.0, -height_over_ground(terrain.profile, x[k], z[k]))
    deepest = np.zeros(walk.steps)
    np.maximum.at(deepest, step, depth)
    begins = np.append(0.0, ends[:-1])
    part = ((time - begins[step]) / (ends - begins)[step])[depth > TOUCHED]
    return Passed(deepest, (float(part.min()), float(part.max())) if part.size else (np.nan, np.nan))


def passes(walks: Sequence[mjbiped.Walk]) -> str:
    """In how many steps of walks the swing foot passed through the ground, and deeper than 1 cm; the greatest depth."""
    depth = np.concatenate([passed_through(walk).depth for walk in walks])
    touched, through = 100 * np.mean(depth > TOUCHED), 100 * np.mean(depth > THROUGH)
    return f"{touched:.0f} %, {through:.0f} %; {100 * depth.max():.2f}"


@click.command(help=__doc__)
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@TABLES
def main(steps: int, tables: Path | None) -> None:
    """Walk everything, and print and write both tables."""
    outcomes: dict[str, list[str]] = {}
    depths: dict[str, list[str]] = {}
    kinds = [ground for ground, _ in grounds(1.0)]
    makers = walkers()
    with tqdm(total=len(kinds) * len(LEGS), desc="grounds", disable=None) as progress:
        for name, (walker, rule) in LEGS.items():
            settings: Mapping[str, Any] = {"scuffing": rule, "sample_period": SAMPLE_PERIOD}
            outcomes[name], depths[name] = [], []
            for _, walks in walk_everywhere(makers[walker](), "mujoco", steps, progress, **settings):
                outcomes[name].append(with_torques(share_and_cost(walks), walks))
                depths[name].append(passes(walks))
    for place, title, cells in (
        ("scuffing", f"came through {steps} steps; c_mt; greatest torques, N m", outcomes),
        ("passes", "of the steps: foot in the ground, deeper than 1 cm; greatest depth, cm", depths),
    ):
        rows = [[ground, *(cells[name][k] for name in LEGS)] for k, ground in enumerate(kinds)]
        show_table(title, ["ground", *LEGS], rows, tables, place)
    walker, rule = next(iter(LEGS.values()))
    level = mjbiped.walk(makers[walker](), Terrain.level(), steps=steps, scuffing=rule, sample_period=SAMPLE_PERIOD)
    begin, end = passed_through(level).part
    click.echo(f"on level ground straight legs scuff from {begin:.1%} to {end:.1%} of the step")


if __name__ == "__main__":
    main()
