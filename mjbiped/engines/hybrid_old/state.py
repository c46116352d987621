"""What the hybrid engine works on: the state of one walk, its constants, and the functions that it calls.

State and constants are objects with named fields in plain Python, and NumPy records with the same fields where the
engine is compiled (`mjbiped.numerics.records.in_one_block`), so that one source serves both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from mjbiped.disturbances.pushes import Pushes
from mjbiped.robots.bent_leg import LENGTH
from mjbiped.robots.equations import FLAT, LOCKED


@dataclass(slots=True)
class State:
    """The state of one walk; sequences are lists in plain Python, and arrays where compiled.

    Attributes:
        y: State of motion at the start of the current integration step: angles, rates, the controller's integrated
            states, and the net work of each joint in this gait step.
        out: State at the step's end.
        spare: A state in between.
        ddq: Accelerations within the step, rad/s^2.
        k: Rates at the step's stages.
        dense: Coefficients of the step's dense output.
        memory: The controller's.
        torques: Torques of all joints at each stage of the current step, N m; the first are those in the state `y`.
        asked: On a sole, torque that the law asks of the ankle at each of these stages, N m.
        normals: On a sole, normal force on the stance foot at each of them, N.
        moments: On feet that are bodies, moment of the ground's force about the ankle at each of them, N m, as that of
            the ankle's torque on a massless sole.
        margins: How much greater it could be without tipping the foot, N m; infinity where the foot has tipped.
        bound_time: Time since the start in which the sole has not transmitted what was asked, s.
        peak_torque: Greatest magnitude of each joint's torque since the start, N m.
        pressure: Greatest distance of the centre of pressure ahead of and behind the ankle in this gait step (m), then
            the time that it has spent in each bin of `records.pressure` since the start (s).
        strike_q: Angles at this gait step's knee strike, rad; NaN without one.
        strike_dq: Rates just before it, rad/s.
        struck_dq: Rates just after it, rad/s.
        slope: Slope of the ground under the stance foot, rad.
        sine: Its sine.
        cosine: Its cosine.
        segment: Terrain segment under the swing foot when last looked at, where the next search begins.
        foot_x: Position of the stance foot, m: of the centre of a round one when it came down; of one that is a body
            the ankle, or the edge about which it turns.
        foot_z: Its height, m.
        foot_angle: Angle of the stance leg from the ground's normal then, rad.
        foot_segment: Terrain segment on which it stands.
        next_tick: Time of the controller's next tick, s; infinity where it does not tick.
        next_push: When the current push ends, or the next one begins, s.
        push_impulse: Impulse of that push, N s.
        next_step: Length of the next integration step, s.
        clock: Time of the last support transfer, s.
        elapsed: Time since then, s.
        limit: Time since then up to which the law is smooth, s.
        after: Earliest time for which the law is asked, s: it lies on this side of the law's last discontinuity.
        before: Latest time for which it is asked, on this side of its next discontinuity.
        time: Time since the start of the walk, s.
        stance: Number of the stance leg: of a biped 0 left, 1 right.
        contact_enabled: Whether the swing foot collides with the ground.
        locked: `FREE`, `LOCKED` or `RESTING`: how the swing knee is.
        stop_press: Acceleration with which a resting knee would bend forwards without its stop, rad/s^2.
        stance_flexion: Flexion at which the stance knee is locked, rad.
        flexion: Greatest flexion of the swing knee in this gait step, rad.
        strike_time: Time of its knee strike since the support transfer, s; NaN without one.
        edge: `FLAT`, `TOE` or `HEEL`: how a stance foot that is a body stands.
        swing_sole: Angle of the swing foot's sole from the stance foot's, rad: not zero in the posture of a touchdown.
        tipped: Greatest angle by which it has tipped in this gait step, rad.
        one_sided: Time in it in which the foot stood on an edge, s.
        stubs: How often the swing foot has struck the ground in it without coming to stand.
        toe: Whether the walk ended with a foot that came down and could not become the stance foot.
        face: 1 while the swing foot slides on a vertical face ahead of it, -1 on one behind it, else 0.
        face_x: Position of the face last struck, or beside which the foot stood before this gait step, m; NaN: none.
        face_top: Height of its upper edge, m.
        face_segment: Terrain segment on the foot's side of it.
        face_impacts: 1 after an impact on a face in this gait step.
        landing: Terrain segment of the touchdown last found.
        sliding: Whether the swing foot slides on the ground, since it could not become the stance foot.
        slid_segment: Terrain segment on which it last slid in this gait step; -1: none.
        pushed_x: Direction in which a face or the ground pushes the swing foot, horizontal component.
        pushed_z: Vertical component.
        press: Contact force on the swing foot in that direction, N.
        friction: Greatest |F_t / F_n| of this gait step.
        normal_force: Least F_n of this gait step, N; below zero the ground would have to pull.
        normal_now: F_n when last computed, N.
        along_now: F_t when last computed, N.
        impulse_x: Impulse of the ground on the stance foot in the impact that led to the state, N s.
        impulse_z: Its vertical component, N s.
        work_absolute: Absolute work of all joints since the start, J.
        work_net: Net work since the start, J.
        work_positive: Positive work since the start, J.
        stage: Stages of the current step at which the law has been evaluated.
        has_dense: Whether the dense output of the current step has been computed.
        first_step: Length of the first integration step of a gait step; at most the last rejected one, s.
        sample: Number of the next sample.
        samples: Rows in the buffer of samples.
        rows: Rows in the buffer of touchdowns.
        count: Touchdowns since the start.
        outcome: A `rules.termination.Outcome`.
        push: Force at the hip along x, N.
        pushing: Whether a push is under way, if only of no force.
        pushes: Number of pushes that have ended.
        evaluations: Evaluations of the law since the start.
        pause: Evaluation count at which the engine returns to Python.
        under_way: Whether it returned in the middle of a gait step.
        step_started: Evaluation count at the start of the gait step.
        look: Evaluation count at which the progress of the gait step is checked.
        looked: Time of the last check since the support transfer, s.
    """

    y: Any
    out: Any
    spare: Any
    ddq: Any
    k: Any
    dense: Any
    memory: Any
    torques: Any
    asked: Any
    normals: Any
    moments: Any
    margins: Any
    peak_torque: Any
    pressure: Any
    strike_q: Any
    strike_dq: Any
    struck_dq: Any
    slope: float
    sine: float
    cosine: float
    segment: int
    foot_x: float
    foot_z: float
    foot_segment: int
    next_tick: float
    next_push: float
    push_impulse: float
    next_step: float
    foot_angle: float = 0.0
    clock: float = 0.0
    elapsed: float = 0.0
    limit: float = 0.0
    after: float = 0.0
    before: float = 0.0
    time: float = 0.0
    stance: int = 0
    contact_enabled: bool = False
    locked: int = LOCKED
    stop_press: float = 0.0
    stance_flexion: float = 0.0
    flexion: float = 0.0
    strike_time: float = math.nan
    edge: int = FLAT
    swing_sole: float = 0.0
    tipped: float = 0.0
    one_sided: float = 0.0
    stubs: int = 0
    toe: bool = False
    face: float = 0.0
    face_x: float = math.nan
    face_top: float = 0.0
    face_segment: int = 0
    face_impacts: int = 0
    landing: int = 0
    sliding: bool = False
    slid_segment: int = -1
    pushed_x: float = 0.0
    pushed_z: float = 0.0
    press: float = 0.0
    friction: float = 0.0
    normal_force: float = math.inf
    normal_now: float = 0.0
    along_now: float = 0.0
    impulse_x: float = 0.0
    impulse_z: float = 0.0
    work_absolute: float = 0.0
    work_net: float = 0.0
    work_positive: float = 0.0
    bound_time: float = 0.0
    stage: int = 0
    has_dense: bool = False
    first_step: float = math.inf
    sample: int = 0
    samples: int = 0
    rows: int = 0
    count: int = 0
    outcome: int = 0
    push: float = 0.0
    pushing: bool = False
    pushes: int = 0
    evaluations: float = 0.0
    pause: float = math.inf
    under_way: bool = False
    step_started: float = 0.0
    look: float = 0.0
    looked: float = 0.0


class Ground(NamedTuple):
    """The terrain's segments; see `mjbiped.Terrain`.

    Attributes:
        x: Where they start, m.
        z: Heights there, m.
        gradient: dz/dx.
        angle: Slopes, rad.
    """

    x: Any
    z: Any
    gradient: Any
    angle: Any


class Tables(NamedTuple):
    """Arrays whose length is another in each walk.

    Attributes:
        ground: The terrain.
        pushes: Pushes at the hip.
        rows: Buffer of touchdowns, one row each, in the order of the robot's `columns.tables_of`.
        samples: Buffer of samples: the robot's columns, then the controller's states.
    """

    ground: Ground
    pushes: Pushes
    rows: Any
    samples: Any


@dataclass(slots=True)
class Constants:
    """Robot, rules and limits of a walk.

    Attributes:
        robot: The robot's constants, as its `Equations` take them.
        tables: Address of the walk's `Tables` where compiled, from which `Laws.tables` makes them.
        length: Length of a leg, m.
        radius: Of round feet, m; 0: the foot is a point.
        behind: Distance from the ankle to the heel of a massless sole, m; infinity without one.
        ahead: Distance from the ankle to its toe, m.
        heel: Distance from the ankle to the heel of a foot that is a body, m; 0 without one.
        toe: Distance from the ankle to its toe, m.
        support: Index in the memory of how far behind and ahead of its ankle the ground bears a new stance foot, for
            laws that ask (`Controller.support`); -1: not told.
        height: Height over the ground of the ankle of a foot that is a body, or of a round one's centre, m.
        mass: Mass of the robot, kg; NaN: the force of the ground is of no interest.
        gravity: m/s^2.
        legs: Number of legs, which stand in turn.
        contact: Whether the swing foot collides from the step's first moment on; if not, the scuffing rule decides.
        reach: Reach of the scuffing rule, m.
        delay: Its delay, s.
        stall_time: Longest time without touchdown, s.
        end: Position x at which the ground ends, m.
        steps: Touchdowns after which the walk is finished.
        distance: Position x of the stance foot at which it is finished, m.
        tolerance: Tolerance of an integration step.
        tested: Number of components over which the mean error of a step is taken: angles, rates, and the states that
            the controller itself has.
        longest_step: Longest integration step, s.
        sample_period: Time between two samples, s.
        control_period: Time between two ticks of a controller that ticks, s.
    """

    robot: Any
    tables: int
    length: float
    radius: float
    behind: float
    ahead: float
    heel: float
    toe: float
    support: int
    height: float
    mass: float
    gravity: float
    legs: int
    contact: bool
    reach: float
    delay: float
    stall_time: float
    end: float
    steps: float
    distance: float
    tolerance: float
    tested: float
    longest_step: float
    sample_period: float
    control_period: float


class Laws(NamedTuple):
    """The functions of a walk.

    Attributes:
        torque: The controller's; see `controllers.Law`.
        touchdown: Its response to a support transfer.
        slope_estimate: Its estimate of the ground's slope.
        next_discontinuity: When its torque jumps next.
        tick: Its tick, where it ticks.
        knee_strike: Its response to a knee strike.
        tables: The walk's `Tables`, of `Constants.tables`.
        begin: See `dormand_prince.Integrator`.
        step: One integration step.
        dense: Its dense output.
        q: Angles of a state; see `mjbiped.engines.hybrid.tuples`.
        dq: Rates of a state.
        own: Rates of the controller's states, of what its law returns.
        with_ankle: What a law returns, with another torque of the ankle.
        still: As many zeros as there are angles.
        powers: Powers of the joints.
        pose: Sines and cosines of the angles from the vertical.
        told: Angles that the law is told.
        told_rates: Their rates.
        sole_slope: Slope of the stance foot's sole.
        reached: The point with given levers in a pose.
        accelerations: The robot's; see `mjbiped.robots.equations.Equations`.
        stop_foot: Reset map of an impact of the swing foot without support transfer.
        lands: Whether the swing foot that has come down becomes the stance foot.
        exchange: Reset map of the support transfer.
        lock_knee: Reset map of the knee strike.
        limbs: Angles of the posture in a record.
        ground_force: Force on the feet.
        turn_foot: Lets the stance foot turn about an edge, or come down.
        write_sample: See `mjbiped.records.rows.Rows`.
        write_touchdown: Writes the row of a touchdown.
    """

    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    knee_strike: Any
    tables: Any
    begin: Any
    step: Any
    dense: Any
    q: Any
    dq: Any
    own: Any
    with_ankle: Any
    still: Any
    powers: Any
    pose: Any
    told: Any
    told_rates: Any
    sole_slope: Any
    reached: Any
    accelerations: Any
    stop_foot: Any
    lands: Any
    exchange: Any
    lock_knee: Any
    limbs: Any
    ground_force: Any
    turn_foot: Any
    write_sample: Any
    write_touchdown: Any


class Walk(NamedTuple):
    """All that the engine's functions take: functions, parameters, constants and state of one walk.

    Attributes:
        laws: The functions.
        law: What the controller's functions take as their parameters.
        c: Robot, rules and limits.
        w: The state.
    """

    laws: Laws
    law: Any
    c: Any
    w: Any


def ground_of(s: Walk) -> Ground:
    """The terrain."""
    ground: Ground = s.laws.tables(s.c.tables).ground
    return ground


def hand_over(s: Walk, state: Any) -> None:
    """Write the controller's integrated states, as they are in a state of motion, into its memory."""
    w = s.w
    first = 2 * len(w.strike_q)
    for index in range(len(w.y) - first - len(w.peak_torque)):
        w.memory[index] = state[first + index]


