"""The commands `return-map`, `bifurcation` and `basin`: maps of many walks."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click
import numpy as np
from numpy.typing import ArrayLike

from mjbiped.cli import options
from mjbiped.cli.commands import Choice, Given, command, filled, span
from mjbiped.cli.results import Plotted, Summary
from mjbiped.cli.walkers import controller_of, robot_of, scuffing_of
from mjbiped.control.loading import FORMS
from mjbiped.gaits.described import passive_gait_of
from mjbiped.records.arrays import write_arrays
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.limit_cycles.basin import Basin
    from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade
    from mjbiped.limit_cycles.map_slices import MapSlices

Ends = tuple[float, float]
Rates = Annotated[Ends | None, span(domains.RATE)]

_MULTIPLIERS_EVERY = math.radians(0.02)


@dataclass
class Computed(Plotted):
    """Results with data.

    Results:
        out: Write the data, an .npz file.
    """

    out: Annotated[Path | None, options.DATA] = None

    def keep(self, found: object, *names: str, **arrays: ArrayLike) -> None:
        """Write attributes of a result and other arrays as data."""
        arrays = {**{name: getattr(found, name) for name in names}, **arrays}
        self.write("data", self.out, partial(write_arrays, arrays=arrays))


@command("return-map")
def return_map(
    *,
    slope_deg: Annotated[float, domains.SLOPE_DEG] = 2.0,
    points: Annotated[int | None, domains.SLOPES] = None,
    steps: Annotated[int, domains.MAP_STEPS] = 40,
    chosen: Annotated[Given, options.MAP_ROBOT],
    results: Computed,
) -> None:
    """Show how a step of the passive robot maps the state after an impact onto the next one.

    The figure plots the legs' angle and rates, in space the roll's too, after a step over their values before the step.
    The gait is the point where the map meets the diagonal. The figure also has the gait's multipliers, and a walk that
    begins 2 % off the gait.

    Map:
        slope_deg: Slope of the plane, positive downhill.
        points: Number of steps in each slice of the map; 400, or 40 in space, where a step takes 0.05 s.
        steps: Number of steps of the walk.

    \b
    Examples:
      mjbiped return-map --slope-deg 2 --plot map.pdf
      mjbiped return-map --slope-deg 3.2 --steps 200 --plot doubled.png
      mjbiped return-map --robot kneed --slope-deg 2.5 --out map.npz
      mjbiped return-map --robot wheel --slope-deg 5 --plot wheel.png
      mjbiped return-map --robot compass3d --plot space.png
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.limit_cycles.map_slices import map_slices

    robot, rule = robot_of(chosen), scuffing_of(chosen)
    found = map_slices(robot, math.radians(slope_deg), points=points, steps=steps, scuffing=rule)
    results.keep(found, "components", "fixed_point", "before", "after", "walk")
    results.draw("gaits:plot_return_map", found)
    results.end(_map_summary(found))


