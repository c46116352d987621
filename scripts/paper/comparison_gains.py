"""Gains of the comparison controllers, found the same way for each, and how they then fare (6 minutes).

Writes the tables of docs/tables/comparison.md and the figure of docs/comparison.md, which explains the procedure:
python -m scripts.paper.comparison_gains
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller
from mjbiped.controllers.comparison.known_slope import SLOPE_SOURCES, KnownSlopeController
from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLACK, BLUE, C_MT, GUIDE, ORANGE, VERMILLION, drawn
from scripts.pages import show_table
from scripts.paper.gain_search import (
    BLIND,
    CHEAPNESS,
    GAIT,
    LEVEL,
    METHODS,
    ROBOT,
    SMALL_STEP,
    WALK,
    Trial,
    blind_trials,
    choose,
    trial,
    walk,
)

TIGHT = mjbiped.Hybrid(tolerance=1e-10)
"""A hundredth of the usual tolerance: what it changes is not converged."""

TOLERANCES = tuple(base * factor for base in (1e-8, 1e-10) for factor in (1.0, 1.1, 1.2, 1.3, 1.4))
"""Of the walks that a cell stands for: a law near its limit ends in some of them only, and on another processor in
others."""

TERRAINS = {
    "level": LEVEL,
    "stair 1, −6 mm": mjbiped.Terrain.stairs(tread=1.8, rise=-0.006),
    "stair 2, −60 mm": mjbiped.Terrain.stairs(tread=1.8, rise=-0.06),
    "slope 1, +0.3° each": mjbiped.Terrain.slopes(length=1.5, change_deg=0.3),
    "slope 1, 0°/+0.3°": mjbiped.Terrain.from_segments([(1.5, 0.3 * (k % 2), 0.0) for k in range(24)]),
    "slope 2, −1° each": mjbiped.Terrain.slopes(length=1.5, change_deg=-1.0),
    "slope 2, 0°/−1°": mjbiped.Terrain.from_segments([(1.5, -1.0 * (k % 2), 0.0) for k in range(24)]),
}
"""Of the paper's section V; it does not say whether the changes of slope add up or alternate, so both."""


@click.command(help=__doc__)
@click.option(
    "--figure", default="docs/images/comparison_gains.png", show_default=True, type=click.Path(path_type=Path)
)
@click.option("--tables", default="docs/tables/comparison", show_default=True, type=click.Path(path_type=Path))
def main(figure: Path, tables: Path) -> None:
    """Search, walk, draw and tabulate."""
    trials = {
        name: [
            trial(replace(method.controller, **gains), gains) for gains in tqdm(method.grid, desc=name, disable=None)
        ]
        for name, method in METHODS.items()
    }
    found = {name: choose(each) for name, each in trials.items()}
    rows = [found_row(name, found[name], trials[name]) for name in METHODS]
    headings = ("method", "gains found", "class's defaults", "settles for", "c_mt", "multiplier", "peak torque (N m)")
    show_table("gains", headings, rows, tables, "gains")
    blind = [(name, *blind_row(blind_trials(name))) for name in tqdm(BLIND, desc="one slope source", disable=None)]
    show_table("blind", ("method", "gains found", "c_mt", "multiplier", "peak torque (N m)"), blind, tables, "blind")
    walked = outcomes(found)
    show_table("terrains", ("method", "slope from", *TERRAINS), walked, tables, "terrains")
    ranges = surviving(trials, found)
    show_table(
        "ranges", ("method", *TERRAINS), [(name, *map(span, each)) for name, each in ranges.items()], tables, "ranges"
    )
    draw(trials, found, ranges, figure)
    click.echo(f"wrote {figure}\nwrote {tables}")


def blind_row(trials: Sequence[Trial]) -> tuple[str, ...]:
    """What the search finds among them."""
    found = choose(trials)
    return in_words(found.gains), *found_numbers(found)


def survives(controller: Controller, terrain: mjbiped.Terrain) -> bool:
    """Whether a walk comes to its end, with the usual tolerance and a tighter one."""
    return all(walk(controller, terrain, engine=engine).outcome == "finished" for engine in ("hybrid", TIGHT))


