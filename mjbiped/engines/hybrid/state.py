"""Constants and state of one walk in the hybrid engine, and positions of the robot's points.

Both are objects in plain Python, and blocks in C's memory for machine code (`mjbiped.numerics.blocks`): one source, and
one machine code, serve all robots and all laws.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mjbiped.disturbances.chance import Pushes
from mjbiped.dynamics.linkage import BASE, END, HIP, Linkage, Motion, point
from mjbiped.dynamics.modes import FLAT, LOCKED
from mjbiped.numerics.blocks import Block, Floats, Numbers, numbers, reader


@dataclass(slots=True)
class State(Motion):
    """The state of one walk."""

    # state of motion at the start of the current integration step: angles, rates, the controller's integrated states,
    # and the net work of each joint in this gait step
    y: Floats
    out: Floats  # state at the step's end
    spare: Floats  # a state in between
    k: list[list[float]]  # rates at the step's stages, one row for each
    dense: list[list[float]]  # coefficients of the step's dense output, one row for each power
    memory: Numbers  # the controller's
    q: Floats  # angles of the state whose rates are asked for, rad
    dq: Floats  # rates of these angles, rad/s
    told: Floats  # the angles that the law is told, rad: from the normal of the stance foot's sole, where that tips
    told_rates: Floats  # their rates, rad/s, as gyros tell them
    told_before: Floats  # the angles before a touchdown
    # what the law returns at each stage of the current step, of which the sole has let act what it can: the torques
    # of all joints, N m, then the rates of the law's states. The first are those in the state `y`
    given: list[list[float]]
    sampled: Floats  # the same in a state between the stages
    asked: Floats  # torque that the law asks of the ankle at each of these stages, N m
    normals: Floats  # normal force on the stance foot at each of them, N, where the ankle is bounded
    # on feet that are bodies, moment of the ground's force about the ankle at each of them, N m, as that of the
    # ankle's torque on a massless sole
    moments: Floats
    margins: Floats  # how much greater it could be without tipping the foot, N m; infinity where the foot has tipped
    peak_torque: Floats  # greatest magnitude of each joint's torque since the start, N m
    # greatest distance of the centre of pressure ahead of and behind the ankle in this gait step (m), then the time
    # that it has spent in each bin of `records.pressure` since the start (s)
    pressure: Floats
    posture: Floats  # room for a posture `qpos`
    strike_q: Floats  # angles at this gait step's knee strike, rad; NaN without one
    strike_dq: Floats  # rates just before it, rad/s
    struck_dq: Floats  # rates just after it, rad/s
    slope: float = 0.0  # slope of the ground under the stance foot, rad
    segment: int = 0  # terrain segment under the swing foot when last looked at, where the next search begins
    # position of the stance foot, m: of the centre of a round one when it came down; of one that is a body the ankle,
    # or the edge about which it turns
    foot_x: float = 0.0
    foot_z: float = 0.0  # its height, m
    foot_segment: int = 0  # terrain segment on which it stands
    next_tick: float = math.inf  # time of the controller's next tick, s; infinity where it does not tick
    next_push: float = math.inf  # when the current push ends, or the next one begins, s
    push_impulse: float = 0.0  # impulse of that push, N s
    next_step: float = 0.0  # length of the next integration step, s
    foot_angle: float = 0.0  # angle of the stance leg from the ground's normal then, rad
    clock: float = 0.0  # time of the last support transfer, s
    elapsed: float = 0.0  # time since then, s
    limit: float = 0.0  # time since then up to which the law is smooth, s
    # earliest time for which the law is asked, s: it lies on this side of the law's last discontinuity
    after: float = 0.0
    before: float = 0.0  # latest time for which it is asked, on this side of its next discontinuity
    time: float = 0.0  # time since the start of the walk, s
    stance: int = 0  # number of the stance leg: of a biped 0 left, 1 right
    contact_enabled: bool = False  # whether the swing foot collides with the ground
    locked: int = LOCKED  # `FREE`, `LOCKED` or `RESTING`: how the swing knee is
    # torque with which the stop bends a knee that rests on it, N m; below zero the knee leaves it
    stop_press: float = 0.0
    stance_flexion: float = 0.0  # flexion at which the stance knee is locked, rad
    flexion: float = 0.0  # greatest flexion of the swing knee in this gait step, rad
    strike_time: float = math.nan  # time of its knee strike since the support transfer, s; NaN without one
    edge: int = FLAT  # `FLAT`, `TOE` or `HEEL`: how a stance foot that is a body stands
    # `TOE` or `HEEL`: the edge of a landing foot that is a body on which it turns; `FLAT`: none is down
    down: int = FLAT
    down_since: float = 0.0  # time since the support transfer at which it came down, s
    slap: float = 0.0  # for how long the foot turned on that edge until it lay flat, s
    tipped: float = 0.0  # greatest angle by which it has tipped in this gait step, rad
    one_sided: float = 0.0  # time in it in which the foot stood on an edge, s
    stubs: int = 0  # how often the swing foot has struck the ground in it without coming to stand
    unmapped: bool = False  # whether the walk ended with a foot that came down and could not become the stance foot
    face: float = 0.0  # 1 while the swing foot slides on a vertical face ahead of it, -1 on one behind it, else 0
    # position of the face last struck, or beside which the foot stood before this gait step, m; NaN: none
    face_x: float = math.nan
    face_top: float = 0.0  # height of its upper edge, m
    face_segment: int = 0  # terrain segment on the foot's side of it
    face_impacts: int = 0  # 1 after an impact on a face in this gait step
    landing: int = 0  # terrain segment of the touchdown last found
    sliding: bool = False  # whether the swing foot slides on the ground, since it could not become the stance foot
    slid_segment: int = -1  # terrain segment on which it last slid in this gait step; -1: none
    pushed_x: float = 0.0  # direction in which a face or the ground pushes the swing foot, horizontal component
    pushed_z: float = 0.0  # vertical component
    press: float = 0.0  # contact force on the swing foot in that direction, N
    friction: float = 0.0  # greatest |F_t / F_n| of this gait step
    normal_force: float = math.inf  # least F_n of this gait step, N; below zero the ground would have to pull
    normal_now: float = 0.0  # F_n when last computed, N
    along_now: float = 0.0  # F_t when last computed, N
    # impulse of the ground along it on the stance foot in the impact that led to the state, N s
    impulse_along: float = 0.0
    impulse_normal: float = 0.0  # its component normal to the ground, N s
    work_absolute: float = 0.0  # absolute work of all joints since the start, J
    work_net: float = 0.0  # net work since the start, J
    work_positive: float = 0.0  # positive work since the start, J
    bound_time: float = 0.0  # time since the start in which the sole has not transmitted what was asked, s
    stage: int = 0  # stages of the current step at which the law has been evaluated
    has_dense: bool = False  # whether the dense output of the current step has been computed
    # length of the first integration step of a gait step; at most the last rejected one, s
    first_step: float = math.inf
    sample: int = 0  # number of the next sample
    samples: int = 0  # rows in the buffer of samples
    rows: int = 0  # rows in the buffer of touchdowns
    count: int = 0  # touchdowns since the start
    outcome: int = 0  # A `rules.termination.Outcome`
    push: float = 0.0  # force at the hip along x, N
    pushing: bool = False  # whether a push is under way, if only of no force
    pushes: int = 0  # number of pushes that have ended
    evaluations: float = 0.0  # evaluations of the law since the start
    pause: float = math.inf  # evaluation count at which the engine returns to Python
    under_way: bool = False  # whether it returned in the middle of a gait step
    step_started: float = 0.0  # evaluation count at the start of the gait step
    look: float = 0.0  # evaluation count at which the progress of the gait step is checked
    looked: float = 0.0  # time of the last check since the support transfer, s


class Constants(Block):
    """Robot, law, ground, rules and limits of a walk.

    Attributes:
        linkages: How the robot stands; see `robots.mechanism.linkages_of`.
        angles: Number of the angles of a state.
        joints: Number of joints.
        states: Number of the controller's integrated states.
        size: Components of a state of motion.
        judged: Components whose error counts.
        told: Number of the angles that a law is told.
        given: Floats of what the law writes: torques, rates of its states, and room for its intermediate results.
        thigh: Index of the angle of the segment above the swing knee.
        shank: Index of that below it; the same without a knee.
        foot: Index of the angle by which the stance foot tips; that of the swing foot follows; -1: feet cannot tip.
        upper: Length of a thigh, m.
        lower: Length of a shank, m.
        between: Angle between two legs that are one rigid body, rad.
        knee_opens: Whether the knee of the leg that leaves the ground is held by its stop alone in the impact.
        lands_bent: Whether a leg with a bent knee can become the stance leg.
        torque: The law's; see `controllers.Law`.
        touchdown: Its response to a support transfer.
        slope_estimate: Its estimate of the ground's slope.
        next_discontinuity: When its torque jumps next.
        tick: Its tick, where it ticks.
        knee_strike: Its response to a knee strike.
        parameters: What these take first.
        support: Index in the memory of how far behind and ahead of its ankle the ground bears a new stance foot, for
            laws that ask (`Controller.support`); -1: not told.
        segments: Number of the terrain's segments.
        x: Where they start, m.
        z: Heights there, m.
        gradient: dz/dx.
        angle: Slopes, rad.
        pushes: Pushes at the hip, alone in a list.
        row_buffer: Touchdowns, one row each, as `rows` has them.
        row_room: Number of rows.
        sample_buffer: Samples, one row each.
        sample_room: Number of rows.
        sample_width: Floats of a row.
        length: Length of a leg, m.
        behind: Distance from the ankle to the heel of a massless sole, m; infinity without one.
        ahead: Distance from the ankle to its toe, m.
        heel: Distance from the ankle to the heel of a foot that is a body, m; 0 without one.
        toe: Distance from the ankle to its toe, m.
        height: Height over the ground of the ankle of a foot that is a body, or of a round one's centre, m.
        foot_stiffness: Of the servo that holds a swing foot that is a body, N m/rad.
        foot_damping: Of that servo, N m s/rad.
        weight: Weight of the robot, N; NaN: the force of the ground is of no interest.
        legs: Number of legs, which stand in turn.
        contact: Whether the swing foot collides from the step's first moment on; if not, the scuffing rule decides.
        reach: Reach of the scuffing rule, m.
        delay: Its delay, s.
        stall_time: Longest time without touchdown, s.
        pace: Time unit of the robot, sqrt(l / g), s.
        end: Position x at which the ground ends, m.
        steps: Touchdowns after which the walk is finished.
        distance: Position x of the stance foot at which it is finished, m.
        tolerance: Tolerance of an integration step.
        longest_step: Longest integration step, s.
        sample_period: Time between two samples, s.
        control_period: Time between two ticks of a controller that ticks, s.
    """


TOGETHER = 1e-8
"""Feet that are so near to each other stand at one place, m."""

constants_at, state_at, pushes_at, _linkage_at = reader(Constants), reader(State), reader(Pushes), reader(Linkage)


def linkage_of(c: Constants, w: State) -> Linkage:
    """The robot as its stance foot stands, flat or on an edge, and with an edge of the swing foot down, or none."""
    return _linkage_at(c.linkages, (w.edge if w.edge >= 0 else 2) + 3 * (w.down if w.down >= 0 else 2))


def flat_linkage(c: Constants) -> Linkage:
    """The robot on a flat foot."""
    return _linkage_at(c.linkages, 0)


def to_memory(c: Constants, w: State, y: Numbers) -> None:
    """Write the controller's integrated states, as they are in a state of motion, into its memory."""
    memory, first = numbers(w.memory, c.states), 2 * c.angles
    for i in range(c.states):
        memory[i] = y[first + i]


