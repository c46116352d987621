"""Events of the hybrid engine: the first within an integration step, which is then taken again so that it ends there.

The clearance is the height of the swing foot over the profile at its own position x. It is continuous as long as the
foot stays over one stretch, and jumps at risers: a jump from above to below ground is an impact on the vertical face,
be it forwards against a riser ahead, or backwards against the one that the foot has just stepped down from.

No event of more than a fraction of a millisecond is missed: an interval is passed over only if the foot, accelerated
no more than `ROOM` times as much as at the step's ends, could not have reached the ground in it.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from mjbiped.engines.hybrid.dynamics import attempt, component_at, ensure_dense
from mjbiped.engines.hybrid.state import Walk, ground_of, hip, pose_of, stance_foot, swing_foot
from mjbiped.numerics.dormand_prince import IN_ORDER, STAGES
from mjbiped.robots.equations import FREE, RESTING
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.rules.termination import FALLEN_HIP
from mjbiped.terrain.profile import height_of, segment_near

Place: TypeAlias = tuple[float, float, int]
"""Distance of the swing foot ahead of the stance foot (m), its clearance (m), and the terrain segment under it."""

NOTHING, TOUCHDOWN, FACE_IMPACT, OVER_THE_TOP, KNEE_STRIKE = 0, 1, 2, 3, 4
FOOT_RELEASED, KNEE_RELEASED, EDGE, FALLEN, BEYOND_END = 5, 6, 7, 8, 9
FOOT_TIPS, FOOT_FLAT = 10, 11

SHORTEST = 5e-4  # intervals are not halved below this, s: the foot's sag in it is some 1e-6 m
RESOLVED = 1e-8  # a crossing is first located so closely, s
CLOSELY = 1e-9  # and other events, s
AT_EDGE = 1e-10  # the moment when a sliding foot leaves its segment, s
ROOM = 2.0
GROUND_WIDTH = 1e-8  # ground that a foot has slid on is left, or met again, so far below its height, m
FACE_WIDTH = 1e-8  # a foot so close to the face that it struck stays on its own side of it, m
CORNER = 1e-6  # a foot that meets a face so close below its edge has landed on top, m
SHORTEST_STEP = 1e-12  # s; if the error of so short a step is too great, the walk ends
POLISHED = 1e-7  # s; the last correction of a touchdown's time, by one term of the Taylor series, is at most this


def first_event(s: Walk, h: float, here: Place, there: Place, pose: Any) -> tuple[int, float]:
    """Find the first event of a step, and take the step again so that it ends there.

    Args:
        s: The walk.
        h: Length of the step, s.
        here: Where the swing foot is at its start.
        there: Where it is at its end.
        pose: Pose at its end.

    Returns:
        The event, and the length of the step up to it, s.
    """
    event, share = NOTHING, 1.0
    ended = body_ends(s, pose)
    struck = NOTHING
    if s.w.locked == FREE and _flexion(s, s.w.out) < 0.0:
        struck = KNEE_STRIKE
    elif s.w.edge * s.w.out[len(s.w.strike_q) - 1] < 0.0:
        struck = FOOT_FLAT
    if ended != NOTHING or struck != NOTHING or not decided_by_ends(s, h, here, there):
        ensure_dense(s, h)
        event = ended
        if ended != NOTHING:
            share = _bisected(s, h, FALLEN)
        if struck != NOTHING:
            strike = _bisected(s, h, struck)
            event = struck if strike < share or ended == NOTHING else event
            share = min(share, strike)
        met, share = foot_event(s, h, share)
        event = met if met != NOTHING else event
        if event != NOTHING:
            h = _end_on(s, share * h, event)
    return _end_of_contact(s, h, event)


def _end_of_contact(s: Walk, h: float, event: int) -> tuple[int, float]:
    """Look whether a sliding foot, a knee that rests on its stop, a heel or a toe loses its contact before all else.

    What a foot in contact would have met later in the step, it then does not.
    """
    w = s.w
    touches = w.face != 0.0 or w.sliding
    if w.sliding and not on_its_segment(s, w.out):
        event, h = EDGE, _retaken(s, h, EDGE, AT_EDGE)
    if touches and w.press < 0.0:
        return FOOT_RELEASED, _retaken(s, h, FOOT_RELEASED, CLOSELY)
    if w.locked == RESTING and w.stop_press < 0.0:
        return KNEE_RELEASED, _retaken(s, h, KNEE_RELEASED, CLOSELY)
    if s.c.toe > 0.0 and _tips(w):
        return FOOT_TIPS, _retaken(s, h, FOOT_TIPS, CLOSELY)
    return event, h


def _tips(w: Any) -> bool:
    """Whether the stance foot would have to tip somewhere in the step."""
    least = w.margins[STAGES]
    for i in range(len(IN_ORDER)):
        least = min(least, w.margins[IN_ORDER[i]])
    return bool(least < 0.0)


def _flexion(s: Walk, state: Any) -> float:
    """Flexion of the swing knee in a state, rad."""
    return float(state[s.c.robot.shank] - state[s.c.robot.thigh])


def flexion_within(s: Walk, x: float) -> float:
    """Flexion of the swing knee at the share x of the step, rad."""
    return component_at(s.w, s.c.robot.shank, x) - component_at(s.w, s.c.robot.thigh, x)


def _happened(s: Walk, x: float, event: int) -> bool:
    """Whether the walk has ended, or the knee has struck its stop, at the share x of the step."""
    if event == KNEE_STRIKE:
        return component_at(s.w, s.c.robot.shank, x) < component_at(s.w, s.c.robot.thigh, x)
    if event == FOOT_FLAT:
        return bool(s.w.edge * component_at(s.w, len(s.w.strike_q) - 1, x) < 0.0)
    return body_ends(s, pose_within(s, x)) != NOTHING


def _bisected(s: Walk, h: float, event: int) -> float:
    """Share of the step at which an event has happened that has by its end, from its dense output."""
    x, end = 0.0, 1.0
    while (end - x) * h > CLOSELY:
        middle = 0.5 * (x + end)
        if _happened(s, middle, event):
            end = middle
        else:
            x = middle
    return end


def _contact_ends(s: Walk, event: int) -> bool:
    """Whether a contact has ended at the step's end: the guard of an event that only a step taken again can tell."""
    if event == EDGE:
        return not on_its_segment(s, s.w.out)
    if event == FOOT_TIPS:
        return _tips(s.w)
    return bool((s.w.press if event == FOOT_RELEASED else s.w.stop_press) < 0.0)


