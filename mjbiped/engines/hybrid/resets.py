"""Support transfer in the hybrid engine: landing, impact, beginning of the next step, and the rows of the record.

Rows have one layout for all robots; each robot's record takes its columns from the rows.
"""

from __future__ import annotations

import math
from collections import namedtuple
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.dynamics.linkage import ROOM, SYSTEM, partner
from mjbiped.dynamics.modes import FLAT, FREE, LOCKED, RESTING, bend_stance_knee, land, opens
from mjbiped.engines.hybrid.impacts import MISSED
from mjbiped.engines.hybrid.meeting import CORNER, FACE_WIDTH
from mjbiped.engines.hybrid.motion import enter_mode, take_angles
from mjbiped.engines.hybrid.state import (
    Constants,
    State,
    ahead_of_stance,
    flat_linkage,
    from_memory,
    hip,
    linkage_of,
    sole_angle,
    swing_foot,
    to_memory,
)
from mjbiped.numerics.blocks import Floats, call, call_for_float, numbers, row
from mjbiped.records.columns import tables_of
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import height_of, segment_stood_on

POSTURE = 8  # room for a posture `qpos`


def _widths(table: str) -> dict[str, int]:
    """All columns of a table that some robot has, with the greatest of their widths."""
    widths: dict[str, int] = {}
    for kind in KINDS.values():
        for name, column in getattr(tables_of(kind), table).items():
            widths[name] = max(widths.get(name, 0), column.width)
    return widths


def _layout(table: str) -> Any:
    """Index of the first number of each column in a row that has all columns."""
    widths = _widths(table)
    firsts = np.cumsum([0, *widths.values()]).tolist()
    return namedtuple("Layout", [*widths, "width"])(*firsts)


TOUCHDOWN, SAMPLE = _layout("touchdowns"), _layout("samples")


@cache
def columns_of(kind: type[Robot], table: str) -> NDArray[np.int64]:
    """Which numbers of a row that has all columns are those of a kind of robot."""
    layout, own = (TOUCHDOWN if table == "touchdowns" else SAMPLE), getattr(tables_of(kind), table)
    return np.concatenate([getattr(layout, name) + np.arange(column.width) for name, column in own.items()])


def write_posture(c: Constants, w: State, y: Floats) -> None:
    """Write the posture `qpos` of a state into `w.posture`: hip, upper segments of both legs, what is below."""
    posture, offsets = numbers(w.posture, POSTURE), numbers(w.offsets, ROOM)
    left = w.stance if c.angles > 1 else 0
    posture[0], posture[1] = hip(c, w, y)
    standing = y[0] + offsets[0] + w.slope + c.between * w.count
    posture[2 + left] = standing
    if c.angles == 1:
        return
    swinging = y[1] + w.slope
    posture[3 - left] = swinging
    if c.foot >= 0:
        sole = y[c.foot] + w.slope
        posture[4 + left], posture[5 - left] = sole - standing, y[c.foot + 1] + w.slope - swinging
    else:
        posture[4 + left], posture[5 - left] = w.stance_flexion, y[c.shank] - y[c.thigh]


def estimated_slope(c: Constants, w: State) -> float:
    """The controller's estimate of the slope, rad."""
    return call_for_float(c.slope_estimate, c.parameters, numbers(w.memory, c.states))


def write_sample(c: Constants, w: State, time: float, y: Floats, asked: float) -> None:
    """Write a row of the samples; the torques that act stand in `w.sampled`.

    Args:
        c: The walk's constants.
        w: Its state.
        time: Since the start, s.
        y: State of motion, the controller's states behind it.
        asked: Torque that the ankle is asked for, N m.
    """
    to, tip = row(c.sample_buffer, w.samples, c.sample_width), sole_angle(c, y)
    given, posture = numbers(w.sampled, c.given), numbers(w.posture, POSTURE)
    write_posture(c, w, y)
    to[SAMPLE.time] = time
    for i in range(c.told):
        to[SAMPLE.q + i], to[SAMPLE.dq + i] = y[i] - tip, y[c.angles + i]
    for i in range(c.joints):
        to[SAMPLE.torque + i] = given[i]
    to[SAMPLE.ankle_asked] = asked
    to[SAMPLE.slope] = w.slope + tip
    to[SAMPLE.slope_estimate] = estimated_slope(c, w)
    to[SAMPLE.stance] = w.stance
    for i in range(6):
        to[SAMPLE.qpos + i] = posture[i]
    to[SAMPLE.locked] = 1.0 if w.locked == LOCKED else 0.0
    for i in range(c.states):
        to[SAMPLE.width + i] = y[2 * c.angles + i]


