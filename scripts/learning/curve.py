"""The figure of a training: returns over practice."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLUE, SHADE, drawn
from mjbiped.utils.palette import SKY
from scripts.learning.checkpoint import Checkpoint


def plot_curves(trainings: Mapping[str, Checkpoint], adaptive: float, path: Path | None = None) -> Figure:
    """Draw each generation's return over the practice so far: of the distribution's mean, and the population's spread.

    Each panel has a scale of its own: a residual policy begins near its end.

    Args:
        trainings: By the policies' names.
        adaptive: Return of the adaptive controller.
        path: File to write as well.
    """
    with drawn(path) as figure:
        figure.set_figheight(3.6)
        panels: Any = figure.subplots(1, len(trainings), squeeze=False)[0]
        for letter, axes, (name, training) in zip("abcdef", panels, trainings.items(), strict=False):
            walked = training.steps / 1e6
            policies = training.returns.mean(axis=2)
            low, middle, high = np.percentile(policies, (10, 50, 90), axis=1)
            axes.fill_between(walked, low, high, color=SKY, alpha=0.35, linewidth=0, label="population, 10 to 90 %")
            axes.plot(walked, middle, color=SKY, label="population, median")
            axes.plot(walked, training.mean_returns.mean(axis=1), color=BLUE, label="policy (mean of the distribution)")
            axes.axhline(adaptive, color=SHADE, linestyle=(0, (3, 1.5)), label="adaptive controller, unseen ground")
            axes.set(xlabel="control periods walked, million", xlim=(0.0, walked[-1]))
            titled(axes, letter, f"{name} policy")
        panels[0].set_ylabel("return of an episode of 20 s")
        legend_below(figure, panels[0].get_legend_handles_labels()[0])
    return figure