def _retaken(s: Walk, h: float, event: int, width: float) -> float:
    """Take the step again so that it ends just after the end of a contact; returns its length, s."""
    low, high = 0.0, h
    while high - low > width:
        middle = 0.5 * (low + high)
        attempt(s, middle)
        if _contact_ends(s, event):
            high = middle
        else:
            low = middle
    attempt(s, high)
    return high


def _end_on(s: Walk, h: float, event: int) -> float:
    """Take the step again so that it ends on its event; returns its length, s.

    Newton's method on steps of the full order, for the dense output is of a lower one, and at last a Taylor term.
    """
    w = s.w
    n = len(w.y)
    h = max(h, SHORTEST_STEP)
    for _ in range(6):
        attempt(s, h)
        if event != TOUCHDOWN and event != FACE_IMPACT and event != KNEE_STRIKE and event != FOOT_FLAT:
            break
        gap, speed = _gap(s, event)
        if speed == 0.0 or abs(gap) > abs(speed) * 1e-3:
            break  # it grazes: the crossing that was found stands
        change = -gap / speed
        if h + change <= 0.0:
            break
        h += change
        if abs(change) < POLISHED:
            for c in range(n):
                w.out[c] += change * w.k[STAGES * n + c]
            break
    return h


def _gap(s: Walk, event: int) -> tuple[float, float]:
    """What the event's guard measures at the step's end, and its rate: distances in m, or the knee's flexion in rad."""
    w = s.w
    if event == KNEE_STRIKE:
        rates = s.laws.dq(w.out)
        return _flexion(s, w.out), rates[s.c.robot.shank] - rates[s.c.robot.thigh]
    if event == FOOT_FLAT:
        return w.out[len(w.strike_q) - 1], w.out[2 * len(w.strike_q) - 1]
    pose = pose_of(s, w.out)
    foot_x, foot_z = swing_foot(s, pose)
    speed_x, speed_z = foot_speed(s, pose)
    if event == FACE_IMPACT:
        return foot_x - w.face_x, speed_x
    ground = ground_of(s)
    return foot_z - height_of(ground, w.landing, foot_x), speed_z - ground.gradient[w.landing] * speed_x


def foot_speed(s: Walk, pose: Any) -> tuple[float, float]:
    """Rates of the swing foot's place at the step's end, m/s."""
    along = up = 0.0
    chain, first = s.c.robot.chain, len(s.w.strike_q)
    for i in range(first):
        speed, beside = chain.reach[i] * s.w.out[first + i], chain.beside[i] * s.w.out[first + i]
        along += speed * pose[2 * i + 1] - beside * pose[2 * i]
        up -= speed * pose[2 * i] + beside * pose[2 * i + 1]
    rolling = s.c.radius * s.w.out[first]
    return along + rolling * s.w.cosine, up - rolling * s.w.sine


