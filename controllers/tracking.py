r"""Trajectory tracking by backstepping, section III-A of the paper, equations (5)-(14).

.. math:: z_1 = q_r - q, \quad \dot z_1 = \dot q_r - \dot q, \quad z_2 = \dot z_1 + K_1 z_1

.. math:: \tau = B^{-1}\{M[\ddot q_r + (K_1 K_2 + I) z_1 + (K_1 + K_2) \dot z_1] + C \dot q + g\}

is the law (12); with the estimates for sine and cosine of the slope it is (14).
"""

from __future__ import annotations

from mjbiped.control.controller import Numbers, Room
from mjbiped.controllers.dynamics import inverse_dynamics
from mjbiped.controllers.layout import ON_ANGLE, ON_RATE, POSITION_GAIN, moving_chain
from mjbiped.controllers.replanning import reference
from mjbiped.controllers.room import ANGLES, COSINE, DQ, ERROR, FORWARD, MOTION, REFERENCE, SINE, UPWARD, Q


def aim(parameters: Numbers, n: int, room: Room) -> None:
    """Write z2 of (9) and the accelerations that (12) asks for, of n angles with their state and reference in the room.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        n: Number of angles.
        room: Has state and reference; receives errors (rad/s), accelerations (rad/s²), and those of the segments' ends.
    """
    gains = parameters[POSITION_GAIN], parameters[ON_ANGLE], parameters[ON_RATE]
    _aim(gains, 0, room)
    _aim(gains, 1, room)
    if n > 2:
        _aim(gains, 2, room)


def _aim(gains: tuple[float, float, float], i: int, room: Room) -> None:
    """Write error and acceleration of one angle, and the acceleration of the segment's end, as `move_end` does."""
    position, on_angle, on_rate = gains
    at, rate = REFERENCE + i, room[DQ + i]
    z1, dz1 = room[at] - room[Q + i], room[at + ANGLES] - rate
    ddq = room[at + 2 * ANGLES] + on_angle * z1 + on_rate * dz1
    room[ERROR + i], room[MOTION + i] = dz1 + position * z1, ddq
    s, c, square = room[SINE + i], room[COSINE + i], rate * rate
    room[FORWARD + i], room[UPWARD + i] = c * ddq - s * square, -s * ddq - c * square


def track(
    parameters: Numbers, memory: Numbers, t: float, slope: tuple[float, float], room: Room
) -> tuple[int, Numbers, int]:
    """Write the generalised forces of the law (12), N m, with the errors and accelerations that they come from.

    Args:
        parameters: Of the law.
        memory: Of the controller.
        t: Time since the touchdown, s.
        slope: Sine and cosine of the slope, or their estimates.
        room: Has the state, as `dynamics.observe` writes it; receives the rest.

    Returns:
        The chain that moves now; see `layout.moving_chain`.
    """
    n, chain, first = moving_chain(parameters, memory)
    reference(parameters, memory, t, n, room)
    aim(parameters, n, room)
    inverse_dynamics(chain, first, n, slope, room)
    return n, chain, first