def from_memory(c: Constants, w: State) -> None:
    """Take the controller's integrated states from its memory, after it has changed them."""
    y, memory, first = numbers(w.y, c.size), numbers(w.memory, c.states), 2 * c.angles
    for i in range(c.states):
        y[first + i] = memory[i]


def sole_angle(c: Constants, y: Numbers) -> float:
    """Angle by which the sole of the stance foot has tipped off the ground in a state, rad."""
    return float(y[c.foot]) if c.foot >= 0 else 0.0


def pivot(c: Constants, w: State, y: Numbers) -> tuple[float, float]:
    """Place x, z, m, from which the linkage stands: stance foot, centre of a round one's arc, or edge of a foot."""
    rolled = _linkage_at(c.linkages, 0).radius * (y[0] - w.foot_angle)
    return w.foot_x + rolled * w.cosine, w.foot_z - rolled * w.sine


def _place(c: Constants, w: State, y: Numbers, which: int) -> tuple[float, float]:
    along, normal = point(_linkage_at(c.linkages, 0), w, y, which)
    x, z = pivot(c, w, y)
    return x + along * w.cosine + normal * w.sine, z - along * w.sine + normal * w.cosine


def stance_foot(c: Constants, w: State, y: Numbers) -> tuple[float, float]:
    """Place x, z, m, of the stance foot: of a round one the centre of its arc, of one that is a body the ankle."""
    return pivot(c, w, y) if c.foot < 0 else _place(c, w, y, BASE)


def swing_foot(c: Constants, w: State, y: Numbers) -> tuple[float, float]:
    """Place x, z of the swing foot, m; of a round one the centre of its arc, of one that is a body the ankle."""
    return _place(c, w, y, END)


def touches(w: State) -> bool:
    """Whether a surface pushes the swing foot: a face, or the ground under the foot or one of its edges."""
    return bool(w.face != 0.0 or w.sliding or w.down != FLAT)


def pushed(w: State) -> tuple[float, float]:
    """Direction in which that surface pushes, along the stance foot's ground and normal to it."""
    return w.pushed_x * w.cosine - w.pushed_z * w.sine, w.pushed_x * w.sine + w.pushed_z * w.cosine


def hip(c: Constants, w: State, y: Numbers) -> tuple[float, float]:
    """Place x, z of the hip, m, at the end of the stance leg's line."""
    return _place(c, w, y, HIP)


def ahead_of_stance(c: Constants, w: State) -> float:
    """How far the swing foot is ahead of the stance foot, m; 0 where they stand together."""
    y = numbers(w.y, c.size)
    ahead = float(swing_foot(c, w, y)[0] - stance_foot(c, w, y)[0])
    return 0.0 if abs(ahead) < TOGETHER else ahead
