"""A gait: a step that repeats itself for ever, as a trajectory that controllers can imitate."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.gaits.reference import Table, reference_at
from mjbiped.robots.compass import Array, Compass
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains


class Periodic(Protocol):
    """What any gait of any robot tells: enough to begin a walk on it, and to record it.

    Attributes:
        robot: whose gait it is.
        slope: of the plane it walks on, rad, positive downhill.
        start: state just after a heel impact: the robot's angles (rad), then their rates (rad/s).
        period: time between heel impacts, s.
        step_length: distance between the feet then, along the ground, m.
    """

    @property
    def robot(self) -> Robot:
        """See above."""

    @property
    def slope(self) -> float:
        """See above."""

    @property
    def start(self) -> Array:
        """See above."""

    @property
    def period(self) -> float:
        """See above."""

    @property
    def step_length(self) -> float:
        """See above."""

    def describe(self) -> dict[str, Any]:
        """What the gait is found by again, in plain JSON types; `mjbiped.gaits.described.gait_from` reads it."""


@dataclass(frozen=True)
class Gait:
    """A periodic gait: passive (`find_passive_gait`), or optimised with motors (`find_reference`).

    States are (q1, q2, dq1, dq2), rad and rad/s.

    Attributes:
        robot: whose gait it is.
        slope: of the plane it walks on, rad, positive downhill.
        start: state just after an impact, shape (4,).
        end: state just before the next impact, shape (4,); the impact leads from it to `start`.
        period: time between impacts, s.
        step_length: distance between the feet at the impact, along the ground, m.
        table: the trajectory as `reference_at` reads it; see `Table`.
    """

    robot: Compass
    slope: float
    start: Array = field(compare=False)
    end: Array = field(compare=False)
    period: float
    step_length: float
    table: Table = field(compare=False, repr=False)

    @property
    def speed(self) -> float:
        """Mean speed along the ground, m/s."""
        return self.step_length / self.period

    @property
    def horizon(self) -> float:
        """Time up to which `reference` moves, s; the period lies before it."""
        return self.table[1]

    def reference(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """The trajectory q_r and its derivatives.

        It goes on beyond the period, for a touchdown that is late, up to the horizon. After that the last posture is
        held at rest.

        Args:
            t: time since the impact, s, >= 0; a number or an array of any shape.

        Returns:
            (q, dq, ddq) in rad, rad/s, rad/s^2, each of shape t.shape + (2,).

        Raises:
            InputError: a time is negative or not finite.
        """
        times = domains.TIME.array("t", t, None)
        rows = [reference_at(self.table, time) for time in times.ravel().tolist()]
        values = np.array(rows).reshape(*times.shape, 3, 2)
        return values[..., 0, :], values[..., 1, :], values[..., 2, :]

    def describe(self) -> dict[str, Any]:
        """What the gait is found by again, in plain JSON types; `gait_from` reads it."""
        return {"slope": self.slope, "robot": self.robot.to_dict()}
