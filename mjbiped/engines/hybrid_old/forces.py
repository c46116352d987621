"""What the motion and its impacts ask of the ground under the stance foot.

An impulse's ratio alone says little, for the slightest touch has that of a strong one. What counts is whether a real
foot would slide or hop: so the impulse of an impact is spread over a short time, `AVERAGED`, as MuJoCo's forces are,
and added to the force after it.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from mjbiped.engines.hybrid.dynamics import dense_state
from mjbiped.engines.hybrid.stance import ground_force, stance_force, turned
from mjbiped.engines.hybrid.state import Walk, pose_of
from mjbiped.numerics.dormand_prince import IN_ORDER, PLACES, dense_rate_at
from mjbiped.records.pressure import note_pressure
from mjbiped.rules.termination import AVERAGED, LIGHT_CONTACT

PIECES = 16  # of a step, in which a change of the power's sign, a peak or the least force is looked for
_BOUNDS = (0.0, *(0.5 * (near + far) for near, far in pairwise(PLACES)), 1.0)
SHARES = tuple(far - near for near, far in pairwise(_BOUNDS))  # of the step, one for each stage


def note_ground_force(s: Walk, pose: Any, state: Any, first: int) -> None:
    """Keep the least F_n and the greatest |F_t / F_n| that the motion asks of the ground under the stance foot.

    F_n < 0 means that the ground would have to pull. Where the foot hardly presses on it the ratio is left out.

    Args:
        s: The walk.
        pose: Pose in the state.
        state: Angles and rates.
        first: Index in `k` of the first acceleration.
    """
    w = s.w
    along, normal = stance_force(s, pose, state, w.k, first)
    w.along_now, w.normal_now = along, normal
    note_force(s, along, normal)


def note_force(s: Walk, along: float, normal: float) -> None:
    """Keep the least F_n and the greatest |F_t / F_n| of a force along and normal to the stance foot's ground, N."""
    s.w.normal_force = min(s.w.normal_force, normal)
    if normal > LIGHT_CONTACT * s.c.mass * s.c.gravity:
        s.w.friction = max(s.w.friction, abs(along) / normal)


def note_least_force(s: Walk, h: float) -> None:
    """Keep the least F_n inside the step: that of some moments, and of the parabolas through the least of them."""
    w = s.w
    n, angles = len(w.y), len(w.strike_q)
    last = before = 0.0
    for piece in range(PIECES + 1):
        x = piece / PIECES
        dense_state(s, x)
        pose = pose_of(s, w.spare)
        for i in range(angles):
            w.ddq[i] = dense_rate_at(w.dense, n, angles + i, x) / h
        _, normal = turned(s, ground_force(s, pose, w.spare, w.ddq, 0))
        w.normal_force = min(w.normal_force, normal)
        if piece > 1 and last < min(before, normal):
            w.normal_force = min(w.normal_force, parabola_top(before, last, normal))
        before, last = last, normal


def parabola_top(left: float, middle: float, right: float) -> float:
    """Extremum of the parabola through three values at equal distances, or 0 if it is not between the outer ones."""
    bend, lean = 0.5 * (left + right) - middle, 0.5 * (right - left)
    if abs(lean) >= 2.0 * abs(bend):
        return 0.0
    return middle - lean * lean / (4.0 * bend)


def note_pressures(s: Walk, before: float, h: float) -> None:
    """Keep where the centre of pressure was in a step of length h: at the stages, whose torques are known.

    The normal force, which changes slowly, is taken to change evenly from `before` (N) to what it is at the step's end;
    on a sole it is known at each stage, as is its moment on feet that are bodies.
    """
    w, soled = s.w, s.c.behind < math.inf
    change, light = w.normal_now - before, LIGHT_CONTACT * s.c.mass * s.c.gravity
    for i in range(len(IN_ORDER)):
        stage, time = IN_ORDER[i], SHARES[i] * h
        torque, normal = w.torques[stage * len(w.peak_torque)], before + PLACES[i] * change
        if s.c.toe > 0.0:
            torque, normal = w.moments[stage], w.normals[stage]
        elif soled:
            normal = w.normals[stage]
            if torque != w.asked[stage]:
                w.bound_time += time
        note_pressure(w.pressure, 0, 2, torque, normal, light, s.c.length, time)


def momentum(s: Walk) -> tuple[float, float]:
    """Momentum of the robot in the state `w.y`, forward and upward, kg m/s.

    It depends on the rates as the ground's force on the accelerations.
    """
    w = s.w
    angles = len(w.strike_q)
    for i in range(angles):
        w.spare[i], w.spare[angles + i] = w.y[i], 0.0
    forward, upward = ground_force(s, pose_of(s, w.spare), w.spare, w.y, angles)
    return forward, upward - s.c.mass * s.c.gravity


def note_impulse(s: Walk, before: tuple[float, float], push: float) -> None:
    """Keep the stance foot's impulse in an impact, N s.

    Args:
        s: The walk, after the impact.
        before: Momentum before it, kg m/s.
        push: Impulse on the swing foot, along (pushed_x, pushed_z), N s.
    """
    w, (forward, upward) = s.w, momentum(s)
    w.impulse_x = forward - before[0] - push * w.pushed_x
    w.impulse_z = upward - before[1] - push * w.pushed_z


def note_impact(s: Walk) -> None:
    """Take the impulse that has led to the state, if one has, into the gait step's normal force and friction."""
    w, x, z = s.w, s.w.impulse_x, s.w.impulse_z
    if x != 0.0 or z != 0.0:
        time = AVERAGED * math.sqrt(s.c.length / s.c.gravity)
        along, normal = (x * w.cosine - z * w.sine) / time, (x * w.sine + z * w.cosine) / time
        note_force(s, w.along_now + along, w.normal_now + normal)
        w.impulse_x = w.impulse_z = 0.0
