"""How MuJoCo's walks converge to the hybrid engine's: with the timestep, the contact step and the foot's radius.

A passive walk down 2 degrees and a closed-loop walk over rough ground, in both engines; the hybrid engine has neither
timesteps nor a foot, and its own error is below 1e-9. Some two minutes. The result stands in
`docs/tables/convergence.md`.

    python -m scripts.studies.convergence_study --tables docs/tables/convergence --plot docs/images/convergence.png
"""

import math
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.engines.mujoco import ground, options, scene, setup
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.panels import legend_below
from mjbiped.records import measures
from scripts.pages import TABLES, show_table

TIMESTEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)
RADII = (3e-2, 1e-2, 1e-3, 1e-4, ground.FOOT_RADIUS, 1e-5)
CONTACT_TIMESTEPS = (2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6)
SMALL_RADIUS = 1e-5  # for the timesteps: the default foot's rolling, 0.01 % of a step, would hide what they do
PASSIVE_GROUND = mjbiped.Terrain.incline(2.0)
# no risers, and no foothold within 4 mm of a break: nothing converges there
ROUGH_GROUND = mjbiped.Terrain.random(seed=7, rise=(0.0, 0.0), roughness=0.003)

ERRORS = ("step length", "period", "impact, mean", "impact, worst", "work, rough", "c_mt, rough")
STYLES: Sequence[dict[str, Any]] = (
    {"color": plot_style.BLUE, "linestyle": "-", "marker": "o"},
    {"color": plot_style.GREEN, "linestyle": (0, (4, 1.2)), "marker": "s"},
    {"color": plot_style.ORANGE, "linestyle": (0, (1.5, 1.2)), "marker": "v"},
    {"color": plot_style.VERMILLION, "linestyle": "-", "marker": "^"},
    {"color": plot_style.BLACK, "linestyle": (0, (6, 1.2, 1.5, 1.2)), "marker": "D"},
    {"color": plot_style.GUIDE, "linestyle": (0, (1, 1)), "marker": "x"},
)

_H, _CONTACT = options.DEFAULT_TIMESTEP, options.DEFAULT_CONTACT_TIMESTEP
VARIED = {
    "timestep": (
        ("Timestep", "timestep s", "timestep $h$ (s);\nfoot 0.01 mm, contact step 10 µs", "h"),
        TIMESTEPS,
        [(value, _CONTACT, SMALL_RADIUS) for value in TIMESTEPS],
    ),
    "contact": (
        ("Contact step", "contact step s", "contact step $h_c$ (s);\nfoot 0.01 mm, timestep 1 ms", "h_c"),
        CONTACT_TIMESTEPS,
        [(_H, value, SMALL_RADIUS) for value in CONTACT_TIMESTEPS],
    ),
    "radius": (
        ("Foot radius", "foot radius m", "foot radius $r$ (m);\ntimestep 1 ms, contact step 10 µs", "r"),
        RADII,
        [(_H, _CONTACT, value) for value in RADII],
    ),
}
"""What is varied: title, heading, label, symbol; values; and timestep (s), contact step (s), radius (m) of each."""


@dataclass(frozen=True)
class Case:
    """A walk that is taken with all step lengths and radii, and what it is in the hybrid engine."""

    controller: Controller
    terrain: mjbiped.Terrain
    steps: int

    def walk(self, timestep: float, contact_timestep: float, radius: float) -> mjbiped.Walk:
        """The walk in MuJoCo."""
        engine = mjbiped.Mujoco(timestep=timestep, contact_timestep=contact_timestep)
        with foot_of(radius):
            return mjbiped.walk(self.controller, self.terrain, steps=self.steps, engine=engine)

    def exact(self) -> mjbiped.Walk:
        """The walk in the hybrid engine."""
        return mjbiped.walk(self.controller, self.terrain, steps=self.steps, engine="hybrid")