def foot_acceleration(s: Walk) -> float:
    """Bound of the swing foot's acceleration in the step, m/s^2, from its ends."""
    w, chain = s.w, s.c.robot.chain
    n, first = len(w.y), len(w.strike_q)
    start = end = 0.0
    for i in range(first):
        rate, later = w.y[first + i], w.out[first + i]
        lever = abs(chain.reach[i]) + abs(chain.beside[i])
        if i == 0:
            lever += s.c.radius
        start += lever * (abs(w.k[first + i]) + rate * rate)
        end += lever * (abs(w.k[STAGES * n + first + i]) + later * later)
    return ROOM * max(start, end) + float(s.c.gravity)


def segment_under(s: Walk, x: float) -> int:
    """The terrain's segment under x, but for a foot on a face: that one stays on its side of it."""
    w = s.w
    if abs(x - w.face_x) < FACE_WIDTH:
        return int(w.face_segment)
    w.segment = segment_near(ground_of(s), x, w.segment)
    return int(w.segment)


def pose_within(s: Walk, x: float) -> Any:
    """The robot's pose at the share x of the step."""
    w = s.w
    if x == 0.0:
        return pose_of(s, w.y)
    if x == 1.0:
        return pose_of(s, w.out)
    for i in range(len(w.strike_q)):
        w.spare[i] = component_at(w, i, x)
    return pose_of(s, w.spare)


def foot_over_ground(s: Walk, pose: Any) -> Place:
    """Distance ahead of the stance foot (m), clearance (m) and segment of the swing foot."""
    w = s.w
    foot_x, foot_z = swing_foot(s, pose)
    segment = int(w.face_segment) if w.face != 0.0 else segment_under(s, foot_x)
    clearance = foot_z - height_of(ground_of(s), segment, foot_x)
    if segment == w.slid_segment:
        clearance += GROUND_WIDTH
    return foot_x - stance_foot(s, pose)[0], clearance, segment


def happens(s: Walk, t: float, ahead: float, clearance: float) -> bool:
    """Whether the awaited event has occurred: the rule enables the foot's contact or, later, it is below ground."""
    if s.w.contact_enabled:
        return clearance <= 0.0
    return swing_foot_collides(s.c.reach, s.c.delay, t, ahead, clearance)


def keeps_clear(room: float, here: Place, there: Place) -> bool:
    """Whether the foot stays above ground between two moments; it deviates at most `room` (m) from a straight path."""
    return here[2] == there[2] and min(here[1], there[1]) > room


def cannot_be_enabled(reach: float, room: float, here: Place, there: Place) -> bool:
    """Whether the scuffing rule keeps contact disabled between two moments: foot too far back, or below ground."""
    if max(here[0], there[0]) + room < reach:
        return True
    return here[2] == there[2] and max(here[1], there[1]) + room < 0.0


def decided_by_ends(s: Walk, h: float, here: Place, there: Place) -> bool:
    """Whether the step's ends prove that the swing foot meets nothing in it; may enable its contact by the rule."""
    w = s.w
    if w.sliding or (not w.contact_enabled and w.elapsed + h <= s.c.delay):
        return True
    if w.face != 0.0:
        return False
    room = foot_acceleration(s) * h * h / 8.0
    return _decided(s, w.elapsed + h, room, here, there)


def _decided(s: Walk, t: float, room: float, here: Place, there: Place) -> bool:
    """Whether the foot can have met nothing up to t; its contact is then enabled, if the rule says so by now.

    The contact of a foot that keeps clear of the ground may as well be enabled at the end of the interval as within it.
    """
    clear = keeps_clear(room, here, there)
    if s.w.contact_enabled:
        return clear
    if cannot_be_enabled(s.c.reach, room, here, there):
        return True
    if clear and happens(s, t, there[0], there[1]):
        s.w.contact_enabled = True
        return True
    return False


def foot_event(s: Walk, h: float, until: float) -> tuple[int, float]:
    """The first event of the swing foot up to the share `until` of the step, and its share.

    The foot's contact is enabled on the way, where the rule says so.

    The dense output must be there. The share is that of the last moment before the event, within `RESOLVED`.
    """
    w = s.w
    x = 0.0
    if not w.contact_enabled:
        x = max(0.0, (s.c.delay - w.elapsed) / h)
    if x >= until or w.sliding:
        return NOTHING, until
    bound = foot_acceleration(s) / 8.0
    here = foot_over_ground(s, pose_within(s, x))
    while x < until:
        event, share, end, there = _interval(s, h, bound, x, until, here)
        if event != NOTHING:
            return event, share
        if w.face != 0.0 and _over_the_top(s, end):
            while (end - x) * h > RESOLVED:
                middle = 0.5 * (x + end)
                if _over_the_top(s, middle):
                    end = middle
                else:
                    x = middle
            return OVER_THE_TOP, end
        x, here = end, there
    return NOTHING, until


