"""A planar gait's legs on a robot in space, with the roll that they leave to itself.

The legs move as in the plane. The roll is the one that repeats itself, mirrored, from step to step without a torque
about the heading: a controller that tracks both spends little on the roll.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from mjbiped.errors import GaitError
from mjbiped.gaits import store
from mjbiped.gaits.cycle import glide
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.kneed import EARLY, ON
from mjbiped.gaits.reference import PIECES, RATE, Table, beside, in_pieces
from mjbiped.robots.in_space import InSpace, pull_of
from mjbiped.robots.space import Array, joined


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RollingGait(Gait):
    """A gait in space whose legs are those of a planar gait, made by `with_roll`.

    Attributes:
        legs: The planar gait.
    """

    legs: Gait

    def describe(self) -> dict[str, Any]:
        """Describe the planar gait, and the robot in space."""
        return {**self.legs.describe(), "robot": self.robot.to_dict()}


def with_roll(robot: InSpace, legs: Gait) -> RollingGait:
    """Return the gait of a robot in space whose legs move as those of a planar gait.

    Args:
        robot: The robot in space.
        legs: A gait of `robot.planar`.

    Raises:
        GaitError: No roll repeats itself.
    """
    asked = {"roll": robot.mechanism.to_dict(), "legs": legs.describe()}
    found = store.with_tables(store.kept(asked, lambda: _search(robot, legs)))
    return RollingGait(
        robot=robot,
        slope=legs.slope,
        period=legs.period,
        step_length=legs.step_length,
        knee_strike=legs.knee_strike,
        legs=legs,
        **found,
    )


def _search(robot: InSpace, legs: Gait) -> dict[str, Any]:
    """The attributes of the gait that the planar one does not have."""
    roll = _Roll(robot, legs)
    solution = scipy.optimize.root(roll.mismatch, np.zeros(2), tol=1e-10)
    if np.abs(solution.fun).max() > 1e-8:
        raise GaitError("no roll repeats itself from step to step; choose another reference or a narrower hip")
    start, half = solution.x, len(legs.start) // 2
    _, last = roll.parts(start)
    tables = roll.tables(start)
    return {
        "start": np.insert(legs.start, [half, 2 * half], start),
        "end": np.insert(legs.end, [half, 2 * half], last(roll.period)),
        **dict(zip(("table",) if len(tables) == 1 else ("bent", "straight"), tables, strict=True)),
    }


@dataclass(frozen=True)
class _Roll:
    """The roll that moves by itself while the legs move as a planar gait's.

    Attributes:
        robot: The robot in space.
        legs: The planar gait.
    """

    robot: InSpace
    legs: Gait

    @cached_property
    def pull(self) -> Array:
        """Gravity's components."""
        return pull_of(self.legs.slope)

    @property
    def period(self) -> float:
        """Of the gait, s."""
        return self.legs.period

    @property
    def strike(self) -> float:
        """Time at which the knee strikes, s; 0 without knees, as all of the step is of straight legs."""
        return self.legs.knee_strike or 0.0

    def at(self, t: float, *, bent: bool) -> tuple[Array, Array, Array]:
        """Pitch angles, rates and accelerations of the legs, with the bent or the straight knee."""
        return self.legs.branch(t, bent=bent or self.legs.knee_strike is None)

    def moved(self, start: Array, since: float, until: float, *, bent: bool) -> Any:
        """Roll (rad) and its rate (rad/s) from one time to another, as a function of time."""

        def rates(t: float, state: Array) -> list[float]:
            q, dq, ddq = self.at(t, bent=bent)
            linkage, angles = self.robot.in_space[len(q)], np.append(q, state[0])
            forces = (
                linkage.coriolis_forces(angles, np.append(dq, state[1])) + linkage.gravity_forces(angles) @ self.pull
            )
            M = linkage.mass_matrix(angles)
            return [state[1], -(forces[-1] + M[-1, :-1] @ ddq) / M[-1, -1]]

        ahead = math.copysign(1.0, until - since)  # time may run backwards
        moved = glide(lambda t, y: [ahead * each for each in rates(since + ahead * t, y)], start, abs(until - since))
        return lambda t: moved.sol(ahead * (t - since))

    def parts(self, start: Array) -> tuple[Any, Any]:
        """The roll before the knee's strike and after it, or throughout, as functions of time."""
        if not self.strike:
            return None, self.moved(start, 0.0, self.period, bent=False)
        before = self.moved(start, 0.0, self.strike + ON * self.period, bent=True)
        (roll, rate), (q, dq, _) = before(self.strike), self.at(self.strike, bent=True)
        linkage, lock = self.robot.in_space[len(q)], self.robot.knee_lock
        after = joined(linkage, lock, np.append(q, roll), np.append(dq, rate))
        return before, self.moved(np.array([roll, after[-1]]), self.strike, self.period, bent=False)

    def mismatch(self, start: Array) -> Array:
        """By how much roll and rate after the touchdown differ from a start."""
        _, last = self.parts(start)
        (q, dq, _), (roll, rate) = self.at(self.period, bent=False), last(self.period)
        after, rates = self.robot.in_space[2].touchdown(np.append(q, roll), np.append(dq, rate))
        return np.array([after[-1], rates[-1]]) - start

    def tables(self, start: Array) -> tuple[Table, ...]:
        """The planar gait's tables with the roll beside; before and after its own motion the roll goes on evenly."""
        before, last = self.parts(start)
        of_straight = self.legs.tables[-1]
        straight = self._pieces(of_straight, last, self.strike, self.period, bent=False)
        if before is None:
            return (beside(of_straight, straight),)
        of_bent = self.legs.tables[0]
        bent = self._pieces(of_bent, before, 0.0, self.strike + ON * self.period, bent=True)
        return beside(of_bent, bent), beside(of_straight, straight)

    def _pieces(self, table: Table, roll: Any, begin: float, end: float, *, bent: bool) -> Array:
        """Coefficients of the roll in a table's pieces: between two times its own motion, outside of them even ones."""
        count, width = int(table[PIECES]), 1.0 / table[RATE]
        first, last = math.floor(EARLY * begin / width), min(math.floor(end / width + 1e-9), count)
        back = self.moved(roll(begin), begin, first * width, bent=bent) if begin else roll
        early, late = back(first * width), roll(last * width)

        def at(place: float) -> float:
            if place < first or place > last:
                (angle, rate), since = (early, first) if place < first else (late, last)
                return float(angle + rate * width * (place - since))
            return float((roll if place * width >= begin else back)(place * width)[0])

        return in_pieces(lambda places: np.array([at(place) for place in places]), range(count))