@contextmanager
def foot_of(radius: float) -> Iterator[None]:
    """Give the feet another radius, which is a constant of the laboratory, for reasons that this study shows.

    The ground is built lower by the radius along its normal, whatever it is.
    """
    with ExitStack() as stack:
        for module in (ground, scene, setup):
            stack.enter_context(mock.patch.object(module, "FOOT_RADIUS", radius))
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

    None is fitted (NaN) to c_mt, whose errors cancel and change their sign, nor to an error that does not fall all the
    way: there something else is the greater part. At the default radius the steps' share is, so it is left out.
    """
    places, slopes = np.array(values), []
    order = np.array([i for i in np.argsort(places) if values is not RADII or places[i] != ground.FOOT_RADIUS])
    for column, name in zip(np.abs(found).T, ERRORS, strict=True):
        there = order[np.isfinite(column[order])]
        falls = len(there) >= 3 and bool((np.diff(column[there]) > 0.0).all())
        fitted = falls and not name.startswith("c_mt")
        slopes.append(float(np.polyfit(np.log(places[there]), np.log(column[there]), 1)[0]) if fitted else math.nan)
    return slopes


def draw(path: Path, studies: Sequence["Study"]) -> None:
    """All studies, log-log, with the orders of the errors that have one."""
    shown = 100.0 * np.concatenate([np.abs(study.found).ravel() for study in studies])
    shown = shown[np.isfinite(shown) & (shown > 0.0)]
    with plot_style.drawn(path) as figure:
        figure.set_figheight(4.9)
        panels = figure.subplots(1, len(studies), sharey=True)
        for letter, axes, study in zip("abc", panels, studies, strict=True):
            draw_study(axes, study)
            axes.set_title(f"({letter}) {study.title}")
        panels[0].set(ylabel="error (%)", ylim=(0.6 * shown.min(), 1.7 * shown.max()))
        handles, names = panels[0].get_legend_handles_labels()
        handles.append(Line2D([], [], color=plot_style.GUIDE, linewidth=0.6))
        legend_below(figure, handles, [*names, "in proportion to what is varied"])


def draw_study(axes: Axes, study: "Study") -> None:
    """One study, with lines of first order to hold the eye to; the fitted orders stand below."""
    values, fitted = study.values, orders(study.values, study.found)
    for name, style, column in zip(ERRORS, STYLES, study.found.T, strict=True):
        label = name.replace("c_mt", plot_style.C_MT)
        axes.loglog(values, 100.0 * np.abs(column), label=label, linewidth=1.1, markersize=4.5, **style)
    ends = np.array([min(values), max(values)])
    for height in (2e-1, 2e1):
        axes.loglog(ends, height * ends / ends[1], color=plot_style.GUIDE, linewidth=0.6, zorder=0)
    powers = [f"{name} {slope:.1f}" for name, slope in zip(ERRORS, fitted, strict=True) if math.isfinite(slope)]
    text = f"fitted powers of ${study.symbol}$: {'; '.join(powers)}" if powers else "no error falls all the way"
    axes.set_xlabel("\n".join([study.label, *textwrap.wrap(text, 46)]))


@dataclass(frozen=True)
class Study:
    """What was varied, and the errors: a row per value."""

    name: str
    title: str
    heading: str
    label: str
    symbol: str
    values: Sequence[float]
    found: NDArray[np.float64]

    def rows(self) -> list[list[str]]:
        """Of the table, in percent, the fitted order last."""
        rows = [
            [
                f"{value:g}",
                *(
                    "-" if math.isnan(e) else f"{100 * e:+.2g}" if i == 5 else f"{100 * e:.2g}"
                    for i, e in enumerate(row)
                ),
            ]
            for value, row in zip(self.values, self.found, strict=True)
        ]
        fitted = ("-" if math.isnan(slope) else f"{slope:.2f}" for slope in orders(self.values, self.found))
        return [*rows, ["fitted order", *fitted]]


@click.command(help=__doc__)
@click.option("--steps", default=40, show_default=True, type=click.IntRange(min=4), help="Steps of the passive walk.")
@click.option("--rough-steps", default=16, show_default=True, type=click.IntRange(min=2), help="Of the rough walk.")
@click.option("--plot", type=click.Path(path_type=Path), help="Figure to write.")
@TABLES
def main(steps: int, rough_steps: int, plot: Path | None, tables: Path | None) -> None:
    """Walk, tabulate and draw."""
    robot = mjbiped.Compass()
    # every step is re-planned: a threshold for it would make the walk jump where a state touches it
    adaptive = AdaptiveController(robot, mjbiped.find_passive_gait(robot, math.radians(2)), replanning_threshold=1e-9)
    passive, rough = Case(PassiveController(), PASSIVE_GROUND, steps), Case(adaptive, ROUGH_GROUND, rough_steps)
    exact = passive.exact(), rough.exact()
    found: dict[tuple[float, float, float], list[float]] = {}
    work = {place: 1.0 / place[0] for _, _, places in VARIED.values() for place in places}
    with tqdm(total=round(sum(work.values())), desc="walks", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        for place in work:
            found[place] = errors(passive.walk(*place), rough.walk(*place), exact)
            bar.update(round(work[place]))
    studies = [
        Study(name, *words, values, np.array([found[place] for place in places]))
        for name, (words, values, places) in VARIED.items()
    ]
    for study in studies:
        headings, rows = [study.heading, *(f"{name} %" for name in ERRORS)], study.rows()
        title = f"{study.name}: MuJoCo against the hybrid engine, {steps} passive steps, {rough_steps} rough ones"
        show_table(title, headings, rows, tables, study.name)
    if plot is not None:
        draw(plot, studies)


if __name__ == "__main__":
    main()
