"""The command `mjbiped reference`: an optimised gait, what it asks of the robot, and its picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mjbiped.cli import options, sections
from mjbiped.cli.files import Files
from mjbiped.cli.robots import robot_of
from mjbiped.gaits.optimised import FRICTION, SPEED, OptimisedGait, OptimisedKneedGait, find_reference
from mjbiped.records.tables import table_of
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains


@click.command("reference", cls=sections.SectionCommand)
@sections.options(
    "Gait",
    ("--speed", domains.SPEED, SPEED, "Mean speed on level ground, m/s."),
    (
        "--clearance",
        domains.CLEARANCE,
        0.06,
        "Height of the swing foot at some moment of the step, m; 0 for no demand on its path.",
    ),
    (
        "--retraction/--no-retraction",
        bool,
        True,
        "Let the foot go no further forward from that moment on; without it the same height costs less.",
    ),
    ("--torque-limit", domains.TORQUE, None, "Greatest torque of each joint, N m; no limit unless given."),
    ("--friction", domains.NEEDED_FRICTION, FRICTION, "Greatest friction that is asked of the ground."),
)
@options.robot_options
@options.plot_option
@options.json_option
@click.pass_context
def reference(
    ctx: click.Context,
    /,
    speed: float,
    clearance: float,
    retraction: bool,
    torque_limit: float | None,
    friction: float,
    plot: Path | None,
    json: bool,
    **values: Any,
) -> None:
    """Find the gait on level ground that costs least and lifts its swing foot so high.

    Controllers track it with `mjbiped walk --reference`. What has been found is kept in the user's cache folder, or
    where the environment variable MJBIPED_CACHE_DIR says.

    \b
    Examples:
      mjbiped reference --clearance 0.06 --plot reference.png
      mjbiped reference --speed 0.6 --clearance 0 --json
      mjbiped reference --robot kneed --clearance 0.08 --plot knees.png
      mjbiped walk stairs:rise=0.05 --reference clearance=0.06 --gain replanning=additive
    """  # noqa: D301 (click reads the backspace)
    robot = robot_of(ctx, values)
    assert isinstance(robot, Compass | KneedBiped)
    gait = find_reference(
        robot,
        speed=speed,
        clearance=clearance,
        retraction=retraction,
        torque_limit=torque_limit,
        friction=friction,
    )
    files = Files()
    kneed = isinstance(gait, OptimisedKneedGait)
    files.plot(plot, "kneed:plot_kneed_reference" if kneed else "reference:plot_reference", gait)
    files.end(_summary(gait), [_table(gait)], json=json, quiet=False)


def _summary(gait: OptimisedGait | OptimisedKneedGait) -> dict[str, Any]:
    """The gait in plain JSON types; states are the robot's angles (rad), then their rates (rad/s)."""
    told = gait.measures
    return {
        "speed_m_per_s": gait.speed,
        "cost_of_transport": told.cost_of_transport,
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "half_angle_rad": float(gait.end[0]),
        **{f"peak_{joint}_torque_Nm": told.peak_torque[k] for k, joint in enumerate(gait.robot.joints)},
        "least_normal_force_weights": told.normal_force / gait.robot.weight,
        "friction": told.friction,
        "clearance_phase": gait.clearance_phase if gait.goal.clearance else None,
        "clearance_m": told.clearance if gait.goal.clearance else None,
        "greatest_clearance_m": told.greatest_clearance,
        "state_after_impact": gait.start.tolist(),
        "state_before_impact": gait.end.tolist(),
        **({"knee_strike_s": gait.knee_strike} if isinstance(gait, OptimisedKneedGait) else {}),
    }


def _table(gait: OptimisedGait | OptimisedKneedGait) -> Any:
    told = gait.measures
    rows = [
        ("speed", f"{gait.speed:.4f}", "m/s"),
        ("cost of transport, level", f"{told.cost_of_transport:.4f}", ""),
        ("period", f"{gait.period:.6f}", "s"),
        ("half the angle between the legs at the impact", f"{gait.end[0]:.6f}", "rad"),
        ("step length", f"{gait.step_length:.6f}", "m"),
        *((f"peak torque, {name}", f"{told.peak_torque[k]:.2f}", "N m") for k, name in enumerate(gait.robot.joints)),
        ("normal force, least", f"{told.normal_force / gait.robot.weight:.3f}", "weights"),
        ("friction used", f"{told.friction:.3f}", ""),
    ]
    if isinstance(gait, OptimisedKneedGait):
        rows.append(("knee strike", f"{gait.knee_strike:.6f}", "s"))
    if gait.goal.clearance:
        rows.append((f"clearance at {100 * gait.clearance_phase:.1f} % of the step", f"{told.clearance:.4f}", "m"))
    rows.append(("clearance ahead of the stance foot, greatest", f"{told.greatest_clearance:.4f}", "m"))
    return table_of(rows)
