"""Reset maps of the hybrid engine: support transfer, knee strike, and impacts of a swing foot that does not land.

A foot that has struck a vertical face, or that could not become the stance foot where it came down, slides there
without friction until it is lifted, leaves its stretch of ground, or comes over the face's top.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid.events import CORNER, FACE_WIDTH
from mjbiped.engines.hybrid.forces import momentum, note_impulse
from mjbiped.engines.hybrid.state import Walk, ground_of, hand_over, hip, pose_of, stance_foot, swing_foot, take_back
from mjbiped.robots.equations import FLAT, HEEL, TOE
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import height_of, segment_stood_on

DIVERGED, FELL, FINISHED, LEFT_TERRAIN = (
    int(outcome) for outcome in (Outcome.DIVERGED, Outcome.FELL, Outcome.FINISHED, Outcome.LEFT_TERRAIN)
)
MISSED = 1e-6  # of the leg's length: a foot that lands so far off the ground has not been followed
TOGETHER = 1e-8  # m; feet that are so near to each other stand at one place
SLID_INTO = 1e-3  # of the leg's length: a sliding foot that is so far below the next segment has met a riser


def transfer_support(s: Walk) -> None:
    """Impact, support transfer, the controller's touchdown, and a row of the record.

    No row tells of a foot that is not on the ground: the walk has then diverged.
    """
    w, c, laws = s.w, s.c, s.laws
    ground, pose = ground_of(s), pose_of(s, w.y)
    foot_x, foot_z = swing_foot(s, pose)
    segment = segment_stood_on(ground, foot_x, foot_z, CORNER, FACE_WIDTH, FACE_WIDTH)
    if not abs(foot_z - height_of(ground, segment, foot_x)) <= MISSED * c.length + CORNER:
        w.outcome = DIVERGED
        return
    before, slope = momentum(s), ground.angle[segment]
    q_before, dq_before = laws.q(w.y), laws.dq(w.y)
    w.swing_sole = slope - laws.sole_slope(w.slope, q_before)
    qpos = hip(s, pose) + laws.limbs(c.robot, w, q_before)
    q, dq = laws.exchange(c.robot, w, q_before, dq_before, slope)
    hand_over(s, w.y)
    estimate_before = laws.slope_estimate(s.law, w.memory)
    told_before, told = (laws.told(q_before), laws.told_rates(dq_before)), (laws.told(q), laws.told_rates(dq))
    if c.support >= 0:
        w.memory[c.support], w.memory[c.support + 1] = c.heel, c.toe  # all of the sole stands
    laws.touchdown(s.law, w.memory, told_before[0], told[0], told[1])
    stand_on(s, segment, foot_x)
    for i in range(len(q)):
        w.y[i], w.y[len(q) + i] = q[i], dq[i]
    take_back(s)
    for component in range(len(w.y) - len(w.peak_torque), len(w.y)):
        w.y[component] = 0.0
    _write_row(s, qpos, slope, told_before, told, estimate_before)
    w.rows += 1
    w.count += 1
    begin_gait_step(w, c.contact)
    note_impulse(s, before, 0.0)
    if w.count >= c.steps or foot_x >= c.distance:
        w.outcome = FINISHED
    elif foot_x >= c.end:
        w.outcome = LEFT_TERRAIN


def _write_row(s: Walk, qpos: Any, slope: float, before: Any, after: Any, estimate_before: float) -> None:
    """Write the row of a touchdown.

    Args:
        s: The walk, after the support transfer.
        qpos: Posture at touchdown.
        slope: Slope of the ground under the new stance foot, rad.
        before: Angles (rad) and rates (rad/s) before the impact.
        after: Angles and rates after it, in the new roles.
        estimate_before: The controller's estimate of the slope before the touchdown, rad.
    """
    w = s.w
    s.laws.write_touchdown(
        s.laws.tables(s.c.tables).rows[w.rows],
        0,
        time=w.time,
        qpos=qpos,
        x=w.foot_x - s.c.height * w.sine,
        z=w.foot_z - s.c.height * w.cosine,
        stance=w.stance,
        slope=slope,
        q_before=before[0],
        dq_before=before[1],
        q=after[0],
        dq=after[1],
        work_absolute=w.work_absolute,
        work_net=w.work_net,
        work_positive=w.work_positive,
        slip=0.0,
        penetration=0.0,
        friction=w.friction,
        strikes=w.face_impacts,
        slope_estimate_before=estimate_before,
        slope_estimate=s.laws.slope_estimate(s.law, w.memory),
        normal_force=w.normal_force,
        pressure_ahead=w.pressure[0],
        pressure_behind=w.pressure[1],
        sole_bound_time=w.bound_time,
        knee_strike=w.strike_time,
        knee_q=w.strike_q,
        knee_dq_before=w.strike_dq,
        knee_dq=w.struck_dq,
        flexion=w.flexion,
        stubs=w.stubs,
        tipped=w.tipped,
        one_sided=w.one_sided,
        slap=0.0,
        support_behind=s.c.heel,
        support_ahead=s.c.toe,
    )


def stand_on(s: Walk, segment: int, foot_x: float) -> None:
    """Stand the robot on its next foot, at x (m) on a segment of the terrain; the gait step's time begins."""
    w, ground = s.w, ground_of(s)
    note_face(s, int(w.foot_segment), w.foot_x)
    w.clock, w.after, w.before = w.time, 0.0, math.inf
    w.stance = (w.stance + 1) % s.c.legs
    slope = ground.angle[segment]
    w.slope, w.sine, w.cosine = slope, math.sin(slope), math.cos(slope)
    w.foot_x, w.foot_z, w.foot_segment = foot_x, height_of(ground, segment, foot_x), segment