def converged(controller: Controller, terrain: mjbiped.Terrain) -> str:
    """c_mt and peak torque, or the step that a walk ends in, as far as they do not depend on tolerance and engine."""
    engines: tuple[mjbiped.Engine | str, ...] = (*map(mjbiped.Hybrid, TOLERANCES), "mujoco")
    walks = [walk(controller, terrain, engine=engine) for engine in engines]
    fell = [each for each in walks if each.outcome != "finished"]
    if not fell:
        return f"{walks[0].cost_of_transport:.4f}, {walks[0].peak_torque.max():.1f}"
    if len(fell) < len(walks):
        return "undecided"
    ends = {(each.outcome, each.steps) for each in fell}
    return f"✗ {fell[0].outcome} at {fell[0].steps}" if len(ends) == 1 else "✗"


def in_words(gains: Mapping[str, Any]) -> str:
    """Gains in words."""
    return ", ".join(f"{name} {value:g}" for name, value in gains.items())


def found_row(name: str, found: Trial, trials: Sequence[Trial]) -> tuple[str, ...]:
    """What the search found for a method."""
    controller = METHODS[name].controller
    defaults = {key: getattr(controller, key) for key in found.gains}
    alike = [each for each in trials if each.gains.get("ratio") == found.gains.get("ratio")]
    key = "position_gain" if "position_gain" in found.gains else "gain"
    settled = [each.gains[key] for each in alike if each.settles]
    span = f"{key} {min(settled):g} to {max(settled):g}"
    return name, in_words(found.gains), in_words(defaults), span, *found_numbers(found)


def found_numbers(found: Trial) -> tuple[str, ...]:
    """Cost, multiplier and torque of the gains found."""
    return f"{found.cost:.4f}", f"{found.multiplier:.2f}", f"{found.peak:.1f}"


def outcomes(found: Mapping[str, Trial]) -> list[tuple[str, ...]]:
    """c_mt and peak torque on the paper's terrains with the classes' defaults, by method and source of the slope."""
    adaptive = AdaptiveController(ROBOT, GAIT)
    cases: list[tuple[str, str, Controller]] = [
        (name, source, replace(METHODS[name].controller, slope_source=source))
        for name in found
        for source in SLOPE_SOURCES[::-1]
    ]
    cases.append(("adaptive", "its estimate", adaptive))
    rows = []
    for name, source, controller in tqdm(cases, desc="terrains", disable=None):
        usual = isinstance(controller, KnownSlopeController) and source == METHODS[name].controller.slope_source
        cells = (converged(controller, terrain) for terrain in TERRAINS.values())
        rows.append((name, f"{source} *" if usual else source, *cells))
    return rows


Ranges = dict[str, list[list[tuple[float, bool]]]]
"""By method, by terrain: gains along the figure's axis, and whether the walk was finished."""


def surviving(trials: Mapping[str, Sequence[Trial]], found: Mapping[str, Trial]) -> Ranges:
    """Which gains finish the walk on each terrain; the energy constraint's ratio as in its class."""
    ranges: Ranges = {}
    for name, method in METHODS.items():
        grid = [each.gains for each in trials[name] if each.gains.get("ratio") == found[name].gains.get("ratio")]
        ranges[name] = [
            [(along(gains), survives(replace(method.controller, **gains), terrain)) for gains in grid]
            for terrain in tqdm(TERRAINS.values(), desc=f"{name}, ranges", disable=None)
        ]
    return ranges


def along(gains: Mapping[str, Any]) -> float:
    """A set of gains as a place on the figure's axis."""
    return float(gains["rate_gain"] / 2.0 if "rate_gain" in gains else gains["gain"])


def span(gains: Sequence[tuple[float, bool]]) -> str:
    """The stretches of gains that finished, in words."""
    stretches: list[list[float]] = []
    before = False
    for gain, finished in gains:
        if finished and before:
            stretches[-1][1] = gain
        elif finished:
            stretches.append([gain, gain])
        before = finished
    return ", ".join(f"{low:g}" if low == high else f"{low:g}–{high:g}" for low, high in stretches) or "none"