def write_touchdown(c: Constants, w: State, slope: float, dq_before: Floats, estimate_before: float) -> None:
    """Write the row of a touchdown, whose posture and angles stand in the state after the support transfer.

    Args:
        c: The walk's constants.
        w: Its state.
        slope: Slope of the ground under the new stance foot, rad.
        dq_before: Rates before the impact, rad/s.
        estimate_before: The controller's estimate of the slope before the touchdown, rad.
    """
    to = row(c.row_buffer, w.rows, TOUCHDOWN.width)
    before, after, dq, posture = (
        numbers(w.told_before, c.told),
        numbers(w.told, c.told),
        numbers(w.told_rates, c.told),
        numbers(w.posture, POSTURE),
    )
    strike_q, strike_dq, struck_dq = numbers(w.strike_q, ROOM), numbers(w.strike_dq, ROOM), numbers(w.struck_dq, ROOM)
    for i in range(6):
        to[TOUCHDOWN.qpos + i] = posture[i]
    for i in range(c.told):
        to[TOUCHDOWN.q_before + i], to[TOUCHDOWN.dq_before + i] = before[i], dq_before[i]
        to[TOUCHDOWN.q + i], to[TOUCHDOWN.dq + i] = after[i], dq[i]
        to[TOUCHDOWN.knee_q + i], to[TOUCHDOWN.knee_dq_before + i] = strike_q[i], strike_dq[i]
        to[TOUCHDOWN.knee_dq + i] = struck_dq[i]
    to[TOUCHDOWN.time], to[TOUCHDOWN.stance], to[TOUCHDOWN.slope] = w.time, w.stance, slope
    to[TOUCHDOWN.x], to[TOUCHDOWN.z] = w.foot_x - c.height * w.sine, w.foot_z - c.height * w.cosine
    to[TOUCHDOWN.work_absolute], to[TOUCHDOWN.work_net] = w.work_absolute, w.work_net
    to[TOUCHDOWN.work_positive] = w.work_positive
    to[TOUCHDOWN.slip] = to[TOUCHDOWN.penetration] = 0.0
    to[TOUCHDOWN.friction], to[TOUCHDOWN.normal_force] = w.friction, w.normal_force
    to[TOUCHDOWN.strikes], to[TOUCHDOWN.stubs] = w.face_impacts, w.stubs
    to[TOUCHDOWN.slope_estimate_before], to[TOUCHDOWN.slope_estimate] = estimate_before, estimated_slope(c, w)
    pressure = numbers(w.pressure, 2)
    to[TOUCHDOWN.pressure_ahead], to[TOUCHDOWN.pressure_behind] = pressure[0], pressure[1]
    to[TOUCHDOWN.sole_bound_time] = w.bound_time
    to[TOUCHDOWN.knee_strike], to[TOUCHDOWN.flexion] = w.strike_time, w.flexion
    to[TOUCHDOWN.tipped], to[TOUCHDOWN.one_sided], to[TOUCHDOWN.slap] = w.tipped, w.one_sided, w.slap
    to[TOUCHDOWN.support_behind], to[TOUCHDOWN.support_ahead] = c.heel, c.toe


DIVERGED, FINISHED, LEFT_TERRAIN = int(Outcome.DIVERGED), int(Outcome.FINISHED), int(Outcome.LEFT_TERRAIN)


def transfer_support(c: Constants, w: State) -> None:
    """Impact, support transfer, the controller's touchdown, and a row; a foot that is off the ground has diverged."""
    y, spare = numbers(w.y, c.size), numbers(w.spare, c.size)
    foot_x, foot_z = swing_foot(c, w, y)
    segment = segment_stood_on(c, foot_x, foot_z, CORNER, FACE_WIDTH, FACE_WIDTH)
    if not abs(foot_z - height_of(c, segment, foot_x)) <= MISSED * c.length + CORNER:
        w.outcome = DIVERGED
        return
    slope, n = numbers(c.angle, c.segments)[segment], c.angles
    if c.foot >= 0:
        y[c.foot + 1] = slope - w.slope
    write_posture(c, w, y)
    to_memory(c, w, y)
    take_angles(c, w, y)
    memory, told, before = numbers(w.memory, c.states), numbers(w.told, c.told), numbers(w.told_before, c.told)
    for i in range(c.told):
        before[i], spare[i] = told[i], y[n + i]
    estimate_before = estimated_slope(c, w)
    exchange_legs(c, w, slope)
    take_angles(c, w, y)
    if c.support >= 0:
        memory[c.support], memory[c.support + 1] = c.heel, c.toe  # all of the sole stands
    call(c.touchdown, c.parameters, memory, before, told, numbers(w.told_rates, c.told))
    _stand_on(c, w, segment, foot_x)
    from_memory(c, w)
    for i in range(c.size - c.joints, c.size):
        y[i] = 0.0
    write_touchdown(c, w, slope, spare, estimate_before)
    w.rows += 1
    w.count += 1
    begin_gait_step(c, w)
    if w.count >= c.steps or foot_x >= c.distance:
        w.outcome = FINISHED
    elif foot_x >= c.end:
        w.outcome = LEFT_TERRAIN