def note_face(s: Walk, own: int, x: float) -> None:
    """Note the vertical face beside which the new swing foot has stood, at x (m) on the segment `own`.

    A foot at the base of a riser lies within rounding of its face, on either side of it. It stays on the side of the
    ground that it stood on until it is clearly elsewhere.
    """
    w, ground = s.w, ground_of(s)
    w.face_x = math.nan
    for other in (own - 1, own + 1):
        if 0 <= other < len(ground.x):
            face = ground.x[max(own, other)]
            top = height_of(ground, other, face)
            if abs(x - face) < FACE_WIDTH and top != height_of(ground, own, face):
                w.face_x, w.face_top, w.face_segment = face, top, own


def begin_gait_step(w: Any, contact: bool) -> None:
    """Reset what is told of one gait step alone; `contact` says whether the swing foot collides from the start."""
    w.contact_enabled, w.foot_angle = contact, w.y[0]
    w.face, w.sliding, w.slid_segment = 0.0, False, -1
    w.face_impacts = w.stubs = 0
    w.flexion, w.friction, w.normal_force = 0.0, 0.0, math.inf
    w.swing_sole = w.tipped = w.one_sided = 0.0
    w.pressure[0] = w.pressure[1] = -math.inf
    w.strike_time = math.nan
    for i in range(len(w.strike_q)):
        w.strike_q[i] = w.strike_dq[i] = w.struck_dq[i] = math.nan


def ahead_of_stance(s: Walk) -> float:
    """How far the swing foot is ahead of the stance foot, m; 0 where they stand together."""
    pose = pose_of(s, s.w.y)
    ahead = float(swing_foot(s, pose)[0] - stance_foot(s, pose)[0])
    return 0.0 if abs(ahead) < TOGETHER else ahead


def stands_still(s: Walk) -> bool:
    """Whether the swing foot that meets the ground stands beside the stance foot, and nothing moves.

    There is then no impact. Nor need the ground hold the foot: while both legs are straight and side by side, no rate
    of theirs moves the foot along the ground's normal. Later the foot meets the ground as one that has slid on it does,
    a little below its height.
    """
    w, moves = s.w, 0.0
    for rate in s.laws.dq(w.y):
        moves += abs(rate)
    if moves > 0.0 or ahead_of_stance(s) != 0.0:
        return False
    w.slid_segment = w.landing
    return True


