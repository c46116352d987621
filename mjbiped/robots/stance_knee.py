"""The torque that holds the stance knee of a biped with knees.

A locked knee bears a torque that no motor gives. It is the force of the row that locks the knee of the linkage with
all four segments free.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.dynamics.linkage import ROOM, SYSTEM, Linkage, Motion, load, room, solve, stand
from mjbiped.dynamics.modes import hold_stop
from mjbiped.errors import InputError
from mjbiped.numerics.blocks import numbers, packed, reader
from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.round_kneed import RoundKneed
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

    table = np.column_stack(
        [
            domains.ANGLE.array("q", rows(q), (count, 3)),
            domains.RATE.array("dq", rows(dq), (count, 3)),
            rows(torque),
            domains.ANGLE.array("slope", column(slope), (count,)),
            column(locked),
            domains.ANGLE.array("stance_flexion", column(stance_flexion), (count,)),
        ]
    )
    leg, found, whole = robot.bodies.leg, np.empty(count), robot.chains[4].linkage
    motion = Motion(free=4, **room())
    stand(whole, motion)
    (linkage, below), (made, kept) = packed(whole), packed(motion)
    lengths = np.array([leg[0].length, leg[-1].length])
    _machine_code()(linkage.ctypes.data, made.ctypes.data, lengths, table, np.empty((2, ROOM)), found)
    del below, kept  # which lived until now
    return found.reshape(leading)


def hold_all(linkage: int, motion: int, lengths: Array, table: Array, state: Array, found: Array) -> None:
    """Write the torque of each row into `found`; see `stance_knee_torque`. Runs compiled.

    Args:
        linkage: Address of the linkage by the angles of all four segments.
        motion: Address of its motion.
        lengths: Of thigh and shank, m.
        table: Angles, rates, torques, slope, whether the swing knee is locked, and the stance knee's flexion, shape
            (n, 12).
        state: Room for the angles of the segments and for their rates, shape (2, 4).
        found: Shape (n,).
    """
    w, whole, q, dq = _motion_at(motion, 0), _linkage_at(linkage, 0), state[0], state[1]
    forces = numbers(w.ddq, ROOM)
    for k in range(len(found)):
        row, flexion = table[k], table[k, 11]
        _, lean = bent_leg(lengths[0], lengths[1], flexion)
        w.sine, w.cosine = sine_cosine(row[9])
        q[0], q[1], q[2], q[3] = row[0] + lean, row[0] + lean - flexion, row[1], row[2]
        dq[0], dq[1], dq[2], dq[3] = row[3], row[3], row[4], row[5]
        forces[0], forces[1], forces[2], forces[3] = row[6], -row[7], row[7] - row[8], row[8]
        load(whole, w, q, dq)
        hold_stop(w, 1, 0)
        if row[10] != 0.0:
            hold_stop(w, 2, 3)
        solve(w)
        found[k] = -numbers(w.right, SYSTEM)[w.size]


_linkage_at, _motion_at = reader(Linkage), reader(Motion)


@cache
def _machine_code() -> Any:
    """`hold_all` as machine code; compiled once, and kept on disk."""
    from mjbiped.numerics.machine import compiled

    table = "float64[:, ::1]"
    return compiled(hold_all, f"void(int64, int64, float64[::1], {table}, {table}, float64[::1])")
