"""Measures of a walk, each defined once for every engine; SI units and radians."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError

if TYPE_CHECKING:
    from mjbiped.record import Walk

WORK_KINDS = ("absolute", "net", "positive")


def distance(walk: Walk) -> float:
    """Horizontal way of the stance foot from x = 0 to the last touchdown, m."""
    return float(walk.touchdowns["x"][-1]) if walk.steps else 0.0


def work(walk: Walk, kind: str = "absolute") -> float:
    """Mechanical work of ankle and hip up to the last touchdown, J.

    Args:
        walk: The walk.
        kind: "absolute" ∫ |τ₁ q̇₁| + |τ₂ (q̇₂ - q̇₁)| dt, "net" (with its sign), or "positive" (positive power alone).

    Raises:
        InputError: The kind is unknown.
    """
    if kind not in WORK_KINDS:
        raise InputError(f"unknown kind of work {kind!r}; valid are {', '.join(WORK_KINDS)}")
    return float(walk.touchdowns[f"work_{kind}"][-1]) if walk.steps else 0.0


def cost_of_transport(walk: Walk, kind: str = "absolute") -> float:
    """Mechanical cost of transport c_mt: work / (weight · distance); NaN for a walk that got nowhere.

    Args:
        walk: The walk.
        kind: See `work`; the paper's c_mt is fitted by "absolute".

    Raises:
        InputError: The kind is unknown.
    """
    done, way = work(walk, kind), distance(walk)
    return done / (walk.robot.weight * way) if way > 0.0 else math.nan


def speed(walk: Walk) -> float:
    """Mean horizontal speed up to the last touchdown, m/s; NaN without one."""
    return distance(walk) / float(walk.touchdowns["time"][-1]) if walk.steps else math.nan


def step_lengths(walk: Walk) -> NDArray[np.float64]:
    """Distance from one stance foot to the next, shape (steps,), m."""
    x = np.append(0.0, walk.touchdowns["x"])
    z = np.append(walk.terrain.height(0.0), walk.touchdowns["z"])
    return np.asarray(np.hypot(np.diff(x), np.diff(z)), dtype=np.float64)


def step_periods(walk: Walk) -> NDArray[np.float64]:
    """Time from one touchdown to the next, shape (steps,), s."""
    return np.asarray(np.diff(np.append(0.0, walk.touchdowns["time"])), dtype=np.float64)


def estimate_errors(walk: Walk) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors of the slope estimate, estimate minus truth, rad; NaN for a controller without one.

    Returns:
        At each step's beginning, after the update (27) at its touchdown, and at each step's end, before the next
        touchdown's update; shape (steps,) each. The last beginning is that of the step that was not walked any more.
    """
    touchdowns = walk.touchdowns
    slope_before = np.append(walk.terrain.slope(0.0), touchdowns["slope"])[:-1]
    return touchdowns["slope_estimate"] - touchdowns["slope"], touchdowns["slope_estimate_before"] - slope_before


def impact_errors(walk: Walk) -> NDArray[np.float64]:
    """Rates after each impact against the paper's impact map (2) of the state before it, shape (steps, 2).

    Relative: measured / map - 1, for the new stance and the new swing leg. What a simulator samples before and after an
    impact lies a physics step apart, and the motion in between is part of this number.
    """
    robot, touchdowns = walk.robot, walk.touchdowns
    mapped = [robot.impact(q, dq)[1] for q, dq in zip(touchdowns["q_before"], touchdowns["dq_before"], strict=True)]
    return np.asarray(touchdowns["dq"] / np.reshape(mapped, (-1, 2)) - 1.0, dtype=np.float64)


def summary(walk: Walk) -> dict[str, Any]:
    """All measures of a walk in plain JSON types; angles here are in degrees, as the names say.

    A measure that does not exist (a cost without a distance, an estimate of a controller that makes none) is None.
    """
    touchdowns = walk.touchdowns
    begun, ended = estimate_errors(walk)

    def largest(values: NDArray[np.float64]) -> float:
        return float(np.max(values)) if values.size else math.nan

    def mean(values: NDArray[np.float64]) -> float:
        return float(np.mean(values)) if values.size else math.nan

    measured = {
        "steps": walk.steps,
        "distance_m": distance(walk),
        "time_s": float(touchdowns["time"][-1]) if walk.steps else 0.0,
        "speed_m_per_s": speed(walk),
        "mean_step_length_m": mean(step_lengths(walk)),
        "mean_step_period_s": mean(step_periods(walk)),
        "cost_of_transport": cost_of_transport(walk),
        "cost_of_transport_net": cost_of_transport(walk, "net"),
        "cost_of_transport_positive": cost_of_transport(walk, "positive"),
        "peak_ankle_torque_Nm": float(walk.peak_torque[0]),
        "peak_hip_torque_Nm": float(walk.peak_torque[1]),
        "estimate_error_at_touchdown_deg": math.degrees(largest(np.abs(begun))),
        "estimate_error_at_step_end_deg": math.degrees(largest(np.abs(ended))),
        "final_estimate_error_deg": math.degrees(float(ended[-1])) if walk.steps else math.nan,
        "largest_impact_error": largest(np.abs(impact_errors(walk))),
        "largest_slip_m": largest(touchdowns["slip"]),
        "largest_penetration_m": largest(touchdowns["penetration"]),
        "largest_stance_friction": largest(touchdowns["friction"]),
        "strikes": int(np.sum(touchdowns["strikes"])),
    }
    plain = {
        name: None if isinstance(value, float) and math.isnan(value) else value for name, value in measured.items()
    }
    return {
        "outcome": walk.outcome,
        "ended_at_time_s": walk.end[0],
        "ended_at_x_m": walk.end[1],
        **plain,
        "warnings": dict(walk.settings.get("warnings", {})),
    }
