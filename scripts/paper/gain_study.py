"""How far gamma, K1 and K2 can be raised: convergence, (24), torque and falls (10 minutes). See docs/stability.md.

python -m scripts.paper.gain_study --figure docs/images/gains.png --tables docs/tables/stability
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from scipy.optimize import brentq
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.error_dynamics import impact_gain
from mjbiped.engines.mujoco.options import DEFAULT_TIMESTEP
from mjbiped.plotting.style import BLACK, BLUE, GUIDE, ORANGE, VERMILLION, drawn
from mjbiped.records import measures
from mjbiped.robots.compass import Array
from scripts.pages import TABLES, Table, show_table
from scripts.paper.theorem_1 import cycle_stability, lyapunov_gain

TERRAINS = {
    "slopes 0.3°": mjbiped.Terrain.slopes(),
    "mixed": mjbiped.Terrain.mixed(),
    "stairs −6 mm": mjbiped.Terrain.stairs(rise=-0.006),
}
LOOKS = {"slopes 0.3°": (BLUE, "o"), "mixed": (ORANGE, "s"), "stairs −6 mm": (VERMILLION, "^")}
GAMMAS = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0]
SCALES = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
"""Of the paper's K1 = 5 and K2 = 12."""
CONTROL_PERIODS = (1e-4, 1e-3)  # s
LEVELS = {0.05: (5.0, 8.5), 0.2: (0.6, 2.0), 0.5: (0.5, 5.0), 0.9: (0.06, 3.0)}
"""Of the slowest multiplier, and where on the plane their names stand."""
HIGHEST_GAMMA = 100.0
"""Of the limit cycle's figures: above, the lines swing faster with gamma than a page can show."""


@dataclass(frozen=True)
class Cycle:
    """Of a set of gains, on the limit cycle: slowest multiplier, left side of (24), its floor, V_a step to step."""

    rate: float
    condition: float
    floor: float
    lyapunov: float


@dataclass(frozen=True)
class Outcome:
    """Of a walk.

    Outcome, peak torques (N m), share of the first step's estimate error that is left at its end, and the least normal
    force on a stance foot, in weights.
    """

    outcome: str
    ankle: float
    hip: float
    left: float
    force: float


@click.command(help=__doc__)
@click.option("--figure", default="docs/images/gains.png", show_default=True, type=click.Path(path_type=Path))
@TABLES
@click.option("--steps", default=40, show_default=True, type=click.IntRange(min=2), help="Steps per walk.")
def main(figure: Path, tables: Path | None, steps: int) -> None:
    """Scan, draw and tabulate."""
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2))
    paper = AdaptiveController(robot, gait, initial_slope_estimate=math.radians(3))
    by_gamma = {gamma: replace(paper, adaptation_gain=gamma) for gamma in GAMMAS}
    by_scale = {scale: scaled(paper, scale) for scale in SCALES}
    walks = {
        (kind, value, ground, delay): replace(controller, replanning_delay=delay)
        for kind, family in (("gamma", by_gamma), ("scale", by_scale))
        for value, controller in family.items()
        for ground in TERRAINS
        for delay in (0.8, None)
    }
    walked = {
        key: walk(controller, key[2], steps) for key, controller in tqdm(walks.items(), desc="walks", disable=None)
    }
    planes = {
        (gamma, scale): walk(
            replace(scaled(paper, scale), adaptation_gain=gamma, replanning_delay=None), "mixed", steps
        ).outcome
        for scale in tqdm(SCALES, desc="walks over both gains", disable=None)
        for gamma in GAMMAS
    }
    held = {
        (gamma, period): mujoco_walk(replace(by_gamma[gamma], initial_slope_estimate=0.0), period, steps)
        for gamma in tqdm(GAMMAS, desc="walks in MuJoCo", disable=None)
        for period in CONTROL_PERIODS
    }
    grid = resolved(300), np.geomspace(0.02, 20.0, 61)
    rows = [
        [on_the_cycle(replace(scaled(paper, scale), adaptation_gain=gamma), 40) for gamma in grid[0].tolist()]
        for scale in tqdm(grid[1].tolist(), desc="limit cycle", disable=None)
    ]
    draw(grid, rows, paper, walked, planes, figure)
    show_table("gamma", *gamma_table(by_gamma, walked, held), tables, "gamma")
    show_table("tracking gains", *scale_table(by_scale, walked), tables, "tracking gains")
    show_table("condition (24)", *condition_table(paper), tables, "condition 24")


