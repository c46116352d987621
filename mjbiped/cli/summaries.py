"""Results of `mjbiped gait`, `reference`, `stability` and of the maps of many walks, in plain JSON types.

A name ends with its unit, if it has one. `mjbiped.cli.files.Results` prints a result as a table or as JSON.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from mjbiped.analysis.stability import Stability
    from mjbiped.gaits.optimised import OptimisedGait
    from mjbiped.limit_cycles.basin import Basin
    from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade
    from mjbiped.limit_cycles.map_slices import MapSlices

Summary = dict[str, Any]


def gait_summary(gait: Any) -> Summary:
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


def reference_summary(gait: OptimisedGait) -> Summary:
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


def stability_summary(found: Stability) -> Summary:
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


def map_summary(found: MapSlices) -> Summary:
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


def bifurcation_summary(
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


def basin_summary(found: Basin, seconds: float) -> Summary:
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
