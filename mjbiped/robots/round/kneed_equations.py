"""The biped with knees and round feet in event-driven engines: its modes, guards and reset maps, as `Equations`.

It walks on planes. The stance knee is held at its stop. A foot that comes down ahead while its knee is bent has no map:
the robot falls.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mjbiped.robots.bent_leg import straight_leg
from mjbiped.robots.equations import FREE, LOCKED, RESTING, Equations
from mjbiped.robots.round.constraints import press, settle
from mjbiped.robots.round.equations import ground_force
from mjbiped.robots.round.linkage import gather, load, turn

if TYPE_CHECKING:
    from mjbiped.robots.round.kneed import RoundKneed

APART, AS_ONE = 3, 2
"""Number of bodies that move: stance leg, swing thigh and swing shank, or both legs where the knee is locked."""

Angles: TypeAlias = tuple[float, float, float]
"""A number for the stance leg, the swing thigh and the swing shank."""


def constants_of(robot: RoundKneed) -> SimpleNamespace:
    """The robot's linkage, with room to compute in."""
    chain, stance = robot.linkage.with_room(), straight_leg(robot.leg_length - robot.foot_radius)
    chain.motion = np.zeros(3)
    return SimpleNamespace(chain=chain, stance=stance, thigh=1, shank=2)


def accelerations(c: Any, w: Any, q: Angles, dq: Angles, torques: Any, push: float) -> Angles:
    """Accelerations of stance leg, swing thigh and swing shank, rad/s^2; a locked knee moves both as one."""
    s, stance, hip, knee = c.chain, torques[0] - torques[1] + push, torques[1], torques[2]
    if w.locked != LOCKED:
        s.force[0], s.force[1], s.force[2] = stance, hip - knee, knee
        move(s, w, q, dq, APART)
        if w.locked == FREE:
            return s.motion[0], s.motion[1], s.motion[2]
        w.stop_press = s.motion[1] - s.motion[2]
    s.force[0], s.force[1], s.force[2] = stance, hip, 0.0
    move(s, w, q, dq, AS_ONE)
    return s.motion[0], s.motion[1], s.motion[2]


def move(s: Any, w: Any, q: Any, dq: Any, size: int) -> None:
    """Turn the forces of motors in `s.force` (N m) into accelerations in `s.motion`, rad/s^2.

    Args:
        s: The linkage with room.
        w: The engine's state; of a foot that slides on the ground the force `press` is written.
        q: Angles, rad.
        dq: Rates, rad/s.
        size: As in `settle`.
    """
    n, last = len(s.force), len(s.mass)
    turn(s, q)
    load(s, dq, w.slope)
    settle(s, size)
    for i in range(n):
        s.motion[i] = s.force[i]
    if w.sliding:
        rest = 0.0
        for i in range(n):
            rest -= s.lever[last, i] * dq[i] * dq[i]
        load(s, dq, w.slope)
        w.press = press(s, size, rest)


def stop_foot(c: Any, w: Any) -> float:
    """Impact of the swing foot on the ground on which it then slides; returns the impulse along its normal, N s.

    A locked knee stays locked, and one that rests on its stop does so if the impact presses it on.
    """
    s, y = c.chain, w.y
    turn(s, y)
    if w.locked != LOCKED:
        impulse = _stopped(s, y, APART)
        if w.locked == FREE or s.motion[2] > s.motion[1]:
            w.locked = FREE
            y[3], y[4], y[5] = s.motion[0], s.motion[1], s.motion[2]
            return impulse
    impulse = _stopped(s, y, AS_ONE)
    y[3], y[4], y[5] = s.motion[0], s.motion[1], s.motion[2]
    return impulse


def _stopped(s: Any, y: Any, size: int) -> float:
    """Impulse, N s, that stops the swing foot along the ground's normal; the rates after it stand in `s.motion`."""
    n = len(s.force)
    for i in range(n):
        s.motion[i] = y[n + i]
    load(s, s.still, 0.0)
    return press(s, size, 0.0)


def lands(_: Any, w: Any, ahead: float) -> bool:
    """A foot that comes down becomes the stance foot if it is ahead, and its knee locked."""
    return bool(ahead > 0.0 and w.locked == LOCKED)


def strike(s: Any, q: Any, dq: Any, q_after: Any) -> bool:
    """Heel strike of a straight leg; writes the rates after it, in the new roles, into `s.force`, rad/s.

    The stop alone holds the knee of the leg that leaves the ground, and bears no pull: the knee bends at once if the
    impact opens it. What comes down is a stance leg from now on, whose knee is locked.

    Args:
        s: The linkage with room.
        q: Angles before the impact, rad.
        dq: Rates before it, rad/s.
        q_after: Angles in the new roles.

    Returns:
        Whether the knee of the new swing leg bends.
    """
    gather(s, q, dq, q_after)
    settle(s, APART)
    if s.force[2] > s.force[1]:
        return True
    gather(s, q, dq, q_after)
    settle(s, AS_ONE)
    return False


def exchange(c: Any, w: Any, q: Angles, dq: Angles, _: float) -> tuple[Angles, Angles]:
    """Angles and rates after the heel strike, in the new roles; the new swing knee is free, or rests on its stop."""
    s, new = c.chain, (q[1], q[0], q[0])
    w.locked = FREE if strike(s, q, dq, new) else RESTING
    return new, (s.force[0], s.force[1], s.force[2])


def lock_knee(c: Any, w: Any) -> None:
    """The knee strikes its stop, plastically, and locks."""
    s, y = c.chain, w.y
    y[2] = y[1]
    turn(s, y)
    load(s, s.still, 0.0)
    for i in range(3):
        s.force[i] = 0.0
        for j in range(3):
            s.force[i] += s.matrix[i, j] * y[3 + j]
    settle(s, AS_ONE)
    y[3], y[4], y[5] = s.force[0], s.force[1], s.force[2]
    w.locked = LOCKED


def limbs(_: Any, w: Any, q: Angles) -> tuple[float, float, float, float]:
    """Left and right leg from the vertical, and flexion of left and right knee, rad."""
    stance, swing, flexion = q[0] + w.slope, q[1] + w.slope, q[2] - q[1]
    return (stance, swing, 0.0, flexion) if w.stance == 0 else (swing, stance, flexion, 0.0)


EQUATIONS = Equations(constants_of, accelerations, stop_foot, lands, exchange, lock_knee, limbs, ground_force)
