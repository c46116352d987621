"""Pictures of a robustness study: survival curves, and the greatest disturbances survived over the cost of walking."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from matplotlib.ticker import MaxNLocator

from mjbiped.plotting.panels import head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import C_MT, GUIDE, drawn, told_apart
from mjbiped.plotting.survival import draw_curve, lay_axes
from mjbiped.robustness.limits import DISTURBANCES
from mjbiped.robustness.result import Findings, Robustness
from mjbiped.robustness.tables import conditions, scuffing_words

_LEAST_SPAN = 0.02  # of the axis of costs of transport


def draw(robustness: Robustness, folder: Path) -> Iterator[Path]:
    """Draw all figures of a study, one of each kind for each engine.

    Yields:
        Their files.

    Raises:
        RenderError: One cannot be written.
    """
    several = len(robustness.plan.engines) > 1
    for engine in robustness.plan.engines:
        suffix = f"_{engine}" if several else ""
        kinds = (plot_survival, robustness.plan.grounds), (plot_limits, robustness.plan.limits.magnitudes)
        for plot, shown in kinds:
            if shown:
                path = folder / f"{plot.__name__.removeprefix('plot_')}{suffix}.png"
                plot(robustness, engine, path)
                yield path


def plot_survival(robustness: Robustness, engine: str, path: Path | None = None) -> Any:
    """Draw, for each random ground, the share of walks that go on against the steps made, with 95 % bands."""
    grounds, findings = robustness.plan.grounds, robustness.of(engine)
    with drawn(path) as figure:
        text = wrapped(f"{robustness.plan.seeds} grounds of each kind, {engine} engine; {scuffing_words(robustness)}")
        figure.set_figheight(0.6 + 2.6 * len(grounds) + head(figure, text))
        panels = figure.subplots(len(grounds), 1, squeeze=False)[:, 0]
        for number, (axes, ground) in enumerate(zip(panels, grounds, strict=True)):
            for place, each in enumerate(findings):
                survival = robustness.survival(engine, each["controller"], ground)
                if survival is not None:
                    draw_curve(axes, survival, each["controller"], told_apart(place))
            titled(axes, chr(ord("a") + number), plain(ground))
            lay_axes(axes, robustness.plan.steps)
        panels[-1].set_xlabel("steps (logarithmic)")
        legend_below(figure, *panels[0].get_legend_handles_labels())
    return figure


def plot_limits(robustness: Robustness, engine: str, path: Path | None = None) -> Any:
    """Draw the greatest disturbances that each controller survives, each over its cost of transport on level ground."""
    findings, tests = robustness.of(engine), robustness.plan.limits.magnitudes
    with drawn(path) as figure:
        text = wrapped(
            f"{engine} engine; {conditions(robustness)} (open: all that were tried); {scuffing_words(robustness)}"
        )
        rows = math.ceil(len(tests) / 2)
        figure.set_figheight(0.8 + 2.6 * rows + head(figure, text))
        panels = figure.subplots(rows, min(2, len(tests)), squeeze=False, sharex=True).ravel()
        for axes in panels[len(tests) :]:
            axes.remove()
        for number, (axes, test) in enumerate(zip(panels, tests, strict=False)):
            for place, each in enumerate(findings):
                (colour, mark, _), limit = told_apart(place), each["greatest_survived"][test]
                fill = "none" if limit["beyond_what_was_tried"] else colour
                cost, height = each["level"]["cost_of_transport"], limit["magnitude"] or 0.0
                shape = {"color": colour, "markersize": 7, "markerfacecolor": fill}
                axes.plot(cost, height, mark, label=plain(each["controller"]), **shape)
            titled(axes, chr(ord("a") + number), test)
            axes.set_ylim(bottom=0.0)
            axes.set_ylabel({"m": "height (m)", "deg": "change (deg)"}[DISTURBANCES[test].unit])
            axes.xaxis.set_major_locator(MaxNLocator(3))
            axes.set_xlim(*_costs(findings))
            axes.margins(y=0.15)
            axes.grid(color=GUIDE, alpha=0.3)
        for axes in panels[: len(tests)][-min(2, len(tests)) :]:
            axes.set_xlabel(f"{C_MT} on level ground")
        legend_below(figure, *panels[0].get_legend_handles_labels())
    return figure


def _costs(findings: list[Findings]) -> tuple[float, float]:
    """Choose the ends of the axis of costs so wide that rounding does not look like a difference."""
    costs = [each["level"]["cost_of_transport"] for each in findings]
    costs = [cost for cost in costs if not math.isnan(cost)] or [0.0]
    middle, half = (min(costs) + max(costs)) / 2.0, (max(costs) - min(costs)) / 2.0
    half = max(1.2 * half, _LEAST_SPAN / 2.0)
    return max(0.0, middle - half), middle + half
