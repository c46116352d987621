"""What the feet of the biped with knees can meet, and what they feel."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from mjbiped.engines.mujoco.callbacks import Places, beside, meets
from mjbiped.engines.mujoco.contact_events import (
    DISTANCE,
    FORCE_SHOWN,
    FOUND,
    NORMAL,
    READING,
    SMALLEST_UPWARD_NORMAL,
)
from mjbiped.engines.mujoco.kneed.state import Scene


class Felt(NamedTuple):
    """What a foot feels in the step just resolved.

    Attributes:
        force: Sum of all normal forces, N.
        bearing: Of those of the ground, and not of a riser's face, N.
        tangential: Force along the ground, N.
        depth: Of the deepest contact with the ground, m.
        ground: Whether it touches the ground.
        face: Whether it touches a riser's face.
    """

    force: float
    bearing: float
    tangential: float
    depth: float
    ground: bool
    face: bool


def felt(readings: Any, first: int, slots: int) -> Felt:
    """The contacts of a foot, of so many floats of its contact sensor from an index on."""
    force = bearing = across = along = depth = 0.0
    ground = face = False
    for slot in range(first, first + slots, READING):
        if readings[slot + FOUND] > 0.0:
            force += readings[slot + FORCE_SHOWN]
            if -readings[slot + NORMAL + 2] < SMALLEST_UPWARD_NORMAL:
                face = True
            else:
                ground = True
                depth = max(depth, -readings[slot + DISTANCE])
                bearing += readings[slot + FORCE_SHOWN]
                across += readings[slot + FORCE_SHOWN + 1]
                along += readings[slot + FORCE_SHOWN + 2]
    tangential = math.sqrt(across * across + along * along)  # hypot has other last bits compiled
    return Felt(force, bearing, tangential, depth, ground, face)


def stand(places: Places, scene: Scene, leg: int, x: float, z: float) -> None:
    """A foot stands at x, z: it meets all ground but what stands beside it, and risers as any foot does."""
    for index in range(len(scene.ground)):
        geom = int(scene.ground[index])
        met = meets(places, x, z, geom) if places.risers[geom] >= 0.0 else not beside(places, x, z, geom)
        scene.bits[leg, index] = 1 if met else 0


def swing(places: Places, scene: Scene, leg: int, x: float, z: float) -> None:
    """A foot moves at x, z: it is a point, which meets the piece that it is over, and a riser beside it."""
    for index in range(len(scene.ground)):
        scene.bits[leg, index] = 1 if meets(places, x, z, int(scene.ground[index])) else 0


def write_collisions(scene: Scene, lifted: int) -> None:
    """Let the feet meet what was said; that of the leg `lifted`, -1 for none, passes through all.

    See `mjbiped.engines.mujoco.callbacks.refuses`; here bits in `geom_conaffinity` say it, one for each foot.
    """
    for index in range(len(scene.ground)):
        left = 0 if lifted == 0 else scene.bits[0, index]
        right = 0 if lifted == 1 else scene.bits[1, index]
        scene.geom_conaffinity[scene.ground[index]] = left + 2 * right
