"""Gaits: steps that repeat themselves for ever, as trajectories that controllers can imitate."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.gaits.reference import HORIZON, Table, motion_at
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed_legs import KneedLegs
from mjbiped.robots.robot import Array, Robot
from mjbiped.utils import domains


class Periodic:
    """A gait of any robot: what is needed to begin a walk on it and to record it. Its arrays are read-only.

    Attributes:
        robot: The robot that walks.
        slope: Slope of the plane it walks on, rad, positive downhill.
        start: State just after a heel impact: the robot's angles (rad), then their rates (rad/s).
        period: Time between heel impacts, s.
        step_length: Distance between the feet at a heel impact, along the ground, m.
    """

    robot: Robot
    slope: float
    start: Array
    period: float
    step_length: float

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def speed(self) -> float:
        """Mean speed along the ground, m/s."""
        return self.step_length / self.period

    def describe(self) -> dict[str, Any]:
        """Describe the gait in plain JSON types, for `mjbiped.gaits.described.gait_from` to make it again."""
        return {"slope": self.slope, "robot": self.robot.to_dict()}


class Passive(Periodic):
    """A passive gait of any robot.

    Attributes:
        multipliers: Floquet multipliers, the eigenvalues of the return map's Jacobian; complex, shape (3,), the largest
            magnitude first.
    """

    multipliers: NDArray[np.complex128]

    def __repr__(self) -> str:
        """Return a summary in one line."""
        kind = "stable" if self.stable else "unstable"
        return (
            f"<{type(self).__name__} on {math.degrees(self.slope):.4g} deg: {kind}, period {self.period:.6g} s, "
            f"step {self.step_length:.6g} m>"
        )

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: every multiplier lies inside the unit circle."""
        return bool(abs(self.multipliers[0]) < 1)


@dataclass(frozen=True)
class Gait(Periodic):
    """A gait of the compass biped: passive (`find_passive_gait`), or optimised with motors (`find_reference`).

    States are (q1, q2, dq1, dq2), rad and rad/s.

    Attributes:
        robot: The robot that walks.
        slope: Slope of the plane it walks on, rad, positive downhill.
        start: State just after an impact, shape (4,).
        end: State just before the next impact, shape (4,); the impact leads from it to `start`.
        period: Time between impacts, s.
        step_length: Distance between the feet at the impact, along the ground, m.
        table: The trajectory as laws read it; see `mjbiped.gaits.reference`.
    """

    robot: Compass
    slope: float
    start: Array = field(compare=False)
    end: Array = field(compare=False)
    period: float
    step_length: float
    table: Table = field(compare=False, repr=False)

    @property
    def horizon(self) -> float:
        """Time up to which `reference` moves, s; the period lies before it."""
        return self.table[HORIZON]

    def reference(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """The trajectory q_r and its derivatives.

        It goes on beyond the period, for a touchdown that is late, up to the horizon. After that the last posture is
        held at rest.

        Args:
            t: Time since the impact, s, >= 0; a number or an array of any shape.

        Returns:
            (q, dq, ddq) in rad, rad/s, rad/s^2, each of shape t.shape + (2,).

        Raises:
            InputError: A time is negative or not finite.
        """
        times = domains.TIME.array("t", t, None)
        rows = [motion_at(self.table, time) for time in times.ravel().tolist()]
        values = np.array(rows).reshape(*times.shape, 3, 2)
        return values[..., 0, :], values[..., 1, :], values[..., 2, :]


@dataclass(frozen=True)
class Branched(Periodic):
    """A gait with knees: one branch of the reference for the bent swing knee, and one for the straight knee.

    A controller follows the branch of the knee that the robot has at the moment, whenever its knee strikes. Both reach
    over the whole step and beyond (reference spreading).

    Attributes:
        robot: The robot that walks.
        slope: Slope of the plane it walks on, rad, positive downhill.
        start: State just after a heel strike, both knees straight: three angles (rad), three rates (rad/s), shape (6,).
        end: State just before the next heel strike, shape (6,); the heel impact leads from it to `start`.
        period: Time between heel strikes, s.
        step_length: Distance between the feet at a heel strike, along the ground, m.
        knee_strike: Time at which the swing knee strikes its stop, s.
        rate: Pieces of the branches per second.
        bent: The branch of the bent knee, polynomials of degree 9 in each piece's own coordinate from 0 to 1, lowest
            power first: shape (pieces, 10, 3), rad.
        straight: The branch of the straight knee, stance and swing leg: shape (pieces, 10, 2).
    """

    robot: KneedLegs
    slope: float
    start: Array = field(compare=False)
    end: Array = field(compare=False)
    period: float
    step_length: float
    knee_strike: float
    rate: float = field(compare=False, repr=False)
    bent: Array = field(compare=False, repr=False)
    straight: Array = field(compare=False, repr=False)

    @property
    def horizon(self) -> float:
        """Time up to which `reference` moves, s; the period lies before it."""
        return len(self.straight) / self.rate

    def reference(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """The trajectory and its derivatives: the branch of the bent knee until the knee strike, then the other one.

        It goes on beyond the period, for a touchdown that is late, up to the horizon. After that the last posture is
        held at rest.

        Args:
            t: Time since the heel strike, s, >= 0; a number or an array of any shape.

        Returns:
            (q, dq, ddq) in rad, rad/s, rad/s², each of shape t.shape + (3,).

        Raises:
            InputError: A time is negative or not finite.
        """
        times = domains.TIME.array("t", t, None)
        before = (times < self.knee_strike)[..., None]
        bent, straight = self.branch(times, bent=True), self.branch(times, bent=False)
        q, dq, ddq = (np.where(before, b, s[..., [0, 1, 1]]) for b, s in zip(bent, straight, strict=True))
        return q, dq, ddq

    def branch(self, t: ArrayLike, *, bent: bool) -> tuple[Array, Array, Array]:
        """One branch and its derivatives at any times of the step and beyond.

        Args:
            t: Time since the heel strike, s, >= 0; a number or an array of any shape.
            bent: Whether the knee is bent.

        Returns:
            (q, dq, ddq), each of shape t.shape + (3,) with the knee bent, t.shape + (2,) with the knee straight.
        """
        times = domains.TIME.array("t", t, None)
        pieces = self.bent if bent else self.straight
        late = (times > len(pieces) / self.rate)[..., None]
        place = np.minimum(times * self.rate, len(pieces))
        piece = np.minimum(place.astype(int), len(pieces) - 1)
        s = (place - piece)[..., None]
        coefficients = np.moveaxis(pieces[piece], -2, 0)
        values = []
        for order in range(3):
            values.append(np.polynomial.polynomial.polyval(s, coefficients, tensor=False) * self.rate**order)
            powers = np.arange(1, len(coefficients)).reshape(-1, *[1] * (coefficients.ndim - 1))
            coefficients = coefficients[1:] * powers
        q, dq, ddq = values
        return q, np.where(late, 0.0, dq), np.where(late, 0.0, ddq)
