"""Outcomes of walks, thresholds of falls and stalls, and the limits at which a walk ends."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

FALLEN_HIP = 0.5  # hip height over the ground, along its normal, in leg lengths
SLIPPED_FOOT = 0.1  # distance of a stance foot within one step, along the ground or across, in leg lengths
STALL_TIME = 10.0  # without touchdown, in sqrt(leg length / gravity): four periods of the passive gait
LIGHT_CONTACT = 0.01  # of the weight: below it the friction ratio is noise
AVERAGED = 0.016  # least stretch of time that forces are averaged over, and impulses spread over, in the same units
SUSTAINED = 0.0016  # in the same units: time for which MuJoCo must ask for friction until it counts


class Outcome(IntEnum):
    """How a walk ended."""

    WALKING = 0
    FINISHED = 1
    FELL = 2
    STALLED = 3
    SLIPPED = 4
    LEFT_TERRAIN = 5
    DIVERGED = 6
    INTERRUPTED = 7
    UNRESOLVED = 8
    TIME_LIMIT = 9

    @property
    def words(self) -> str:
        """The outcome as it stands in records and summaries."""
        return "left the terrain" if self is Outcome.LEFT_TERRAIN else self.name.lower().replace("_", " ")


class Limits(NamedTuple):
    """Termination limits of a walk, as plain numbers that do not change while it lasts.

    Attributes:
        leg_length: Length of a leg, m.
        lowest_hip: Height of the hip over the ground, as its profile has it, below which the robot has fallen, m.
        foot_radius: Radius of the sphere that stands on the ground, m.
        rolling_radius: Radius on which a standing foot rolls, m: 0 where the sphere's centre is held.
        weight: Weight of the robot, N.
        reach: Distance of the scuffing rule, m.
        delay: Time of the scuffing rule, s.
        stall_time: Longest time without touchdown, s.
        averaged: Least time over which the stance foot's normal force is averaged, s.
        airborne: Time without contact after which a stance foot is off the ground, s.
        sustained: Time for which friction must be asked for to count, s.
        start: Position x at which the ground begins, m.
        end: Position x at which the ground ends, m.
        steps: Touchdowns after which the walk is finished.
        distance: Position of the stance foot at which it is finished, x in m.
    """

    leg_length: float
    lowest_hip: float
    foot_radius: float
    rolling_radius: float
    weight: float
    reach: float
    delay: float
    stall_time: float
    averaged: float
    airborne: float
    sustained: float
    start: float
    end: float
    steps: float
    distance: float
