"""Events of the hybrid engine: where within an integration step the swing foot may touch, lands or meets a face.

The clearance is the height of the swing foot over the profile at its own position x. It is continuous as long as the
foot stays over one stretch, and jumps at risers: a jump from above to below ground is an impact on the vertical face,
be it forwards against a riser ahead, or backwards against the one that the foot has just stepped down from.

No event of more than a fraction of a millisecond is missed: an interval is passed over only if the foot, accelerated
no more than `ROOM` times as much as at the step's ends, could not have reached the ground in it.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import FACE_WIDTH
from mjbiped.numerics.dormand_prince import STAGES
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.terrain.profile import height_of, segment_near

Place: TypeAlias = tuple[float, float, int]
"""Distance of the swing foot ahead of the stance foot (m), its clearance (m), and the terrain segment under it."""

NOTHING, TOUCHDOWN, FACE_IMPACT, OVER_THE_TOP, KNEE_STRIKE = 0, 1, 2, 3, 4

SHORTEST = 5e-4  # intervals are not halved below this, s: the foot's sag in it is some 1e-6 m
RESOLVED = 1e-8  # a crossing is first located so closely, s
ROOM = 2.0
GROUND_WIDTH = 1e-8  # ground that a foot has slid on is left, or met again, so far below its height, m
CORNER = 1e-6  # a foot that meets a face so close below its edge has landed on top, m


def segment_under(constants: SimulationConstants, b: Buffers, x: float) -> int:
    """The terrain's segment under x, but for a foot on a face: that one stays on its side of it."""
    if abs(x - b.w[at.FACE_X]) < FACE_WIDTH:
        return int(b.w[at.FACE_SEGMENT])
    index = segment_near(constants, x, int(b.w[at.SEGMENT]))
    b.w[at.SEGMENT] = index
    return index


def pose_within(laws: Laws, b: Buffers, x: float) -> Any:
    """The robot's pose at the share x of the step."""
    if x == 0.0:
        return laws.pose(b, b.y)
    if x == 1.0:
        return laws.pose(b, b.out)
    return laws.pose_between(b, x)


def foot_over_ground(laws: Laws, constants: SimulationConstants, b: Buffers, pose: Any) -> Place:
    """Distance ahead of the stance foot (m), clearance (m) and segment of the swing foot."""
    foot_x, foot_z = laws.swing_foot(constants, b, pose)
    segment = int(b.w[at.FACE_SEGMENT]) if b.w[at.FACE] != 0.0 else segment_under(constants, b, foot_x)
    clearance = foot_z - height_of(constants, segment, foot_x)
    if segment == b.w[at.GROUND_SEGMENT]:
        clearance += GROUND_WIDTH
    return foot_x - b.w[at.FOOT_X], clearance, segment


def foot_acceleration(laws: Laws, constants: SimulationConstants, b: Buffers) -> float:
    """Bound of the swing foot's acceleration in the step, m/s^2, from its ends."""
    greatest = 0.0
    for first, state in ((0, b.y), (STAGES * len(b.y), b.out)):
        greatest = max(greatest, laws.foot_rush(constants, b, first, state))
    return ROOM * greatest + constants.gravity


def happens(constants: SimulationConstants, b: Buffers, t: float, ahead: float, clearance: float) -> bool:
    """Whether the event waited for is there: the rule enables the foot's contact or, later, it is below ground."""
    if b.w[at.CONTACT_ENABLED] != 0.0:
        return clearance <= 0.0
    return swing_foot_collides(constants.reach, constants.delay, t, ahead, clearance)


def keeps_clear(room: float, here: Place, there: Place) -> bool:
    """Whether the foot cannot have met ground between two moments, if it strays `room` m from a straight line there."""
    return here[2] == there[2] and min(here[1], there[1]) > room


def cannot_be_enabled(constants: SimulationConstants, room: float, here: Place, there: Place) -> bool:
    """Whether the rule cannot let the foot collide between two moments: not ahead enough, or below ground."""
    if max(here[0], there[0]) + room < constants.reach:
        return True
    return here[2] == there[2] and max(here[1], there[1]) + room < 0.0