def lands(s: Walk) -> bool:
    """Whether the swing foot becomes the stance foot where it has come down."""
    return bool(s.laws.lands(s.c.robot, s.w, ahead_of_stance(s)))


def strike_knee(s: Walk) -> None:
    """The knee strikes its stop, and the controller is told."""
    w, laws = s.w, s.laws
    angles, before = len(w.strike_q), momentum(s)
    shank, thigh = s.c.robot.shank, s.c.robot.thigh
    w.y[shank] = w.y[thigh]
    for i in range(angles):
        w.strike_q[i], w.strike_dq[i] = w.y[i], w.y[angles + i]
    laws.lock_knee(s.c.robot, w)
    for i in range(angles):
        w.struck_dq[i] = w.y[angles + i]
    w.strike_time = w.elapsed
    hand_over(s, w.y)
    laws.knee_strike(s.law, w.memory, w.elapsed, laws.told(laws.q(w.y)), laws.told_rates(laws.dq(w.y)))
    take_back(s)
    note_impulse(s, before, 0.0)


def tip_over(s: Walk) -> None:
    """The stance foot begins to turn about the edge at which the ground's force has come to act."""
    _turn_foot(s, TOE if s.w.moments[0] < 0.0 else HEEL)


def lay_flat(s: Walk) -> None:
    """The stance foot comes down on all of its sole, in a plastic impact."""
    before = momentum(s)
    _turn_foot(s, FLAT)
    note_impulse(s, before, 0.0)


def _turn_foot(s: Walk, edge: int) -> None:
    """Let the stance foot stand otherwise; its ankle stays where it is."""
    w, chain = s.w, s.c.robot.chain
    x, z = stance_foot(s, pose_of(s, w.y))
    s.laws.turn_foot(s.c.robot, w, edge)
    along, beside = (0.0, 0.0) if edge == FLAT else (chain.reach[-1], chain.beside[-1])
    w.foot_x = x - along * w.sine - beside * w.cosine
    w.foot_z = z - along * w.cosine + beside * w.sine


def hit_face(s: Walk) -> None:
    """The swing foot meets a vertical face: a plastic impact without friction; the stance foot stays."""
    w, before = s.w, momentum(s)
    w.face = 1.0 if ground_of(s).x[w.landing] == w.face_x else -1.0
    w.pushed_x, w.pushed_z = -w.face, 0.0
    w.face_impacts = 1
    note_impulse(s, before, s.laws.stop_foot(s.c.robot, w))


def stub(s: Walk) -> None:
    """The ground stops a swing foot that cannot become the stance foot, which slides on it from now on.

    Where the foot is ahead of the stance foot, the robot falls: such an impact has no map.
    """
    w, segment, before = s.w, int(s.w.landing), momentum(s)
    if ahead_of_stance(s) > 0.0:
        w.outcome, w.toe = FELL, True
        return
    if w.slid_segment != segment:
        w.stubs += 1
    slope = ground_of(s).angle[segment]
    w.sliding, w.slid_segment, w.face = True, segment, 0.0
    w.pushed_x, w.pushed_z = math.sin(slope), math.cos(slope)
    note_impulse(s, before, s.laws.stop_foot(s.c.robot, w))


def slide_on(s: Walk) -> None:
    """A sliding foot comes to another segment: off a step, on along a change of slope, or, falling, into a riser."""
    w, ground = s.w, ground_of(s)
    x, z = swing_foot(s, pose_of(s, w.y))
    segment = int(w.slid_segment)
    segment += 1 if x > ground.x[segment] else -1
    w.sliding, w.slid_segment, w.landing = False, -1, segment
    above = z - height_of(ground, segment, x)
    if above <= -SLID_INTO * s.c.length:
        w.outcome, w.toe = FELL, True
    elif above <= 0.0:
        stub(s)


def release_foot(s: Walk, over_the_top: bool) -> None:
    """A foot that slides leaves the surface that no longer presses on it, or its face at the top."""
    w = s.w
    if over_the_top or w.press < 0.0:
        w.face = 0.0
    if w.press < 0.0:
        w.sliding = False
