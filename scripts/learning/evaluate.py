"""Lay trained policies beside the adaptive controller on ground that they have not seen.

    python -m scripts.learning.evaluate
    python -m scripts.learning.evaluate --policies out/learning

Tables on the screen; in OUT all walks as evaluation.csv, the curves of the trainings as curves.png and a walk of each
kind of policy as a video.
"""

from __future__ import annotations

import csv
import shutil
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

import mjbiped
from mjbiped.errors import InputError
from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLUE, GREEN, ORANGE, SHADE, VERMILLION, drawn, make_small
from mjbiped.records.record import Walk
from mjbiped.utils.palette import PURPLE
from scripts.learning.checkpoint import LAST, Checkpoint
from scripts.learning.commands import OUT, Command
from scripts.learning.evaluation import GROUNDS, TIME, Interval, Results, adaptive_on, by_training, interval, try_out
from scripts.pages import show_table

LOOKS = ((BLUE, "-"), (ORANGE, (0, (4, 1))), (GREEN, (0, (1.5, 1))), (VERMILLION, "-."), (PURPLE, (0, (7, 1.5))))
"""Of the seeds' lines, from the first on: colour and style."""


def plot_curves(trainings: Mapping[str, Sequence[Checkpoint]], adaptive: float, path: Path | None = None) -> Figure:
    """Draw the return of each training's policy, the mean of CMA-ES's distribution, over the generations.

    Each panel has a scale of its own: a residual policy begins near its end.

    Args:
        trainings: By the policies' kind.
        adaptive: Return of the adaptive controller on unseen ground of the same sort.
        path: File to write as well.
    """
    with drawn(path) as figure:
        figure.set_figheight(3.6)
        panels: Any = figure.subplots(1, len(trainings), squeeze=False)[0]
        for letter, axes, (kind, seeds) in zip("ab", panels, trainings.items(), strict=False):
            axes.axhline(adaptive, color=SHADE, linewidth=1.0, label="adaptive controller")
            for index, training in enumerate(seeds):
                colour, style = LOOKS[index % len(LOOKS)]
                returns = training.mean_returns.mean(axis=1)
                axes.plot(
                    range(1, len(returns) + 1), returns, color=colour, linestyle=style, label=f"seed {training.seed}"
                )
            axes.set(xlabel="generation")
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            titled(axes, letter, f"{kind} policies")
        panels[0].set_ylabel("return of an episode of 20 s")
        legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure


Trainings = Mapping[str, Sequence[Checkpoint]]
"""By the policies' kind."""

KINDS = ("residual", "free")
STORED = Path(__file__).parent / "policies"
"""The policies of docs/environments.md."""
SHOWN = 10.0
"""Of a walk in its video, s."""
SMALL_SHOWN = 4.0
"""The same of the last policy's on the page, s."""
SMALL: Mapping[str, Any] = {"width": 544, "height": 306, "fps": 10, "hide": "chart"}

COMPARED: Mapping[str, Mapping[str, tuple[str, int]]] = {
    "returns": {"return": ("return", 0)},
    "through": {"through": ("share through", 2)},
    "costs": {"c_mt": ("c_mt", 4)},
}
TOLD: Mapping[str, Mapping[str, tuple[str, int]]] = {
    "through": {"steps": (f"steps in {TIME:.0f} s", 1)},
    "costs": {"speed": ("speed, m/s", 3)},
    "torques": {
        "peak ankle": ("peak, ankle", 2),
        "peak hip": ("peak, hip", 2),
        "rms ankle": ("RMS, ankle", 2),
        "rms hip": ("RMS, hip", 2),
    },
}
"""Measures by the table that they stand in, with heading and digits after the point. Those compared have the least and
greatest training and the difference from the adaptive controller beside them."""


@click.command(cls=Command, help=__doc__)
@click.option(
    "--policies",
    default=STORED,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the policies; by default those stored beside this program.",
)
@OUT
@click.option(
    "--page",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Markdown page to write the tables into.",
)
@click.option(
    "--images",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder for a small copy of the figure and a small video, as docs/environments.md shows them.",
)
def main(policies: Path, out: Path, page: Path | None, images: Path | None) -> None:
    """Walk, and show what came of it."""
    trainings = trained(policies)
    out.mkdir(parents=True, exist_ok=True)
    show_table("trainings", *training_table(trainings), page, "trainings")
    results, shown = _walked(trainings, out / "evaluation.csv")
    for name in ("returns", "through", "costs", "torques"):
        show_table(name, *results_table(results, name), page, name)
    curves = out / "curves.png"
    plot_curves(trainings, float(results[0].measures["return"].mean()), curves)
    for kind, walk in shown.items():
        mjbiped.render_video(walk, out / f"{kind}.mp4", stop=min(SHOWN, walk.end[0]), progress=True)
        click.echo(f"wrote {out / kind}.mp4")
    click.echo(f"wrote {curves} and {out / 'evaluation.csv'}")
    if images is not None:
        shutil.copy(curves, images / "learning.png")
        make_small(images / "learning.png")
        walk = list(shown.values())[-1]
        mjbiped.render_video(walk, images / "learning.gif", **SMALL, stop=min(SMALL_SHOWN, walk.end[0]))