def draw(trials: Mapping[str, Sequence[Trial]], found: Mapping[str, Trial], ranges: Ranges, path: Path) -> None:
    """Return, torque and survival over the gains."""
    with drawn(path) as figure:
        figure.set_figheight(7.8)
        (back, torque), (plane, survival) = figure.subplots(2, 2)
        for name, method in METHODS.items():
            ratio = found[name].gains.get("ratio")
            line = [each for each in trials[name] if each.gains.get("ratio") == ratio and math.isfinite(each.peak)]
            gains = np.array([along(each.gains) for each in line])
            chosen_ratio = "" if ratio is None else f", μ = {ratio:g}".replace("-", "−")
            label = f"{method.words} ({method.axis}{chosen_ratio})"
            look: dict[str, Any] = {"color": method.color, "linestyle": method.style}
            fell = np.array([not each.survived for each in line])
            for axes, values in (
                (back, np.array([each.multiplier for each in line])),
                (torque, np.array([each.peak for each in line])),
            ):
                axes.plot(gains, values, label=label, **look)
                axes.plot(gains[fell], values[fell], "x", color=method.color, markersize=5)
                chosen = found[name]
                axes.plot(
                    along(chosen.gains),
                    chosen.multiplier if axes is back else chosen.peak,
                    "*",
                    color=method.color,
                    markersize=10,
                )
        back.axhline(1.0, color=GUIDE, linewidth=1.0)
        back.set(xscale="log", xlabel="gain", ylabel="slowest multiplier", ylim=(0.0, 1.2))
        back.set_title("(a) Return to the gait; above 1 no walk of period one")
        torque.set(xscale="log", yscale="log", xlabel="gain", ylabel="peak torque (N m)")
        torque.set_title(f"(b) Over one step of ±{1e3 * SMALL_STEP:g} mm")
        torque.legend(
            handles=[
                Line2D([], [], color=BLACK, marker="*", linestyle="none", markersize=9, label="found"),
                Line2D([], [], color=BLACK, marker="x", linestyle="none", label="falls over a small step"),
            ],
            loc="upper left",
        )
        _draw_plane(plane, trials["ECC"], found["ECC"])
        _draw_survival(survival, ranges)
        legend_below(figure, *back.get_legend_handles_labels())


def _draw_plane(axes: Axes, trials: Sequence[Trial], found: Trial) -> None:
    """Both gains of the energy constraint."""
    negative = [each for each in trials if each.gains["ratio"] < 0.0]
    settled = [each for each in negative if each.settles]
    dear = [each for each in negative if each.survived and each.multiplier < 1.0 and not each.settles]
    restless = [each for each in negative if each.survived and not each.multiplier < 1.0]
    fallen = [each for each in negative if not each.survived]
    for some, marker, color, label in (
        (settled, "o", BLUE, f"settles, |{C_MT} − sin φ_r| ≤ {CHEAPNESS:g}"),
        (dear, "s", ORANGE, f"settles, {C_MT} further off"),
        (restless, "^", VERMILLION, "walks, does not settle"),
        (fallen, "x", GUIDE, "falls"),
    ):
        places = [[each.gains[key] for each in some] for key in ("ratio", "gain")]
        axes.plot(*places, marker, color=color, markersize=4, linestyle="none", label=label)
    axes.plot(found.gains["ratio"], found.gains["gain"], "k*", markersize=10)
    axes.set(yscale="log", xlabel="μ = ankle over hip torque", ylabel="ζ (1/s)", ylim=(None, 3e3))
    titled(axes, "c", "Energy constraint; every positive μ tried falls on the level")
    axes.legend(loc="upper right", ncols=2, fontsize=7, framealpha=1.0)


def _draw_survival(axes: Axes, ranges: Ranges) -> None:
    """Which gains finish 60 steps, method by method on each terrain."""
    for row in range(len(TERRAINS)):
        for place, (name, method) in enumerate(METHODS.items()):
            height = -row + 0.3 - 0.15 * place
            for finished, marker in ((True, "o"), (False, "x")):
                gains = [gain for gain, fine in ranges[name][row] if fine is finished]
                axes.plot(
                    gains,
                    [height] * len(gains),
                    marker,
                    color=method.color if finished else GUIDE,
                    markersize=3.5 if finished else 3.0,
                    linestyle="none",
                )
    axes.set_yticks([-row for row in range(len(TERRAINS))], list(TERRAINS))
    axes.set(xscale="log", xlabel="gain")
    titled(axes, "d", f"{WALK} steps finished: dots; rows from above as in the legend")


if __name__ == "__main__":
    main()