def scaled(controller: AdaptiveController, scale: float) -> AdaptiveController:
    """The controller with both tracking gains multiplied."""
    return replace(
        controller, position_gain=scale * controller.position_gain, velocity_gain=scale * controller.velocity_gain
    )


def resolved(count: int) -> Array:
    """Values of gamma for lines over it: equal ratios, and equal steps of its root.

    Posture and estimate swing against each other at sqrt(gamma) ||W||, and a touchdown meets the swing at any phase:
    all that is found at touchdowns swings over gamma, with some 11 rad for each unit of sqrt(gamma).
    """
    return np.union1d(np.geomspace(0.01, HIGHEST_GAMMA, 40), np.linspace(0.1, math.sqrt(HIGHEST_GAMMA), count) ** 2)


def on_the_cycle(controller: AdaptiveController, intervals: int = 200) -> Cycle:
    """What Theorem 1 and the return map say of the gains; 40 intervals are within 0.3 % up to `HIGHEST_GAMMA`."""
    cycle = cycle_stability(controller, intervals)
    gain = controller.position_gain
    return Cycle(
        rate=float(np.abs(cycle.multipliers[0])),
        condition=impact_gain(gain, cycle.alpha, cycle.beta) * cycle.contraction,
        floor=impact_gain(gain, 0.0, 0.0) * cycle.contraction,
        lyapunov=lyapunov_gain(controller, cycle.return_map),
    )


def windows(controller: AdaptiveController) -> list[tuple[float, float]]:
    """Ranges of gamma up to `HIGHEST_GAMMA` in which (24) holds on the limit cycle.

    They are found on the grid of the lines, and their ends between its values to four digits. One that is narrower than
    the grid's steps, of 0.03 in the root of gamma, can be missed.
    """

    def beyond(gamma: float, intervals: int = 200) -> float:
        return math.log(on_the_cycle(replace(controller, adaptation_gain=gamma), intervals).condition)

    grid = resolved(300).tolist()
    holds = [beyond(gamma, 40) < 0.0 for gamma in grid]
    ends = [
        brentq(beyond, low, high, rtol=1e-4)
        for low, high, before, after in zip(grid, grid[1:], holds, holds[1:], strict=False)
        if before != after
    ]
    ends = [*([grid[0]] if holds[0] else []), *ends, *([grid[-1]] if holds[-1] else [])]
    return list(zip(ends[::2], ends[1::2], strict=True))


def condition_table(paper: AdaptiveController) -> Table:
    """Where (24) holds with the paper's tracking gains, and with twice these."""
    rows = []
    for scale in (1.0, 2.0):
        gains = scaled(paper, scale)
        ranges = ", ".join(f"{low:.3g} to {high:.3g}" for low, high in windows(gains))
        rows.append((f"{gains.position_gain:g}, {gains.velocity_gain:g}", ranges))
    return ("K₁, K₂ (1/s)", f"γ up to {HIGHEST_GAMMA:g} with which (24) holds"), rows


def walk(controller: AdaptiveController, ground: str, steps: int) -> Outcome:
    """A walk in the hybrid engine that begins with an estimate 3 degrees wrong."""
    done = mjbiped.walk(controller, TERRAINS[ground], engine="hybrid", steps=steps, sample_period=0.05)
    _, ended = measures.estimate_errors(done)
    first = controller.initial_slope_estimate - done.terrain.slope_at(0.0)
    left = abs(ended[0] / first) if done.steps else math.nan
    force = float(done.touchdowns["normal_force"].min()) / done.robot.weight if done.steps else math.nan
    return Outcome(done.outcome, float(done.peak_torque[0]), float(done.peak_torque[1]), float(left), force)


