"""What there is to be drawn of an instant of a walk: posture, torques, forces, slopes and the tracked reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import TrackedReference, recorded_tracking
from mjbiped.errors import MjbipedError
from mjbiped.records.record import Walk
from mjbiped.records.stance_knee import is_sound
from mjbiped.robots import compass
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot

TRACE = 2.0
"""How long the way of a foot is seen, s."""

APART = 0.04  # of the points of a foot's way, in leg lengths
_SAME = 1e-9  # times that differ by less are the same, s

Pair = tuple[float, float]
Points = NDArray[np.float64]


class Moment(NamedTuple):
    """An instant of a walk.

    Attributes:
        time: Since the walk's start, s.
        step: That is under way, from 1 on; a touchdown belongs to the step that it ends.
        qpos: Hip x and z (m), left and right leg from the vertical (rad), and what the robot's `places` have beyond.
        stance: 0 left, 1 right.
        slope: Of the ground under the stance foot, rad.
        slope_estimate: The controller's, rad; NaN where it has none.
        torque: Of the robot's joints: ankle, hip, and a swing knee's, N m.
        force: Of the ground on the stance foot, forward and upward, N; NaN where the walk has diverged.
        reference: Posture that the controller tracks on the stance foot, as `qpos`; None where there is no reference.
        ground: Height (m) and slope (rad) of the ground under left and right foot.
        traces: The ways that left and right foot have come, points x, z in m, each of shape (n, 2).
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
    ground: tuple[Pair, Pair]
    traces: tuple[Points, Points]