def take_back(s: Walk) -> None:
    """Take the controller's integrated states from its memory, after it has changed them."""
    w = s.w
    first = 2 * len(w.strike_q)
    for index in range(len(w.y) - first - len(w.peak_torque)):
        w.y[first + index] = w.memory[index]


def pose_of(s: Walk, state: Any) -> tuple[float, ...]:
    """Sine and cosine of each angle from the vertical in a state, and at last the stance leg's angle, rad."""
    pose: tuple[float, ...] = s.laws.pose(s.laws.q(state), s.w.slope)
    return pose


def pivot(s: Walk, pose: tuple[float, ...]) -> tuple[float, float]:
    """Place x, z, m, from which levers count: stance foot, centre of a round one's arc, or edge of a foot."""
    w = s.w
    if s.c.radius == 0.0:
        return w.foot_x, w.foot_z
    rolled = s.c.radius * (pose[-1] - w.foot_angle)
    return w.foot_x + rolled * w.cosine, w.foot_z - rolled * w.sine


def stance_foot(s: Walk, pose: tuple[float, ...]) -> tuple[float, float]:
    """Place x, z, m, of the stance foot: of a round one the centre of its arc, of one that is a body the ankle."""
    x, z = pivot(s, pose)
    if s.w.edge == FLAT:
        return x, z
    along, beside, sine, cosine = s.c.robot.chain.reach[-1], s.c.robot.chain.beside[-1], pose[-3], pose[-2]
    return x + along * sine + beside * cosine, z + along * cosine - beside * sine


def swing_foot(s: Walk, pose: tuple[float, ...]) -> tuple[float, float]:
    """Place x, z of the swing foot, m; of a round one the centre of its arc, of one that is a body the ankle."""
    chain, (foot_x, foot_z) = s.c.robot.chain, pivot(s, pose)
    x, z = s.laws.reached(chain.reach, chain.beside, pose)
    return foot_x + x, foot_z + z


def hip(s: Walk, pose: tuple[float, ...]) -> tuple[float, float]:
    """Place x, z of the hip, m, at the end of the stance leg's line."""
    length, (foot_x, foot_z) = s.c.robot.stance[LENGTH], stance_foot(s, pose)
    return foot_x + length * pose[0], foot_z + length * pose[1]
