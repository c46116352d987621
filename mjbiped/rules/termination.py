"""Outcomes of walks, and the thresholds at which a walk ends."""

from __future__ import annotations

from enum import IntEnum

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