def trained(folder: Path) -> Trainings:
    """The trainings in a folder, by kind and in the order of their seeds.

    Raises:
        InputError: There is none, or a file there is no policy, or is named after the other kind.
    """
    found = {
        kind: sorted(map(Checkpoint.load, folder.glob(f"{kind}-*.npz")), key=lambda training: training.seed)
        for kind in KINDS
    }
    if not any(found.values()):
        raise InputError(f"there is no policy in {folder}; train one: python -m scripts.learning.train --help")
    for kind, trainings in found.items():
        if any(training.residual != (kind == KINDS[0]) for training in trainings):
            raise InputError(
                f"a file {kind}-*.npz in {folder} holds a policy of the other kind; give it its own name again"
            )
    return {kind: trainings for kind, trainings in found.items() if trainings}


def _walked(trainings: Trainings, file: Path) -> tuple[list[Results], dict[str, Walk]]:
    """All walks of all, written as they come; and one of each kind on random ground."""
    results: list[Results] = []
    shown: dict[str, Walk] = {}
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer: csv.DictWriter[str] | None = None
        for ground in GROUNDS:
            entrants = [adaptive_on(ground)]
            for kind, of in trainings.items():
                click.echo(f"{kind}, {ground.name}: {len(of)} policies, {ground.walks} walks each", err=True)
                weights = np.array([training.weights for training in of])
                seeds = tuple(training.seed for training in of)
                found, walk = try_out(ground, kind, seeds, weights, of[0].residual)
                entrants.append(found)
                shown.setdefault(kind, walk)
            results += entrants
            for row in (row for found in entrants for row in found.rows()):
                if writer is None:
                    writer = csv.DictWriter(stream, list(row))
                    writer.writeheader()
                writer.writerow(row)
            stream.flush()
    return results, shown


def training_table(trainings: Trainings) -> tuple[list[str], list[list[str]]]:
    """Headings and rows of what the trainings took and came to."""
    headings = [
        "policy",
        "seed",
        "generations",
        "control periods walked, million",
        "processor time, s",
        f"return in the last {LAST}",
    ]
    rows = [
        [
            kind,
            f"{training.seed}",
            f"{training.generations}",
            f"{training.steps[-1] / 1e6:.2f}",
            f"{training.processor[-1]:.0f}",
            f"{training.last_return:.0f}",
        ]
        for kind, of in trainings.items()
        for training in of
    ]
    return headings, rows


def results_table(results: Sequence[Results], name: str) -> tuple[list[str], list[list[str]]]:
    """Headings and rows of one of the tables of `COMPARED` and `TOLD`."""
    compared, told = COMPARED.get(name, {}), TOLD.get(name, {})
    headings, rows = ["ground", "controller"], []
    for heading, _ in compared.values():
        headings += [heading, "least to greatest", "less adaptive's"]
    headings += [heading for heading, _ in told.values()]
    if name == "through":
        headings.append("ended early")
    for _, group in groupby(results, lambda found: found.ground):
        adaptive, *others = group
        for found in (adaptive, *others):
            cells = [found.ground, found.kind]
            for measure, (_, digits) in compared.items():
                cells += _compared(found, adaptive, measure, digits)
            cells += [in_words(interval(by_training(found, measure)), digits) for measure, (_, digits) in told.items()]
            rows.append([*cells, found.ends()] if name == "through" else cells)
    return headings, rows


def _compared(found: Results, adaptive: Results, measure: str, digits: int) -> Iterator[str]:
    """A measure's mean, its least and greatest training, and its difference, bold where its interval leaves out 0."""
    means = by_training(found, measure)
    yield in_words(interval(means), digits)
    if found is adaptive or not len(means):
        yield from ("", "")
        return
    yield f"{means.min():.{digits}f} to {means.max():.{digits}f}"
    difference = interval(by_training(found, measure, adaptive))
    told = in_words(difference, digits)
    yield f"**{told}**" if difference[1] > 0.0 or difference[2] < 0.0 else told


def in_words(values: Interval, digits: int) -> str:
    """A mean and its interval, in brackets where it is more than the mean's rounding."""
    mean, low, high = (f"{value:.{digits}f}".replace("-", "−") for value in values)
    if np.isnan(values[0]):
        return "–"
    return mean if low == high or np.isnan(values[1]) else f"{mean} ({low} to {high})"


if __name__ == "__main__":
    main()
