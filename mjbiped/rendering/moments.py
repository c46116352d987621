"""Instants of a walk as they are drawn: posture, torques, forces, slopes and the tracked reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import TrackedReference, recorded_controller
from mjbiped.control.tracking import Tracking
from mjbiped.errors import MjbipedError
from mjbiped.records.loads import is_sound
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain

TRACE = 2.0
"""Time for which the path of a foot is seen, s."""

APART = 0.04  # distance between the points of a foot's path, in leg lengths
_SAME = 1e-9  # times that differ by less are the same, s

Pair = tuple[float, float]
Points = NDArray[np.float64]


class Moment(NamedTuple):
    """An instant of a walk.

    Attributes:
        time: Time since the start of the walk, s.
        step: Number of the current step, from 1 on; a touchdown belongs to the step that it ends.
        qpos: Posture, see `Robot.places`: hip x and z (m), left and right leg from the vertical, flexions (rad).
        stance: Number of the stance leg; of a biped 0 left, 1 right.
        slope: Slope of the ground under the stance foot, rad.
        slope_estimate: Slope that the controller estimates, rad; NaN if it makes no estimate.
        torque: Torques of the robot's joints, N m.
        force: Force of the ground on the stance foot, forward and upward, N; NaN where the walk has diverged.
        reference: Posture that the controller tracks on the stance foot, as `qpos`; None without a reference.
        ground: Height (m) and slope (rad) of the ground under left and right foot.
        traces: Paths of left and right foot until now, points x, z in m, each of shape (n, 2).
    """

    time: float
    step: int
    qpos: tuple[float, ...]
    stance: int
    slope: float
    slope_estimate: float
    torque: tuple[float, ...]
    force: Pair
    reference: tuple[float, ...] | None
    ground: tuple[Pair, ...]
    traces: tuple[Points, ...]


class Moments:
    """Instants of a record."""

    def __init__(self, walk: Walk, *, ghost: bool = True) -> None:
        """Prepare the paths of the feet and the reference that the controller tracked.

        Args:
            walk: A record with samples.
            ghost: Whether the tracked reference is wanted.
        """
        self._samples, self._terrain, self._robot = walk.samples, walk.terrain, walk.robot
        self._sound = is_sound(walk)
        self._times, self._touchdowns = walk.samples["time"], walk.touchdowns["time"]
        self._reference = _reference(walk) if ghost else None
        length = self._robot.leg_length
        self._ways = []
        for feet in np.moveaxis(self._robot.limbs(walk.samples["qpos"])[:, :, -1], 1, 0):
            way = np.append(0.0, np.cumsum(np.hypot(*np.diff(feet, axis=0).T)))
            marks = np.flatnonzero(np.diff(np.floor(way / (APART * length)), prepend=-1.0))
            self._ways.append((marks, feet[marks]))

    def greatest_torque(self, start: float, stop: float) -> float:
        """Greatest finite torque of all joints between two times (s), N m; 0 without one."""
        low, high = np.searchsorted(self._times, (start, stop), side="left")
        torque = np.abs(self._samples["torque"][max(0, low - 1) : high + 1])
        return float(np.max(torque, initial=0.0, where=np.isfinite(torque)))

    def at(self, time: float) -> Moment:
        """Return the instant at a time (s) of the record.

        The posture is interpolated between samples; everything else is from the latest sample.
        """
        samples, times = self._samples, self._times
        latest = max(0, int(np.searchsorted(times, time + _SAME, side="right")) - 1)
        following = min(latest + 1, len(times) - 1)
        between = times[following] - times[latest]
        share = min(1.0, max(0.0, (time - times[latest]) / between)) if between > 0.0 else 0.0
        before = samples["qpos"][latest]
        qpos = before + share * (samples["qpos"][following] - before)
        feet = [(float(x), float(z)) for x, z in self._robot.limbs(qpos)[:, -1]]
        slope = float(samples["slope"][latest])
        q, dq, torque = (samples[name][latest] for name in ("q", "dq", "torque"))
        stance = int(samples["stance"][latest])
        locked = bool(samples["locked"][latest]) if "locked" in samples else False
        bent = float(self._robot.flexion(before, stance))
        force = (math.nan, math.nan)
        if self._sound[latest]:
            force = self._robot.ground_force(q, dq, torque, slope, locked=locked, stance_flexion=bent)
        tracked = None if self._reference is None else self._reference.at(time, locked=locked)
        return Moment(
            time=time,
            step=1 + int(np.searchsorted(self._touchdowns, time - _SAME)),
            qpos=tuple(qpos.tolist()),
            stance=stance,
            slope=slope,
            slope_estimate=float(samples["slope_estimate"][latest]),
            torque=tuple(torque.tolist()),
            force=force,
            reference=tracked and tracked_posture(self._robot, feet[stance], stance, slope, tracked, bent),
            ground=ground_under(self._terrain, feet),
            traces=tuple(self._trace(leg, time, foot) for leg, foot in enumerate(feet)),
        )

    def _trace(self, leg: int, time: float, foot: Pair) -> Points:
        """Path of a foot until a time (s), at which it is at a place (m)."""
        marks, points = self._ways[leg]
        low, high = np.searchsorted(marks, np.searchsorted(self._times, (time - TRACE, time + _SAME), side="right"))
        return np.vstack([points[low:high], foot])


def ground_under(terrain: Terrain, feet: Sequence[Pair]) -> tuple[Pair, ...]:
    """Height (m) and slope (rad) of the ground under each foot at x, z (m)."""
    return tuple((terrain.height_at(x), terrain.slope_at(x)) for x, _ in feet)


def tracked_posture(
    robot: Robot, foot: Pair, stance: int, slope: float, tracked: Sequence[float], bent: float
) -> tuple[float, ...] | None:
    """Posture `qpos` with the angles that a controller tracks; None where these are no finite numbers.

    Args:
        robot: The robot.
        foot: Place of the stance foot, x and z in m.
        stance: Number of the stance leg.
        slope: Slope of the ground, rad.
        tracked: Angles from the ground's normal, stance leg first, rad.
        bent: Flexion of the stance knee, rad.
    """
    posture = robot.posture(foot, stance, [angle + slope for angle in tracked], bent)
    return posture if all(map(math.isfinite, posture)) else None


def _reference(walk: Walk) -> TrackedReference | None:
    """Reference that the walk's controller tracked; None if it tracks none, or cannot be rebuilt."""
    try:
        return TrackedReference(walk, recorded_controller(walk, kind=Tracking))
    except (MjbipedError, ArithmeticError, ValueError):
        return None
