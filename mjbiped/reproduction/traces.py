"""Measures of what Figs. 4 to 6 show: slope estimate, tracking and torque along a whole record."""

from __future__ import annotations

import math

import numpy as np

from mjbiped.analysis.replay import recorded_controller, replayed
from mjbiped.control.registry import settings_of
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array

RESOLVED_SLOPE = float(settings_of("adaptive")["update_threshold"])
"""Epsilon of (27), rad: the controller treats slopes that differ by less as one."""

TRACES = tuple(
    f"trace_{name}" for name in ("settled", "later", "off_time", "error", "travel", "z1", "z2", "straight", "bent")
)
"""Measures of a walk of the adaptive controller:

settled: Error of the slope estimate at the end of the last step that began before the ground first changes, degrees.
later: Greatest error from then on, degrees.
off_time: Time for which the error was greater than `RESOLVED_SLOPE`, s.
error: Root mean square of the error over time, degrees.
travel: Total variation of the error, degrees.
z1: Greatest tracking error of a leg's angle (5), degrees.
z2: Greatest error of the second stage (9), rad/s.
straight: Greatest distance of a torque from a straight line over its step, N m, of all steps that began on the
    imitated gait.
bent: Least distance of a torque from a straight line over its step, N m, of all re-planned steps.
"""

_SAME_TIME = 1e-9  # s; a sample nearer to a touchdown has the state of one step and the roles of another
_FEWEST = 3  # samples of a step that is measured


def traced(walk: Walk) -> dict[str, float]:
    """Measure a record.

    Args:
        walk: A walk of the adaptive controller, with samples.

    Returns:
        The `TRACES` that exist.

    Raises:
        InputError: Another controller walked.
    """
    controller = recorded_controller(walk)
    samples, time = walk.samples, walk.samples["time"]
    error = np.degrees(samples["slope_estimate"] - samples["slope"])
    first_change = walk.terrain.x[1] if len(walk.terrain.x) > 1 else math.inf
    places, ends = [0.0, *walk.touchdowns["x"].tolist()], walk.touchdowns["time"].tolist()
    before: list[Array] = []  # errors of the estimate by step, until the ground first changes
    after: list[Array] = []
    tracking: list[Array] = []
    straight: list[float] = []
    bent: list[float] = []
    for (start, memory), place, end in zip(replayed(walk, controller), places, ends, strict=False):
        inside = (time > start.time + _SAME_TIME) & (time < end - _SAME_TIME)
        if inside.sum() < _FEWEST:
            continue
        (after if place >= first_change else before).append(error[inside])
        now = time[inside] - start.time
        motion = zip(now.tolist(), samples["q"][inside].tolist(), samples["dq"][inside].tolist(), strict=True)
        z = np.abs([controller.tracking_errors(memory, t, q, dq) for t, q, dq in motion])
        tracking.append(np.array([z[:, :2].max(), z[:, 4:].max()]))
        joints = samples["torque"][inside].T
        lines = (np.polynomial.Polynomial.fit(now, joint, 1)(now) for joint in joints)
        bend = max(float(np.abs(joint - line).max()) for joint, line in zip(joints, lines, strict=True))
        (bent if controller.transition_end(memory) > 0.0 else straight).append(bend)
    if not tracking:
        return {}
    lasted, (z1, z2) = np.diff(time), np.max(tracking, axis=0).tolist()
    found = {
        "off_time": float(lasted[np.abs(error[:-1]) > math.degrees(RESOLVED_SLOPE)].sum()),
        "error": math.sqrt(float((lasted * error[:-1] ** 2).sum() / lasted.sum())),
        "travel": float(np.abs(np.diff(error)).sum()),
        "z1": math.degrees(z1),
        "z2": z2,
    }
    if before:
        found["settled"] = abs(float(before[-1][-1]))
    if after:
        found["later"] = max(float(np.abs(errors).max()) for errors in after)
    if straight and controller.replanning_delay is not None:
        found["straight"] = max(straight)
    if bent:
        found["bent"] = min(bent)
    return {f"trace_{name}": value for name, value in found.items()}
