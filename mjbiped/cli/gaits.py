"""The commands `gait`, `reference` and `stability`.

A name in their results ends with its unit, if it has one. `mjbiped.cli.results.Results` prints a result as a table or
as JSON.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from mjbiped.cli import options
from mjbiped.cli.commands import Choice, Given, command, options_of
from mjbiped.cli.results import Plotted, Summary
from mjbiped.cli.walkers import robot_of
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.optimised import FRICTION, SPEED, OptimisedGait, find_reference
from mjbiped.gaits.steps import Goal
from mjbiped.records.record import Walk
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.analysis.stability import Stability

_GOAL = options_of(Goal, "Gait", speed=SPEED, clearance=0.06, retraction=True, torque_limit=None, friction=FRICTION)


@command("gait")
def gait(
    *, slope_deg: Annotated[float, domains.SLOPE_DEG] = 2.0, chosen: Annotated[Given, options.ROBOT], results: Plotted
) -> None:
    """Find the passive gait on a slope, its limit cycle and its stability.

    With straight legs the swing foot passes through the ground while it is beside the stance foot; with knees it clears
    the ground. A rimless wheel rolls.

    Gait:
        slope_deg: Slope of the plane, positive downhill.

    \b
    Examples:
      mjbiped gait --slope-deg 3 --plot cycle.pdf
      mjbiped gait --slope-deg 3 --leg-inertia 0 --hip-mass 10 --json
      mjbiped gait --robot kneed --slope-deg 2.5 --plot knees.png
      mjbiped gait --robot wheel --slope-deg 5
    """  # noqa: D301 (click reads the backspace)
    found: Any = passive_gait_of(robot_of(chosen), math.radians(slope_deg))
    results.draw("gait:plot_gait", found)
    results.end(_gait_summary(found))


@command("reference")
def reference(*, goal: Annotated[Given, _GOAL], chosen: Annotated[Given, options.ROBOT], results: Plotted) -> None:
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
    robot: Any = robot_of(chosen)
    found = find_reference(robot, **goal)
    results.draw("gait:plot_gait", found)
    results.end(_reference_summary(found))


@command("stability")
def stability(
    record: Annotated[Path, options.FILE],
    /,
    *,
    controller: Annotated[str | None, Choice("FILE.py:CLASS")] = None,
    results: Plotted,
) -> None:
    """Evaluate the paper's Theorem 1 along the walk of RECORD, an .npz file.

    An adaptive controller must have made the walk, in either engine. The page "stability" of the documentation
    explains the numbers.

    Walk:
        controller: Your own controller class, if it made the walk; mjbiped never loads code that only a record names.

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
    results.draw("comparison:plot_stability", {record.stem: found})
    results.end(_stability_summary(found))


def _gait_summary(gait: Any) -> Summary:
    """Report a passive gait; states are the robot's angles (rad), then their rates (rad/s)."""
    if "knee" in gait.robot.joints:
        own = {
            "state_after_heel_strike": gait.start.tolist(),
            "rates_before_knee_strike": gait.knee_rates.tolist(),
            "state_before_heel_strike": gait.end.tolist(),
            "knee_strike_s": gait.knee_strike,
            "clearance_m": gait.clearance,
            "greatest_flexion_deg": math.degrees(gait.greatest_flexion),
        }
    else:
        states = {"state_after_impact": gait.start.tolist(), "state_before_impact": gait.end.tolist()}
        own = {**states, "energy_J": gait.energy}
    found: list[complex] = gait.multipliers.tolist()
    return {
        "slope_deg": math.degrees(gait.slope),
        **own,
        **{"period_s": gait.period, "step_length_m": gait.step_length, "speed_m_per_s": gait.speed},
        "multipliers": [{"real": each.real, "imaginary": each.imag, "modulus": abs(each)} for each in found],
        "stable": gait.stable,
    }


def _reference_summary(gait: OptimisedGait) -> Summary:
    """Report an optimised gait; states are the robot's angles (rad), then their rates (rad/s)."""
    found = gait.measures
    return {
        "speed_m_per_s": gait.speed,
        "cost_of_transport": found.cost_of_transport,
        "period_s": gait.period,
        "step_length_m": gait.step_length,
        "half_angle_rad": float(gait.end[0]),
        **{f"peak_{joint}_torque_Nm": found.peak_torque[k] for k, joint in enumerate(gait.robot.joints)},
        "least_normal_force_weights": found.normal_force / gait.robot.weight,
        "friction": found.friction,
        "clearance_phase": gait.clearance_phase if gait.goal.clearance else None,
        "clearance_m": found.clearance if gait.goal.clearance else None,
        "greatest_clearance_m": found.greatest_clearance,
        "state_after_impact": gait.start.tolist(),
        "state_before_impact": gait.end.tolist(),
        **({"knee_strike_s": gait.knee_strike} if gait.knee_strike else {}),
    }


def _stability_summary(found: Stability) -> Summary:
    """Report on Theorem 1 along a walk; results that need more than one step are None for a walk of one."""
    norms = np.linalg.norm(found.end, axis=1)
    compared = found.ratio[np.isfinite(found.ratio)]
    left = found.condition[1:]
    within = np.diff(found.step) == 0
    return {
        "steps": found.steps,
        "excitation_smallest_eigenvalue": float(found.excitation[:, 0].min()),
        "excitation_largest_eigenvalue": float(found.excitation[:, 1].max()),
        "excitation_weak_direction_from_cosine_deg": math.degrees(float(found.weak_direction.max())),
        "transition_norm_smallest": float(found.contraction.min()),
        "transition_norm_largest": float(found.contraction.max()),
        "condition_24_smallest": float(left.min()) if left.size else None,
        "condition_24_smallest_for_any_constants": float(found.condition_floor.min()),
        "condition_24_holds_steps": int((left < 1.0).sum()),
        "errors_26_compared_steps": int(compared.size),
        "errors_26_holds_steps": int((compared < 1.0).sum()),
        "lyapunov_largest_rise_within_a_step": max(0.0, float(np.diff(found.lyapunov)[within].max())),
        "lyapunov_largest_jump_at_a_touchdown": float(found.lyapunov_jump[1:].max()) if found.steps > 1 else None,
        "lyapunov_balance_largest": float(np.abs(found.balance).max()),
        "estimate_error_largest_rise_within_a_step": float(found.estimate_rise.max()),
        "error_before_last_touchdown": float(norms[-1]),
        "residual_largest": float(found.residual.max()),
    }
