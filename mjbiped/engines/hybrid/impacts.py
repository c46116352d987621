"""Impacts in which the stance foot stands: of a knee on its stop, of the stance foot's sole, and of a swing foot.

Each is a plastic impact of the linkage under the rows that hold it afterwards (`mjbiped.dynamics.modes`), and the mode
that follows. A foot that has struck a vertical face, or that could not become the stance foot where it came down,
slides there without friction until it is lifted, leaves its stretch of ground, or comes over the face's top.
"""

from __future__ import annotations

import math

from mjbiped.dynamics import modes
from mjbiped.dynamics.equations import load_impact, solve, unfold
from mjbiped.dynamics.linkage import ROOM, SYSTEM, momentum
from mjbiped.dynamics.modes import FLAT, FREE, HEEL, LOCKED, RESTING, TOE
from mjbiped.engines.hybrid.meeting import level_angle
from mjbiped.engines.hybrid.motion import enter_mode, hold_edge, push_from_ground, rub_edge, take_angles
from mjbiped.engines.hybrid.state import (
    Constants,
    State,
    ahead_of_stance,
    from_memory,
    linkage_of,
    pushed,
    stance_foot,
    swing_foot,
    to_memory,
)
from mjbiped.numerics.blocks import call, numbers
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import GROUND_FRICTION, height_of

FELL = int(Outcome.FELL)
MISSED = 1e-6
"""Per leg length: distance from the ground at landing beyond which the foot's events have been missed."""
SLID_INTO = 1e-3  # of the leg's length: a sliding foot that is so far below the next segment has met a riser


def strike_knee(c: Constants, w: State) -> None:
    """The knee strikes its stop and locks, and the controller is told."""
    y, n = numbers(w.y, c.size), c.angles
    q, before, after = numbers(w.strike_q, ROOM), numbers(w.strike_dq, ROOM), numbers(w.struck_dq, ROOM)
    y[c.shank] = y[c.thigh]
    for i in range(n):
        q[i], before[i] = y[i], y[n + i]
    _load(c, w)
    modes.hold_stop(w, c.thigh, c.shank)
    solve(w)
    _take(c, w)
    w.locked = LOCKED
    enter_mode(c, w)
    for i in range(n):
        after[i] = y[n + i]
    w.strike_time = w.elapsed
    to_memory(c, w, y)
    take_angles(c, w, y)
    memory, told, told_rates = numbers(w.memory, c.states), numbers(w.told, c.told), numbers(w.told_rates, c.told)
    call(c.knee_strike, c.parameters, memory, w.elapsed, told, told_rates)
    from_memory(c, w)


def _load(c: Constants, w: State) -> None:
    """Write the equations of an impact in which the stance foot stands."""
    y, q, dq = numbers(w.y, c.size), numbers(w.q, ROOM), numbers(w.dq, ROOM)
    for i in range(c.angles):
        q[i], dq[i] = y[i], y[c.angles + i]
    load_impact(linkage_of(c, w), w, q, dq)


def _take(c: Constants, w: State) -> None:
    """Take rates and the stance foot's impulse from the solution of an impact."""
    y, result, rates, linkage = numbers(w.y, c.size), numbers(w.right, SYSTEM), numbers(w.ddq, ROOM), linkage_of(c, w)
    before_along, before_normal = momentum(linkage, w, numbers(w.q, ROOM), numbers(w.dq, ROOM))
    for i in range(w.free):
        rates[i] = result[i]
    unfold(linkage, w)
    for i in range(c.angles):
        y[c.angles + i] = rates[i]
    along, normal = momentum(linkage, w, numbers(w.q, ROOM), rates)
    w.impulse_along, w.impulse_normal = along - before_along, normal - before_normal


def _take_pushed(c: Constants, w: State) -> None:
    """As `_take`, without the impulse of the surface that pushes the swing foot, the first of the constraints."""
    along, normal = pushed(w)
    impulse = numbers(w.right, SYSTEM)[w.size]
    _take(c, w)
    w.impulse_along -= along * impulse
    w.impulse_normal -= normal * impulse


def tip_over(c: Constants, w: State) -> None:
    """The stance foot begins to turn about the edge at which the ground's force has come to act."""
    w.edge = TOE if numbers(w.moments, 1)[0] < 0.0 else HEEL
    enter_mode(c, w)
    x, z = stance_foot(c, w, numbers(w.y, c.size))
    w.foot_x, w.foot_z = w.foot_x - (x - w.foot_x), w.foot_z - (z - w.foot_z)


def lay_flat(c: Constants, w: State) -> None:
    """The stance foot comes down on all of its sole, in a plastic impact."""
    y = numbers(w.y, c.size)
    y[c.foot] = 0.0
    w.foot_x, w.foot_z = stance_foot(c, w, y)
    _load(c, w)
    if w.down != FLAT:
        rub_edge(c, w)
        hold_edge(c, w, False)
        numbers(w.right, SYSTEM)[w.size] = 0.0
    modes.hold_angle(w, c.foot)
    solve(w)
    if w.down != FLAT:
        _take_pushed(c, w)
    else:
        _take(c, w)
    w.edge = FLAT
    enter_mode(c, w)


