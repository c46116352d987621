"""Contact forces of the feet in the physics step just resolved."""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.engines.mujoco.constants import Constants, Leg, foot_of, sole_angle
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import Numbers

READING = 11
"""Number of floats in one slot of a contact sensor: found, force (3), distance, position (3), normal (3)."""
FOUND, FORCE_SHOWN, DISTANCE, POSITION, NORMAL = 0, 1, 4, 5, 8

SMALLEST_UPWARD_NORMAL = 0.7  # below it, a contact is with a riser's face or a heightfield's inner edge


class Felt(NamedTuple):
    """Contact forces on the ground and depth of one foot; how the ground bears a sole stands behind them.

    Attributes:
        pressure: Sum of the normal forces of all contacts, N.
        forward: Force of the foot on the ground along x, without that on risers' faces, N.
        downward: Force of the foot on the ground along -z, without that on risers' faces, N.
        depth: Depth of the deepest contact with the ground, m.
        ground: Whether the foot touches the ground.
        face: Whether the foot touches a riser's face.
        moment: Of the normal forces of the ground about the point below the ankle, as an ankle's torque, N m.
        behind: Distance of the farthest contact with the ground behind the ankle, m; 0: there is none.
        ahead: Distance of the farthest one ahead of it, m.
        shear: Sum of the ground's friction forces, N; how contacts share it is undetermined.
    """

    pressure: float
    forward: float
    downward: float
    depth: float
    ground: bool
    face: bool
    moment: float = 0.0
    behind: float = 0.0
    ahead: float = 0.0
    shear: float = 0.0


def felt(c: Constants, u: State, readings: Numbers, leg: Leg) -> Felt:
    """Sum the contacts of a leg's foot over the slots of its contact sensor.

    The axes of a contact's frame are its normal, which points from the foot into the ground, the robot's lateral axis,
    and the direction perpendicular to both. Where two pieces of ground join, each bears part of the force and the
    frames tilt with the foot's distance from the joint; forces are therefore added as vectors.

    Args:
        c: The walk's constants.
        u: State.
        readings: MuJoCo's `sensordata`.
        leg: With the foot.
    """
    foot_x, foot_z = foot_of(leg, u.q)
    angle = sole_angle(leg, u.q) if leg.sole >= 0 else 0.0
    sine, cosine = math.sin(angle), math.cos(angle)
    pressure = forward = downward = depth = moment = shear = behind = ahead = 0.0
    ground = face = False
    for slot in range(leg.contacts, leg.contacts + c.slots, READING):
        if readings[slot + FOUND] > 0.0:
            force, along = readings[slot + FORCE_SHOWN], readings[slot + FORCE_SHOWN + 2]
            normal_x, normal_z = readings[slot + NORMAL], readings[slot + NORMAL + 2]
            pressure += force
            if -normal_z < SMALLEST_UPWARD_NORMAL:
                face = True
                continue
            ground = True
            depth = max(depth, -readings[slot + DISTANCE])
            forward += force * normal_x - along * normal_z
            downward -= force * normal_z + along * normal_x
            x, z = readings[slot + POSITION] - foot_x, readings[slot + POSITION + 2] - foot_z
            lever = x * cosine - z * sine
            moment -= lever * force
            behind, ahead = max(behind, -lever), max(ahead, lever)
            shear += along
    return Felt(pressure, forward, downward, depth, ground, face, moment, behind, ahead, shear)


def friction_ratio(foot: Felt, slope: float, light: float) -> float:
    """Friction ratio |F_t| / F_n of a foot on a slope (rad); 0 where F_n <= `light` (N), for it is noise there."""
    sine, cosine = math.sin(slope), math.cos(slope)
    normal = foot.downward * cosine - foot.forward * sine
    return abs(foot.forward * cosine + foot.downward * sine) / normal if normal > light else 0.0
