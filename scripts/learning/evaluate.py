"""Lay the trained policies beside the adaptive controller on ground that they have not seen.

    python -m scripts.learning.evaluate

Tables on the screen; in OUT all walks as evaluation.csv, the curves of the training as curves.png and a walk of each
policy as a video.
"""

from __future__ import annotations

import csv
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.table import Table

import mjbiped
from controllers import Controller
from mjbiped.errors import InputError
from mjbiped.plotting.style import make_small
from mjbiped.records.record import Walk
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.commands import FOLDER, Command
from scripts.learning.controller import LearnedController
from scripts.learning.curve import plot_curves
from scripts.learning.evaluation import GROUNDS, STEPS, Interval, Results, intervals, try_out
from scripts.learning.policy import Array
from scripts.pages import write_table

POLICIES = ("residual", "free")
SHOWN = 10.0
"""Of a walk in its video, s."""
SMALL_SHOWN = 4.0
"""The same of the last policy's on the page, s."""
SMALL: Mapping[str, Any] = {"width": 640, "height": 360, "fps": 12, "hide": ("chart", "labels")}

WALKING: Mapping[str, tuple[str, int]] = {
    "return": ("return", 0),
    "steps": (f"steps, at most {STEPS}", 1),
    "finished": (f"share with {STEPS}", 2),
    "speed": ("speed, m/s", 3),
    "cost": ("c_mt", 4),
    "cost less adaptive": ("c_mt less adaptive's", 4),
}
TORQUES: Mapping[str, tuple[str, int]] = {
    "peak ankle": ("peak, ankle", 2),
    "peak hip": ("peak, hip", 2),
    "rms ankle": ("RMS, ankle", 2),
    "rms hip": ("RMS, hip", 2),
}
"""Measures of the tables: headings, and digits after the point."""


@dataclass(frozen=True)
class _Entrant:
    """Who walks."""

    name: str
    controller: Controller
    weights: Array | None
    residual: bool


@click.command(cls=Command, help=__doc__)
@FOLDER
@click.option(
    "--page",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Markdown page to write the tables into; figures go into the folder images beside it.",
)
def main(out: Path, page: Path | None) -> None:
    """Walk, and show what came of it."""
    trainings = {name: Checkpoint.load(out / f"{name}.npz") for name in POLICIES if (out / f"{name}.npz").exists()}
    if not trainings:
        raise InputError(f"there is no policy in {out}; train one: python -m scripts.learning.train --task residual")
    adaptive = GROUNDS[0].residual.controller.base
    entrants = [_Entrant("adaptive", adaptive, None, True)]
    for name, training in trainings.items():
        controller = LearnedController(str(out / f"{name}.npz"))
        entrants.append(_Entrant(name, controller, training.weights, training.residual))

    results, shown = _walked(entrants, out / "evaluation.csv")
    console = Console(width=max(160, Console().width))
    for title, measures in (("walking", WALKING), ("torques, N m", TORQUES)):
        table = Table(title=title)
        headings, rows = _table(results, measures)
        for heading in headings:
            table.add_column(heading)
        for row in rows:
            table.add_row(*row)
        console.print(table)
        if page is not None:
            write_table(page, title.partition(",")[0], headings, rows)
    curves = out / "curves.png"
    plot_curves(trainings, float(results[0].returns.mean()), curves)
    for name, walk in shown.items():
        mjbiped.render_video(walk, out / f"{name}.mp4", stop=min(SHOWN, walk.end[0]), progress=True)
        click.echo(f"wrote {out / name}.mp4")
    click.echo(f"wrote {curves} and {out / 'evaluation.csv'}")
    if page is not None:
        images = page.parent / "images"
        shutil.copy(curves, images / "learning.png")
        make_small(images / "learning.png")
        name, walk = list(shown.items())[-1]
        mjbiped.render_video(walk, images / "learning.gif", **SMALL, stop=min(SMALL_SHOWN, walk.end[0]))


def _walked(entrants: Sequence[_Entrant], file: Path) -> tuple[list[Results], dict[str, Walk]]:
    """All walks of all, written as they come; and one of each policy on random ground."""
    results, shown = [], {}
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer: csv.DictWriter[str] | None = None
        for ground in GROUNDS:
            for entrant in entrants:
                click.echo(f"{entrant.name}, {ground.name}: {ground.walks} walks", err=True)
                found, walks = try_out(ground, entrant.name, entrant.controller, entrant.weights, entrant.residual)
                results.append(found)
                if ground is GROUNDS[0] and entrant.weights is not None:
                    shown[entrant.name] = walks[0]
                for row in found.rows():
                    if writer is None:
                        writer = csv.DictWriter(stream, list(row))
                        writer.writeheader()
                    writer.writerow(row)
                stream.flush()
    return results, shown


def _table(results: Sequence[Results], measures: Mapping[str, tuple[str, int]]) -> tuple[list[str], list[list[str]]]:
    """Headings and rows."""
    rows, adaptive = [], {found.ground: found for found in results if found.controller == "adaptive"}
    for found in results:
        values = intervals(found, adaptive[found.ground])
        cells = [in_words(values[name], digits) for name, (_, digits) in measures.items()]
        if found is adaptive[found.ground] and "cost less adaptive" in measures:
            cells[list(measures).index("cost less adaptive")] = ""
        rows.append([found.ground, found.controller, *cells])
    return ["ground", "controller", *(heading for heading, _ in measures.values())], rows


def in_words(values: Interval, digits: int) -> str:
    """A mean and its interval."""
    mean, low, high = (f"{value:.{digits}f}".replace("-", "−") for value in values)
    if np.isnan(values[0]):
        return "–"
    return mean if low == high or np.isnan(values[1]) else f"{mean} ({low} to {high})"


if __name__ == "__main__":
    main()
