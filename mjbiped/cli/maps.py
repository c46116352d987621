"""The commands `mjbiped return-map`, `bifurcation` and `basin`: maps of many walks."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from mjbiped.cli import kinds, options, sections, summaries
from mjbiped.cli.ending import INTERRUPTED
from mjbiped.cli.files import Results
from mjbiped.cli.sections import results, taken
from mjbiped.cli.walkers import controller_of, robot_of
from mjbiped.control.loading import FORMS
from mjbiped.gaits.described import passive_gait_of
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.utils import domains

_MULTIPLIERS_EVERY = math.radians(0.02)
_MULTIPLIERS: sections.Row = ("--plot-multipliers", kinds.PLOT, "Write a figure of the multipliers.")


@click.command("return-map", cls=sections.SectionCommand)
@sections.options(
    "Map",
    ("--slope-deg", domains.SLOPE_DEG, "Slope of the plane, positive downhill.", 2.0),
    ("--points", domains.SLOPES, "Number of steps in each slice of the map.", 400),
    ("--steps", domains.MAP_STEPS, "Number of steps of the walk.", 40),
)
@options.scuffing_option("Map")
@options.robot_options
@results(options.DATA, *options.PLOT, *options.PRINTED)
@click.pass_context
def return_map(ctx: click.Context, /, results: Results, **values: object) -> None:
    """Show how a step of the passive robot maps the state after an impact onto the next one.

    Angle and rates of the legs after a step, over the same before it; the gait, where the map meets the diagonal; its
    multipliers; and a walk that begins 2 % off the gait.

    \b
    Examples:
      mjbiped return-map --slope-deg 2 --plot map.pdf
      mjbiped return-map --slope-deg 3.2 --steps 200 --plot doubled.png
      mjbiped return-map --robot kneed --slope-deg 2.5 --out map.npz
      mjbiped return-map --robot wheel --slope-deg 5 --plot wheel.png
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.limit_cycles.map_slices import map_slices

    slope_deg, points, steps, reach = taken(ctx, values, "Map").values()
    robot = robot_of(ctx, values)
    found = map_slices(robot, math.radians(slope_deg), points=points, steps=steps, scuffing=ScuffingRule(reach=reach))
    columns = ("components", "fixed_point", "before", "after", "walk")
    results.save_arrays({name: getattr(found, name) for name in columns})
    results.draw("gaits:plot_return_map", found)
    results.end(summaries.map_summary(found))


