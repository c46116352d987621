"""Events of the swing foot: where it meets the ground, or a vertical face, within an integration step.

The clearance is the height of the swing foot over the profile at its own position x. It is continuous as long as the
foot stays over one stretch, and jumps at risers: a jump from above to below ground is an impact on the vertical face,
be it forwards against a riser ahead, or backwards against the one that the foot has just stepped down from.

No event of more than a fraction of a millisecond is missed: an interval is passed over only if the foot, accelerated
no more than `MARGIN` times as much as at the step's ends, could not have reached the ground in it.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from mjbiped.dynamics.integrate import STAGES, narrowed, value_at
from mjbiped.dynamics.linkage import END, ROOM
from mjbiped.dynamics.modes import FLAT
from mjbiped.engines.hybrid.state import Constants, State, linkage_of, stance_foot, swing_foot
from mjbiped.numerics.blocks import Floats, numbers, row
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.terrain.profile import GROUND_FRICTION, height_of, segment_near

Place: TypeAlias = tuple[float, float, int]
"""Distance of the swing foot ahead of the stance foot (m), its clearance (m), and the terrain segment under it."""

NOTHING, TOUCHDOWN, FACE_IMPACT, OVER_THE_TOP = 0, 1, 2, 3

SHORTEST = 5e-4  # intervals are not halved below this, s: the foot's sag in it is some 1e-6 m
RESOLVED = 1e-8  # a crossing is first located so closely, s
MARGIN = 2.0
GROUND_WIDTH = 1e-8  # ground that a foot has slid on is left, or met again, so far below its height, m
FACE_WIDTH = 1e-8  # a foot so close to the face that it struck stays on its own side of it, m
CORNER = 1e-6  # a foot that meets a face so close below its edge has landed on top, m


def acceleration_bound(c: Constants, w: State) -> float:
    """Bound of the swing foot's acceleration in the step, m/s^2, from its ends."""
    n, linkage = c.angles, linkage_of(c, w)
    along, ahead = row(w.levers, END, ROOM), row(w.levers, END + 1, ROOM)
    y, out = numbers(w.y, c.size), numbers(w.out, c.size)
    first, last = row(w.k, 0, c.size), row(w.k, STAGES, c.size)
    start = end = 0.0
    for i in range(n):
        lever = abs(along[i]) + abs(ahead[i])
        if i == 0:
            lever += linkage.radius
        if i == c.foot:  # by which the sole of the swing foot turns, too
            lever += c.heel + c.toe
        start += lever * (abs(first[n + i]) + y[n + i] * y[n + i])
        end += lever * (abs(last[n + i]) + out[n + i] * out[n + i])
    return float(MARGIN * max(start, end) + linkage.gravity)


def segment_under(c: Constants, w: State, x: float) -> int:
    """The terrain's segment under x, but for a foot on a face: that one stays on its side of it."""
    if abs(x - w.face_x) < FACE_WIDTH:
        return int(w.face_segment)
    w.segment = segment_near(c, x, w.segment)
    return int(w.segment)


def write_angles_at(c: Constants, w: State, x: float) -> None:
    """Write the angles at the share x of the step into `w.spare`."""
    y, out, spare = numbers(w.y, c.size), numbers(w.out, c.size), numbers(w.spare, c.size)
    for i in range(c.angles):
        spare[i] = y[i] if x == 0.0 else out[i] if x == 1.0 else value_at(c, w, i, x)


def foot_over_ground_within(c: Constants, w: State, x: float) -> Place:
    """Where the swing foot is at the share x of the step; see `foot_over_ground`."""
    write_angles_at(c, w, x)
    return foot_over_ground(c, w, numbers(w.spare, c.size))


def foot_over_ground(c: Constants, w: State, y: Floats) -> Place:
    """Distance ahead of the stance foot (m), clearance (m) and segment of the swing foot in a state."""
    foot_x, foot_z = swing_foot(c, w, y)
    segment = int(w.face_segment) if w.face != 0.0 else segment_under(c, w, foot_x)
    clearance = clearance_of(c, w, y, segment, foot_x, foot_z)
    if segment == w.slid_segment:
        clearance += GROUND_WIDTH
    return foot_x - stance_foot(c, w, y)[0], clearance, segment