def mujoco_walk(controller: AdaptiveController, control_period: float, steps: int) -> str:
    """Rms error of the estimate at the steps' ends on `mixed`, and peak ankle torque in N m, or how else it ended.

    And in how many steps the stance foot left the ground, if it did.
    """
    timestep = min(control_period, DEFAULT_TIMESTEP)
    engine = mjbiped.Mujoco(timestep=timestep, control_period=control_period)
    done = mjbiped.walk(controller, TERRAINS["mixed"], steps=steps, engine=engine)
    if done.outcome != "finished":
        return done.outcome
    _, ended = measures.estimate_errors(done)
    lifted = int(measures.pulls(done.touchdowns).sum())
    text = f"{math.degrees(math.sqrt(np.mean(ended**2))):.3f}°, {done.peak_torque[0]:.1f}"
    return f"{text}, off the ground in {lifted} steps" if lifted else text


Walked = dict[tuple[str, float, str, float | None], Outcome]


def gamma_table(family: dict[float, AdaptiveController], walked: Walked, held: dict[tuple[float, float], str]) -> Table:
    """Rows by gamma, at the paper's K1 and K2."""
    rows = []
    for gamma, controller in family.items():
        cells = (*_cells(on_the_cycle(controller)), *_peaks(walked, "gamma", gamma))
        rows.append((f"{gamma:g}", *cells, *(held[gamma, period] for period in CONTROL_PERIODS)))
    return ("γ", *_HEADINGS, *(f"MuJoCo, {1e3 * period:g} ms" for period in CONTROL_PERIODS)), rows


def scale_table(family: dict[float, AdaptiveController], walked: Walked) -> Table:
    """Rows by tracking gains, at the paper's gamma."""
    rows = [
        (
            f"{controller.position_gain:g}, {controller.velocity_gain:g}",
            *_cells(on_the_cycle(controller)),
            *_peaks(walked, "scale", scale),
        )
        for scale, controller in family.items()
    ]
    return ("K₁, K₂ (1/s)", *_HEADINGS), rows


_HEADINGS = ("slowest multiplier", "(24)", "its floor", "V_a⁺/V_a⁺", "error left after 1 step", *TERRAINS)


def _cells(cycle: Cycle) -> tuple[str, ...]:
    """Of the limit cycle."""
    return tuple(f"{value:.3g}" for value in (cycle.rate, cycle.condition, cycle.floor, cycle.lyapunov))


def _peaks(walked: Walked, kind: str, value: float) -> tuple[str, ...]:
    """Error left after the first step, then per terrain the peak ankle torque re-planned / not re-planned.

    Where the ground would have to pull, the least normal force in weights stands behind it.
    """
    cells = [f"{walked[kind, value, 'stairs −6 mm', 0.8].left:.3f}"]
    for ground in TERRAINS:
        pair = (walked[kind, value, ground, delay] for delay in (0.8, None))
        cells.append(" / ".join(map(_peak, pair)))
    return tuple(cells)


def _peak(walked: Outcome) -> str:
    if walked.outcome != "finished":
        return walked.outcome
    pulls = f" ({walked.force:.2f})".replace("-", "−") if walked.force < 0.0 else ""
    return f"{walked.ankle:.3g}{pulls}"


def draw(
    grid: tuple[Array, Array],
    rows: list[list[Cycle]],
    paper: AdaptiveController,
    walked: Walked,
    planes: dict[tuple[float, float], str],
    path: Path,
) -> None:
    """Convergence and conditions on the limit cycle, and peak torques of the walks."""
    with drawn(path) as figure:
        figure.set_figheight(7.5)
        (line, plane), (gammas, scales) = figure.subplots(2, 2)
        fine = resolved(900)
        cycles = [on_the_cycle(replace(paper, adaptation_gain=gamma)) for gamma in fine.tolist()]
        line.loglog(
            fine, [cycle.condition for cycle in cycles], color=VERMILLION, linestyle="-", label="left side of (24)"
        )
        line.loglog(
            fine,
            [cycle.floor for cycle in cycles],
            color=BLACK,
            linestyle="-.",
            label="the same, best constants there can be",
        )
        line.loglog(fine, [cycle.rate for cycle in cycles], color=BLUE, linestyle="--", label="slowest multiplier")
        line.loglog(
            fine, [cycle.lyapunov for cycle in cycles], color=ORANGE, linestyle=":", label="$V_a$ from step to step"
        )
        line.axhline(1.0, color=GUIDE, linewidth=1.0)
        line.axvline(paper.adaptation_gain, color=GUIDE, linewidth=0.7)
        line.set(xlabel="γ", ylabel="factor per step")
        line.set_title("(a) On the limit cycle, K₁ = 5, K₂ = 12")
        line.set_ylim(None, 500.0)
        line.legend(loc="upper right")
        _draw_plane(plane, grid, rows, planes)
        for axes, kind, values in ((gammas, "gamma", GAMMAS), (scales, "scale", SCALES)):
            _draw_torques(axes, kind, values, walked)
        gammas.set(xlabel="γ")
        gammas.set_title("(c) Peak ankle torque, K₁ = 5, K₂ = 12")
        scales.set(xlabel="K₁/5 = K₂/12")
        scales.set_title("(d) Peak ankle torque, γ = 0.3")
        handles = [Line2D([], [], color=color, marker=marker, label=name) for name, (color, marker) in LOOKS.items()]
        handles += [
            Line2D([], [], color=BLACK, label="re-planned"),
            Line2D([], [], color=BLACK, linestyle=":", label="not re-planned"),
        ]
        if any(outcome.outcome != "finished" for outcome in walked.values()):
            handles.append(Line2D([], [], color=BLACK, marker="x", linestyle="none", label="fell"))
        gammas.legend(handles=handles, loc="upper left")