@click.command("bifurcation", cls=sections.SectionCommand)
@sections.options(
    "Diagram",
    ("--slope-deg", kinds.span(domains.SLOPE_DEG), "Slopes of the diagram; around the period doublings if left out."),
    ("--slopes", domains.SLOPES, "Number of slopes; half of them where the period keeps doubling.", 1000),
    ("--steps", domains.MAP_STEPS, "Steps on each slope.", 600),
    ("--keep", domains.MAP_STEPS, "Number of last steps that are kept.", 100),
    ("--doublings", domains.DOUBLINGS, "Period doublings to look for.", 4),
)
@options.scuffing_option("Diagram")
@options.robot_options
@results(options.DATA, *options.PLOT, _MULTIPLIERS, *options.PRINTED)
@click.pass_context
def bifurcation(ctx: click.Context, /, results: Results, **values: object) -> None:
    """Follow the passive gait over the slope: where its period doubles, and where the robot falls.

    The onsets are zeros of a multiplier plus one on the branches of gaits, found by Newton's method; the diagram is
    walked, slope by slope.

    \b
    Examples:
      mjbiped bifurcation --plot bifurcation.png --plot-multipliers multipliers.png
      mjbiped bifurcation --slope-deg 4..5.2 --hip-mass 10 --leg-inertia 0 --json
      mjbiped bifurcation --robot kneed --plot knees.png
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.engines.checks import check_rule
    from mjbiped.limit_cycles.bifurcation import bifurcation_diagram, find_cascade
    from mjbiped.limit_cycles.periodic import follow
    from mjbiped.limit_cycles.section import check_biped, check_scuffing

    slope_deg, slopes, steps, keep, doublings, reach = taken(ctx, values, "Diagram").values()
    if slope_deg is not None and math.radians(slope_deg[0]) < domains.DOWNHILL.low:
        raise click.UsageError("--slope-deg: slopes must be above 0, downhill.")
    if keep > steps:
        raise click.UsageError(f"--keep {keep} is more than the {steps} steps that are walked.")
    domains.KEPT.check("--keep times --slopes", keep * slopes)
    robot, rule = robot_of(ctx, values), ScuffingRule(reach=reach)
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
    results.save_arrays({**{name: getattr(diagram, name) for name in columns}, "onsets": cascade.onsets})

    def draw_multipliers(path: Path) -> None:
        from mjbiped.plotting import gaits as plot_gaits

        first = cascade.branches[0].gaits[0]
        places = np.arange(first.slope, high * 1.2, _MULTIPLIERS_EVERY)[1:].tolist()
        one = list(follow(first, places))
        plot_gaits.plot_multipliers([one, *(branch.gaits for branch in cascade.branches[1:4])], path)

    results.draw("gaits:plot_bifurcation", diagram, cascade)
    results.write("multipliers", results.plot_multipliers, draw_multipliers)
    results.end(summaries.bifurcation_summary(cascade, diagram, steps, (searched - began, ended - searched)))


class _Basin:
    """Options of a map of starts.

    Attributes:
        slope_deg: Slope of the plane; 2 for the passive robot, 0 with a controller.
        controller: 'passive', or a controller that imitates a gait, such as 'adaptive'; your own by its class: {forms}.
        stance_rates: Initial rates of the stance leg, rad/s; around the gait's if left out.
        swing_rates: Initial rates of the swing leg, rad/s; around the gait's if left out.
        grid: Number of starts along each side; 300, or 100 with a controller.
        limit: Greatest number of steps; 100, or 10 with a controller.
        threads: Number of threads; one for each core unless given.
    """

    slope_deg = domains.SLOPE_DEG
    controller = kinds.CONTROLLER, "passive"
    stance_rates = swing_rates = kinds.span(domains.RATE)
    grid = domains.GRID
    limit = domains.LIMIT
    threads = domains.WORKERS


@click.command("basin", cls=sections.SectionCommand)
@sections.options("Map", *sections.rows_of(_Basin, forms=FORMS))
@sections.options(options.ADAPTIVE, options.IMITATE, options.REFERENCE)
@options.gain_option("Map")
@options.scuffing_option("Map")
@options.robot_options
@results(options.DATA, *options.PLOT, *options.PRINTED)
@click.pass_context
def basin(ctx: click.Context, /, results: Results, scuffing_reach: float, **values: Any) -> None:
    """Map the initial rates of the legs from which the robot settles into walking, or falls.

    Each start stands just after an impact, both feet on the plane and the legs as far apart as in the gait. A
    controller's torques are not bounded; the map shows the greatest.

    \b
    Examples:
      mjbiped basin --slope-deg 2 --plot basin.png --out basin.npz
      mjbiped basin --controller adaptive --stance-rates=-2..12 --swing-rates=-30..30 --plot controlled.png
      mjbiped basin --robot kneed --slope-deg 2.5
      mjbiped basin --controller my_law.py:MyLaw --gain stiffness=25 --grid 20
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.limit_cycles.basin import BasinInterrupted, BasinStopped, Fate, basin_of_attraction, basin_of_control

    robot = robot_of(ctx, values)
    controlled = values["controller"] != "passive"
    law = controller_of(ctx, robot, values)
    slope_deg, grid, limit = (values.pop(name) for name in ("slope_deg", "grid", "limit"))
    slope = math.radians(slope_deg if slope_deg is not None else (0.0 if controlled else 2.0))
    gait = law.gait if controlled else passive_gait_of(robot, slope)
    settings: dict[str, Any] = {"scuffing": ScuffingRule(reach=scuffing_reach), "progress": not results.quiet}
    settings |= {"limit": limit or (10 if controlled else 100), "threads": values["threads"]}
    settings |= _rates(gait, grid or (100 if controlled else 300), controlled, values)
    began, trouble = time.perf_counter(), (0, "")
    try:
        if controlled:
            found = basin_of_control(law, slope, robot=robot, **settings)
        else:
            found = basin_of_attraction(robot, slope, **settings)
    except BasinInterrupted as stop:
        found, trouble = stop.basin, (INTERRUPTED, "the map was interrupted")
    except BasinStopped as stop:
        found, trouble = stop.basin, (1, str(stop))
    seconds = time.perf_counter() - began
    columns = ("slope", "start", "stance_rates", "swing_rates", "fates", "steps", "peak_torque")
    names = [fate.name.lower() for fate in Fate]
    results.save_arrays({**{name: getattr(found, name) for name in columns}, "fate_names": names})
    status, reason = trouble
    if reason:
        results.fail(status, f"{reason}; what was not computed counts as undecided")
    results.draw("gaits:plot_basins", [found])
    results.end(summaries.basin_summary(found, seconds))


def _rates(gait: Any, count: int, controlled: bool, values: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Return the initial rates along both sides of the map, rad/s; by default a range around the gait's rates."""
    rates = gait.start[len(gait.start) // 2 :] if gait is not None else np.zeros(1)  # refused later
    greatest = float(np.abs(rates).max())
    around = ((-2.0, 11.0), (-25.0, 25.0)) if controlled else ((0.7, 1.45), (-1.5, 2.2))
    sides = {}
    for name, (low, high) in zip(("stance_rates", "swing_rates"), around, strict=True):
        first, last = values[name] or (low * greatest, high * greatest)
        sides[name] = np.linspace(first, last, count)
    return sides
