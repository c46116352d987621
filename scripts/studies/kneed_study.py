"""How the biped with knees walks on slopes, slope changes, stairs and random ground, beside straight legs.

Sixty steps, robots with knees in both engines. With knees the swing foot's contact is on from lift-off; straight legs
scuff, under their rule. Stairs and slope changes begin at twelve places over one step length. Ten minutes, and once two
for the references. The result stands in `docs/tables/kneed_walks.md`.

    python -m scripts.studies.kneed_study --tables docs/tables/kneed_walks
    python -m scripts.studies.kneed_study --images docs/images
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, KneedController
from mjbiped import Terrain
from mjbiped.plotting.style import make_small
from scripts.pages import TABLES, show_table

PLACES = 12  # of the first change of the ground, over one step length
CLEARANCE = 0.08  # of the optimised references, m
FORWARD = 0.2  # m, of the mean step: half of one on level ground; who steps on the spot before a riser is stuck
STAIRS = 150  # of any tread, drawn by chance
MOTOR = 50.0  # of weak motors, N m
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


def signed(number: float, form: str = "g") -> str:
    """A number with its sign, as a page shows it."""
    return f"{number:+{form}}".replace("-", "−")


def grounds(step: float) -> Iterator[tuple[str, Sequence[Terrain]]]:
    """Grounds of each kind; the first change moves over one step length, m."""
    first = [1.5 + k * step / PLACES for k in range(PLACES)]
    yield "level", [Terrain.level()]
    for slope in (3.0, -3.0):
        yield f"{signed(slope)}° all along", [Terrain.incline(slope)]
    for slope in (3.0, 5.0, -3.0, -5.0):
        yield f"level, then {signed(slope)}°", [Terrain.from_segments([(x, 0.0), (90.0, slope)]) for x in first]
    for height in HEIGHTS_CM:
        yield f"stairs {signed(height)} cm", [Terrain.stairs(rise=0.01 * height, first=x, tread=1.8) for x in first]
    seeds = range(PLACES)
    rough = [Terrain.random(seed=seed, length=60.0, slope_deg=(-3.0, 3.0), rise=(-0.04, 0.04)) for seed in seeds]
    yield "random, ±4 cm and ±3°", rough


def walk_everywhere(
    law: Controller, engine: str, steps: int, progress: "tqdm[Any]", **settings: Any
) -> Iterator[tuple[str, list[mjbiped.Walk]]]:
    """Walks of a controller on all grounds, ground after ground; the settings are those of `mjbiped.walk`."""
    assert law.gait is not None
    for ground, terrains in grounds(law.gait.step_length):
        yield ground, [mjbiped.walk(law, each, engine=engine, steps=steps, **settings) for each in terrains]
        progress.update()


def any_stairs(rise: float) -> list[Terrain]:
    """Stairs whose first riser and whose treads, in m, are drawn by chance, the same for every rise."""
    chance = np.random.default_rng(7)
    drawn = [(chance.uniform(0.5, 1.5), chance.uniform(1.2, 2.6)) for _ in range(STAIRS)]
    return [Terrain.stairs(rise=rise, first=first, tread=tread, count=40) for first, tread in drawn]


def climbers() -> Mapping[str, Controller]:
    """Who climbs those, by name: the numbers are the clearances of the references."""
    light, rods = mjbiped.KneedBiped(), mjbiped.KneedBiped.halved_rods()
    return {
        "light shanks, 8 cm": KneedController(light, mjbiped.find_reference(light, clearance=0.08)),
        "light shanks, 12 cm": KneedController(light, mjbiped.find_reference(light, clearance=0.12)),
        "halved rods, 8 cm": KneedController(rods, mjbiped.find_reference(rods, clearance=0.08)),
    }


def walk_on_any_stairs(steps: int, tables: Path | None) -> None:
    """How many walks come through on stairs of any tread, in the hybrid engine, with any motors and with weak ones."""
    laws, rows = climbers(), []
    weak = mjbiped.Disturbances(torque_limit=MOTOR)
    for height in tqdm((5, 6, 7, 8, 9, 10, 11, -10), desc="stairs", disable=None):
        grounds = any_stairs(0.01 * height)
        walks = [
            mjbiped.walk_many(law, grounds, engine="hybrid", steps=steps, sample_period=None, disturbances=limited)
            for law in laws.values()
            for limited in (None, weak)
        ]
        rows.append([f"{signed(height)} cm", *map(share_and_cost, walks)])
    names = [name for law in laws for name in (law, f"{law}, {MOTOR:g} N m")]
    show_table(
        f"came through {steps} steps on stairs of any tread; c_mt", ["stairs", *names], rows, tables, "any stairs"
    )


def honest(walks: Sequence[mjbiped.Walk]) -> list[mjbiped.Walk]:
    """Those of the walks that came through on ground as there is: it never pulls, nor has friction over 0.8."""
    return [walk for walk in came_through(walks) if not walk.contact_violations.any()]


def came_through(walks: Sequence[mjbiped.Walk]) -> list[mjbiped.Walk]:
    """The walks that made all their steps, and did not step on the spot."""
    return [walk for walk in walks if walk.outcome == "finished" and walk.distance > FORWARD * walk.steps]


def share_and_cost(walks: Sequence[mjbiped.Walk]) -> str:
    """How many walks came through, at which mean cost."""
    done, sound = came_through(walks), honest(walks)
    share = f"{len(done)} of {len(walks)}" if len(walks) > 1 else ("yes" if done else "no")
    if len(sound) < len(done):
        share += f" ({len(done) - len(sound)} violate the contact)" if len(walks) > 1 else " (violates the contact)"
    return f"{share}, {np.mean([walk.cost_of_transport for walk in done]):.4f}" if done else share


def torques(walks: Sequence[mjbiped.Walk]) -> str:
    """The greatest torques of the walks that came through, with spaces at which no cell of a page breaks."""
    done = came_through(walks)
    return (
        ",\u00a0".join(f"{peak:.1f}" for peak in np.max([walk.peak_torque for walk in done], axis=0)) if done else "-"
    )


def soles(walks: Sequence[mjbiped.Walk]) -> str:
    """The foot that would hold the centre of pressure 99 % of the time of the walks that came through, cm."""
    lengths = [walk.summary()["foot_length_99_percent_m"] for walk in came_through(walks)]
    return f"{100.0 * np.median(lengths):.0f}" if lengths else "-"


def with_torques(told: str, walks: Sequence[mjbiped.Walk]) -> str:
    """What is told of walks, and their greatest torques if any came through."""
    return f"{told}; {torques(walks)}" if came_through(walks) else told


def beside(walks: Sequence[mjbiped.Walk], others: Sequence[mjbiped.Walk]) -> str:
    """Share and cost of walks, and how far their mean cost is from that of other walks on the same grounds.

    Only grounds that both came through are compared.
    """
    pairs = [pair for pair in zip(walks, others, strict=True) if len(came_through(pair)) == len(pair)]
    if not pairs:
        return share_and_cost(walks)
    difference = float(np.mean([walk.cost_of_transport - other.cost_of_transport for walk, other in pairs]))
    return f"{share_and_cost(walks)} ({signed(round(difference, 5) + 0.0, '.5f')})"


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
@TABLES
@click.option(
    "--images", type=click.Path(exists=True, path_type=Path), help="Folder for a figure and a GIF; no tables."
)
def main(steps: int, tables: Path | None, images: Path | None) -> None:
    """Walk everything and print the tables, or draw one walk."""
    if images is not None:
        draw(images)
        return
    laws = {name: make() for name, make in walkers().items()}
    kneed = [name for name, law in laws.items() if isinstance(law, KneedController)]
    kinds = [ground for ground, _ in grounds(1.0)]
    with tqdm(total=len(kinds) * (len(laws) + len(kneed)), desc="grounds", disable=None) as progress:
        settings: Mapping[str, Any] = {"steps": steps, "progress": progress, "sample_period": None}
        hybrid = {name: dict(walk_everywhere(law, "hybrid", **settings)) for name, law in laws.items()}
        for place, title, cell in (
            ("walks", f"came through {steps} steps; c_mt", share_and_cost),
            ("torques", "greatest torques of ankle, hip and swing knee, N m", torques),
            ("soles", "foot that holds the centre of pressure 99 % of the time, cm, median", soles),
        ):
            rows = [[ground, *(cell(hybrid[name][ground]) for name in laws)] for ground in kinds]
            show_table(title, ["ground", *laws], rows, tables, place)
        walk_on_any_stairs(steps, tables)
        mujoco = {name: dict(walk_everywhere(laws[name], "mujoco", **settings)) for name in kneed}
    rows = []
    for ground in kinds:
        both = [(mujoco[name][ground], hybrid[name][ground]) for name in kneed]
        rows.append([ground, *(with_torques(beside(walks, others), walks) for walks, others in both)])
    title = f"MuJoCo: came through {steps} steps; c_mt (less that of the hybrid engine); greatest torques, N m"
    show_table(title, ["ground", *kneed], rows, tables, "mujoco")


if __name__ == "__main__":
    main()
