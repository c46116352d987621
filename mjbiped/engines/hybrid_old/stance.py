"""The force of the ground on the stance foot, and the ankle torque that a sole transmits under it."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid.state import Walk
from mjbiped.robots.bent_leg import LENGTH
from mjbiped.robots.equations import FLAT, TOE
from mjbiped.rules.sole import bounded_by_own_force, moment_about_ankle


def ground_force(s: Walk, pose: Any, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Force on the feet, forward and upward, N: the rate of the robot's momentum, and its weight.

    Args:
        s: The walk.
        pose: Pose in the state.
        state: Angles and rates.
        ddq: Holds the accelerations, rad/s^2.
        first: Index of the first of them.
    """
    force: tuple[float, float] = s.laws.ground_force(s.c.robot, s.w, s.c.mass * s.c.gravity, pose, state, ddq, first)
    return force


def turned(s: Walk, force: tuple[float, float]) -> tuple[float, float]:
    """A force on the feet along the stance foot's ground and normal to it, N, without a push at the hip."""
    w, (forward, upward) = s.w, force
    along, normal = forward * w.cosine - upward * w.sine, forward * w.sine + upward * w.cosine
    if w.push != 0.0:  # is none of the ground's
        along -= w.push * w.cosine
        normal -= w.push * w.sine
    return along, normal


def stance_force(s: Walk, pose: Any, state: Any, ddq: Any, first: int) -> tuple[float, float]:
    """Force on the stance foot along its ground and normal to it, N; the arguments are those of `ground_force`."""
    w = s.w
    along, normal = turned(s, ground_force(s, pose, state, ddq, first))
    if w.face != 0.0 or w.sliding:  # what pushes at the swing foot does not at the stance foot
        along -= w.press * (w.pushed_x * w.cosine - w.pushed_z * w.sine)
        normal -= w.press * (w.pushed_x * w.sine + w.pushed_z * w.cosine)
    return along, normal


def push_torque(s: Walk, angle: float) -> float:
    """Torque about the stance foot of the push at the hip, N m, with the stance leg's line at an angle, rad."""
    w = s.w
    lever = s.c.robot.stance[LENGTH] * math.cos(angle + w.slope)
    if s.c.radius > 0.0:
        lever += s.c.radius * w.cosine
    return float(w.push * lever)


def on_sole(s: Walk, state: Any, q: Any, dq: Any, asked: Any) -> tuple[Any, float]:
    """What the sole transmits of the torques that a law returns, and the normal force on the stance foot then, N.

    Args:
        s: The walk.
        state: State of motion.
        q: Its angles, rad.
        dq: Its rates, rad/s.
        asked: What the law returns: the ankle's torque first.
    """
    force = _normal_force(s, state, q, dq, asked)
    if asked[0] == 0.0:
        return asked, force
    without = _normal_force(s, state, q, dq, s.laws.with_ankle(asked, 0.0))
    ankle, force = bounded_by_own_force(asked[0], force, without, s.c.behind, s.c.ahead)
    return s.laws.with_ankle(asked, ankle), force


def bear(s: Walk, state: Any, q: Any, torques: Any, ddq: Any) -> None:
    """Note how the ground bears a stance foot that is a body, in the current stage of a step.

    About the ankle, where the foot's centre of mass is, the ground's force and the torque on the leg balance: its
    moment is tau + h F_t, of a force at x = -(tau + h F_t) / F_n. A flat foot stays so while x lies on its sole.

    Args:
        s: The walk.
        state: State of motion.
        q: Its angles, rad.
        torques: Of the joints, N m.
        ddq: Accelerations, rad/s^2.
    """
    w, heel, toe = s.w, s.c.heel, s.c.toe
    along, normal = stance_force(s, s.laws.pose(q, w.slope), state, ddq, 0)
    moment, margin = moment_about_ankle(torques[0], s.c.height, along), math.inf
    if w.edge != FLAT:
        moment = -toe * normal if w.edge == TOE else heel * normal
    elif normal > 0.0:
        margin = min(toe * normal + moment, heel * normal - moment)
    w.normals[w.stage], w.moments[w.stage], w.margins[w.stage] = normal, moment, margin


def _normal_force(s: Walk, state: Any, q: Any, dq: Any, torques: Any) -> float:
    """Normal force on the stance foot under given torques, N."""
    ddq = s.laws.accelerations(s.c.robot, s.w, q, dq, torques, push_torque(s, q[0]))
    _, normal = stance_force(s, s.laws.pose(q, s.w.slope), state, ddq, 0)
    return normal
