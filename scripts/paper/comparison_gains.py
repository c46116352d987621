"""Gains of the comparison controllers, found the same way for each, and how they then fare (6 minutes).

Writes the figure and the tables of docs/comparison.md, which explains the procedure:
python -m scripts.paper.comparison_gains
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from rich.console import Console
from rich.table import Table
from tqdm.auto import tqdm

import mjbiped
from controllers import (
    AdaptiveController,
    Controller,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassivityController,
)
from controllers.comparison.known_slope import SLOPE_SOURCES, KnownSlopeController
from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLACK, BLUE, C_MT, GREEN, GUIDE, ORANGE, VERMILLION, new_figure, save_figure, styled
from mjbiped.robots.compass import Array
from scripts.pages import write_table

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
GAINS = [0.3, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 200.0]
RATIOS = [-3.5, -3.0, -2.75, -2.5, -2.4, -2.3, -2.25, -2.2, -2.1, -2.0, -1.75, -1.5, -1.0, -0.5, -0.1]
RATIOS += [0.1, 0.5, 1.0, 2.0, 4.0, 10.0, 45.0, 100.0]
MAUVE = "#CC79A7"  # the last of Okabe and Ito's colours
POLES = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0]

SMALL_STEP = 0.006  # m, up and down
CHEAPNESS = 5e-4  # how far c_mt may be from sin(phi_r)
LEAST_DIFFERENCE = 1.0  # steps: returns that differ by less are alike
WALK = 60  # steps
TIGHT = mjbiped.Hybrid(tolerance=1e-10)
"""A hundredth of the usual tolerance: what it changes is not converged."""
LIKE_THE_LAST = 1e-3  # rad and rad/s: far above an unstable gait's growth from rounding, far below a gait of period two

TERRAINS = {
    "level": mjbiped.Terrain.level(),
    "stair 1, −6 mm": mjbiped.Terrain.stairs(tread=1.8, rise=-0.006),
    "stair 2, −60 mm": mjbiped.Terrain.stairs(tread=1.8, rise=-0.06),
    "slope 1, +0.3° each": mjbiped.Terrain.slopes(length=1.5, change_deg=0.3),
    "slope 1, 0°/+0.3°": mjbiped.Terrain.from_segments([(1.5, 0.3 * (k % 2), 0.0) for k in range(24)]),
    "slope 2, −1° each": mjbiped.Terrain.slopes(length=1.5, change_deg=-1.0),
    "slope 2, 0°/−1°": mjbiped.Terrain.from_segments([(1.5, -1.0 * (k % 2), 0.0) for k in range(24)]),
}
"""Of the paper's section V; it does not say whether the changes of slope add up or alternate, so both."""


@dataclass(frozen=True)
class Method:
    """A controller and the gains to try.

    Attributes:
        words: What it is called in the figure.
        controller: With its default gains.
        grid: Sets of gains, each a dictionary of fields.
        axis: Label of the gain that the figure has along the axis.
        color: Of its lines.
        style: Of its lines.
    """

    words: str
    controller: KnownSlopeController
    grid: Sequence[Mapping[str, Any]]
    axis: str
    color: str
    style: str | tuple[int, tuple[int, ...]]


METHODS = {
    "PBC": Method(
        "passivity-based", PassivityController(ROBOT, GAIT), [{"gain": gain} for gain in GAINS], "k", BLUE, "-"
    ),
    "ECC": Method(
        "energy constraint",
        EnergyConstraintController(ROBOT, GAIT),
        [{"ratio": ratio, "gain": gain} for ratio in RATIOS for gain in GAINS],
        "ζ",
        ORANGE,
        "--",
    ),
    "KETC": Method(
        "kinetic energy tracking",
        KineticEnergyController(ROBOT, GAIT),
        [{"gain": gain} for gain in GAINS],
        "λ",
        VERMILLION,
        "-.",
    ),
    "KETC, w = 1": Method(
        "kinetic energy tracking, both joints",
        KineticEnergyController(ROBOT, GAIT, gain=6.0, hip_weight=1.0, slope_source="local"),
        [{"gain": gain} for gain in GAINS],
        "λ",
        MAUVE,
        (0, (3, 1, 1, 1, 1, 1)),
    ),
    "limit cycle": Method(
        "limit cycle",
        LimitCycleController(ROBOT, GAIT),
        [{"rate_gain": 2.0 * pole, "position_gain": pole * pole} for pole in POLES],
        "K₁/2 = √K₂",
        GREEN,
        ":",
    ),
}


BLIND: Mapping[str, tuple[KnownSlopeController, Sequence[Mapping[str, Any]]]] = {
    "PBC": (PassivityController(ROBOT, GAIT, slope_source="two_point"), METHODS["PBC"].grid),
    "ECC": (EnergyConstraintController(ROBOT, GAIT, slope_source="two_point"), METHODS["ECC"].grid),
    "KETC": (
        KineticEnergyController(ROBOT, GAIT, slope_source="two_point"),
        [{"gain": gain, "hip_weight": weight} for gain in GAINS for weight in (0.0, 1.0)],
    ),
}
"""The energy-based methods with the one slope source that the paper names for such a method, and their grids."""


@dataclass(frozen=True)
class Trial:
    """What the search sees of a set of gains.

    Attributes:
        gains: The fields tried.
        survived: Whether it walked on the level and over each small step.
        cost: c_mt of its steady walk on the level.
        multiplier: Largest magnitude of the return map's multipliers there; NaN where no step is like the one before.
        peak: Greatest torque over the small steps, N m.
    """

    gains: Mapping[str, Any]
    survived: bool
    cost: float
    multiplier: float
    peak: float

    @property
    def settles(self) -> bool:
        """Whether it walks, cheaply, at every step the same."""
        return self.survived and self.multiplier < 1.0 and abs(self.cost - math.sin(GAIT.slope)) <= CHEAPNESS

    @property
    def steps_back(self) -> float:
        """Steps after which a tenth of a small disturbance is left."""
        return math.log(0.1) / math.log(self.multiplier) if 0.0 < self.multiplier < 1.0 else math.inf


