"""How the biped with knees walks on slopes, slope changes, stairs and random ground, beside straight legs.

The hybrid engine, sixty steps. With knees the swing foot's contact is on from lift-off; straight legs scuff, under
their rule. Stairs and slope changes begin at twelve places over one step length. A minute and a half, and once two
minutes for the references. The result stands in `docs/knees.md`.

    python -m scripts.studies.kneed_study --page docs/knees.md
    python -m scripts.studies.kneed_study --images docs/images
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, KneedController
from mjbiped import Terrain
from mjbiped.plotting.style import make_small
from scripts.pages import write_table

PLACES = 12  # of the first change of the ground, over one step length
CLEARANCE = 0.08  # of the optimised references, m
HEIGHTS_CM = (2, -2, 4, -4, 6, -6, 8, -8, 10, -10)


def walkers() -> Mapping[str, Callable[[], Controller]]:
    """Who walks, by name."""
    light, rods, compass = mjbiped.KneedBiped(), mjbiped.KneedBiped.halved_rods(), mjbiped.Compass()
    return {
        "light shanks, passive gait of 2.5°": lambda: KneedController(
            light, mjbiped.find_kneed_gait(light, math.radians(2.5))
        ),
        "light shanks, reference of 8 cm": lambda: KneedController(
            light, mjbiped.find_reference(light, clearance=CLEARANCE)
        ),
        "halved rods, reference of 8 cm": lambda: KneedController(
            rods, mjbiped.find_reference(rods, clearance=CLEARANCE)
        ),
        "straight legs, passive gait of 2°": lambda: AdaptiveController(
            compass, mjbiped.find_passive_gait(compass, math.radians(2))
        ),
        "straight legs, reference of 8 cm": lambda: AdaptiveController(
            compass, mjbiped.find_reference(compass, clearance=CLEARANCE)
        ),
    }


def grounds(step: float) -> Iterator[tuple[str, Sequence[Terrain]]]:
    """Grounds of each kind; the first change moves over one step length, m."""
    first = [1.5 + k * step / PLACES for k in range(PLACES)]
    yield "level", [Terrain.level()]
    for slope in (3.0, -3.0):
        yield f"{slope:+g}° all along", [Terrain.incline(slope)]
    for slope in (3.0, 5.0, -3.0, -5.0):
        yield f"level, then {slope:+g}°", [Terrain.from_segments([(x, 0.0), (90.0, slope)]) for x in first]
    for height in HEIGHTS_CM:
        yield f"stairs {height:+d} cm", [Terrain.stairs(rise=0.01 * height, first=x, tread=1.8) for x in first]
    seeds = range(PLACES)
    rough = [Terrain.random(seed=seed, length=60.0, slope_deg=(-3.0, 3.0), rise=(-0.04, 0.04)) for seed in seeds]
    yield "random, ±4 cm and ±3°", rough


def cells(walks: Sequence[mjbiped.Walk]) -> tuple[str, str]:
    """What came of walks: how many came through at which mean cost, and the greatest torques of those."""
    done = [walk for walk in walks if walk.outcome == "finished"]
    share = f"{len(done)} of {len(walks)}" if len(walks) > 1 else ("yes" if done else "no")
    if not done:
        return share, "-"
    cost = float(np.mean([walk.cost_of_transport for walk in done]))
    peaks = np.max([walk.peak_torque for walk in done], axis=0).tolist()
    return f"{share}, {cost:.4f}", ", ".join(f"{peak:.1f}" for peak in peaks)


def draw(folder: Path) -> None:
    """A figure and a GIF of light shanks on stairs up and down and on a slope."""
    law = walkers()["light shanks, reference of 8 cm"]()
    ground = Terrain.from_segments(
        [(1.2, 0.0), (0.9, 0.0, 0.06), (0.9, 0.0, 0.06), (0.9, 0.0, -0.06), (0.9, 0.0, -0.06), (9.0, 4.0)],
        name="stairs of 6 cm",
    )
    walk = mjbiped.walk(law, ground, engine="hybrid", steps=13)
    walk.plot(folder / "knees_walk.png")
    make_small(folder / "knees_walk.png")
    walk.video(folder / "knees_walk.gif", width=400, height=225, fps=10, hide=("chart", "labels"), stop=7.0)


@click.command(help=__doc__)
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@click.option("--page", type=click.Path(exists=True, path_type=Path), help="Markdown page to write the tables into.")
@click.option(
    "--images", type=click.Path(exists=True, path_type=Path), help="Folder for a figure and a GIF; no tables."
)
def main(steps: int, page: Path | None, images: Path | None) -> None:
    """Walk everything and print the tables, or draw one walk."""
    if images is not None:
        draw(images)
        return
    walked, torques = {}, {}
    for name, make in tqdm(walkers().items(), desc="walkers", disable=None):
        law = make()
        assert law.gait is not None
        for ground, terrains in grounds(law.gait.step_length):
            walks = [mjbiped.walk(law, each, engine="hybrid", steps=steps, sample_period=None) for each in terrains]
            walked[ground, name], torques[ground, name] = cells(walks)
    names = list(walkers())
    kinds = list(dict.fromkeys(ground for ground, _ in walked))
    for place, title, found in (
        ("walks", f"came through {steps} steps; c_mt", walked),
        ("torques", "greatest torques of ankle, hip and swing knee, N m", torques),
    ):
        rows = [[ground.replace("-", "−"), *(found[ground, name] for name in names)] for ground in kinds]
        table = Table(title=title)
        for heading in ("ground", *names):
            table.add_column(heading, justify="right")
        for line in rows:
            table.add_row(*line)
        Console(width=140).print(table)
        if page is not None:
            write_table(page, place, ["ground", *names], rows)


if __name__ == "__main__":
    main()
