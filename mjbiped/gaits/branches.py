"""References with knees as controllers read them: a branch for the bent swing knee, and one for the straight knee.

A controller follows the branch of the knee that the robot has at the moment, whenever its knee strikes: so both reach
over the whole step and beyond (reference spreading).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mjbiped.gaits.bezier import NODES, powers_through
from mjbiped.gaits.hold import acceleration_decays, hold, pieces_of
from mjbiped.robots.chain import Array, Chain, machine_code
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

FINE = 1e-11
"""Tolerance of the integration of gaits, relative and absolute."""

_EARLY = 0.5  # of the time until the knee strike: further back no robot's knee strikes that is to walk on
_ON = 0.15  # of the period after the knee strike, in which the motion of the bent knee goes on of itself


class Branches(NamedTuple):
    """Both branches in pieces of equal length.

    Attributes:
        rate: Pieces per second.
        bent: The branch of the bent knee, polynomials of degree 9 in each piece's own coordinate from 0 to 1, lowest
            power first: shape (pieces, 10, 3), rad.
        straight: The branch of the straight knee, stance and swing leg: shape (pieces, 10, 2).
    """

    rate: float
    bent: Array
    straight: Array


class Branched:
    """A gait with knees that controllers can track; frozen dataclasses derive from it, which name the attributes.

    Attributes:
        robot: Whose gait it is.
        slope: Of the plane it walks on, rad, positive downhill.
        start: State just after a heel strike, both knees straight: three angles (rad), three rates (rad/s), shape (6,).
        period: Time between heel strikes, s.
        step_length: Distance between the feet then, m.
        knee_strike: Time at which the swing knee strikes its stop, s.
        rate: See `Branches`.
        bent: The same.
        straight: The same.
    """

    robot: KneedBiped
    slope: float
    start: Array
    period: float
    step_length: float
    knee_strike: float
    rate: float
    bent: Array
    straight: Array

    @abstractmethod
    def describe(self) -> dict[str, Any]:
        """What the gait is found by again, in plain JSON types; `mjbiped.gaits.described.gait_from` reads it."""

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
        bent, straight = self.branch(times, bent=True), self.branch(times, bent=False)
        before = (times < self.knee_strike)[..., None]
        return tuple(  # type: ignore[return-value]  # three
            np.where(before, first, second[..., [0, 1, 1]]) for first, second in zip(bent, straight, strict=True)
        )

    def branch(self, t: ArrayLike, *, bent: bool) -> tuple[Array, Array, Array]:
        """One branch and its derivatives at any times of the step and beyond.

        Args:
            t: As of `reference`.
            bent: Whether with the knee bent.

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


def free_motion(chain: Chain, slope: float) -> Callable[[float, Array], Array]:
    """The unpowered motion of a chain on a slope (rad): state -> its rates."""
    n = len(chain.reach)
    (even, odd), accelerate = np.empty((2, n, n)), machine_code()

    def rates(_: float, state: Array) -> Array:
        result = np.zeros(2 * n)
        result[:n] = state[n:]
        accelerate(chain.weights, chain.moments, slope, state[:n], state[n:], even, odd, result[n:])
        return result

    return rates


def passive_branches(
    robot: KneedBiped, slope: float, start: Array, struck: Array, knee_strike: float, period: float
) -> Branches:
    """Branches of a passive gait: its own motion, continued beyond the knee strike on either side by the same laws.

    Where the robot's knee strikes early or late, no torque is asked for so. The bent knee's free motion goes on past
    the stop for a while; then it is driven on at its last closing rate, and the legs come to rest as after the period.
    The straight knee's motion is followed back.

    Args:
        robot: Whose gait it is.
        slope: Of the plane, rad.
        start: State just after a heel strike, shape (6,).
        struck: State of both legs just after the knee strike, shape (4,).
        knee_strike: Its time, s.
        period: Time between heel strikes, s.
    """
    count = pieces_of(period, robot.leg_length, robot.gravity)
    width = period / count
    free, locked = (free_motion(robot.chains[n], slope) for n in (3, 2))

    def motion(law: Any, begin: float, end: float, state: Array) -> Any:
        solution = scipy.integrate.solve_ivp(
            law, (begin, end), state, method="DOP853", rtol=FINE, atol=FINE, dense_output=True
        )
        dense: Any = solution.sol
        return dense

    goes_on = min(knee_strike + _ON * period, period)
    bent_until = math.ceil(goes_on / width)
    bent = motion(free, 0.0, bent_until * width, start.copy())  # writable, as machine code is made for
    ahead = motion(locked, knee_strike, period, struck)
    back_until = math.floor(_EARLY * knee_strike / width)
    back = motion(locked, knee_strike, back_until * width, struck)

    def straight(t: float) -> Array:
        legs: Array = (ahead if t >= knee_strike else back)(t)[:2]
        return legs

    first = back(back_until * width)
    early = [first[:2] + first[2:] * (width * (k + NODES) - back_until * width)[:, None] for k in range(back_until)]
    walked = [np.array([straight(width * (k + node)) for node in NODES]) for k in range(back_until, count)]
    end = ahead(period)
    ddq = locked(0.0, end.copy())[2:]
    straight_pieces = np.concatenate(
        [np.stack([powers_through(each) for each in (*early, *walked)]), hold(end[:2], end[2:], ddq, width, count)]
    )
    last = bent(bent_until * width)
    slowing = free(0.0, last.copy())[3:]
    legs = hold(last[:2], last[3:5], slowing[:2], width, len(straight_pieces) - bent_until)
    flexion, closing, braking = np.diff([last[1:3], last[4:6], slowing[1:3]]).ravel().tolist()
    times = [width * (k + NODES) for k in range(len(legs))]
    driven = [powers_through(flexion + closing * t + braking * acceleration_decays(t, width)) for t in times]
    on = np.concatenate([legs, (legs[..., 1] + np.stack(driven))[..., None]], axis=-1)
    moved = [powers_through(np.array([bent(width * (k + node))[:3] for node in NODES])) for k in range(bent_until)]
    bent_pieces = np.concatenate([np.stack(moved), on])
    for array in (bent_pieces, straight_pieces):
        array.flags.writeable = False
    return Branches(1.0 / width, bent_pieces, straight_pieces)
