"""The torque that holds the stance knee of a biped with knees.

A locked knee bears a torque that no motor gives. It is a constraint's: the equations of motion of the chain of four
segments, with the accelerations that the locked robot has, leave it over in the row of the stance shank.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from mjbiped.numerics import jit
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.chain import Array, add_gravity, solve, weighted
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.round.kneed import RoundKneed
from mjbiped.robots.round.stance_knee import stance_knee_torques
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
    count = math.prod(leading)

    def rows(value: ArrayLike) -> Array:
        return np.ascontiguousarray(np.broadcast_to(value, (*leading, 3)), dtype=np.float64).reshape(count, 3)

    def column(value: ArrayLike) -> Array:
        return np.ascontiguousarray(np.broadcast_to(value, leading), dtype=np.float64).reshape(count)

    state = (
        domains.ANGLE.array("q", rows(q), (count, 3)),
        domains.RATE.array("dq", rows(dq), (count, 3)),
        rows(torque),
        domains.ANGLE.array("slope", column(slope), (count,)),
        column(locked),
    )
    if isinstance(robot, RoundKneed):
        return stance_knee_torques(robot, *state).reshape(leading)
    flexion = domains.ANGLE.array("stance_flexion", column(stance_flexion), (count,))
    found, chain = np.empty(count), robot.chains[4]
    _machine_code()(chain.weights, chain.moments, robot.thigh_length, robot.shank_length, *state, flexion, found)
    return found.reshape(leading)


def hold_all(
    weights: Array,
    moments: Array,
    upper: float,
    lower: float,
    q: Array,
    dq: Array,
    torque: Array,
    slope: Array,
    locked: Array,
    flexion: Array,
    found: Array,
) -> None:
    """Write the torque of each row into `found`; see `stance_knee_torque`. Runs compiled."""
    angles, rates, forces, motion = np.empty(4), np.empty(4), np.empty(4), np.empty(3)
    even, odd, few = np.empty((4, 4)), np.empty((4, 4)), np.empty((3, 3))
    for row in range(len(found)):
        _, lean = bent_leg(upper, lower, flexion[row])
        angles[0] = q[row, 0] + lean
        angles[1] = angles[0] - flexion[row]
        rates[0] = rates[1] = dq[row, 0]
        for free in range(1, 3):
            angles[free + 1], rates[free + 1] = q[row, free], dq[row, free]
        ankle, hip, knee = torque[row]
        forces[0], forces[1], forces[2], forces[3] = ankle, -hip, hip - knee, knee
        found[row] = _held(
            weights, moments, slope[row], locked[row] != 0.0, angles, rates, forces, motion, even, odd, few
        )


def _held(
    weights: Array,
    moments: Array,
    slope: float,
    locked: bool,
    q: Array,
    dq: Array,
    forces: Array,
    motion: Array,
    even: Array,
    odd: Array,
    few: Array,
) -> float:
    """The torque between stance thigh and shank, of four angles, rates and motors' forces; the rest is room."""
    weighted(weights, q, q, even, odd)
    for i in range(4):
        for j in range(4):
            forces[i] -= odd[i, j] * dq[j] * dq[j]
    add_gravity(moments, q, slope, -1.0, forces)
    count = 2 if locked else 3
    few[:] = 0.0
    motion[:] = 0.0
    for i in range(4):
        moves = min(max(i - 1, 0), count - 1)  # segments of locked knees move as one
        motion[moves] += forces[i]
        for j in range(4):
            few[moves, min(max(j - 1, 0), count - 1)] += even[i, j]
    solve(few[:count, :count], motion[:count])
    torque = float(forces[0])
    for j in range(4):
        torque -= even[0, j] * motion[min(max(j - 1, 0), count - 1)]
    return torque


@cache
def _machine_code() -> Any:
    """`hold_all` as machine code; compiled once, and kept on disk."""
    digest = jit.prepared((hold_all,), inlined=())
    return jit.from_source(jit.jitted, "held", _SOURCE, {"hold_all": hold_all}, digest)


_SOURCE = """
def held(weights, moments, upper, lower, q, dq, torque, slope, locked, flexion, found):
    hold_all(weights, moments, upper, lower, q, dq, torque, slope, locked, flexion, found)
"""