@click.command(help=__doc__)
@click.option(
    "--figure", default="docs/images/comparison_gains.png", show_default=True, type=click.Path(path_type=Path)
)
@click.option("--page", default="docs/comparison.md", show_default=True, type=click.Path(path_type=Path))
def main(figure: Path, page: Path) -> None:
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
    publish(page, "gains", headings, rows)
    blind = [(name, *blind_row(blind_trials(name))) for name in tqdm(BLIND, desc="one slope source", disable=None)]
    publish(page, "blind", ("method", "gains found", "c_mt", "multiplier", "peak torque (N m)"), blind)
    walked = outcomes(found)
    publish(page, "terrains", ("method", "slope from", *TERRAINS), walked)
    ranges = surviving(trials, found)
    publish(page, "ranges", ("method", *TERRAINS), [(name, *map(span, each)) for name, each in ranges.items()])
    draw(trials, found, ranges, figure)
    click.echo(f"wrote {figure}\nwrote {page}")


def trial(controller: KnownSlopeController, gains: Mapping[str, Any]) -> Trial:
    """Walk on the level, then over one small step up or down, met at an odd and at an even step."""
    level = walk(controller, TERRAINS["level"], 3 * WALK)
    if level.outcome != "finished":
        return Trial(gains, False, math.nan, math.nan, math.nan)
    states = np.hstack([level.touchdowns["q"], level.touchdowns["dq"]])
    repeats = np.abs(states[-1] - states[-2]).max() < LIKE_THE_LAST
    work, x = level.touchdowns["work_absolute"], level.touchdowns["x"]
    over = [
        walk(controller, mjbiped.Terrain.from_segments([(steps * GAIT.step_length, 0, 0), (99, 0, rise)]), WALK)
        for rise in (-SMALL_STEP, SMALL_STEP)
        for steps in (6.5, 7.5)
    ]
    return Trial(
        gains,
        all(each.outcome == "finished" for each in over),
        float((work[-1] - work[-21]) / (ROBOT.weight * (x[-1] - x[-21]))),
        float(multipliers(controller, states[-1]).max()) if repeats else math.nan,
        float(max(each.peak_torque.max() for each in over)),
    )


def multipliers(controller: Controller, state: Array, change: float = 1e-6) -> Array:
    """Magnitudes of the eigenvalues of the map from one step's first state to the next one's on the level.

    By central differences. The integration's 1e-10 over the change leaves an error of 1e-4.
    """

    def after(start: Array) -> Array:
        done = mjbiped.walk(
            controller, TERRAINS["level"], engine="hybrid", steps=1, sample_period=0.05, initial=tuple(start)
        )
        return np.append(done.touchdowns["q"][0, 0], done.touchdowns["dq"][0])

    directions = change * np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    columns = [(after(state + each) - after(state - each)) / (2.0 * change) for each in directions]
    return np.asarray(np.abs(np.linalg.eigvals(np.array(columns).T)), dtype=np.float64)


def choose(trials: Sequence[Trial]) -> Trial:
    """Of the gains that settle those of the fastest return, and of these the gentlest."""
    settled = [each for each in trials if each.settles]
    fastest = min(each.steps_back for each in settled)
    return min((each for each in settled if each.steps_back <= fastest + LEAST_DIFFERENCE), key=lambda each: each.peak)


def blind_trials(name: str) -> list[Trial]:
    """A method's grid with the source of slope that all have."""
    controller, grid = BLIND[name]
    return [trial(replace(controller, **gains), gains) for gains in grid]


def blind_row(trials: Sequence[Trial]) -> tuple[str, ...]:
    """What the search finds among them."""
    found = choose(trials)
    return in_words(found.gains), *found_numbers(found)


def walk(
    controller: Controller, terrain: mjbiped.Terrain, steps: int = WALK, engine: mjbiped.Engine | str = "hybrid"
) -> mjbiped.Walk:
    """A walk from the imitated gait, in the hybrid engine unless another is given."""
    return mjbiped.walk(controller, terrain, engine=engine, steps=steps, sample_period=0.05)


def survives(controller: Controller, terrain: mjbiped.Terrain) -> bool:
    """Whether a walk comes to its end, with the usual tolerance and a tighter one."""
    return all(walk(controller, terrain, engine=engine).outcome == "finished" for engine in ("hybrid", TIGHT))


def converged(controller: Controller, terrain: mjbiped.Terrain) -> str:
    """c_mt and peak torque, or the step that a walk ends in, as far as they do not depend on tolerance and engine."""
    walks = [walk(controller, terrain, engine=engine) for engine in ("hybrid", TIGHT, "mujoco")]
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
        rows.append((name, f"**{source}**" if usual else source, *cells))
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


def publish(page: Path, name: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Show a table, and write it into the page."""
    table = Table(*headings, title=name)
    for row in rows:
        table.add_row(*row)
    Console().print(table)
    write_table(page, name, headings, rows)


def draw(trials: Mapping[str, Sequence[Trial]], found: Mapping[str, Trial], ranges: Ranges, path: Path) -> None:
    """Return, torque and survival over the gains."""
    with styled():
        figure = new_figure(7.8)
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
        save_figure(figure, path)


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
