"""The torque that holds the stance knee of a biped with knees.

A locked knee bears a torque that no motor gives. It is the force of the row that locks the knee of the linkage with
all four segments free.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.round import RoundKneed
from mjbiped.utils import domains


def stance_knee_torque(
    robot: KneedBiped | RoundKneed,
    q: ArrayLike,
    dq: ArrayLike,
    torque: ArrayLike,
    slope: ArrayLike,
    *,
    locked: ArrayLike,
    stance_flexion: ArrayLike = 0.0,
) -> Array:
    """Torque that a motor at the stance knee has to give to hold it as it is, N m.

    It is positive where the motor must keep the knee from bending further. Where it is negative the load straightens
    the knee: its stop bears that if the knee is straight, and no motor is needed; a motor must give it if the knee is
    bent.

    Any number of instants may be asked for at once; the leading shapes of all arguments are broadcast.

    Args:
        robot: The robot.
        q: Stance leg, swing thigh and swing shank from the ground's normal, shape (..., 3), rad. A stance leg that is
            bent has the angle of the line from its foot to the hip.
        dq: Their rates, shape (..., 3), rad/s.
        torque: Of ankle, hip and swing knee, shape (..., 3), N m.
        slope: Of the ground, shape (...), rad, positive downhill.
        locked: Whether the swing knee is locked as well, shape (...).
        stance_flexion: At which the stance knee is held, shape (...), rad.

    Returns:
        Shape (...). NaN where a torque is no finite number.

    Raises:
        InputError: An angle or a rate is outside its domain, or of another shape.
    """
    for name, given in (("q", q), ("dq", dq), ("torque", torque)):
        if np.shape(given)[-1:] != (3,):
            raise InputError(f"{name}: expected shape (..., 3), got {np.shape(given)}")
    leading = np.broadcast_shapes(
        *(np.shape(given)[:-1] for given in (q, dq, torque)),
        *(np.shape(given) for given in (slope, locked, stance_flexion)),
    )

    def spread(values: ArrayLike, *more: int) -> Array:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), (*leading, *more))

    # of all four segments, stance shank first
    angles = domains.ANGLE.array("q", spread(q, 3), (*leading, 3))[..., [0, 0, 1, 2]]
    rates = domains.RATE.array("dq", spread(dq, 3), (*leading, 3))[..., [0, 0, 1, 2]]
    ankle, hip, knee = np.moveaxis(spread(torque, 3), -1, 0)
    lean = domains.ANGLE.array("slope", spread(slope), leading)
    flexion = domains.ANGLE.array("stance_flexion", spread(stance_flexion), leading)
    upper, lower = (segment.length for segment in robot.bodies.leg)
    angles[..., :2] += np.arctan2(upper * np.sin(flexion), lower + upper * np.cos(flexion))[..., None]
    angles[..., 1] -= flexion
    # the equations, and a row for each knee: the swing knee's is zero where it is free
    whole, equations = robot.chains[4], np.zeros((*leading, 6, 6))
    equations[..., :4, :4] = whole.mass_matrix(angles)
    equations[..., 4, :2], equations[..., 5, 2:4] = (1.0, -1.0), np.multiply.outer(spread(locked), (-1.0, 1.0))
    equations[..., :4, 4:] = -np.swapaxes(equations[..., 4:, :4], -1, -2)
    equations[..., 5, 5] = spread(locked) == 0.0
    right = np.concatenate([np.stack([ankle, -hip, hip - knee, knee], -1), np.zeros((*leading, 2))], -1)
    right[..., :4] -= whole.pull(angles, rates, lean)
    return np.asarray(-np.linalg.solve(equations, right[..., None])[..., 4, 0])
