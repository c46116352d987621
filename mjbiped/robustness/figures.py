"""Pictures of a robustness study: survival curves, and the greatest disturbances survived over the cost of walking."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from mjbiped.plotting.panels import head, legend_below, plain, titled, wrapped
from mjbiped.plotting.style import BLACK, BLUE, C_MT, GREEN, GUIDE, ORANGE, SHADE, VERMILLION, drawn
from mjbiped.robustness.limits import DISTURBANCES
from mjbiped.robustness.result import Findings, Robustness
from mjbiped.robustness.tables import scuffing_words

_LOOKS = (
    (BLACK, "o", "-"),
    (BLUE, "s", (0, (5, 1.2))),
    (ORANGE, "^", (0, (2, 1))),
    (GREEN, "D", (0, (4, 1, 1, 1))),
    (VERMILLION, "v", (0, (1, 1))),
    (SHADE, "P", (0, (6, 1, 1, 1, 1, 1))),
)
"""Of controllers, in their order: colour, mark and line, which tell them apart each by itself."""

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
        if robustness.plan.grounds:
            path = folder / f"survival{suffix}.png"
            plot_survival(robustness, engine, path)
            yield path
        if robustness.plan.disturbances:
            path = folder / f"limits{suffix}.png"
            plot_limits(robustness, engine, path)
            yield path


def plot_survival(robustness: Robustness, engine: str, path: Path | None = None) -> Any:
    """Draw, for each random ground, the share of walks that go on against the steps made, with 95 % bands."""
    grounds, findings = robustness.plan.grounds, robustness.of(engine)
    with drawn(path) as figure:
        text = wrapped(f"{robustness.plan.seeds} grounds of each kind, {engine} engine; {scuffing_words(robustness)}")
        figure.set_figheight(0.6 + 2.6 * len(grounds) + head(figure, text))
        panels = figure.subplots(len(grounds), 1, squeeze=False)[:, 0]
        for number, (axes, ground) in enumerate(zip(panels, grounds, strict=True)):
            for look, each in zip(_looks(findings), findings, strict=True):
                if ground in each.survival:
                    _draw_curve(axes, each, ground, look)
            titled(axes, chr(ord("a") + number), plain(ground))
            axes.set_xscale("symlog", linthresh=10.0)
            axes.set_xlim(0.0, robustness.plan.steps)
            axes.xaxis.set_major_formatter(ScalarFormatter())
            axes.set_ylim(0.0, 1.03)
            axes.set_ylabel("share still walking")
            axes.grid(color=GUIDE, alpha=0.3)
        panels[-1].set_xlabel("steps")
        legend_below(figure, *panels[0].get_legend_handles_labels())
    return figure


def _draw_curve(axes: Axes, each: Findings, ground: str, look: tuple[Any, str, Any]) -> None:
    colour, _, line = look
    steps, share, low, high = each.survival[ground].curve()
    mean = each.survival[ground].mean
    words = "no fall" if math.isinf(mean) else f"{mean:.3g} steps to a fall"
    label = each.controller if len(each.survival) > 1 else f"{each.controller}: {words}"
    axes.step(steps, share, where="post", color=colour, linestyle=line, label=plain(label))
    axes.fill_between(steps, low, high, step="post", color=colour, alpha=0.15, linewidth=0.0)


def plot_limits(robustness: Robustness, engine: str, path: Path | None = None) -> Any:
    """Draw the greatest disturbances that each controller survives, each over its cost of transport on level ground."""
    findings, tests = robustness.of(engine), robustness.plan.disturbances
    with drawn(path) as figure:
        condition = f"at {robustness.plan.share:.0%} of {robustness.plan.phases} phases of the step"
        if robustness.plan.torque is not None:
            condition += f", within {robustness.plan.torque:g} N m"
        text = wrapped(f"Greatest survived {condition}, {engine} engine; {scuffing_words(robustness)}")
        rows = math.ceil(len(tests) / 2)
        figure.set_figheight(0.8 + 2.6 * rows + head(figure, text))
        panels = figure.subplots(rows, min(2, len(tests)), squeeze=False, sharex=True).ravel()
        for axes in panels[len(tests) :]:
            axes.remove()
        for number, (axes, test) in enumerate(zip(panels, tests, strict=False)):
            for (colour, mark, _), each in zip(_looks(findings), findings, strict=True):
                limit = each.limits[test]
                if not limit.magnitudes or math.isnan(each.level_cost):
                    continue
                axes.plot(
                    each.level_cost,
                    limit.greatest,
                    mark,
                    color=colour,
                    markersize=7,
                    markerfacecolor=colour if limit.reached else "none",
                    linestyle="none",
                    label=plain(each.controller),
                )
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
    """Ends of the axis of costs: rounding is no difference between controllers."""
    costs = [each.level_cost for each in findings if not math.isnan(each.level_cost)] or [0.0]
    middle, half = (min(costs) + max(costs)) / 2.0, (max(costs) - min(costs)) / 2.0
    half = max(1.2 * half, _LEAST_SPAN / 2.0)
    return max(0.0, middle - half), middle + half


def _looks(findings: list[Findings]) -> list[tuple[Any, str, Any]]:
    return [_LOOKS[number % len(_LOOKS)] for number in range(len(findings))]
