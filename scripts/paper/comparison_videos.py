"""Videos of Table II's five grounds, all methods one above the other, in the reading that fits the table best.

The gains of the comparison methods are those that settle (docs/reproduction.md).

python -m scripts.paper.comparison_videos --folder out/videos --steps 12
"""

from pathlib import Path

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from mjbiped.rendering.overlay import Overlay, Pixels
from mjbiped.rendering.video import encoder, render_frame
from mjbiped.studies.reproduction.cell import SAMPLED, cell
from mjbiped.studies.reproduction.reproduce import TABLE
from mjbiped.studies.reproduction.results import Results, read_rows
from mjbiped.studies.reproduction.section_5 import GROUNDS, SETTLED, Variant, settled, terrain_of
from mjbiped.utils.files import written_whole

WIDTH, HEIGHT = 720, 180
HELD = 1.0  # s, the last frame


def walks_of(results: Results, ground: str, engine: str, steps: int) -> dict[str, mjbiped.Walk]:
    """A walk of each method on a ground."""
    terrain = terrain_of(next(place for place in results.best.places if place.ground == ground))
    chosen = [Variant("adaptive", results.best.delay), *(settled(name, results.sources[0]) for name in SETTLED)]
    return {each.method: cell(terrain, each.law(terrain), steps=steps, engine=engine).walk(SAMPLED) for each in chosen}


def stacked(walks: dict[str, mjbiped.Walk], fps: int) -> list[Pixels]:
    """Frames of all walks one above the other; who has ended waits in his last posture."""
    last = max(walk.end[0] for walk in walks.values()) + HELD
    times = np.arange(0.0, last, 1.0 / fps)
    strips = []
    for name, walk in walks.items():
        strip = render_frame(walk, np.minimum(times, walk.end[0]), width=WIDTH, height=HEIGHT, hide="caption,chart")
        captions = [name if time < walk.end[0] else f"{name}: {walk.outcome}, {walk.steps} steps" for time in times]
        for frame, text in zip(strip, captions, strict=True):
            Overlay(frame, HEIGHT).legend((), headline=text)
        strips.append(strip)
    return [np.concatenate(frames) for frames in zip(*strips, strict=True)]


@click.command(help=__doc__)
@click.option("--table", default=f"docs/{TABLE}", type=click.Path(exists=True, path_type=Path), help="Of walks.")
@click.option("--folder", default="out/videos", show_default=True, type=click.Path(file_okay=False, path_type=Path))
@click.option("--steps", default=12, show_default=True, type=click.IntRange(min=1), help="Steps per walk.")
@click.option("--engine", type=click.Choice(("mujoco", "hybrid")), default="mujoco", show_default=True)
@click.option("--fps", default=25, show_default=True, type=click.IntRange(1, 60))
def main(table: Path, folder: Path, steps: int, engine: str, fps: int) -> None:
    """Walk and render."""
    folder.mkdir(parents=True, exist_ok=True)
    results = Results(read_rows(table.read_text(encoding="utf-8")))
    for ground in tqdm(GROUNDS, desc="grounds", disable=None):
        frames = stacked(walks_of(results, ground, engine, steps), fps)
        path, (height, width, _) = folder / f"{ground.replace(' ', '_')}.mp4", frames[0].shape
        with written_whole(path) as unfinished, encoder(unfinished, width, height, fps) as add:
            for frame in frames:
                add(frame)


if __name__ == "__main__":
    main()
