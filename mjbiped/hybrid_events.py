"""Events of the hybrid engine: where within an integration step the swing foot starts to collide, lands or strikes.

The clearance is the height of the swing foot over the profile at its own place x. It is continuous as long as the foot
stays over one stretch, and jumps at risers: a jump from above to below ground is a strike of the vertical face, be it
forwards against a riser ahead, or backwards against the one that the foot has just stepped down from.

No event of more than a fraction of a millisecond is missed: an interval is passed over only if the foot, accelerated
no more than `ROOM` times as much as at the step's ends, could not have reached the ground in it.
"""

from __future__ import annotations

import math

from mjbiped.dormand_prince import STAGES, dense_at
from mjbiped.hybrid_state import (
    ARMED,
    FACE,
    FACE_SEGMENT,
    FACE_TOP,
    FACE_X,
    FOOT_X,
    FOOT_Z,
    LANDING,
    SEGMENT,
    SLOPE,
    Buffers,
    World,
)
from mjbiped.scuffing import swing_foot_collides

NOTHING, TOUCHDOWN, STRIKE, OVER_THE_TOP = 0, 1, 2, 3

SHORTEST = 5e-4  # intervals are not halved below this, s: the foot's sag in it is some 1e-6 m
RESOLVED = 1e-8  # a crossing is first located so closely, s
ROOM = 2.0
FACE_WIDTH = 1e-8  # a foot so close to the face that it struck stays on its own side of it, m
CORNER = 1e-6  # a foot that meets a face so close below its edge has landed on top, m


def segment_under(world: World, b: Buffers, x: float) -> int:
    """The terrain's segment under x, as `Terrain.segment_at`, searched from the last one."""
    if abs(x - b.w[FACE_X]) < FACE_WIDTH:
        return int(b.w[FACE_SEGMENT])
    index = int(b.w[SEGMENT])
    while index + 1 < len(world.x) and world.x[index + 1] <= x:
        index += 1
    while index > 0 and world.x[index] > x:
        index -= 1
    b.w[SEGMENT] = index
    return index


def height_of(world: World, segment: int, x: float) -> float:
    """Height of a segment's line at x, m."""
    return float(world.z[segment] + world.gradient[segment] * (x - world.x[segment]))


def swing_foot(world: World, b: Buffers, q1: float, q2: float) -> tuple[float, float]:
    """Place x, z of the swing foot, m."""
    stance, swing = q1 + b.w[SLOPE], q2 + b.w[SLOPE]
    return (
        b.w[FOOT_X] + world.length * (math.sin(stance) - math.sin(swing)),
        b.w[FOOT_Z] + world.length * (math.cos(stance) - math.cos(swing)),
    )


def hip(world: World, b: Buffers, q1: float) -> tuple[float, float]:
    """Place x, z of the hip, m."""
    stance = q1 + b.w[SLOPE]
    return b.w[FOOT_X] + world.length * math.sin(stance), b.w[FOOT_Z] + world.length * math.cos(stance)


def angles(b: Buffers, x: float) -> tuple[float, float]:
    """q1 and q2 at the share x of the step."""
    if x == 0.0:
        return b.y[0], b.y[1]
    if x == 1.0:
        return b.out[0], b.out[1]
    n = len(b.y)
    return dense_at(b.dense, n, 0, b.y[0], x), dense_at(b.dense, n, 1, b.y[1], x)


def foot_over_ground(world: World, b: Buffers, x: float) -> tuple[float, float, int]:
    """Distance ahead of the stance foot (m), clearance (m) and segment of the swing foot at the share x of the step."""
    q1, q2 = angles(b, x)
    foot_x, foot_z = swing_foot(world, b, q1, q2)
    segment = int(b.w[FACE_SEGMENT]) if b.w[FACE] != 0.0 else segment_under(world, b, foot_x)
    return foot_x - b.w[FOOT_X], foot_z - height_of(world, segment, foot_x), segment


def foot_acceleration(world: World, b: Buffers) -> float:
    """Bound of the swing foot's acceleration in the step, m/s^2, from its ends."""
    greatest = 0.0
    for first, state in ((0, b.y), (STAGES * len(b.y), b.out)):
        legs = abs(b.k[first + 2]) + abs(b.k[first + 3]) + state[2] * state[2] + state[3] * state[3]
        greatest = max(greatest, world.length * legs)
    return ROOM * greatest + world.gravity


def happens(world: World, b: Buffers, t: float, ahead: float, clearance: float) -> bool:
    """Whether what is waited for is so: the rule arms the foot, or the armed foot is below ground."""
    if b.w[ARMED] != 0.0:
        return clearance <= 0.0
    return swing_foot_collides(world.reach, world.delay, t, ahead, clearance)


def cannot_happen(
    world: World,
    b: Buffers,
    room: float,
    at: tuple[float, float, int],
    then: tuple[float, float, int],
) -> bool:
    """Whether nothing can have happened between two moments in which the foot strays `room` m from a straight line."""
    if b.w[ARMED] == 0.0 and max(at[0], then[0]) + room < world.reach:
        return True
    if at[2] != then[2]:
        return False
    if b.w[ARMED] == 0.0:
        return max(at[1], then[1]) + room < 0.0
    return min(at[1], then[1]) > room