class Moments:
    """The instants of a record."""

    def __init__(self, walk: Walk, *, ghost: bool = True) -> None:
        """Look up what the controller tracked, if it tracked anything.

        Args:
            walk: A record with samples.
            ghost: Whether that is wanted.
        """
        self._samples, self._terrain = walk.samples, walk.terrain
        self._robot = walk.robot
        self._sound = is_sound(walk)
        self._times, self._touchdowns = walk.samples["time"], walk.touchdowns["time"]
        self._reference = _reference(walk) if ghost else None
        length = self._robot.leg_length
        self._ways = []
        for feet in np.moveaxis(self._robot.limbs(walk.samples["qpos"])[:, :, -1], 1, 0):
            way = np.append(0.0, np.cumsum(np.hypot(*np.diff(feet, axis=0).T)))
            marks = np.flatnonzero(np.diff(np.floor(way / (APART * length)), prepend=-1.0))
            self._ways.append((marks, feet[marks]))

    @property
    def tracks(self) -> bool:
        """Whether the controller tracked a reference."""
        return self._reference is not None

    def greatest_torque(self, start: float, stop: float) -> float:
        """Greatest finite torque of all joints between two times (s), N m; 0 where there is none."""
        low, high = np.searchsorted(self._times, (start, stop), side="left")
        torque = np.abs(self._samples["torque"][max(0, low - 1) : high + 1])
        return float(np.max(torque, initial=0.0, where=np.isfinite(torque)))

    def at(self, time: float) -> Moment:
        """The instant at a time (s) of the record.

        The posture is interpolated between samples; all else is of the latest sample.
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
        q, dq, torque = (samples[name][latest].tolist() for name in ("q", "dq", "torque"))
        locked, bent = False, 0.0
        if isinstance(self._robot, KneedBiped):
            locked = bool(samples["locked"][latest])
            bent = float(self._robot.flexion(samples["qpos"][latest], samples["stance"][latest]))
        stance = int(samples["stance"][latest])
        reference = None
        if self._reference is not None:
            tracked = self._reference.at(time, locked=locked)
            reference = tracked_posture(self._robot, feet[stance], stance, slope, tracked, bent)
        return Moment(
            time=time,
            step=1 + int(np.searchsorted(self._touchdowns, time - _SAME)),
            qpos=tuple(qpos.tolist()),
            stance=stance,
            slope=slope,
            slope_estimate=float(samples["slope_estimate"][latest]),
            torque=tuple(torque),
            force=ground_force(self._robot, slope, q, dq, torque, locked=locked, stance_flexion=bent)
            if self._sound[latest]
            else (math.nan, math.nan),
            reference=reference if reference is not None and all(map(math.isfinite, reference)) else None,
            ground=(self._ground(feet[0][0]), self._ground(feet[1][0])),
            traces=(self._trace(0, time, feet[0]), self._trace(1, time, feet[1])),
        )

    def _ground(self, x: float) -> Pair:
        """Height (m) and slope (rad) of the ground at x (m)."""
        return self._terrain.height_at(x), self._terrain.slope_at(x)

    def _trace(self, leg: int, time: float, foot: Pair) -> Points:
        """The way that a foot has come until a time (s), at which it is at a place (m)."""
        marks, points = self._ways[leg]
        low, high = np.searchsorted(marks, np.searchsorted(self._times, (time - TRACE, time + _SAME), side="right"))
        return np.vstack([points[low:high], foot])


def foot_of(robot: Robot, hip: Sequence[float], angle: float) -> Pair:
    """Where the foot of a leg is that leans by an angle (rad) from the vertical, x and z in m."""
    return hip[0] - robot.leg_length * math.sin(angle), hip[1] - robot.leg_length * math.cos(angle)


def tracked_posture(
    robot: Robot, foot: Pair, stance: int, slope: float, tracked: Sequence[float], bent: float
) -> tuple[float, ...]:
    """The posture `qpos` of angles that are tracked.

    Args:
        robot: The robot.
        foot: Where its stance foot is, x and z in m.
        stance: 0 left, 1 right.
        slope: Of the ground, rad.
        tracked: Angles from its normal, stance leg first, rad.
        bent: Flexion of the stance knee, rad.
    """
    line, swing = tracked[0] + slope, tracked[1] + slope
    length, thigh, knees = robot.leg_length, line, []
    if isinstance(robot, KneedBiped):
        length, lean = bent_leg(robot.thigh_length, robot.shank_length, bent)
        thigh = line + lean - bent
        knees = [bent, tracked[2] - tracked[1]][:: -1 if stance else 1]
    hip = (foot[0] + length * math.sin(line), foot[1] + length * math.cos(line))
    return (*hip, *((swing, thigh) if stance else (thigh, swing)), *knees)


def ground_force(
    robot: Robot,
    slope: float,
    q: Sequence[float],
    dq: Sequence[float],
    torque: Sequence[float],
    *,
    locked: bool = False,
    stance_flexion: float = 0.0,
) -> Pair:
    """Force of the ground on the stance foot in a motion by the equations of motion, forward and upward, N.

    Args:
        robot: The robot.
        slope: Of the ground, rad.
        q: Its angles from the ground's normal, rad.
        dq: Their rates, rad/s.
        torque: Of its joints, N m.
        locked: Whether the swing knee is, if it has one.
        stance_flexion: Of the stance knee, rad.
    """
    if isinstance(robot, KneedBiped):
        return robot.ground_force(q, dq, torque, slope, locked=locked, stance_flexion=stance_flexion)
    assert isinstance(robot, Compass)
    (q1, q2), (dq1, dq2), (ankle, hip) = q, dq, torque
    ddq1, ddq2 = compass.acceleration(
        robot.constants, q1, q2, dq1, dq2, math.sin(slope), math.cos(slope), ankle - hip, hip
    )
    legs = compass.legs_of(q1 + slope, q2 + slope)
    return compass.ground_force(robot.constants, robot.total_mass, robot.gravity, legs, dq1, dq2, ddq1, ddq2)


def _reference(walk: Walk) -> TrackedReference | None:
    """What the walk's controller tracked; None where it is none that tracks, or cannot be built anew."""
    try:
        return TrackedReference(walk, recorded_tracking(walk))
    except (MjbipedError, ArithmeticError, ValueError):
        return None
