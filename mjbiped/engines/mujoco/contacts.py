"""What the feet can meet, and what they feel of their contacts in the step just resolved."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from mjbiped.engines.mujoco.state import Constants, Places, stance_of, swing_of
from mjbiped.terrain.profile import height_of, segment_met, segment_stood_on

READING = 11
"""Floats of one slot of a contact sensor: found, force (3), distance, position (3), normal (3)."""
FOUND, FORCE_SHOWN, DISTANCE, NORMAL = 0, 1, 4, 8

SMALLEST_UPWARD_NORMAL = 0.7  # a contact that faces up less is a riser's face or an inner edge of a heightfield
SUNK = 5e-4  # no standing foot lies deeper in the ground, m


class Felt(NamedTuple):
    """What a foot feels.

    Attributes:
        pressure: Sum of the normal forces of all contacts, N.
        forward: Force of the foot on the ground along x, without that on risers' faces, N.
        downward: That force along -z, N.
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


def refuses(constants: Constants, u: Any, centres: Any, first: int, second: int) -> bool:
    """`mjcb_contactfilter`: whether a pair of geoms does not collide.

    A swing foot passes through everything until its contact is enabled (scuffing rule). From then on it is a point: it
    meets the piece of the ground that it is over, and a riser if it is beside that (`profile.segment_met`). It cannot
    meet a piece's corner.

    The stance foot, which stands still, meets all ground but what stands beside it: not the risers, nor a higher piece.

    The feet of all other legs pass through everything.

    A foot that leaves the ground in this step passes through it: a solver with a convex friction cone would drag one
    that leaves obliquely, as the stance foot does in the step that resolves the other foot's touchdown.

    Args:
        constants: The walk's.
        u: State, after the observation.
        centres: Of all geoms, an array of shape (geoms, 3), m.
        first: One geom.
        second: The other.
    """
    places = constants.places
    stance, swing = stance_of(u), swing_of(u, places.legs)
    lifted, foot = int(u.lifted), places.legs[swing].foot
    if foot in (first, second):
        other = second if first == foot else first
        return lifted == swing or not u.collides or not meets(places, centres[foot, 0], centres[foot, 2], other)
    foot = places.legs[stance].foot
    if foot not in (first, second):
        resting = False
        for leg in places.legs:
            resting = resting or leg.foot in (first, second)
        return resting
    other, x, z = second if first == foot else first, centres[foot, 0], centres[foot, 2]
    if u.time == u.transfer_time and u.count > 0.0:  # as it did when it landed
        return not meets(places, x, z, other)
    return lifted == stance or beside(constants, x, z, other)


def meets(places: Places, x: float, z: float, geom: int) -> bool:
    """Whether a foot at x, z can meet a geom of the ground."""
    segment = segment_met(places.profile, x, z)
    riser = int(places.risers[geom])
    if riser >= 0:
        return (segment < riser) == (places.rises[riser] > 0.0)
    return bool(places.first[geom] <= segment <= places.last[geom])


def beside(constants: Constants, x: float, z: float, geom: int) -> bool:
    """Whether a standing foot at x, z, which may have sunk a little, has a geom of the ground beside it."""
    places = constants.places
    if places.risers[geom] >= 0.0:
        return constants.scuffs or not meets(places, x, z, geom)
    segment = segment_stood_on(places.profile, x, z, SUNK)
    if places.first[geom] <= segment <= places.last[geom]:
        return False
    nearest = int(places.first[geom]) if segment < places.first[geom] else int(places.last[geom])
    return height_of(places.profile, nearest, x) > z + SUNK