def decided_by_ends(
    laws: Laws, constants: SimulationConstants, b: Buffers, t: float, h: float, here: Place, there: Place
) -> bool:
    """Whether the step's ends alone tell that the swing foot meets nothing in it; arms the foot where that is safe."""
    w = b.w
    if w[at.GROUND] != 0.0 or (w[at.CONTACT_ENABLED] == 0.0 and t + h <= constants.delay):
        return True
    if w[at.FACE] != 0.0:
        return False
    room = foot_acceleration(laws, constants, b) * h * h / 8.0
    return _decided(constants, b, t + h, room, here, there)


def _decided(constants: SimulationConstants, b: Buffers, t: float, room: float, here: Place, there: Place) -> bool:
    """Whether the foot can have met nothing up to t; its contact is then enabled, if the rule says so by now.

    The contact of a foot that keeps clear of the ground may as well be enabled at the end of the interval as within it.
    """
    w = b.w
    clear = keeps_clear(room, here, there)
    if w[at.CONTACT_ENABLED] != 0.0:
        return clear
    if cannot_be_enabled(constants, room, here, there):
        return True
    if clear and happens(constants, b, t, there[0], there[1]):
        w[at.CONTACT_ENABLED] = 1.0
        return True
    return False


def first_event(
    laws: Laws, constants: SimulationConstants, b: Buffers, t: float, h: float, until: float
) -> tuple[int, float]:
    """The first event of the swing foot up to the share `until` of the step, and its share.

    The foot's contact is enabled on the way, where the rule says so.

    The dense output must be there. The share is that of the last moment before the event, within `RESOLVED`.
    """
    w = b.w
    bound = foot_acceleration(laws, constants, b) / 8.0
    x = 0.0
    if w[at.CONTACT_ENABLED] == 0.0:
        x = max(0.0, (constants.delay - t) / h)
    if x >= until or w[at.GROUND] != 0.0:
        return NOTHING, until
    here = foot_over_ground(laws, constants, b, pose_within(laws, b, x))
    while x < until:
        end = until
        while True:
            there = foot_over_ground(laws, constants, b, pose_within(laws, b, end))
            width = (end - x) * h
            room = bound * width * width
            if _decided(constants, b, t + end * h, room, here, there):
                break
            if (
                w[at.CONTACT_ENABLED] != 0.0
                and here[2] == there[2]
                and here[1] > 0.0 >= there[1]
                and here[1] - there[1] > 8.0 * room
            ):
                # the clearance falls all the way: one crossing
                share = _crossing(laws, constants, b, h, x, end, here[1], there[1], here[2])
                if _draws_in(laws, constants, b, share):
                    break
                w[at.LANDING] = there[2]
                return TOUCHDOWN, share
            if width < SHORTEST:
                if happens(constants, b, t + end * h, there[0], there[1]):
                    if w[at.CONTACT_ENABLED] != 0.0:
                        before, after = _narrowed(laws, constants, b, t, h, x, end)
                        if _draws_in(laws, constants, b, before):
                            break
                        return _kind(laws, constants, b, before, after), before
                    w[at.CONTACT_ENABLED] = 1.0
                break
            end = 0.5 * (x + end)
        if w[at.FACE] != 0.0 and _over_the_top(laws, constants, b, end):
            while (end - x) * h > RESOLVED:
                middle = 0.5 * (x + end)
                if _over_the_top(laws, constants, b, middle):
                    end = middle
                else:
                    x = middle
            return OVER_THE_TOP, end
        x, here = end, there
    return NOTHING, until


def _draws_in(laws: Laws, constants: SimulationConstants, b: Buffers, x: float) -> bool:
    """Whether the scuffing rule draws in the foot that comes down at the share x of the step; its contact is then off.

    The rule ends the contact when the foot comes nearer than the reach, which matters only where the foot comes down.
    """
    if constants.contact != 0.0:
        return False
    ahead = foot_over_ground(laws, constants, b, pose_within(laws, b, x))[0]
    if not swing_foot_is_drawn_in(constants.reach, ahead):
        return False
    b.w[at.CONTACT_ENABLED] = 0.0
    return True


