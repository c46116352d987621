"""The figure of the trainings: returns over generations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLUE, GREEN, ORANGE, SHADE, VERMILLION, drawn
from mjbiped.utils.palette import PURPLE
from scripts.learning.checkpoint import Checkpoint

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
