"""Guards of the hybrid engine: the first event within an integration step, which is then taken again to end there.

Guards of the state (the hip falls, a knee or a foot comes to its stop) are evaluated on the dense output. Guards of a
force (a contact that would have to pull, a foot that would tip) are evaluated on repeated shorter steps, because forces
of the dense output do not satisfy the mode's constraints. `mjbiped.engines.hybrid.meeting` has the swing foot's guards.

At a jump of a torque, integration steps shrink until the jump is within the tolerance, and then grow again. If a torque
jumps to and fro without end (as one with the sign of a rate that it brings to zero), steps stay short, and the walk
hardly advances. Gains far beyond any robot's have the same effect. `lags` detects it.
"""

from __future__ import annotations

from mjbiped.dynamics.integrate import IN_ORDER, STAGES, STAGES_WITH_DENSE, narrowed
from mjbiped.dynamics.linkage import END, ROOM, speed
from mjbiped.dynamics.modes import FLAT, FREE, RESTING
from mjbiped.engines.hybrid.meeting import (
    FACE_IMPACT,
    NOTHING,
    TOUCHDOWN,
    Place,
    clearance_of,
    clearance_rate,
    decided_by_ends,
    foot_event,
    level_angle,
    write_angles_at,
)
from mjbiped.engines.hybrid.motion import attempt, ensure_dense
from mjbiped.engines.hybrid.state import Constants, State, hip, linkage_of, swing_foot, touches
from mjbiped.numerics.blocks import Floats, Numbers, numbers, row
from mjbiped.rules.termination import FALLEN_HIP
from mjbiped.terrain.profile import height_of, segment_near

KNEE_STRIKE, FOOT_RELEASED, KNEE_RELEASED, EDGE, FALLEN, BEYOND_END, FOOT_TIPS, FOOT_FLAT, FOOT_DOWN = range(4, 13)

CLOSELY = 1e-9  # events other than the swing foot's are located so closely, s
AT_EDGE = 1e-10  # the moment when a sliding foot leaves its segment, s
SHORTEST_STEP = 1e-12  # s; if the error of so short a step is too great, the walk ends
POLISHED = 1e-7  # s; the last correction of a touchdown's time, by one term of the Taylor series, is at most this


def first_event(c: Constants, w: State, h: float, here: Place, there: Place) -> tuple[int, float]:
    """Find the first event of a step, and take the step again so that it ends there.

    Args:
        c: The walk's constants.
        w: Its state.
        h: Length of the step, s.
        here: Where the swing foot is at its start.
        there: Where it is at its end.

    Returns:
        The event, and the length of the step up to it, s.
    """
    event, share = NOTHING, 1.0
    out = numbers(w.out, c.size)
    ended, struck = body_ends(c, w, out), NOTHING
    if w.locked == FREE and _to_the_stop(c, w, out, KNEE_STRIKE) < 0.0:
        struck = KNEE_STRIKE
    elif w.edge != FLAT and _to_the_stop(c, w, out, FOOT_FLAT) < 0.0:
        struck = FOOT_FLAT
    elif w.down != FLAT and _to_the_stop(c, w, out, FOOT_DOWN) < 0.0:
        struck = FOOT_DOWN
    if ended != NOTHING or struck != NOTHING or not decided_by_ends(c, w, h, here, there):
        ensure_dense(c, w, h)
        event = ended
        if ended != NOTHING:
            _, share = narrowed(_happened, c, w, FALLEN, (0.0, 1.0), h, CLOSELY)
        if struck != NOTHING:
            _, strike = narrowed(_happened, c, w, struck, (0.0, 1.0), h, CLOSELY)
            event = struck if strike < share or ended == NOTHING else event
            share = min(share, strike)
        met, share = foot_event(c, w, h, share)
        event = met if met != NOTHING else event
        if event != NOTHING:
            h = _end_on(c, w, share * h, event)
    return _end_of_contact(c, w, h, event)


def _end_of_contact(c: Constants, w: State, h: float, event: int) -> tuple[int, float]:
    """Look whether a pushed swing foot, a knee on its stop, a heel or a toe loses its contact before the event.

    The end of a contact then replaces the event, which lies later in the step.
    """
    if w.sliding and not on_its_segment(c, w, numbers(w.out, c.size)):
        event, h = EDGE, _retaken(c, w, h, EDGE, AT_EDGE)
    if touches(w) and w.press < 0.0:
        return FOOT_RELEASED, _retaken(c, w, h, FOOT_RELEASED, CLOSELY)
    if w.locked == RESTING and w.stop_press < 0.0:
        return KNEE_RELEASED, _retaken(c, w, h, KNEE_RELEASED, CLOSELY)
    if c.toe > 0.0 and _tips(w):
        return FOOT_TIPS, _retaken(c, w, h, FOOT_TIPS, CLOSELY)
    return event, h


def _retaken(c: Constants, w: State, h: float, event: int, width: float) -> float:
    """Take the step again so that it ends just after the end of a contact; returns its length, s."""
    _, h = narrowed(_contact_ends, c, w, event, (0.0, h), 1.0, width)
    attempt(c, w, h)
    return h


def _contact_ends(c: Constants, w: State, h: float, _scale: float, event: int) -> bool:
    """Whether a contact ends within a step of a length, s: the guard of an event that only a repeated step shows."""
    attempt(c, w, h)
    if event == EDGE:
        return not on_its_segment(c, w, numbers(w.out, c.size))
    if event == FOOT_TIPS:
        return _tips(w)
    return bool((w.press if event == FOOT_RELEASED else w.stop_press) < 0.0)


