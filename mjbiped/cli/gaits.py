"""The commands `mjbiped gait`, `reference` and `stability`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from mjbiped.cli import kinds, options, sections, summaries
from mjbiped.cli.files import Results
from mjbiped.cli.sections import results
from mjbiped.cli.walkers import robot_of
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.optimised import FRICTION, SPEED, find_reference
from mjbiped.gaits.steps import Goal
from mjbiped.records.record import Walk
from mjbiped.utils import domains


@click.command("gait", cls=sections.SectionCommand)
@sections.options("Gait", ("--slope-deg", domains.SLOPE_DEG, "Slope of the plane, positive downhill.", 2.0))
@options.robot_options
@results(*options.PLOT, *options.PRINTED)
@click.pass_context
def gait(ctx: click.Context, /, results: Results, slope_deg: float, **values: object) -> None:
    """Find the passive gait on a slope, its limit cycle and its stability.

    With straight legs the swing foot passes through the ground while it is beside the stance foot; with knees it clears
    the ground. A rimless wheel rolls.

    \b
    Examples:
      mjbiped gait --slope-deg 3 --plot cycle.pdf
      mjbiped gait --slope-deg 3 --leg-inertia 0 --hip-mass 10 --json
      mjbiped gait --robot kneed --slope-deg 2.5 --plot knees.png
      mjbiped gait --robot wheel --slope-deg 5
    """  # noqa: D301 (click reads the backspace)
    robot, slope = robot_of(ctx, values), math.radians(slope_deg)
    found: Any = passive_gait_of(robot, slope)
    results.draw("gait:plot_gait", found)
    results.end(summaries.gait_summary(found))


@click.command("reference", cls=sections.SectionCommand)
@options.field_options("Gait", Goal, speed=SPEED, clearance=0.06, retraction=True, torque_limit=None, friction=FRICTION)
@options.robot_options
@results(*options.PLOT, *options.PRINTED)
@click.pass_context
def reference(ctx: click.Context, /, results: Results, **values: Any) -> None:
    """Find the cheapest gait on level ground that lifts its swing foot to a given height.

    Controllers track it with `mjbiped walk --reference`. Results are kept in the user's cache folder, or in
    the folder that the environment variable MJBIPED_CACHE_DIR names.

    \b
    Examples:
      mjbiped reference --clearance 0.06 --plot reference.png
      mjbiped reference --speed 0.6 --clearance 0 --json
      mjbiped reference --robot kneed --clearance 0.08 --plot knees.png
      mjbiped walk stairs:rise=0.05 --reference clearance=0.06 --gain replanning=additive
    """  # noqa: D301 (click reads the backspace)
    robot: Any = robot_of(ctx, values)
    found = find_reference(robot, **values)
    results.draw("gait:plot_gait", found)
    results.end(summaries.reference_summary(found))


_OWN = "Your own controller class, if it made the walk: a record never decides which code is loaded."


@click.command("stability", cls=sections.SectionCommand)
@click.argument("record", type=click.Path(path_type=Path))
@sections.options("Walk", ("--controller", kinds.OWN_CONTROLLER, _OWN))
@results(*options.PLOT, *options.PRINTED)
def stability(record: Path, results: Results, controller: str | None) -> None:
    """Evaluate the paper's Theorem 1 along the walk of RECORD, an .npz file.

    The walk is an adaptive controller's, of either engine. docs/stability.md explains the numbers.

    \b
    Examples:
      mjbiped walk mixed --engine hybrid --no-estimate-update --out walk.npz
      mjbiped stability walk.npz --plot stability.png
      mjbiped stability mine.npz --controller mine.py:MyAdaptive
    """  # noqa: D301 (click reads the backspace)
    # only this command needs SciPy's linear algebra
    from mjbiped.analysis.stability import recorded_controller
    from mjbiped.analysis.stability import stability as evaluated

    done = Walk.load(record)
    found = evaluated(done, recorded_controller(done, controller))
    results.draw("stability:plot_stability", {record.stem: found})
    results.end(summaries.stability_summary(found))