@command("bifurcation")
def bifurcation(
    *,
    slope_deg: Annotated[Ends | None, span(domains.SLOPE_DEG)] = None,
    slopes: Annotated[int, domains.SLOPES] = 1000,
    steps: Annotated[int, domains.MAP_STEPS] = 600,
    keep: Annotated[int, domains.MAP_STEPS] = 100,
    doublings: Annotated[int, domains.DOUBLINGS] = 4,
    chosen: Annotated[Given, options.MAP_ROBOT],
    plot_multipliers: Annotated[Path | None, options.PLOT] = None,
    results: Computed,
) -> None:
    """Follow the passive gait over the slope: where its period doubles, and where the robot falls.

    Newton's method finds the period doublings, the gaits with a multiplier of -1. The diagram shows the last steps of a
    walk on each slope.

    Map:
        slope_deg: Slopes of the diagram; around the period doublings if left out.
        slopes: Number of slopes, half of them in the range of the period doublings.
        steps: Steps on each slope.
        keep: Number of last steps that are kept.
        doublings: Period doublings to look for.

    Results:
        plot_multipliers: Write a figure of the multipliers.

    \b
    Examples:
      mjbiped bifurcation --plot bifurcation.png --plot-multipliers multipliers.png
      mjbiped bifurcation --slope-deg 4..5.2 --hip-mass 10 --leg-inertia 0 --json
      mjbiped bifurcation --robot kneed --plot knees.png
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.engines.checks import check_rule
    from mjbiped.limit_cycles.bifurcation import bifurcation_diagram, find_cascade
    from mjbiped.limit_cycles.periodic import check_biped, check_scuffing, follow

    if slope_deg is not None and math.radians(slope_deg[0]) < domains.DOWNHILL.low:
        raise click.UsageError("--slope-deg: slopes must be above 0, downhill.")
    if keep > steps:
        raise click.UsageError(f"--keep {keep} is more than the {steps} steps that are walked.")
    domains.KEPT.check("--keep times --slopes", keep * slopes)
    robot, rule = robot_of(chosen), scuffing_of(chosen)
    check_biped(robot)
    check_rule(robot, rule)
    if slope_deg is not None:  # before the search
        low, high = np.radians(slope_deg).tolist()
        check_scuffing(passive_gait_of(robot, low), low, rule)
    began = time.perf_counter()
    cascade = find_cascade(robot, doublings, progress=not results.quiet)
    if slope_deg is None:
        low, high = cascade.span
    grid = np.linspace(low, high, slopes)
    if cascade.window is not None:
        near = np.clip(cascade.window, low, high)
        if near[0] < near[1]:
            grid = np.union1d(np.linspace(low, high, slopes // 2), np.linspace(near[0], near[1], slopes - slopes // 2))
    searched = time.perf_counter()
    diagram = bifurcation_diagram(robot, grid, steps=steps, keep=keep, scuffing=rule, progress=not results.quiet)
    ended = time.perf_counter()
    columns = ("slopes", "states", "periods", "step_lengths", "outcomes")
    results.keep(diagram, *columns, onsets=cascade.onsets)

    def draw_multipliers(path: Path) -> None:
        from mjbiped.plotting import gaits as plot_gaits

        first = cascade.branches[0].gaits[0]
        places = np.arange(first.slope, high * 1.2, _MULTIPLIERS_EVERY)[1:].tolist()
        one = list(follow(first, places))
        plot_gaits.plot_multipliers([one, *(branch.gaits for branch in cascade.branches[1:4])], path)

    results.draw("gaits:plot_bifurcation", diagram, cascade)
    results.write("multipliers", plot_multipliers, draw_multipliers)
    results.end(_bifurcation_summary(cascade, diagram, steps, (searched - began, ended - searched)))


@command("basin")
@filled(forms=FORMS)
def basin(
    *,
    slope_deg: Annotated[float | None, domains.SLOPE_DEG] = None,
    controller: Annotated[str, Choice("NAME")] = "passive",
    stance_rates: Rates = None,
    swing_rates: Rates = None,
    grid: Annotated[int | None, domains.GRID] = None,
    limit: Annotated[int | None, domains.LIMIT] = None,
    threads: Annotated[int | None, domains.WORKERS] = None,
    law: Annotated[Given, [*options.MAP_LAW, *options.MAP_ROBOT]],
    results: Computed,
) -> None:
    """Map the initial rates of the legs from which the robot settles into walking, or falls.

    Each start stands just after an impact, both feet on the plane and the legs as far apart as in the gait. A
    controller's torque is not limited; the map shows the peak torque of each walk.

    Map:
        slope_deg: Slope of the plane; 2 for the passive robot, 0 with a controller.
        controller: 'passive', or a controller that imitates a gait, such as 'adaptive'; your own by its class: {forms}.
        stance_rates: Initial rates of the stance leg, rad/s; around the gait's if left out.
        swing_rates: Initial rates of the swing leg, rad/s; around the gait's if left out.
        grid: Number of starts along each side; 300, or 100 with a controller.
        limit: Greatest number of steps; 100, or 10 with a controller.
        threads: Number of threads; one for each core unless given.

    \b
    Examples:
      mjbiped basin --slope-deg 2 --plot basin.png --out basin.npz
      mjbiped basin --controller adaptive --stance-rates=-2..12 --swing-rates=-30..30 --plot controlled.png
      mjbiped basin --robot kneed --slope-deg 2.5
      mjbiped basin --controller my_law.py:MyLaw --gain stiffness=25 --grid 20
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.limit_cycles.basin import BasinInterrupted, BasinStopped, Fate, basin_of_attraction, basin_of_control

    robot = robot_of(law)
    controlled = controller != "passive"
    driver = controller_of(robot, law, controller)
    slope = math.radians(slope_deg if slope_deg is not None else (0.0 if controlled else 2.0))
    start = driver.gait if controlled else passive_gait_of(robot, slope)
    rates, count = _usual_rates(start, controlled=controlled), grid or (100 if controlled else 300)
    walk = (
        partial(basin_of_control, driver, slope, robot=robot)
        if controlled
        else partial(basin_of_attraction, robot, slope)
    )
    began = time.perf_counter()
    try:
        found = walk(
            stance_rates=np.linspace(*(stance_rates or rates[0]), count),
            swing_rates=np.linspace(*(swing_rates or rates[1]), count),
            limit=limit or (10 if controlled else 100),
            scuffing=scuffing_of(law),
            threads=threads,
            progress=not results.quiet,
        )
    except (BasinInterrupted, BasinStopped) as stop:
        found = stop.basin
        results.stopped(stop, "; what was not computed counts as undecided")
    seconds = time.perf_counter() - began
    columns = ("slope", "start", "stance_rates", "swing_rates", "fates", "steps", "peak_torque")
    results.keep(found, *columns, fate_names=[fate.name.lower() for fate in Fate])
    results.draw("gaits:plot_basins", [found])
    results.end(_basin_summary(found, seconds))


