"""What a reference does after its period, where the touchdown is late: it comes to rest without a jerk.

The swing leg's rate decays to zero, and the posture is held: a foot that is carried on would run away from the ground.
The stance leg's acceleration decays to zero, and the leg goes on falling evenly, as an inverted pendulum does. Angle,
rate and acceleration are continuous.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mjbiped.gaits.bezier import NODES, powers_through

HOLD = 0.05 * math.sqrt(9.81)
"""Of sqrt(l/g): the time in which the stance leg's acceleration decays, 0.05 s for legs of 1 m; twice that for the
swing leg's rate. It is rounded so that the period is a whole number of them."""

FALLEN = math.radians(60)
"""The reference ends where the stance leg has fallen this far."""


def pieces_of(period: float, length: float, gravity: float) -> int:
    """How many pieces of the time of `HOLD` at most make up a period.

    Args:
        period: s.
        length: Of a leg, m.
        gravity: m/s².
    """
    return math.ceil(period / (HOLD * math.sqrt(length / gravity)))


def hold(
    angles: NDArray[np.float64], rates: NDArray[np.float64], accelerations: NDArray[np.float64], width: float, most: int
) -> NDArray[np.float64]:
    """The motion after the period, in pieces as `mjbiped.gaits.reference.table_of` takes them.

    Args:
        angles: At the period's end, rad, stance leg first.
        rates: There, rad/s.
        accelerations: There, rad/s².
        width: Time of a piece, s.
        most: Pieces at most.

    Returns:
        Coefficients, shape (pieces, 10, 2); the last piece is the one before the stance leg has fallen by `FALLEN`.
    """
    pieces = []
    for k in range(most):
        t = width * (k + NODES)
        stance = angles[0] + rates[0] * t + accelerations[0] * acceleration_decays(t, width)
        swing = angles[1] + _rate_decays(t, rates[1], accelerations[1], 2.0 * width)
        if k and abs(stance[-1]) > FALLEN:
            break
        pieces.append(powers_through(np.stack([stance, swing], axis=-1)))
    return np.array(pieces)


def acceleration_decays(t: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Angle of the unit acceleration that falls to zero as 1 - 3 u² + 2 u³ until `end`."""
    u = np.minimum(t / end, 1.0)
    until = end * end * (u**2 / 2 - u**4 / 4 + u**5 / 10)
    return np.asarray(until + 0.5 * end * np.maximum(t - end, 0.0))


def _rate_decays(t: NDArray[np.float64], rate: float, acceleration: float, end: float) -> NDArray[np.float64]:
    """Angle from a rate and an acceleration that are both zero at `end`: the rate is a cubic."""
    u = np.minimum(t / end, 1.0)
    of_rate = end * (u - u**3 + u**4 / 2)
    of_acceleration = end * end * (u**2 / 2 - 2 * u**3 / 3 + u**4 / 4)
    return np.asarray(rate * of_rate + acceleration * of_acceleration)
