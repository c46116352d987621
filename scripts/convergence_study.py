"""How MuJoCo's walks converge to the hybrid engine's, with the timestep and with the foot's radius.

A passive walk down 2 degrees and a closed-loop walk over rough ground, in both engines; the hybrid engine has neither a
timestep nor a foot, and its own error is below 1e-9. Some three minutes. The result stands in `docs/convergence.md`.

    python scripts/convergence_study.py --page docs/convergence.md --plot docs/images/convergence.png
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import click
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from pages import write_table
from rich.console import Console
from rich.table import Table
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped import measures, physics, plot_style, scene

TIMESTEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)
RADII = (3e-2, 1e-2, 1e-3, 1e-4)
DEFAULT_TIMESTEP = 1e-4
SMALL_RADIUS = 1e-5  # for the timesteps: the default foot's rolling, 0.02 % of a step, would hide what they do
PASSIVE_GROUND = mjbiped.Terrain.incline(2.0)
ROUGH_GROUND = mjbiped.Terrain.random(seed=1, rise=(0.0, 0.0), roughness=0.003)  # no risers, which nothing converges at

ERRORS = ("step length", "period", "impact, mean", "impact, worst", "work, rough", "c_mt, rough")
STYLES: Sequence[dict[str, Any]] = (
    {"color": plot_style.BLUE, "linestyle": "-", "marker": "o"},
    {"color": plot_style.GREEN, "linestyle": (0, (4, 1.2)), "marker": "s"},
    {"color": plot_style.ORANGE, "linestyle": (0, (1.5, 1.2)), "marker": "v"},
    {"color": plot_style.VERMILLION, "linestyle": "-", "marker": "^"},
    {"color": plot_style.BLACK, "linestyle": (0, (6, 1.2, 1.5, 1.2)), "marker": "D"},
    {"color": plot_style.GUIDE, "linestyle": (0, (1, 1)), "marker": "x"},
)


@dataclass(frozen=True)
class Case:
    """A walk that is taken with all timesteps and radii, and what it is in the hybrid engine."""

    controller: Controller
    terrain: mjbiped.Terrain
    steps: int

    def walk(self, timestep: float, radius: float) -> mjbiped.Walk:
        """The walk in MuJoCo."""
        with foot_of(radius):
            return mjbiped.walk(self.controller, self.terrain, steps=self.steps, timestep=timestep)

    def exact(self) -> mjbiped.Walk:
        """The walk in the hybrid engine."""
        return mjbiped.walk(self.controller, self.terrain, steps=self.steps, engine="hybrid")


@contextmanager
def foot_of(radius: float) -> Iterator[None]:
    """Give the feet another radius, and let timesteps be as long as one likes.

    Both are constants of the laboratory, for reasons that this study shows. The ground is built lower by the radius
    along its normal, whatever it is.
    """
    with (
        mock.patch.object(scene, "FOOT_RADIUS", radius),
        mock.patch.object(physics, "FOOT_RADIUS", radius),
        mock.patch.object(physics, "LONGEST_TIMESTEP", math.inf),
    ):
        yield


def errors(passive: mjbiped.Walk, rough: mjbiped.Walk, exact: tuple[mjbiped.Walk, mjbiped.Walk]) -> list[float]:
    """Relative errors in the order of `ERRORS`; NaN where a walk did not come to its end.

    Step length and period of the passive walk and work of the rough one are root mean squares over the steps, of the
    difference to the same step in the hybrid engine, divided by the mean: errors of single steps do not cancel, as they
    do in c_mt. Impacts are those of the passive walk against the impact map of the state before each, relative to the
    rate itself.
    """
    found = [math.nan] * len(ERRORS)
    if passive.outcome == "finished":
        for index, of in enumerate((measures.step_lengths, measures.step_periods)):
            found[index] = root_mean_square(of(passive), of(exact[0]))
        impacts = np.abs(measures.impact_errors(passive)).max(axis=1)
        found[2:4] = float(impacts.mean()), float(impacts.max())
    if rough.outcome == "finished":
        works = [np.diff(np.append(0.0, walk.touchdowns["work_absolute"])) for walk in (rough, exact[1])]
        found[4] = root_mean_square(works[0], works[1])
        found[5] = rough.cost_of_transport / exact[1].cost_of_transport - 1.0
    return found


def root_mean_square(values: NDArray[np.float64], exact: NDArray[np.float64]) -> float:
    """Of the differences, divided by the exact values' mean."""
    return float(np.sqrt(np.mean((values - exact) ** 2)) / exact.mean())


def orders(values: Sequence[float], found: NDArray[np.float64]) -> list[float]:
    """Slopes of log |error| over the log of what was varied, by least squares, in the order of `ERRORS`.

    The default radius is left out: there the timestep's error is the greater part. None is fitted to c_mt, whose
    errors cancel and change their sign; NaN stands there, and where there are less than three errors.
    """
    places, slopes = np.array(values), []
    for column, name in zip(found.T, ERRORS, strict=True):
        there = np.isfinite(column) & (places != scene.FOOT_RADIUS if values is RADII else True)
        fitted = there.sum() >= 3 and not name.startswith("c_mt")
        slopes.append(
            float(np.polyfit(np.log(places[there]), np.log(np.abs(column[there])), 1)[0]) if fitted else math.nan
        )
    return slopes


