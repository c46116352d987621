"""Contacts of the feet: which geoms collide, and the forces of the physics step just resolved."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

READING = 11
"""Number of floats in one slot of a contact sensor: found, force (3), distance, position (3), normal (3)."""
FOUND, FORCE_SHOWN, DISTANCE, POSITION, NORMAL = 0, 1, 4, 5, 8

SMALLEST_UPWARD_NORMAL = 0.7  # below it, a contact is with a riser's face or a heightfield's inner edge


class Felt(NamedTuple):
    """Contact forces on the ground and depth of one foot.

    Attributes:
        pressure: Sum of the normal forces of all contacts, N.
        forward: Force of the foot on the ground along x, without that on risers' faces, N.
        downward: Force of the foot on the ground along -z, without that on risers' faces, N.
        depth: Depth of the deepest contact with the ground, m.
        ground: Whether the foot touches the ground.
        face: Whether the foot touches a riser's face.
    """

    pressure: float
    forward: float
    downward: float
    depth: float
    ground: bool
    face: bool


def felt(readings: Any, first: int, slots: int) -> Felt:
    """Sum the contacts of a foot over the slots of its contact sensor.

    The axes of a contact's frame are its normal, which points from the foot into the ground, the robot's lateral axis,
    and the direction perpendicular to both. Where two pieces of ground join, each bears part of the force and the
    frames tilt with the foot's distance from the joint; forces are therefore added as vectors.

    Args:
        readings: MuJoCo's `sensordata`.
        first: Index of the sensor's first float.
        slots: Number of the sensor's floats.
    """
    pressure = forward = downward = depth = 0.0
    ground = face = False
    for slot in range(first, first + slots, READING):
        if readings[slot + FOUND] > 0.0:
            force, along = readings[slot + FORCE_SHOWN], readings[slot + FORCE_SHOWN + 2]
            normal_x, normal_z = readings[slot + NORMAL], readings[slot + NORMAL + 2]
            pressure += force
            if -normal_z < SMALLEST_UPWARD_NORMAL:
                face = True
            else:
                ground = True
                depth = max(depth, -readings[slot + DISTANCE])
                forward += force * normal_x - along * normal_z
                downward -= force * normal_z + along * normal_x
    return Felt(pressure, forward, downward, depth, ground, face)


class Borne(NamedTuple):
    """How the ground bears a foot with a sole.

    Attributes:
        moment: Of the contacts' normal forces about the point below the ankle, as an ankle's torque, N m.
        behind: Distance of the farthest contact behind the ankle, m; 0: there is none.
        ahead: Distance of the farthest one ahead of it, m.
        shear: Sum of the contacts' friction forces, N; how they share it is undetermined.
    """

    moment: float
    behind: float
    ahead: float
    shear: float


def borne(readings: Any, first: int, slots: int, foot: tuple[float, float], angle: float) -> Borne:
    """How the ground bears a foot; see `felt`.

    Args:
        readings: MuJoCo's `sensordata`.
        first: Index of the sensor's first float.
        slots: Number of the sensor's floats.
        foot: The point of the sole below the ankle, x and z in m.
        angle: Of the sole, as a slope, rad.
    """
    sine, cosine = math.sin(angle), math.cos(angle)
    moment = shear = behind = ahead = 0.0
    for slot in range(first, first + slots, READING):
        if readings[slot + FOUND] > 0.0 and -readings[slot + NORMAL + 2] >= SMALLEST_UPWARD_NORMAL:
            x, z = readings[slot + POSITION] - foot[0], readings[slot + POSITION + 2] - foot[1]
            along, force = x * cosine - z * sine, readings[slot + FORCE_SHOWN]
            moment -= along * force
            behind, ahead = max(behind, -along), max(ahead, along)
            shear += readings[slot + FORCE_SHOWN + 2]
    return Borne(moment, behind, ahead, shear)


def friction_ratio(foot: Felt, slope: float, light: float) -> float:
    """Friction ratio |F_t| / F_n of a foot on a slope (rad); 0 where F_n <= `light` (N), for it is noise there."""
    sine, cosine = math.sin(slope), math.cos(slope)
    normal = foot.downward * cosine - foot.forward * sine
    return abs(foot.forward * cosine + foot.downward * sine) / normal if normal > light else 0.0