def _crossing(
    laws: Laws,
    constants: SimulationConstants,
    b: Buffers,
    h: float,
    x: float,
    end: float,
    above: float,
    below: float,
    segment: int,
) -> float:
    """Share of the step at which the foot meets a segment that it is above at x and not above at `end`.

    The false position, in the variant of Illinois (Dowell and Jarratt 1971): it keeps the root between x and end.
    """
    side = 0
    middle = x
    while (end - x) * h > RESOLVED:
        last, middle = middle, (x * below - end * above) / (below - above)
        foot_x, foot_z = laws.swing_foot(constants, b, pose_within(laws, b, middle))
        gap = foot_z - height_of(constants, segment, foot_x)
        if gap > 0.0:
            x, above = middle, gap
            below = 0.5 * below if side > 0 else below
            side = 1
        else:
            end, below = middle, gap
            above = 0.5 * above if side < 0 else above
            side = -1
        if gap == 0.0 or abs(middle - last) * h < RESOLVED:
            break
    return middle


def _narrowed(
    laws: Laws, constants: SimulationConstants, b: Buffers, t: float, h: float, x: float, end: float
) -> tuple[float, float]:
    """Shares of the step just before and just after something happens, `RESOLVED` apart."""
    while (end - x) * h > RESOLVED:
        middle = 0.5 * (x + end)
        if not x < middle < end:
            break
        ahead, clearance, _ = foot_over_ground(laws, constants, b, pose_within(laws, b, middle))
        if happens(constants, b, t + middle * h, ahead, clearance):
            end = middle
        else:
            x = middle
    return x, end


def _kind(laws: Laws, constants: SimulationConstants, b: Buffers, before: float, after: float) -> int:
    """What a foot that is below ground after the share `before` has met; a face that it hit is noted in `w`."""
    w = b.w
    pose = pose_within(laws, b, after)
    own = foot_over_ground(laws, constants, b, pose_within(laws, b, before))[2]
    other = foot_over_ground(laws, constants, b, pose)[2]
    w[at.LANDING] = other
    if own == other:
        return TOUCHDOWN
    face = constants.x[max(own, other)]
    top = height_of(constants, other, face)
    if top - height_of(constants, own, face) < CORNER or laws.swing_foot(constants, b, pose)[1] > top - CORNER:
        return TOUCHDOWN
    w[at.FACE_X], w[at.FACE_TOP], w[at.FACE_SEGMENT] = face, top, own
    return FACE_IMPACT


def _over_the_top(laws: Laws, constants: SimulationConstants, b: Buffers, x: float) -> bool:
    return bool(laws.swing_foot(constants, b, pose_within(laws, b, x))[1] >= b.w[at.FACE_TOP])


def landing(laws: Laws, constants: SimulationConstants, b: Buffers, segment: int) -> tuple[float, float]:
    """Clearance of the swing foot over a segment at the step's end, m, and its rate, m/s."""
    pose = laws.pose(b, b.out)
    foot_x, foot_z = laws.swing_foot(constants, b, pose)
    speed_x, speed_z = laws.foot_speed(constants, b, pose)
    return foot_z - height_of(constants, segment, foot_x), speed_z - constants.gradient[segment] * speed_x


def face_gap(laws: Laws, constants: SimulationConstants, b: Buffers) -> tuple[float, float]:
    """Distance of the swing foot from the struck face at the step's end, m, and its rate, m/s."""
    pose = laws.pose(b, b.out)
    return laws.swing_foot(constants, b, pose)[0] - b.w[at.FACE_X], laws.foot_speed(constants, b, pose)[0]


def body_ends(laws: Laws, constants: SimulationConstants, b: Buffers, pose: Any, fallen_hip: float) -> int:
    """1 if the hip is too low, 2 if it is beyond the ground's end, 0 if neither."""
    x, z = laws.hip(constants, b, pose)
    index = int(b.w[at.SEGMENT])
    while index > 0 and constants.x[index] > x:
        index -= 1
    while index + 1 < len(constants.x) and constants.x[index + 1] <= x:
        index += 1
    if (z - height_of(constants, index, x)) * b.w[at.COSINE] < fallen_hip * constants.length:
        return 1
    return 2 if x >= constants.end else 0