def set_down(c: Constants, w: State) -> bool:
    """An edge of the swing foot comes down, in a plastic impact with friction; False: all of the sole does."""
    if c.foot < 0 or set_edge(c, w) < MISSED * c.length:
        w.down = FLAT
        return False
    w.face, w.down_since = 0.0, w.elapsed
    enter_mode(c, w)
    push_from_ground(c, w, 0.0)
    _hit_edge(c, w, True)
    normal, along = numbers(w.right, SYSTEM)[w.size], numbers(w.right, SYSTEM)[w.size + 1]
    if abs(along) > GROUND_FRICTION * normal:
        push_from_ground(c, w, -math.copysign(GROUND_FRICTION, along))
        _hit_edge(c, w, False)
    elif normal > 0.0:
        push_from_ground(c, w, -along / normal)
    _take_pushed(c, w)
    return True


def _hit_edge(c: Constants, w: State, sticks: bool) -> None:
    """Solve the impact of an edge that slides, or sticks; the impulse along the normal comes first, then that along."""
    right = numbers(w.right, SYSTEM)
    _load(c, w)
    hold_edge(c, w, sticks)
    right[w.size] = right[w.size + 1] = 0.0
    solve(w)


def lay_down(c: Constants, w: State) -> None:
    """The landing foot lies flat: it no longer turns."""
    w.slap = w.elapsed - w.down_since
    w.down = FLAT
    enter_mode(c, w)


def hit_face(c: Constants, w: State) -> None:
    """The swing foot meets a vertical face: a plastic impact without friction; the stance foot stays."""
    w.face = 1.0 if numbers(c.x, c.segments)[w.landing] == w.face_x else -1.0
    w.pushed_x, w.pushed_z = -w.face, 0.0
    w.face_impacts = 1
    stop_swing_foot(c, w)


def stop_swing_foot(c: Constants, w: State) -> None:
    """A plastic, frictionless impact of the swing foot along (pushed_x, pushed_z); the stance foot stays.

    A locked knee stays locked, and one that rests on its stop does so if the impact presses it on.
    """
    _hit(c, w, False)
    result = numbers(w.right, SYSTEM)
    if w.locked == RESTING and result[c.shank] > result[c.thigh]:
        w.locked = FREE
    elif w.locked == RESTING:
        _hit(c, w, True)
    _take_pushed(c, w)


def _hit(c: Constants, w: State, stop: bool) -> None:
    """Solve an impact of the swing foot on a surface, and of the knee's stop if the knee rests on it."""
    _load(c, w)
    along, normal = pushed(w)
    modes.hold_contact(linkage_of(c, w), w, numbers(w.dq, ROOM), along, normal)
    numbers(w.right, SYSTEM)[w.size] = 0.0  # the surface stops the foot, however it turns
    if stop:
        modes.hold_stop(w, c.thigh, c.shank)
    solve(w)
    if stop:
        numbers(w.right, SYSTEM)[c.shank] = numbers(w.right, SYSTEM)[c.thigh]  # to the last digit


def stub(c: Constants, w: State) -> None:
    """The ground stops a swing foot that cannot become the stance foot, which slides on it from now on.

    Where the foot is ahead of the stance foot, the robot falls: such an impact has no map.
    """
    segment = int(w.landing)
    if ahead_of_stance(c, w) > 0.0:
        w.outcome, w.unmapped = FELL, True
        return
    if w.slid_segment != segment:
        w.stubs += 1
    slope = numbers(c.angle, c.segments)[segment]
    w.sliding, w.slid_segment, w.face = True, segment, 0.0
    w.pushed_x, w.pushed_z = math.sin(slope), math.cos(slope)
    stop_swing_foot(c, w)


def slide_on(c: Constants, w: State) -> None:
    """A sliding foot comes to another segment: off a step, on along a change of slope, or, falling, into a riser."""
    x, z = swing_foot(c, w, numbers(w.y, c.size))
    segment = int(w.slid_segment)
    segment += 1 if x > numbers(c.x, c.segments)[segment] else -1
    w.sliding, w.slid_segment, w.landing = False, -1, segment
    above = z - height_of(c, segment, x)
    if above <= -SLID_INTO * c.length:
        w.outcome, w.unmapped = FELL, True
    elif above <= 0.0:
        stub(c, w)


def release_foot(c: Constants, w: State, over_the_top: bool) -> None:
    """A foot that slides leaves the surface that no longer presses on it, or its face at the top."""
    if over_the_top or w.press < 0.0:
        w.face = 0.0
    if w.press < 0.0:
        w.sliding = False
        if w.down != FLAT:
            w.down = FLAT
            enter_mode(c, w)


def set_edge(c: Constants, w: State) -> float:
    """Turn a swing foot that has come down to where its edge is on the ground; returns how high its ankle stands, m.

    An ankle that comes over a change of slope may be lower than the edge of its foot lets it: the foot then turns.
    """
    y, segment = numbers(w.y, c.size), w.landing
    x, z = swing_foot(c, w, y)
    slope = numbers(c.angle, c.segments)[segment]
    above, level = (z - height_of(c, segment, x)) * math.cos(slope), level_angle(c, w, segment)
    w.down = TOE if y[c.foot + 1] > level else HEEL
    reach = c.toe if w.down == TOE else c.heel
    share = min((c.height + above) / math.sqrt(reach * reach + c.height * c.height), 1.0)
    y[c.foot + 1] = level + w.down * (math.asin(share) - math.atan2(c.height, reach))
    return float(above)