def happens(c: Constants, w: State, ahead: float, clearance: float) -> bool:
    """Whether the awaited event has occurred: the rule enables the foot's contact or, later, it is below ground.

    Nobody asks before the rule's delay has passed.
    """
    if w.contact_enabled:
        return clearance <= 0.0
    return swing_foot_collides(c.reach, c.delay, math.inf, ahead, clearance)


def decided_by_ends(c: Constants, w: State, h: float, here: Place, there: Place) -> bool:
    """Whether the step's ends prove that the swing foot meets nothing in it; may enable its contact by the rule."""
    if w.sliding or w.down != FLAT or (not w.contact_enabled and w.elapsed + h <= c.delay):
        return True
    if w.face != 0.0:
        return False
    room = acceleration_bound(c, w) * h * h / 8.0
    return _decided(c, w, room, here, there)


def _decided(c: Constants, w: State, room: float, here: Place, there: Place) -> bool:
    """Whether the foot can have met nothing on the way; its contact is then enabled, if the rule says so by now.

    The contact of a foot that keeps clear of the ground may as well be enabled at the end of the interval as within it.
    """
    same = here[2] == there[2]
    clear = same and min(here[1], there[1]) > room  # a foot deviates at most `room` (m) from a straight path
    if w.contact_enabled:
        return clear
    if max(here[0], there[0]) + room < c.reach or (same and max(here[1], there[1]) + room < 0.0):
        return True  # too far back, or below ground
    if clear and happens(c, w, there[0], there[1]):
        w.contact_enabled = True
        return True
    return False


def foot_event(c: Constants, w: State, h: float, until: float) -> tuple[int, float]:
    """The first event of the swing foot up to the share `until` of the step, and its share.

    The foot's contact is enabled on the way, where the rule says so.

    The dense output must be there. The share is that of the last moment before the event, within `RESOLVED`.
    """
    x = 0.0
    if not w.contact_enabled:
        x = max(0.0, (c.delay - w.elapsed) / h)
    if x >= until or w.sliding or w.down != FLAT:
        return NOTHING, until
    bound = acceleration_bound(c, w) / 8.0
    here = foot_over_ground_within(c, w, x)
    while x < until:
        event, share, end, there = _interval(c, w, h, bound, x, until, here)
        if event != NOTHING:
            return event, share
        if w.face != 0.0 and _over_the_top(c, w, end, h, OVER_THE_TOP):
            return OVER_THE_TOP, narrowed(_over_the_top, c, w, OVER_THE_TOP, (x, end), h, RESOLVED)[1]
        x, here = end, there
    return NOTHING, until


def _interval(
    c: Constants, w: State, h: float, bound: float, x: float, end: float, here: Place
) -> tuple[int, float, float, Place]:
    """The first event between two shares of the step, halved until the foot's bound tells all of its first part.

    Returns:
        Event and its share, or nothing; the end of that first part, and where the foot is there.
    """
    while True:
        there = foot_over_ground_within(c, w, end)
        width = (end - x) * h
        room = bound * width * width
        if _decided(c, w, room, here, there):
            return NOTHING, end, end, there
        falls = here[2] == there[2] and here[1] > 0.0 >= there[1] and here[1] - there[1] > 8.0 * room
        if w.contact_enabled and falls:  # the clearance falls all the way: one crossing
            share = _crossing(c, w, h, x, end, here, there)
            if _draws_in(c, w, share):
                return NOTHING, end, end, there
            w.landing = there[2]
            return TOUCHDOWN, share, end, there
        if width < SHORTEST:
            if not happens(c, w, there[0], there[1]):
                return NOTHING, end, end, there
            if not w.contact_enabled:
                w.contact_enabled = True
                return NOTHING, end, end, there
            before, after = narrowed(_happens_within, c, w, TOUCHDOWN, (x, end), h, RESOLVED)
            if _draws_in(c, w, before):
                return NOTHING, end, end, there
            return _kind(c, w, before, after), before, end, there
        end = 0.5 * (x + end)