def _draw_plane(
    axes: Axes, grid: tuple[Array, Array], rows: list[list[Cycle]], planes: dict[tuple[float, float], str]
) -> None:
    """Slowest multiplier over both gains, where (24) holds, and which walks fell."""
    rate, condition, lyapunov = (
        np.array([[getattr(cycle, name) for cycle in row] for row in rows])
        for name in ("rate", "condition", "lyapunov")
    )
    axes.set(xscale="log", yscale="log", xlabel="γ", ylabel="K₁/5 = K₂/12")
    axes.set(xlim=grid[0][[0, -1]], ylim=grid[1][[0, -1]])  # first, for the labels' places are found on the page
    axes.contourf(*grid, rate, levels=[1.0, np.inf], colors=[GUIDE], alpha=0.5)
    axes.contourf(*grid, condition, levels=[0.0, 1.0], colors=[VERMILLION], alpha=0.25)
    lines = axes.contour(*grid, rate, levels=list(LEVELS), colors=[BLUE], linewidths=0.8)
    axes.clabel(lines, fontsize=7, fmt="%g", manual=list(LEVELS.values()))
    axes.contour(*grid, lyapunov, levels=[1.0], colors=[ORANGE], linestyles=[":"], linewidths=1.6)
    fallen = [key for key, outcome in planes.items() if outcome != "finished"]
    axes.plot([key[0] for key in fallen], [key[1] for key in fallen], "kx", markersize=5, clip_on=False)
    axes.plot(0.3, 1.0, "k*", markersize=9)
    axes.set_title("(b) Slowest multiplier; ★: the paper's gains")
    axes.legend(
        handles=[
            Line2D([], [], color=BLUE, label="slowest multiplier"),
            Line2D([], [], color=GUIDE, alpha=0.5, linewidth=7, label="limit cycle unstable"),
            Line2D([], [], color=VERMILLION, alpha=0.35, linewidth=7, label="(24) holds"),
            Line2D([], [], color=ORANGE, linestyle=":", label="$V_a$ falls from step to step above"),
            Line2D([], [], color=BLACK, marker="x", linestyle="none", label="fell on mixed, not re-planned"),
        ],
        loc="upper center",  # under the panel, of which every part holds contours
        bbox_to_anchor=(0.48, -0.17),
        ncols=2,
        columnspacing=1.2,
    )


def _draw_torques(axes: Axes, kind: str, values: list[float], walked: Walked) -> None:
    """Peak ankle torque against a gain."""
    for ground, (color, marker) in LOOKS.items():
        for delay, style in ((0.8, "-"), (None, ":")):
            each = [walked[kind, value, ground, delay] for value in values]
            peaks = np.array([outcome.ankle for outcome in each])
            fell = np.array([outcome.outcome != "finished" for outcome in each])
            axes.plot(
                values, np.where(fell, np.nan, peaks), color=color, linestyle=style, marker=marker, markersize=3.5
            )
            axes.plot(np.array(values)[fell], peaks[fell], "x", color=color)
    axes.set(xscale="log", yscale="log", ylabel="peak ankle torque (N m)")


if __name__ == "__main__":
    main()
