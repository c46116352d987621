"""Measures of what Figs. 4 to 6 show: slope estimate, tracking and torque along a whole record."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mjbiped.analysis.replay import recorded_controller, replayed
from mjbiped.control.registry import settings_of
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array

RESOLVED_SLOPE = float(settings_of("adaptive")["update_threshold"])
"""Epsilon of (27), rad: the controller treats slopes that differ by less as one."""

_SAME_TIME = 1e-9  # s; a sample nearer to a touchdown has the state of one step and the roles of another
_FEWEST = 3  # samples of a step that is measured


class Traces(NamedTuple):
    """Measures of a walk of the adaptive controller. Numbers that do not exist are NaN.

    Attributes:
        settled: Error of the slope estimate at the end of the last step that began before the ground first changes,
            degrees.
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

    settled: float = math.nan
    later: float = math.nan
    off_time: float = math.nan
    error: float = math.nan
    travel: float = math.nan
    z1: float = math.nan
    z2: float = math.nan
    straight: float = math.nan
    bent: float = math.nan


def traced(walk: Walk) -> Traces:
    """Measure a record.

    Args:
        walk: A walk of the adaptive controller, with samples.

    Raises:
        InputError: Another controller walked.
    """
    controller = recorded_controller(walk)
    steps = list(_steps(walk, controller))
    if not steps:
        return Traces()
    before, after = ([step for step in steps if step.changed is changed] for changed in (False, True))
    replans = controller.replanning_delay is not None
    time = walk.samples["time"]
    error = np.degrees(walk.samples["slope_estimate"] - walk.samples["slope"])
    lasted = np.diff(time)
    return Traces(
        settled=abs(before[-1].error[-1]) if before else math.nan,
        later=max((float(np.abs(step.error).max()) for step in after), default=math.nan),
        off_time=float(lasted[np.abs(error[:-1]) > math.degrees(RESOLVED_SLOPE)].sum()),
        error=math.sqrt(float((lasted * error[:-1] ** 2).sum() / lasted.sum())),
        travel=float(np.abs(np.diff(error)).sum()),
        z1=math.degrees(max(step.z1 for step in steps)),
        z2=max(step.z2 for step in steps),
        straight=max((step.bend for step in steps if replans and not step.replanned), default=math.nan),
        bent=min((step.bend for step in steps if step.replanned), default=math.nan),
    )


class _Step(NamedTuple):
    """A whole step between its touchdowns."""

    changed: bool  # whether the ground had changed before it
    replanned: bool
    error: Array  # of the estimate, degrees
    z1: float  # rad
    z2: float  # rad/s
    bend: float  # N m


def _steps(walk: Walk, controller: AdaptiveTracking) -> Iterator[_Step]:
    """List the steps that have enough samples to fit a line."""
    samples = walk.samples
    error = np.degrees(samples["slope_estimate"] - samples["slope"])
    places = [0.0, *walk.touchdowns["x"].tolist()]
    first_change = walk.terrain.x[1] if len(walk.terrain.x) > 1 else math.inf
    ends = walk.touchdowns["time"].tolist()
    for (start, memory), place, end in zip(replayed(walk, controller), places, ends, strict=False):
        inside = (samples["time"] > start.time + _SAME_TIME) & (samples["time"] < end - _SAME_TIME)
        if inside.sum() < _FEWEST:
            continue
        time, torque = samples["time"][inside] - start.time, samples["torque"][inside]
        motion = zip(time.tolist(), samples["q"][inside].tolist(), samples["dq"][inside].tolist(), strict=True)
        z = np.abs([controller.tracking_errors(memory, t, q, dq) for t, q, dq in motion])
        lines = (np.polynomial.Polynomial.fit(time, joint, 1)(time) for joint in torque.T)
        bend = max(float(np.abs(joint - line).max()) for joint, line in zip(torque.T, lines, strict=True))
        replanned = controller.transition_end(memory) > 0.0
        yield _Step(place >= first_change, replanned, error[inside], float(z[:, :2].max()), float(z[:, 4:].max()), bend)
