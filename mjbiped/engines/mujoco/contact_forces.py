"""What a foot feels of its contacts in the step just resolved, as MuJoCo's contact sensors show it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

READING = 11
"""Floats of one slot of a contact sensor: found, force (3), distance, position (3), normal (3)."""
FOUND, FORCE_SHOWN, DISTANCE, NORMAL = 0, 1, 4, 8

SMALLEST_UPWARD_NORMAL = 0.7  # a contact that faces up less is a riser's face or an inner edge of a heightfield


class Felt(NamedTuple):
    """What a foot feels.

    Attributes:
        pressure: Sum of the normal forces of all contacts, N.
        forward: Force of the foot on the ground along x, without that on risers' faces, N.
        downward: The same along -z, N.
        depth: Of the deepest contact with the ground, m.
        ground: Whether it touches the ground.
        face: Whether it touches a riser's face.
    """

    pressure: float
    forward: float
    downward: float
    depth: float
    ground: bool
    face: bool


def felt(readings: Any, first: int, slots: int) -> Felt:
    """The contacts of a foot, of so many floats of its contact sensor from an index on.

    A contact's frame is its normal, which points from the foot into the ground, the robot's lateral axis, and what is
    at right angles to both. On a joint of the ground either side bears a part of the force, and the frames lean by as
    much as the foot lies off the joint: so forces are added as vectors.
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


def friction_ratio(foot: Felt, slope: float, light: float) -> float:
    """|F_t| / F_n of a foot on a slope (rad), or 0 where F_n is no more than `light` (N): the ratio is noise there."""
    sine, cosine = math.sin(slope), math.cos(slope)
    normal = foot.downward * cosine - foot.forward * sine
    return abs(foot.forward * cosine + foot.downward * sine) / normal if normal > light else 0.0