def draw(path: Path, timesteps: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
    """Both studies, log-log, with the order of each error."""
    with plot_style.styled():
        figure = plot_style.new_figure(4.6)
        left, right = figure.subplots(1, 2, sharey=True)
        draw_study(left, TIMESTEPS, timesteps, "timestep h (s);  foot radius 0.01 mm", "h")
        draw_study(right, RADII, radii, "foot radius r (m);  timestep 0.1 ms", "r")
        left.set(ylabel="error (%)")
        left.set_title("(a) Timestep")
        right.set_title("(b) Foot radius")
    plot_style.save_figure(figure, path)


def draw_study(axes: Axes, values: Sequence[float], found: NDArray[np.float64], label: str, symbol: str) -> None:
    """One study, with lines of first order to hold the eye to."""
    for name, style, slope, column in zip(ERRORS, STYLES, orders(values, found), found.T, strict=True):
        told = f"{name}:  {symbol}$^{{{slope:.1f}}}$" if math.isfinite(slope) else name
        axes.loglog(values, 100.0 * np.abs(column), label=told, linewidth=1.1, markersize=4.5, **style)
    ends = np.array([min(values), max(values)])
    for height in (2e-1, 2e1):
        axes.loglog(ends, height * ends / ends[1], color=plot_style.GUIDE, linewidth=0.6, zorder=0)
    axes.annotate(
        f"thin lines: order 1, error ∝ {symbol}",
        (0.97, 0.02),  # the corner that rising curves leave free
        xycoords="axes fraction",
        ha="right",
        fontsize=7.5,
        color=plot_style.SHADE,
    )
    axes.set(xlabel=label, ylim=(1e-3, 5e2))
    axes.legend(loc="upper left", title=f"error: fitted power of {symbol}", title_fontsize=8.0)


def table_of(first: str, values: Sequence[float], found: NDArray[np.float64]) -> tuple[list[str], list[list[str]]]:
    """Headings and rows, the fitted order last; errors in percent."""
    headings = [first, *(f"{name} %" for name in ERRORS)]
    rows = [
        [
            f"{value:g}",
            *("-" if math.isnan(e) else f"{100 * e:+.2g}" if i == 5 else f"{100 * e:.2g}" for i, e in enumerate(row)),
        ]
        for value, row in zip(values, found, strict=True)
    ]
    fitted = ("-" if math.isnan(slope) else f"{slope:.2f}" for slope in orders(values, found))
    return headings, [*rows, ["fitted order", *fitted]]


@click.command(help=__doc__)
@click.option("--steps", default=40, show_default=True, type=click.IntRange(min=4), help="Steps of the passive walk.")
@click.option("--rough-steps", default=16, show_default=True, type=click.IntRange(min=2), help="Of the rough walk.")
@click.option("--plot", type=click.Path(path_type=Path), help="Figure to write.")
@click.option("--page", type=click.Path(exists=True, path_type=Path), help="Markdown page to write the tables into.")
def main(steps: int, rough_steps: int, plot: Path | None, page: Path | None) -> None:
    """Walk, tabulate and draw."""
    robot = mjbiped.Compass()
    # every step is re-planned: a threshold for it would make the walk jump where a state touches it
    adaptive = AdaptiveController(robot, mjbiped.find_passive_gait(robot, math.radians(2)), replanning_threshold=1e-9)
    passive, rough = Case(PassiveController(), PASSIVE_GROUND, steps), Case(adaptive, ROUGH_GROUND, rough_steps)
    exact = passive.exact(), rough.exact()
    pairs = [(h, SMALL_RADIUS) for h in TIMESTEPS] + [(DEFAULT_TIMESTEP, r) for r in RADII]
    found: dict[tuple[float, float], list[float]] = {}
    work = {pair: 1.0 / pair[0] for pair in pairs}
    with tqdm(total=round(sum(work.values())), desc="walks", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        for pair in work:
            found[pair] = errors(passive.walk(*pair), rough.walk(*pair), exact)
            bar.update(round(work[pair]))
    studies = {
        "timestep": ("timestep s", TIMESTEPS, np.array([found[h, SMALL_RADIUS] for h in TIMESTEPS])),
        "radius": ("foot radius m", RADII, np.array([found[DEFAULT_TIMESTEP, r] for r in RADII])),
    }
    for name, study in studies.items():
        headings, rows = table_of(*study)
        table = Table(
            title=f"{name}: MuJoCo against the hybrid engine, {steps} passive steps, {rough_steps} rough ones"
        )
        for heading in headings:
            table.add_column(heading, justify="right")
        for cells in rows:
            table.add_row(*cells)
        Console(width=120).print(table)
        if page is not None:
            write_table(page, name, headings, rows)
    if plot is not None:
        draw(plot, studies["timestep"][2], studies["radius"][2])


if __name__ == "__main__":
    main()