def _draws_in(c: Constants, w: State, x: float) -> bool:
    """Whether the scuffing rule draws in the foot that comes down at the share x of the step; its contact is then off.

    The rule ends the contact when the foot comes nearer than the reach, which matters only where the foot comes down.
    """
    if c.contact:
        return False
    ahead = foot_over_ground_within(c, w, x)[0]
    if not swing_foot_is_drawn_in(c.reach, ahead):
        return False
    w.contact_enabled = False
    return True


def _crossing(c: Constants, w: State, h: float, x: float, end: float, here: Place, there: Place) -> float:
    """Share of the step at which the foot meets a segment that it is above at x and not above at `end`.

    The false position, in the variant of Illinois (Dowell and Jarratt 1971): it keeps the root between x and end.
    """
    above, below, segment = here[1], there[1], here[2]
    side = 0
    middle = x
    while (end - x) * h > RESOLVED:
        last, middle = middle, (x * below - end * above) / (below - above)
        write_angles_at(c, w, middle)
        foot_x, foot_z = swing_foot(c, w, numbers(w.spare, c.size))
        gap = clearance_of(c, w, numbers(w.spare, c.size), segment, foot_x, foot_z)
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


def _happens_within(c: Constants, w: State, x: float, _h: float, _event: int) -> bool:
    ahead, clearance, _ = foot_over_ground_within(c, w, x)
    return happens(c, w, ahead, clearance)


def _over_the_top(c: Constants, w: State, x: float, _h: float, _event: int) -> bool:
    write_angles_at(c, w, x)
    return bool(swing_foot(c, w, numbers(w.spare, c.size))[1] >= w.face_top)


def _kind(c: Constants, w: State, before: float, after: float) -> int:
    """What a foot that is below ground after the share `before` has met; a face that it hit is noted in the state."""
    own = foot_over_ground_within(c, w, before)[2]
    other = foot_over_ground_within(c, w, after)[2]
    w.landing = other
    if own == other:
        return TOUCHDOWN
    face = numbers(c.x, c.segments)[max(own, other)]
    top = height_of(c, other, face)
    if swing_foot(c, w, numbers(w.spare, c.size))[1] > top - CORNER:
        return TOUCHDOWN
    w.face_x, w.face_top, w.face_segment = face, top, own
    return FACE_IMPACT


def level_angle(c: Constants, w: State, segment: int) -> float:
    """Angle of the swing foot's sole that lies flat on a segment of the terrain, from the stance foot's ground, rad."""
    return float(numbers(c.angle, c.segments)[segment] - w.slope)


def clearance_of(c: Constants, w: State, y: Floats, segment: int, x: float, z: float) -> float:
    """Height of the swing foot at (x, z) over a segment of the terrain, m; of one that is a body, of its lower edge."""
    clearance = z - height_of(c, segment, x)
    if c.foot >= 0:
        rise, _ = _edge_below(c, y[c.foot + 1] - level_angle(c, w, segment))
        clearance -= rise / math.cos(numbers(c.angle, c.segments)[segment])
    return float(clearance)


def clearance_rate(c: Constants, w: State, y: Floats, segment: int, speed_x: float, speed_z: float) -> float:
    """Rate of that clearance, m/s, of a swing foot with a velocity, m/s."""
    rate = speed_z - numbers(c.gradient, c.segments)[segment] * speed_x
    if c.foot >= 0:
        _, lever = _edge_below(c, y[c.foot + 1] - level_angle(c, w, segment))
        rate -= lever * y[c.angles + c.foot + 1] / math.cos(numbers(c.angle, c.segments)[segment])
    return float(rate)


def _edge_below(c: Constants, tilt: float) -> tuple[float, float]:
    """How far a tilted sole's lower edge is below its flat one, m, and the derivative by the tilt (rad), m.

    A sole that is so short that friction would jam it (Painleve's paradox) comes down flat at once.
    """
    reach, sign = (c.toe, 1.0) if tilt > 0.0 else (c.heel, -1.0)
    if reach <= GROUND_FRICTION * c.height:
        return 0.0, 0.0
    sine, cosine = math.sin(sign * tilt), math.cos(tilt)
    return reach * sine - c.height * (1.0 - cosine), sign * (reach * cosine - c.height * sine)