def _interval(s: Walk, h: float, bound: float, x: float, end: float, here: Place) -> tuple[int, float, float, Place]:
    """The first event between two shares of the step, halved until the foot's bound tells all of its first part.

    Returns:
        Event and its share, or nothing; the end of that first part, and where the foot is there.
    """
    w = s.w
    while True:
        there = foot_over_ground(s, pose_within(s, end))
        width = (end - x) * h
        room = bound * width * width
        if _decided(s, w.elapsed + end * h, room, here, there):
            return NOTHING, end, end, there
        falls = here[2] == there[2] and here[1] > 0.0 >= there[1] and here[1] - there[1] > 8.0 * room
        if w.contact_enabled and falls:  # the clearance falls all the way: one crossing
            share = _crossing(s, h, x, end, here, there)
            if _draws_in(s, share):
                return NOTHING, end, end, there
            w.landing = there[2]
            return TOUCHDOWN, share, end, there
        if width < SHORTEST:
            if not happens(s, w.elapsed + end * h, there[0], there[1]):
                return NOTHING, end, end, there
            if not w.contact_enabled:
                w.contact_enabled = True
                return NOTHING, end, end, there
            before, after = _narrowed(s, h, x, end)
            if _draws_in(s, before):
                return NOTHING, end, end, there
            return _kind(s, before, after), before, end, there
        end = 0.5 * (x + end)


def _draws_in(s: Walk, x: float) -> bool:
    """Whether the scuffing rule draws in the foot that comes down at the share x of the step; its contact is then off.

    The rule ends the contact when the foot comes nearer than the reach, which matters only where the foot comes down.
    """
    if s.c.contact:
        return False
    ahead = foot_over_ground(s, pose_within(s, x))[0]
    if not swing_foot_is_drawn_in(s.c.reach, ahead):
        return False
    s.w.contact_enabled = False
    return True


def _crossing(s: Walk, h: float, x: float, end: float, here: Place, there: Place) -> float:
    """Share of the step at which the foot meets a segment that it is above at x and not above at `end`.

    The false position, in the variant of Illinois (Dowell and Jarratt 1971): it keeps the root between x and end.
    """
    above, below, segment = here[1], there[1], here[2]
    side = 0
    middle = x
    while (end - x) * h > RESOLVED:
        last, middle = middle, (x * below - end * above) / (below - above)
        foot_x, foot_z = swing_foot(s, pose_within(s, middle))
        gap = foot_z - height_of(ground_of(s), segment, foot_x)
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


def _narrowed(s: Walk, h: float, x: float, end: float) -> tuple[float, float]:
    """Shares of the step just before and just after something happens, `RESOLVED` apart."""
    while (end - x) * h > RESOLVED:
        middle = 0.5 * (x + end)
        if not x < middle < end:
            break
        ahead, clearance, _ = foot_over_ground(s, pose_within(s, middle))
        if happens(s, s.w.elapsed + middle * h, ahead, clearance):
            end = middle
        else:
            x = middle
    return x, end


def _kind(s: Walk, before: float, after: float) -> int:
    """What a foot that is below ground after the share `before` has met; a face that it hit is noted in the state."""
    w, ground = s.w, ground_of(s)
    own = foot_over_ground(s, pose_within(s, before))[2]
    pose = pose_within(s, after)
    other = foot_over_ground(s, pose)[2]
    w.landing = other
    if own == other:
        return TOUCHDOWN
    face = ground.x[max(own, other)]
    top = height_of(ground, other, face)
    if top - height_of(ground, own, face) < CORNER or swing_foot(s, pose)[1] > top - CORNER:
        return TOUCHDOWN
    w.face_x, w.face_top, w.face_segment = face, top, own
    return FACE_IMPACT


def _over_the_top(s: Walk, x: float) -> bool:
    return bool(swing_foot(s, pose_within(s, x))[1] >= s.w.face_top)


def on_its_segment(s: Walk, state: Any) -> bool:
    """Whether a foot that slides on the ground is, in a state, still on the segment where it came down."""
    ground, segment = ground_of(s), int(s.w.slid_segment)
    x, _ = swing_foot(s, pose_of(s, state))
    begun = segment == 0 or ground.x[segment] <= x
    return bool(begun and (segment + 1 == len(ground.x) or x <= ground.x[segment + 1]))


def body_ends(s: Walk, pose: Any) -> int:
    """`FALLEN` if the hip is too low, `BEYOND_END` if it is beyond the ground's end, else `NOTHING`."""
    x, z = hip(s, pose)
    ground = ground_of(s)
    segment = segment_near(ground, x, int(s.w.segment))
    # the ground of round feet lies higher by their radius, that of feet by the height of their ankles
    if (z - height_of(ground, segment, x)) * s.w.cosine < FALLEN_HIP * s.c.length - s.c.height:
        return FALLEN
    return BEYOND_END if x >= s.c.end else NOTHING