def decided_without_dense(world: World, b: Buffers, t: float, h: float) -> bool:
    """Whether the step's ends alone tell that the swing foot meets nothing in it."""
    if b.w[ARMED] == 0.0 and t + h <= world.delay:
        return True
    if b.w[FACE] != 0.0:
        return False
    room = foot_acceleration(world, b) * h * h / 8.0
    return cannot_happen(world, b, room, foot_over_ground(world, b, 0.0), foot_over_ground(world, b, 1.0))


def first_event(world: World, b: Buffers, t: float, h: float, until: float) -> tuple[int, float]:
    """The first event of the swing foot up to the share `until` of the step, and its share; arms the foot on its way.

    The dense output must be there. The share is that of the last moment before the event, within `RESOLVED`.
    """
    w = b.w
    bound = foot_acceleration(world, b) / 8.0
    x = 0.0
    if w[ARMED] == 0.0:
        x = max(0.0, (world.delay - t) / h)
    if x >= until:
        return NOTHING, until
    here = foot_over_ground(world, b, x)
    while x < until:
        end = until
        while True:
            there = foot_over_ground(world, b, end)
            width = (end - x) * h
            if cannot_happen(world, b, bound * width * width, here, there):
                break
            if width < SHORTEST:
                if happens(world, b, t + end * h, there[0], there[1]):
                    before, end = _narrowed(world, b, t, h, x, end)
                    if w[ARMED] != 0.0:
                        return _kind(world, b, before, end), before
                    w[ARMED] = 1.0
                    there = foot_over_ground(world, b, end)
                break
            end = 0.5 * (x + end)
        if w[FACE] != 0.0 and _over_the_top(world, b, end):
            while (end - x) * h > RESOLVED:
                middle = 0.5 * (x + end)
                if _over_the_top(world, b, middle):
                    end = middle
                else:
                    x = middle
            return OVER_THE_TOP, end
        x, here = end, there
    return NOTHING, until


def _narrowed(world: World, b: Buffers, t: float, h: float, x: float, end: float) -> tuple[float, float]:
    """Shares of the step just before and just after something happens, `RESOLVED` apart."""
    while (end - x) * h > RESOLVED:
        middle = 0.5 * (x + end)
        if not x < middle < end:
            break
        ahead, clearance, _ = foot_over_ground(world, b, middle)
        if happens(world, b, t + middle * h, ahead, clearance):
            end = middle
        else:
            x = middle
    return x, end


def _kind(world: World, b: Buffers, before: float, after: float) -> int:
    """What an armed foot that is below ground after `before` has met; a struck face is noted in `w`."""
    w = b.w
    own = foot_over_ground(world, b, before)[2]
    other = foot_over_ground(world, b, after)[2]
    w[LANDING] = other
    if own == other:
        return TOUCHDOWN
    face = world.x[max(own, other)]
    q1, q2 = angles(b, after)
    top = height_of(world, other, face)
    if top - height_of(world, own, face) < CORNER or swing_foot(world, b, q1, q2)[1] > top - CORNER:
        return TOUCHDOWN
    w[FACE_X], w[FACE_TOP], w[FACE_SEGMENT] = face, top, own
    return STRIKE


def _over_the_top(world: World, b: Buffers, x: float) -> bool:
    q1, q2 = angles(b, x)
    return bool(swing_foot(world, b, q1, q2)[1] >= b.w[FACE_TOP])


def landing(world: World, b: Buffers, segment: int) -> tuple[float, float]:
    """Clearance of the swing foot over a segment at the step's end, m, and its rate, m/s."""
    q1, q2 = b.out[0], b.out[1]
    foot_x, foot_z = swing_foot(world, b, q1, q2)
    speed_x, speed_z = _foot_speed(world, b)
    return foot_z - height_of(world, segment, foot_x), speed_z - world.gradient[segment] * speed_x


def striking(world: World, b: Buffers) -> tuple[float, float]:
    """Distance of the swing foot from the struck face at the step's end, m, and its rate, m/s."""
    foot_x, _ = swing_foot(world, b, b.out[0], b.out[1])
    speed_x, _ = _foot_speed(world, b)
    return foot_x - b.w[FACE_X], speed_x


def _foot_speed(world: World, b: Buffers) -> tuple[float, float]:
    stance, swing = b.out[0] + b.w[SLOPE], b.out[1] + b.w[SLOPE]
    return (
        world.length * (math.cos(stance) * b.out[2] - math.cos(swing) * b.out[3]),
        world.length * (math.sin(swing) * b.out[3] - math.sin(stance) * b.out[2]),
    )


def body_ends(world: World, b: Buffers, q1: float, fallen_hip: float) -> int:
    """1 if the hip is too low, 2 if it is beyond the ground's end, 0 if neither."""
    x, z = hip(world, b, q1)
    index = int(b.w[SEGMENT])
    while index > 0 and world.x[index] > x:
        index -= 1
    while index + 1 < len(world.x) and world.x[index + 1] <= x:
        index += 1
    if (z - height_of(world, index, x)) * math.cos(b.w[SLOPE]) < fallen_hip * world.length:
        return 1
    return 2 if x >= world.end else 0
