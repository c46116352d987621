"""What an event-driven engine takes of a robot: equations of motion, guards and reset maps, as functions.

A robot whose pinned stance leg carries a chain of segments fills in one `Equations`; the engine brings the ground, the
integrator, the events and the record. Numba compiles the functions, which run in plain Python from the same source.
Of the engine's state `w` they read and write these fields:

    slope, sine, cosine         the ground's slope under the stance foot (rad), its sine and cosine
    stance, count               number of the stance leg (of a biped 0 left, 1 right); touchdowns since the start
    face, sliding               whether the swing foot slides on a vertical face (not 0), or on the ground
    pushed_x, pushed_z          direction in which these push the swing foot
    press                       written: force with which they do, N; below zero the contact ends
    locked                      the swing knee: FREE, LOCKED, or RESTING on its stop
    stop_press                  written: acceleration with which a resting knee would bend forwards, rad/s^2
    stance_flexion              flexion at which the stance knee is locked, rad
    swing_sole                  angle of the swing foot's sole from that of the stance foot as it lands, rad, else 0
    edge                        how a stance foot that is a body stands: `FLAT`, or turning about its TOE or HEEL
    y                           angles and rates, one after the other
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

from mjbiped.robots.bent_leg import ACROSS, force_beside
from mjbiped.robots.chain import segment_force

FREE, LOCKED, RESTING = 0, 1, 2
"""How the swing knee is: it bends freely, is locked since it has struck its stop, or is straight and rests on it. A leg
without a knee is always locked."""

HEEL, FLAT, TOE = -1, 0, 1
"""How the stance foot stands: flat, or on one of its edges, about which it turns. Feet without mass stand flat."""


def stays_flat(*_: Any) -> None:
    """There is no foot that could tip."""


def chain_force(c: Any, w: Any, weight: float, pose: Any, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Force of the ground on a robot's chain, forward and upward, N: the rate of its momentum, and its weight.

    Args:
        c: The robot's constants.
        w: The engine's state.
        weight: Of the robot, N.
        pose: Sine and cosine of each angle from the vertical.
        state: Angles and rates.
        ddq: Holds the accelerations, rad/s^2.
        first: Index of the first of them.
    """
    moments, across, gravity = c.chain.moments, c.stance[ACROSS], c.chain.gravity
    n = len(moments)
    forward, upward = 0.0, weight
    for i in range(n):
        sine, cosine = pose[2 * i], pose[2 * i + 1]
        ahead, above = segment_force(moments[i] / gravity, sine, cosine, state[n + i], ddq[first + i])
        forward, upward = forward + ahead, upward + above
    if across != 0.0:
        ahead, above = force_beside(across, gravity, state[0] + w.slope, state[n], ddq[first])
        forward, upward = forward + ahead, upward + above
    return forward, upward


class Equations(NamedTuple):
    """The equations, guards and reset maps of a kind of robot.

    Attributes:
        constants: (robot) -> `c`, what the others take of the robot, with room to compute in that is of one walk alone:
            `chain` (`mjbiped.robots.chain.with_room`) of all angles; `stance`, how the stance leg stands
            (`mjbiped.robots.bent_leg.stand` and `straight_leg`); and `thigh` and `shank`, indices of the
            angles between which the swing knee bends, equal where there is none.
        accelerations: (c, w, q, dq, torques, push) -> accelerations, rad/s^2. The push is a torque on the stance leg.
        stop_foot: (c, w) -> impulse along (pushed_x, pushed_z), N s. Changes the rates in `y` by a plastic,
            frictionless impact of the swing foot, in which the stance foot stays where it is.
        lands: (c, w, ahead) -> whether a swing foot that comes down so far ahead of the other becomes the stance foot.
        exchange: (c, w, q, dq, slope) -> angles and rates in the new roles, after the impact of a support transfer; the
            angles are from the normal of the ground under the new stance foot, whose slope is given, rad.
        lock_knee: (c, w) -> None. The knee strike, in `y`.
        limbs: (c, w, q) -> the posture behind the place of the hip: angles of left and right leg from the vertical, ...
        ground_force: (c, w, weight, pose, state, ddq, first) -> force of the ground, forward and upward, N; see
            `chain_force`, which serves all whose first segment turns about a fixed foot.
        turn_foot: (c, w, edge) -> None. The stance foot turns about an edge from now on, or comes down flat, in `y`.
            The last levers of `chain` are then those of its ankle from there.
        inlined: Whether `accelerations` is so short that it shall become part of the integrator's machine code.
    """

    constants: Callable[[Any], SimpleNamespace]
    accelerations: Callable[..., Any]
    stop_foot: Callable[..., Any]
    lands: Callable[..., Any]
    exchange: Callable[..., Any]
    lock_knee: Callable[..., Any]
    limbs: Callable[..., Any]
    ground_force: Callable[..., tuple[float, float]] = chain_force
    turn_foot: Callable[..., None] = stays_flat
    inlined: bool = False