def _tips(w: State) -> bool:
    """Whether the stance foot would have to tip somewhere in the step."""
    margins = numbers(w.margins, STAGES_WITH_DENSE)
    least = margins[STAGES]
    for stage in IN_ORDER:
        least = min(least, margins[stage])
    return bool(least < 0.0)


def _happened(c: Constants, w: State, x: float, _h: float, event: int) -> bool:
    """Whether the walk has ended, the knee has struck its stop, or a foot lies flat, at the share x of the step."""
    write_angles_at(c, w, x)
    angles = numbers(w.spare, c.size)
    if event == FALLEN:
        return body_ends(c, w, angles) != NOTHING
    return _to_the_stop(c, w, angles, event) < 0.0


def _to_the_stop(c: Constants, w: State, angles: Numbers, event: int) -> float:
    """Angle of a knee from its stop, or of a foot from the ground on which it comes to lie, rad, by the event."""
    if event == KNEE_STRIKE:
        return float(angles[c.shank] - angles[c.thigh])
    if event == FOOT_FLAT:
        return float(w.edge * angles[c.foot])
    return float(w.down * (angles[c.foot + 1] - level_angle(c, w, w.landing)))


def _end_on(c: Constants, w: State, h: float, event: int) -> float:
    """Take the step again so that it ends on its event; returns its length, s.

    Newton's method on steps of the full order, for the dense output is of a lower one, and at last a Taylor term.
    """
    h = max(h, SHORTEST_STEP)
    for _ in range(6):
        attempt(c, w, h)
        if event not in (TOUCHDOWN, FACE_IMPACT, KNEE_STRIKE, FOOT_FLAT, FOOT_DOWN):
            break
        gap, rate = _gap_at_end(c, w, event)
        if rate == 0.0 or abs(gap) > abs(rate) * 1e-3:
            break  # it grazes: the crossing that was found stands
        change = -gap / rate
        if h + change <= 0.0:
            break
        h += change
        if abs(change) < POLISHED:
            out, rates = numbers(w.out, c.size), row(w.k, STAGES, c.size)
            for i in range(c.size):
                out[i] += change * rates[i]
            break
    return h


def _gap_at_end(c: Constants, w: State, event: int) -> tuple[float, float]:
    """What the event's guard measures at the step's end, and its rate: distances in m, or angles in rad."""
    y, dq, n = numbers(w.out, c.size), numbers(w.dq, ROOM), c.angles
    for i in range(n):
        dq[i] = y[n + i]
    if event == KNEE_STRIKE:
        return _to_the_stop(c, w, y, event), dq[c.shank] - dq[c.thigh]
    if event in (FOOT_FLAT, FOOT_DOWN):
        return _to_the_stop(c, w, y, event), w.edge * dq[c.foot] if event == FOOT_FLAT else w.down * dq[c.foot + 1]
    foot_x, foot_z = swing_foot(c, w, y)
    along, normal = speed(linkage_of(c, w), w, y, dq, END)
    speed_x, speed_z = along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine
    if event == FACE_IMPACT:
        return foot_x - w.face_x, speed_x
    rate = clearance_rate(c, w, y, w.landing, speed_x, speed_z)
    return clearance_of(c, w, y, w.landing, foot_x, foot_z), rate


def on_its_segment(c: Constants, w: State, y: Floats) -> bool:
    """Whether a foot that slides on the ground is, in a state, still on the segment where it came down."""
    starts, segment, (x, _) = numbers(c.x, c.segments), w.slid_segment, swing_foot(c, w, y)
    begun = segment == 0 or starts[segment] <= x
    return bool(begun and (segment + 1 == c.segments or x <= starts[segment + 1]))


def body_ends(c: Constants, w: State, y: Floats) -> int:
    """`FALLEN` if the hip is too low, `BEYOND_END` if it is beyond the ground's end, else `NOTHING`."""
    x, z = hip(c, w, y)
    segment = segment_near(c, x, w.segment)
    # the ground of round feet lies higher by their radius, that of feet by the height of their ankles
    if (z - height_of(c, segment, x)) * w.cosine < FALLEN_HIP * c.length - c.height:
        return FALLEN
    return BEYOND_END if x >= c.end else NOTHING


MOST_ATTEMPTS = 100_000  # most integration steps tried in one gait step; the paper's controller needs some 20
ATTEMPTS_BETWEEN_LOOKS = 2000
LEAST_PROGRESS = 2e-3
"""Least progress between two looks, in stall times; with less a gait step would need ten times `MOST_ATTEMPTS`."""

TAME = 1e3
"""Greatest sum of the legs' rates, in sqrt(g / l), of a motion that does not diverge."""


def watch(w: State) -> None:
    """Begin to watch a gait step."""
    w.under_way, w.looked = True, 0.0
    w.step_started = w.evaluations
    w.look = w.step_started + STAGES * ATTEMPTS_BETWEEN_LOOKS


def lags(c: Constants, w: State) -> bool:
    """Whether a gait step takes too many integration steps, or the last of them have advanced too little."""
    progress = w.elapsed - w.looked
    w.looked, w.look = w.elapsed, w.evaluations + STAGES * ATTEMPTS_BETWEEN_LOOKS
    tried = w.evaluations - w.step_started
    return bool(tried > STAGES * MOST_ATTEMPTS or progress < LEAST_PROGRESS * c.stall_time)


def is_tame(c: Constants, w: State) -> bool:
    """Whether the sum of the legs' rates is below `TAME`."""
    y, rates = numbers(w.y, c.size), 0.0
    for i in range(c.angles):
        rates += abs(y[c.angles + i])
    return bool(rates < TAME / c.pace)
