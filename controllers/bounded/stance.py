"""A robot on its sole: the ankle torque that the sole transmits, and the accelerations under it."""

from __future__ import annotations

import math

from mjbiped.control.controller import Numbers, Room
from mjbiped.controllers import layout
from mjbiped.controllers.dynamics import inverse_dynamics, move_end, write_torques
from mjbiped.controllers.layout import ANKLE_HEIGHT, GRAVITY, WEIGHT, bounds, moving_chain
from mjbiped.controllers.room import ALONG, BY_STANCE, COSINE, FORCE, FORWARD, MOTION, NORMAL, SINE, TORQUE, UPWARD
from mjbiped.robots.robot import Robot
from mjbiped.rules.sole import bounded_by_own_force, moment_about_ankle


def footing_of(robot: Robot, share: float) -> dict[int, float]:
    """Return what presses on a robot's sole, how large that is, and the share on which a law leans, as parameters."""
    behind, ahead = robot.sole or (math.inf, math.inf)
    foot = robot.bodies.foot
    return {
        layout.WEIGHT: robot.total_mass * robot.gravity,
        layout.GRAVITY: robot.gravity,
        layout.BEHIND: behind,
        layout.AHEAD: ahead,
        layout.SOLE_SHARE: share,
        layout.ANKLE_HEIGHT: 0.0 if foot is None else foot.height,
    }


def stand(
    parameters: Numbers,
    memory: Numbers,
    ankle: float,
    follows: float,
    share: float,
    slope: tuple[float, float],
    room: Room,
) -> float:
    """Bound an ankle torque by the sole; the other segments accelerate as wanted nevertheless.

    The stance leg is let go: its acceleration follows from the moments about the ankle, which are the sum of all rows
    of (1) and hold no torque of the other joints. Forces and accelerations are linear in it.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Of the controller.
        ankle: Ankle torque that is asked for, N m.
        follows: Share of the stance leg's acceleration by which the swing leg accelerates in addition.
        share: Share of the sole on which the law leans.
        slope: Sine and cosine of the slope, or of its estimate.
        room: Has the state, and the accelerations wanted of all segments but the stance leg, with those of their ends.
            Receives the torques, the accelerations, and the force of the ground.

    Returns:
        The ankle torque, N m.
    """
    n, chain, first = moving_chain(parameters, memory)
    move_end(0, 0.0, room)
    inverse_dynamics(chain, first, n, slope, room)
    moments, gravity, weight = first + n * n, parameters[GRAVITY], parameters[WEIGHT]
    beside, rest, inertia = chain[moments + n], 0.0, 0.0
    room[ALONG] = beside * room[UPWARD] / gravity - weight * slope[0]
    room[NORMAL] = weight * slope[1] - beside * room[FORWARD] / gravity
    # forces, and the ground's: while the stance leg does not accelerate, and their change by its acceleration
    for i in range(n):
        s, c, row, moment = room[SINE + i], room[COSINE + i], first + n * i, chain[moments + i] / gravity
        room[BY_STANCE + i] = chain[row] * (c * room[COSINE] + s * room[SINE])
        if follows != 0.0:
            room[BY_STANCE + i] += follows * chain[row + 1] * (c * room[COSINE + 1] + s * room[SINE + 1])
        rest, inertia = rest + room[FORCE + i], inertia + room[BY_STANCE + i]
        room[ALONG], room[NORMAL] = room[ALONG] + moment * room[FORWARD + i], room[NORMAL] + moment * room[UPWARD + i]
    along_gain = (chain[moments] * room[COSINE] - beside * room[SINE]) / gravity
    normal_gain = -(chain[moments] * room[SINE] + beside * room[COSINE]) / gravity
    if follows != 0.0:
        along_gain += follows * chain[moments + 1] / gravity * room[COSINE + 1]
        normal_gain -= follows * chain[moments + 1] / gravity * room[SINE + 1]
    along = room[ALONG] - along_gain * rest / inertia, along_gain / inertia
    normal = room[NORMAL] - normal_gain * rest / inertia, normal_gain / inertia
    sole = bounds(parameters, memory, share)
    given = _transmitted(ankle, parameters[ANKLE_HEIGHT], sole, along, normal)
    acceleration = (given - rest) / inertia
    room[MOTION] = acceleration
    room[MOTION + 1] += follows * acceleration
    room[ALONG], room[NORMAL] = room[ALONG] + along_gain * acceleration, room[NORMAL] + normal_gain * acceleration
    for i in range(n):
        room[FORCE + i] += room[BY_STANCE + i] * acceleration
    write_torques(n, room, room, TORQUE)
    room[TORQUE] = given
    return given


def _transmitted(
    asked: float, height: float, sole: tuple[float, float], along: tuple[float, float], normal: tuple[float, float]
) -> float:
    """Return the ankle torque that a sole transmits of one that is asked for, N m.

    Args:
        asked: That torque, N m.
        height: Of the ankle over the sole, m.
        sole: Distances from the ankle back to the heel and forward to the toe, m.
        along: Force of the ground along it without a torque of the ankle, N, and its change by that torque, 1/m.
        normal: Force of the ground normal to it, likewise.
    """
    behind, ahead = sole
    force = normal[0] + normal[1] * asked
    moment = moment_about_ankle(asked, height, along[0] + along[1] * asked)
    if asked == 0.0 or moment == 0.0 or behind == math.inf or -ahead * force <= moment <= behind * force:
        return asked
    lever, sheared = 1.0 + height * along[1], height * along[0]
    without = normal[0] - sheared / lever * normal[1]
    borne, _ = bounded_by_own_force(moment, force, without, behind, ahead)
    return (borne - sheared) / lever
