"""Gaits: steps that repeat themselves for ever, as trajectories that controllers can imitate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.gaits.reference import HORIZON, Table, motion_at
from mjbiped.robots.robot import Array
from mjbiped.utils import domains


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Gait:
    """A gait of any robot: passive (`find_passive_gait`), or optimised with motors (`find_reference`).

    States are the robot's angles (rad), then their rates (rad/s). Arrays are read-only. Gaits are equal if they are
    described alike.

    With knees there are two trajectories over the whole step and beyond: one for the bent swing knee, and one for the
    straight knee, of stance and swing leg. A controller follows that of the knee that the robot has at the moment,
    whenever its knee strikes (reference spreading).

    Attributes:
        robot: The robot that walks.
        slope: Slope of the plane it walks on, rad, positive downhill.
        start: State just after a heel strike.
        end: State just before the next heel strike; the impact leads from it to `start`.
        period: Time between heel strikes, s.
        step_length: Distance between the feet at a heel strike, along the ground, m.
        knee_strike: Time at which the swing knee strikes its stop, s; None without knees.
        tables: The trajectory as laws read it (`mjbiped.gaits.reference`); with knees that of the bent knee, then that
            of the straight one.
    """

    robot: Any
    slope: float
    start: Array
    end: Array
    period: float
    step_length: float
    knee_strike: float | None = None
    tables: tuple[Table, ...]

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def speed(self) -> float:
        """Mean speed along the ground, m/s."""
        return self.step_length / self.period

    @property
    def horizon(self) -> float:
        """Time up to which `reference` moves, s; the period lies before it."""
        return self.tables[-1][HORIZON]

    def reference(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """The trajectory q_r and its derivatives; with knees that of the bent knee until the knee strike.

        It goes on beyond the period, for a touchdown that is late, up to the horizon. After that the last posture is
        held at rest.

        Args:
            t: Time since the heel strike, s, >= 0; a number or an array of any shape.

        Returns:
            (q, dq, ddq) in rad, rad/s, rad/s^2, each of shape t.shape + (angles,).

        Raises:
            InputError: A time is negative or not finite.
        """
        if self.knee_strike is None:
            return self.branch(t, bent=True)
        before = (np.asarray(t) < self.knee_strike)[..., None]
        bent, straight = self.branch(t, bent=True), self.branch(t, bent=False)
        columns = [0, 1, *range(1, straight[0].shape[-1])]  # the straight leg's angle is that of thigh and shank
        q, dq, ddq = (np.where(before, b, s[..., columns]) for b, s in zip(bent, straight, strict=True))
        return q, dq, ddq

    def branch(self, t: ArrayLike, *, bent: bool) -> tuple[Array, Array, Array]:
        """The trajectory of the bent or of the straight knee at any times, as `reference` has it.

        Args:
            t: Time since the heel strike, s, >= 0; a number or an array of any shape.
            bent: Whether the knee is bent; without knees there is no other trajectory.
        """
        times, table = domains.TIME.array("t", t, None), self.tables[0 if bent else 1]
        rows = [motion_at(table, time) for time in times.ravel().tolist()]
        q, dq, ddq = np.moveaxis(np.reshape(rows, (*times.shape, 3, -1 if rows else len(self.robot.angles))), -2, 0)
        return q, dq, ddq

    def describe(self) -> dict[str, Any]:
        """Describe the gait in plain JSON types, for `mjbiped.gaits.described.gait_from` to make it again."""
        return {"slope": self.slope, "robot": self.robot.to_dict()}

    def __eq__(self, other: object) -> bool:
        """Whether it is the same gait of the same robot."""
        return type(other) is type(self) and self.describe() == other.describe()

    def __hash__(self) -> int:
        """Hash of what gaits that are equal have in common."""
        return hash((type(self), self.robot, self.slope))
