"""The adaptive controller on every kind of ground: a record, a figure and a still of each walk, and a table of all.

python -m scripts.studies.gallery --folder out/gallery --steps 60

With --images, the pictures of the front page and of the pages on videos and on feet instead:
python -m scripts.studies.gallery --images docs/images
"""

import math
from pathlib import Path
from typing import Any

import click
import matplotlib.image
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, SupervisedController
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.rendering.video import render_frame
from scripts.pages import show_table

TERRAINS = {
    "level": mjbiped.Terrain.level(),
    "down_3deg": mjbiped.Terrain.incline(3.0),
    "up_3deg": mjbiped.Terrain.incline(-3.0),
    "slopes_0.3deg": mjbiped.Terrain.slopes(change_deg=0.3),
    "slopes_-1deg": mjbiped.Terrain.slopes(change_deg=-1.0),
    "stairs_-6mm": mjbiped.Terrain.stairs(rise=-0.006),
    "stairs_+6mm": mjbiped.Terrain.stairs(rise=0.006),
    "stairs_-60mm": mjbiped.Terrain.stairs(rise=-0.06),
    "mixed": mjbiped.Terrain.mixed(),
    "rough": mjbiped.Terrain.random(seed=1, roughness=0.003),
}
ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
ADAPTIVE = AdaptiveController(ROBOT, GAIT)
HEADINGS = ("terrain", "outcome", "steps", "c_mt", "ankle N m", "hip N m", "estimate error deg", "impact worst %")


FRONT = mjbiped.Terrain.from_segments(
    [(0.35, 0.0), (0.7, 0.0, 0.03), (0.8, 4.0), (0.7, 0.0, -0.05), (0.9, -4.0), (0.9, 0.0, 0.03), (9.0, 2.0)],
    name="steps and slopes",
)


def draw(folder: Path) -> None:
    """Draw moving pictures of a walk on point feet and of one on feet with mass, and a frame of a video."""
    small: dict[str, Any] = {"width": 512, "height": 288, "fps": 10}
    walk = mjbiped.walk(ADAPTIVE, FRONT, steps=14)
    walk.video(folder / "mixed_walk.gif", hide=("chart", "scale"), stop=6.2, **small)
    matplotlib.image.imsave(folder / "video_frame.png", render_frame(walk, 4.3))
    footed = mjbiped.FootedCompass()
    law = SupervisedController(footed, mjbiped.find_reference(footed, clearance=0.077, retraction=False))
    walk = mjbiped.walk(law, mjbiped.Terrain.stairs(rise=0.04, first=0.5), steps=12)
    walk.video(folder / "feet_walk.gif", hide=("chart", "labels"), stop=6.0, **small)


@click.command(help=__doc__)
@click.option("--folder", default="out/gallery", show_default=True, type=click.Path(file_okay=False, path_type=Path))
@click.option("--steps", default=60, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@click.option("--images", type=click.Path(exists=True, path_type=Path), help="Folder for pictures; no table.")
def main(folder: Path, steps: int, images: Path | None) -> None:
    """Walk, draw and tabulate."""
    if images is not None:
        draw(images)
        return
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, terrain in tqdm(TERRAINS.items(), desc="terrains", disable=None):
        walk = mjbiped.walk(ADAPTIVE, terrain, steps=steps)
        walk.save(folder / f"{name}.npz")
        plot_walk(walk, folder / f"{name}.png")
        still = render_frame(walk, 0.6 * walk.end[0])
        matplotlib.image.imsave(folder / f"{name}_still.png", still)
        started, _ = measures.estimate_errors(walk)
        impacts = measures.impact_errors(walk)
        cells = (
            name,
            walk.outcome,
            str(walk.steps),
            f"{walk.cost_of_transport:.4f}",
            *(f"{torque:.2f}" for torque in walk.peak_torque),
            f"{math.degrees(started[-1]):+.4f}" if walk.steps else "-",
            f"{100 * abs(impacts).max():.2f}" if walk.steps else "-",
        )
        rows.append(cells)
    show_table(f"adaptive controller, {steps} steps", HEADINGS, rows)


if __name__ == "__main__":
    main()
