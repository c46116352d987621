"""Measures in the summary of a walk: names, displayed units, and values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from mjbiped.records import stance_knee
from mjbiped.records.pressure import shortest_foot
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot

if TYPE_CHECKING:
    from mjbiped.records.measures import Summary
    from mjbiped.records.record import Walk

OF_STANCE_KNEE = ("peak_stance_knee_torque_Nm", "cost_of_transport_stance_knee")
"""Keys of the measures of the stance knee of a robot with knees. The torque of a lock is known from samples alone."""

Value: TypeAlias = Callable[["Summary", "Walk"], float | None]
"""Function that computes a measure from a summary and the walk's record, which may lack the touchdowns."""


class Measure(NamedTuple):
    """A measure in a summary: label, key, factor to the displayed unit, format, that unit, and value.

    Robots without the `joint` lack the measure.
    """

    label: str
    key: str
    factor: float
    form: str
    unit: str
    value: Value
    joint: str = ""


def ratio(part: float, whole: float) -> float:
    """Divide two numbers; NaN where the divisor is not positive."""
    return part / whole if whole > 0.0 else math.nan


def _cost(work: str) -> Value:
    return lambda s, _: ratio(s.last[work], s.robot.weight * s.last["x"])


def _peak(joint: str) -> Value:
    return lambda s, walk: float(walk.peak_torque[s.robot.joints.index(joint)])


def _largest(name: str) -> Value:
    return lambda s, _: s.largest(name)


def _worst(name: str) -> Value:
    """Largest error of the slope estimate, degrees."""
    return lambda s, _: math.degrees(s.largest(name))


def _least(s: Summary, _: Walk) -> float:
    return s.least_force / s.robot.weight if s.steps else math.nan


def _held(s: Summary, walk: Walk) -> float:
    """Greatest torque of the stance knee, N m: of a motor at the touchdowns, of a lock in the samples."""
    return float(np.fmax(stance_knee.peak_torque(walk), s.largest("stance_knee")))


def _foot(s: Summary, walk: Walk) -> float:
    ahead, behind = s.largest("ahead"), s.largest("behind")
    return shortest_foot(walk.pressure_times, walk.end[0], ahead, behind, s.robot.leg_length)


def _bound(s: Summary, _: Walk) -> float:
    """Share of the time in which the sole has not transmitted the ankle torque asked for; NaN without a sole."""
    return math.nan if s.robot.sole is None else ratio(s.last["sole_bound_time"], s.last["time"])


_ROWS: tuple[tuple[Any, ...], ...] = (
    ("steps", "steps", 1, "d", "", lambda s, _: s.steps),
    ("distance", "distance_m", 1, ".3f", "m", lambda s, _: s.last["x"]),
    ("last touchdown at", "time_s", 1, ".3f", "s", lambda s, _: s.last["time"]),
    ("speed", "speed_m_per_s", 1, ".4f", "m/s", lambda s, _: ratio(s.last["x"], s.last["time"])),
    ("step length, mean", "mean_step_length_m", 1, ".4f", "m", lambda s, _: ratio(s.sums["length"], s.steps)),
    ("step period, mean", "mean_step_period_s", 1, ".4f", "s", lambda s, _: ratio(s.last["time"], s.steps)),
    ("cost of transport, absolute", "cost_of_transport", 1, ".4f", "", _cost("work_absolute")),
    ("cost of transport, net", "cost_of_transport_net", 1, ".4f", "", _cost("work_net")),
    ("cost of transport, positive", "cost_of_transport_positive", 1, ".4f", "", _cost("work_positive")),
    ("peak torque, ankle", "peak_ankle_torque_Nm", 1, ".2f", "N m", _peak("ankle"), "ankle"),
    ("peak torque, hip", "peak_hip_torque_Nm", 1, ".2f", "N m", _peak("hip"), "hip"),
    ("peak torque, swing knee", "peak_knee_torque_Nm", 1, ".2f", "N m", _peak("knee"), "knee"),
    ("peak torque, stance knee", OF_STANCE_KNEE[0], 1, ".2f", "N m", _held, "knee"),
    ("cost of transport, stance knee's part", OF_STANCE_KNEE[1], 1, ".4f", "", _cost("stance_knee_work"), "knee"),
    ("estimate error at touchdown, largest", "estimate_error_at_touchdown_deg", 1, ".4f", "deg", _worst("started")),
    ("estimate error at step end, largest", "estimate_error_at_step_end_deg", 1, ".4f", "deg", _worst("ended")),
    ("final estimate error", "final_estimate_error_deg", 1, ".4f", "deg", lambda s, _: math.degrees(s.last_error)),
    ("impact against the impact map, worst", "largest_impact_error", 1e2, ".3f", "%", _largest("impact")),
    ("slip, largest", "largest_slip_m", 1e3, ".4f", "mm", _largest("slip")),
    ("penetration, largest", "largest_penetration_m", 1e3, ".4f", "mm", _largest("penetration")),
    ("stance friction used, largest", "largest_stance_friction", 1, ".3f", "", _largest("friction")),
    ("normal force on the stance foot, least", "least_normal_force_weights", 1, ".3f", "weights", _least),
    ("steps in which the ground would have to pull", "steps_that_pull", 1, "d", "", lambda s, _: s.counted("pulls")),
    (
        "steps that violate the contact (pull, or friction over 0.8)", "steps_violating_contact", 1, "d", "",
        lambda s, _: s.counted("violations"),
    ),
    ("centre of pressure, ahead of the ankle at most", "pressure_ahead_m", 1e2, ".2f", "cm", _largest("ahead")),
    ("centre of pressure, behind it at most", "pressure_behind_m", 1e2, ".2f", "cm", _largest("behind")),
    ("foot that holds it 99 % of the time, length", "foot_length_99_percent_m", 1e2, ".1f", "cm", _foot),
    ("time in which the sole transmits less than asked", "share_of_time_at_sole_bound", 1e2, ".1f", "%", _bound),
    ("impacts on vertical faces", "strikes", 1, "d", "", lambda s, _: int(s.sums["strikes"])),
)  # fmt: skip


def measures_of(robot: type[Robot]) -> tuple[Measure, ...]:
    """Measures in the summary of a kind of robot, in the order in which they are shown."""
    return tuple(measure for row in _ROWS if (measure := Measure(*row)).joint in ("", *robot.joints))


MEASURES = measures_of(Compass)
"""Measures in the summary of the compass biped."""


def in_words(value: float | None, factor: float, form: str) -> str:
    """Format a measure for display; a dash stands for one that does not exist."""
    if value is None or value == math.inf:
        return "-" if value is None else "unbounded"
    text = format(value * factor, form)
    return text if text.strip("-0.") else text.lstrip("-")  # a small negative number is no "-0.00"


def quantile_rows(finished: Mapping[str, Any]) -> list[list[str]]:
    """Return label, formatted quantiles and unit of each measure of a study's finished walks."""
    return [
        [label, *(in_words(value, factor, form) for value in finished[key]), unit]
        for label, key, factor, form, unit, *_ in MEASURES
        if finished.get(key) is not None
    ]