def _usual_rates(gait: Any, *, controlled: bool) -> tuple[Ends, Ends]:
    """Return the ranges of initial rates of stance and swing leg around a gait's, rad/s; zero without a gait."""
    greatest = 0.0 if gait is None else float(np.abs(gait.start[len(gait.start) // 2 :]).max())
    if controlled:
        return (-2.0 * greatest, 11.0 * greatest), (-25.0 * greatest, 25.0 * greatest)
    return (0.7 * greatest, 1.45 * greatest), (-1.5 * greatest, 2.2 * greatest)


def _map_summary(found: MapSlices) -> Summary:
    """Report the fixed point of a return map, its multipliers, and the period on which a walk from near it settles."""
    gait: Any = found.gait
    return {
        "slope_deg": math.degrees(gait.slope),
        "fixed_point": dict(zip(found.components, found.fixed_point.tolist(), strict=True)),
        "multipliers": [[value.real, value.imag] for value in gait.multipliers.tolist()],
        "stable": gait.stable,
        "outcome": found.outcome,
        "settled_period": 1 if found.settled is None and gait.stable else found.settled and len(found.settled.states),
    }


def _bifurcation_summary(
    cascade: Cascade, diagram: BifurcationDiagram, steps: int, seconds: tuple[float, float]
) -> Summary:
    """Report period doublings, and the slope from which the robot falls.

    Args:
        cascade: The onsets of the doublings.
        diagram: The walks.
        steps: Steps on each slope.
        seconds: Time of the search and of the walks, s.
    """
    return {
        "onsets_deg": np.degrees(cascade.onsets).tolist(),
        "ratios": cascade.ratios.tolist(),
        "accumulation_deg": math.degrees(cascade.accumulation),
        "cascade_end": cascade.end,
        "lost_deg": math.degrees(diagram.lost),
        "slopes": len(diagram.slopes),
        "steps": steps,
        "search_s": seconds[0],
        "diagram_s": seconds[1],
    }


def _basin_summary(found: Basin, seconds: float) -> Summary:
    """Report the share of a basin's starts by their fate, and the duration of the computation, s."""
    from mjbiped.limit_cycles.basin import Fate

    shares = {fate.name.lower(): found.share(fate) for fate in Fate}
    return {
        "walker": found.walker,
        "slope_deg": math.degrees(found.slope),
        "starts": found.fates.size,
        "shares": shares,
        "mean_steps_to_settle": float(found.steps[found.fates == Fate.SETTLED].mean()) if shares["settled"] else None,
        "seconds": seconds,
    }
