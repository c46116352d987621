"""The command `mjbiped figures`: the figures of all subjects, by the commands that draw each of them."""

from __future__ import annotations

import shlex
import time
from pathlib import Path

import click

from mjbiped.cli import kinds, options, sections
from mjbiped.cli.ending import INTERRUPTED
from mjbiped.cli.files import Results
from mjbiped.cli.sections import results
from mjbiped.utils.progress import progress_bar

SET = {
    "gait": "gait --slope-deg 2",
    "gait_knees": "gait --robot kneed --slope-deg 2.5",
    "gait_wheel": "gait --robot wheel --slope-deg 5",
    "reference": "reference --clearance 0.06",
    "return_map": "return-map --slope-deg 3.2 --steps 100",
    "return_map_knees": "return-map --robot kneed --slope-deg 6 --steps 100",
    "bifurcation": "bifurcation --slopes 400 --plot-multipliers {folder}/multipliers.pdf",
    "bifurcation_knees": "bifurcation --robot kneed --slopes 400 --plot-multipliers {folder}/multipliers_knees.pdf",
    "basin": "basin --slope-deg 2 --grid 150",
    "basin_knees": "basin --robot kneed --slope-deg 2.5 --grid 100",
    "basin_controlled": "basin --controller adaptive --grid 40",
    "walk": "walk mixed --initial rest --out {folder}/walk.npz",
    "walk_knees": "walk stairs:rise=0.04 --robot kneed --engine hybrid --steps 20",
    "comparison": "compare mixed --steps 18",
    "stability": "stability {folder}/walk.npz",
}
"""Commands by the names of the figures that they draw; each is given its `--plot`."""


@click.command("figures", cls=sections.SectionCommand)
@click.argument("folder", type=kinds.FOLDER)
@results(options.WIDTH, *options.PRINTED)
def figures(folder: Path, results: Results) -> None:
    """Draw the whole set of figures into FOLDER, as PDF for slides and papers.

    Gaits, return maps, bifurcations, basins, walks, both engines compared, and Theorem 1, with straight legs and with
    knees. Each is what another command draws; the summary tells that command, to draw it again otherwise. It takes some
    minutes.

    \b
    Examples:
      mjbiped figures slides
      mjbiped figures paper --plot-width single
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.cli.main import main  # which imports this command by its name

    folder.mkdir(parents=True, exist_ok=True)
    shared = ("--plot-width", results.plot_width, "--quiet")
    done: list[dict[str, str | float]] = []
    with progress_bar(total=len(SET), desc="figures", progress=not results.quiet) as bar:
        for name, command in SET.items():
            bar.set_postfix_str(name, refresh=False)
            told = [word.format(folder=folder) for word in command.split()] + ["--plot", str(folder / f"{name}.pdf")]
            began = time.perf_counter()
            status = main.main([*told, *shared], standalone_mode=False)  # which says what is wrong
            if status == INTERRUPTED:
                results.fail(INTERRUPTED, f"interrupted in mjbiped {told[0]}; the figures before it are written")
                break
            if status:
                results.fail(status, f"mjbiped {told[0]} failed")
            else:
                results.written |= {Path(word).name: word for word in told if word.startswith(f"{folder}/")}
                done.append({"command": f"mjbiped {shlex.join(told)}", "seconds": time.perf_counter() - began})
            bar.update()
    results.end({"figures": done}, [f"{each['seconds']:6.1f} s  {each['command']}" for each in done])