def exchange_legs(c: Constants, w: State, slope: float) -> None:
    """Impact of a touchdown on a slope (rad), and the legs exchange their roles; the state is then in `w.y`.

    The new swing knee rests on its stop, or is free: if it is bent, or if the impact opens a knee that its stop holds.
    """
    y, n, linkage, flat = numbers(w.y, c.size), c.angles, linkage_of(c, w), flat_linkage(c)
    offsets, angles, result, locked = numbers(w.offsets, ROOM), numbers(w.q, ROOM), numbers(w.right, SYSTEM), RESTING
    standing = 0.0 if w.locked == LOCKED else y[c.shank] - y[c.thigh]
    if linkage.knees and (w.stance_flexion != 0.0 or (c.knee_opens and opens(linkage, flat, w, y))):
        locked = FREE
    along, normal, _ = land(linkage, flat, w, y, locked == RESTING or not c.knee_opens)
    turned = w.slope - slope
    for i in range(linkage.segments):
        angles[partner(linkage, i)] = y[i if i < n else 0] + offsets[i] + turned - c.between
    if linkage.knees:
        w.locked = locked
        w.stance_flexion = standing
        bend_stance_knee(w, c.upper, c.lower, standing)
    for i in range(n):
        y[i], y[n + i] = angles[i] - offsets[i], result[i]
    w.impulse_along = along * math.cos(turned) + normal * math.sin(turned)
    w.impulse_normal = normal * math.cos(turned) - along * math.sin(turned)
    w.edge = FLAT
    enter_mode(c, w)


def _stand_on(c: Constants, w: State, segment: int, foot_x: float) -> None:
    """Stand the robot on its next foot, at x (m) on a segment of the terrain; the gait step's time begins."""
    note_face(c, w, int(w.foot_segment), w.foot_x)
    w.clock, w.after, w.before = w.time, 0.0, math.inf
    w.stance = (w.stance + 1) % c.legs
    slope = numbers(c.angle, c.segments)[segment]
    w.slope, w.sine, w.cosine = slope, math.sin(slope), math.cos(slope)
    w.foot_x, w.foot_z, w.foot_segment = foot_x, height_of(c, segment, foot_x), segment


def note_face(c: Constants, w: State, own: int, x: float) -> None:
    """Note the vertical face beside which the new swing foot has stood, at x (m) on the segment `own`.

    A foot at the base of a riser lies within rounding of its face, on either side of it. It stays on the side of the
    ground that it stood on until it is clearly elsewhere.
    """
    w.face_x = math.nan
    for other in (own - 1, own + 1):
        if 0 <= other < c.segments:
            face = numbers(c.x, c.segments)[max(own, other)]
            top = height_of(c, other, face)
            if abs(x - face) < FACE_WIDTH and top != height_of(c, own, face):
                w.face_x, w.face_top, w.face_segment = face, top, own


def begin_gait_step(c: Constants, w: State) -> None:
    """Reset what is told of one gait step alone."""
    w.contact_enabled, w.foot_angle = c.contact, numbers(w.y, c.size)[0]
    w.face, w.sliding, w.slid_segment = 0.0, False, -1
    w.face_impacts = w.stubs = 0
    w.flexion, w.friction, w.normal_force = 0.0, 0.0, math.inf
    w.tipped = w.one_sided = w.slap = 0.0
    pressure = numbers(w.pressure, 2)
    pressure[0] = pressure[1] = -math.inf
    w.strike_time = math.nan
    q, dq, after = numbers(w.strike_q, ROOM), numbers(w.strike_dq, ROOM), numbers(w.struck_dq, ROOM)
    for i in range(c.angles):
        q[i] = dq[i] = after[i] = math.nan


def stands_still(c: Constants, w: State) -> bool:
    """Whether the swing foot that meets the ground stands beside the stance foot, and nothing moves.

    There is then no impact. Nor need the ground hold the foot: side by side, no rate of straight legs moves the foot
    along the ground's normal. Later the foot meets the ground as one that has slid on it does.
    """
    y, moves = numbers(w.y, c.size), 0.0
    for i in range(c.angles):
        moves += abs(y[c.angles + i])
    if moves > 0.0 or ahead_of_stance(c, w) != 0.0:
        return False
    w.slid_segment = w.landing
    return True


def lands(c: Constants, w: State) -> bool:
    """Whether the swing foot that has come down becomes the stance foot.

    It does where the scuffing rule has drawn in the others, and ahead of the stance foot with a locked, straight knee;
    with bent knees if the impact lifts the other foot.
    """
    if not c.contact:
        return True
    if ahead_of_stance(c, w) <= 0.0:
        return False
    if w.locked == LOCKED and w.stance_flexion == 0.0:
        return True
    if not c.lands_bent:
        return False
    _, _, leaves = land(linkage_of(c, w), flat_linkage(c), w, numbers(w.y, c.size), True)
    return leaves > 0.0
