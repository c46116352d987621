"""What a walk in MuJoCo works on: its state, which lasts from step to step, and its constants.

`State` stands at the beginning of `mjData.userdata`, so that a walk can be copied, saved and resumed with MuJoCo's own
state functions. Behind it stand the last touchdown's row, the controller's memory, and the rates of its integrated
states. One source works on all of it in plain Python and as machine code, bit by bit the same
(`mjbiped.numerics.blocks`).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass
from typing import Any

from mjbiped.disturbances.pushes import Pushes
from mjbiped.numerics.blocks import Floats, reader
from mjbiped.records.pressure import BINS

COORDINATES = 6
"""Room for as many coordinates of a robot: hip x and z, and the angles of its legs' joints."""
ANGLES = 3
"""Room for as many angles, and joints with motors."""

X, Z = 0, 1

MARK = 7.385102934e-305
"""What tells the userdata of a walk from those of somebody else's model."""


class State(ctypes.Structure):
    """What is remembered from one physics step to the next: plain numbers, zeros before a walk begins.

    A field of coordinates is in the order of `qpos`, one of angles in the order of `Robot.angles`, or of
    `Robot.joints` where it is of torques.
    """

    mark: float  # `MARK`; 0 in zeroed userdata, where nothing acts
    walk: float  # address or number of the walk's `Constants`; see `callback`
    time: float  # of the last observation, s
    asked: float  # time of the last control callback, s
    planned: float  # length of the physics step from the observation on that its contacts are made for, s
    planned_next: float  # length of the step after it, s
    plain: float  # 1: the effective step is as long as the step itself
    plain_next: float  # whether that of the step after it is
    effective_step: float  # time for which the accelerations act in the step, s
    last_step: float  # length of the step before, s; 0 just after an impact
    smooth: float  # 1: the accelerations of the step before are those of a motion without an impact
    smooth_next: float  # whether those of this step are
    stance: float  # number of the leg that stands: the remainder of `count` by the number of legs
    transfer_time: float  # of the last support transfer, s
    next_control: float  # when the controller ticks next, s
    ticked: float  # when it ticked last, s
    next_sample: float  # when a sample is due, s
    samples: float  # number that waits to be taken from the recording
    rows: float  # number of touchdowns that waits there
    transferred: float  # 1: there was a support transfer that the controller does not know of yet
    enabled: float  # 1: the swing foot may collide, by the scuffing rule
    collides: float  # 1: it does in this step
    slope: float  # of the ground under the stance foot, rad
    old_slope: float  # that at the observation before
    foot_x: float  # stance foot at the support transfer, m
    foot_z: float
    foot_angle: float  # what stands on it at the support transfer, from the vertical, rad
    noted: float  # 1: a touchdown was resolved in the last step
    work_absolute: float  # since the start, J
    work_net: float
    work_positive: float
    bound_time: float  # in which the sole did not transmit the ankle torque asked for, since the start, s
    ankle: float  # torque that the law asks of the ankle, held, N m
    turns: float  # 1: motors have turned the joints since the observation before
    slip: float  # greatest distance that the stance foot slid along the ground in this gait step, m
    slides: float  # gait steps in which it slid farther than a standing foot does
    penetration: float  # greatest depth of a foot in this gait step, m
    friction: float  # greatest |F_t| / F_n in this gait step, of those that last
    ratio: float  # |F_t| / F_n in the physics step last resolved
    least_ratio: float  # least of those since a ratio was last taken
    ratio_time: float  # how long that is ago, s
    force: float  # normal force of the stance foot in the physics step last resolved, N
    impulse: float  # of that force since the last stretch ended over which it is averaged, N s
    stretch: float  # how long that is ago, s
    pressing: float  # normal forces of all contacts of both feet in the physics step last resolved, N
    load: float  # impulse of these since a stretch ended over which they are averaged, N s
    load_time: float  # how long that is ago, s
    contact_force: float  # greatest average of these in this gait step, N
    squeezes: float  # gait steps in which that was more than any motion asks for
    without_contact: float  # how long the stance foot has had none, s
    normal_force: float  # least average in this gait step, N
    ankle_impulse: float  # of the ankle's torque over the same stretch, N m s
    face_impacts: float  # 1: the swing foot struck a vertical face in this gait step
    next_push: float  # when the next push begins, or the present one has begun, s
    push_impulse: float  # of it, N s
    pushes: float  # number that has ended
    pushing: float  # 1: a push is under way
    push_left: float  # what is left of its impulse, N s
    push: float  # its force at the hip along x, N
    count: float  # touchdowns so far
    outcome: float
    over: float  # 1: the outcome was known at the last control callback
    # what a knee needs
    locked: float  # 1: the swing knee is, against its stop
    opened: float  # 1: it has been bent in this gait step
    strikes: float  # 1: it strikes its stop in the step under way
    softened: float  # 1: it is locked for that by what `step_size.soften` has written last
    acted: float  # 1: by what that has written before
    strikes_next: float  # 1: it does in the step after it
    struck: float  # 1: it did in the step last resolved
    strike_untold: float  # 1: the controller does not know of the strike yet
    strike_time: float  # of the knee strike, from the support transfer on, s; NaN: there was none
    flexion: float  # greatest in this gait step, rad
    lifted: float  # leg whose foot passes through the ground, as it leaves it in this step; -1: none
    clear: float  # height of the swing foot over the ground, m
    touching: float  # 1: the swing foot has not left the ground since it last touched it
    stubs: float  # in this gait step
    bent: float  # 1: the swing knee is locked as it is, for a touchdown in this step
    bend: float  # flexion at which it is, rad
    rest: float  # flexion at which the stance knee is locked, or held by its servo, rad
    tilt: float  # of the line from stance foot to hip, from the stance thigh, rad: 0 where that knee is straight
    old_tilt: float  # that at the observation before
    share: float  # of the stance knee's rate in the rate of that line, beside the thigh's: 0 where the knee is locked
    old_share: float
    reach: float  # length of that line, m
    hold: float  # torque of the servo at the stance knee, N m
    peak_hold: float  # greatest in this gait step, N m
    work_hold: float  # its absolute work since the start, J
    # what a foot that turns about an ankle needs
    stood: float  # angle of the stance foot when it came to stand, rad
    level: float  # what the feet take the ground's slope to be, rad
    flat: float  # 1: the ground bore the stance foot on both sides of the ankle in the step last resolved
    tipped: float  # greatest angle by which the stance foot has tipped in this gait step, rad
    one_sided: float  # time in this gait step in which the stance foot was borne on one side alone, or not at all, s
    touched: float  # when the swing foot touched the ground first, s; NaN: it is in the air
    down: float  # when it touched it last, s
    support_behind: float  # how far behind its ankle the ground bore the stance foot when it came to stand, m
    support_ahead: float  # how far ahead of it
    intrusion: float  # how high the ground stood over the line from its heel to its toe, m
    intrusions: float  # number of footholds where that was more than `observation.INTRUDES`
    moment: float  # of the stance foot's contacts about the ankle, as an ankle's torque, N m, in the step last resolved
    shear: float  # friction force of the stance foot in the step last resolved, N
    shear_impulse: float  # of it since the last stretch ended over which forces are averaged, N s
    foot_torque: float  # that holds the swing foot, N m

    q: Coordinates  # qpos at the last observation
    rates: Coordinates  # their rates then
    old_q: Coordinates  # qpos at the observation before
    old_rates: Coordinates
    rates_before: Coordinates  # rates when the swing foot was last not about to stand flat
    qvel: Coordinates  # `mjData.qvel` then, which shows the velocity stage other rates
    qacc: Coordinates  # accelerations in the step last resolved
    acceleration: Coordinates  # those of the step before it, where `smooth` says so
    lag: Coordinates  # what `qvel` lacks to be the rates of the observation's time; see `leapfrog`
    lag_next: Coordinates  # what it will lack after this step
    angles: Angles  # from the normal of the ground under the stance foot, rad
    turning: Angles  # their rates, rad/s
    torque: Angles  # held, N m
    peak: Angles  # greatest magnitudes since the start, N m
    told_before: Angles  # angles at the touchdown, in the roles of the gait step that ended, rad
    told_q: Angles  # those in the new roles
    told_dq: Angles  # their rates just after it, rad/s
    strike_q: Angles  # angles just before the knee strike, rad
    strike_rates: Angles  # their rates, rad/s
    struck_q: Angles  # angles just after it, rad
    struck_rates: Angles  # their rates, rad/s
    pressure: Pressure  # greatest distances of the centre of pressure ahead of the ankle and behind it, m, then times
    """Times by places of the centre of pressure, s; see `records.pressure`."""


_KINDS: dict[str, Any] = {
    "float": ctypes.c_double,
    "Coordinates": ctypes.c_double * COORDINATES,
    "Angles": ctypes.c_double * ANGLES,
    "Pressure": ctypes.c_double * (2 + BINS),
}
State._fields_ = [(name, _KINDS[kind]) for name, kind in State.__annotations__.items()]

SIZE = ctypes.sizeof(State) // ctypes.sizeof(ctypes.c_double)
"""Floats of `State`."""

Coordinates = MutableSequence[float]
Angles = MutableSequence[float]
Pressure = MutableSequence[float]


@dataclass(slots=True)
class Leg:
    """A leg: a chain of one segment or two that hangs at the hip, with a foot at its end.

    Attributes:
        hip: Index in qpos of the hinge that turns its upper segment.
        offset: Angle of its upper segment from the vertical where that of the hinge is zero, rad.
        lap: What is added to that with each round in which all legs have stood, rad.
        upper: Length of its upper segment, m.
        foot: Geom.
        contacts: Index in the sensor data where the foot's contacts begin.
        ankle: Actuator.
        knee: Index in qpos of its knee's flexion; -1: it is straight, and has none.
        lower: Length of its lower segment, m.
        motor: Actuator of the knee.
        stop: Joint of the knee, which has a limit.
        lock: Equality constraint of the knee.
        sole: Index in qpos of the ankle of a foot that turns about it; -1: the leg ends in a point or an arc.
        toe: Geom of that foot beside `foot`; -1: there is one alone.
        height: Of the ankle over the sole, m.
        behind: From below the ankle to the heel, m.
        ahead: From below the ankle to the toe, m.
        turn: Angle of its upper segment's line where those of its joints are zero, rad.
        bend: That of its lower segment's line.
        reach: From its foot to the hip, while its knee is at its stop, m.
    """

    hip: int
    offset: float
    lap: float
    upper: float
    foot: int
    contacts: int
    ankle: int
    knee: int = -1
    lower: float = 0.0
    motor: int = -1
    stop: int = -1
    lock: int = -1
    sole: int = -1
    toe: int = -1
    height: float = 0.0
    behind: float = 0.0
    ahead: float = 0.0
    turn: float = 0.0
    bend: float = 0.0
    reach: float = 0.0


@dataclass(slots=True)
class Constants:
    """What does not change in a walk while its scene is the same, and where things are.

    Attributes:
        data: Address of the mjData.
        state: The walk's `State`, alone in a list.
        whole: The state and the row in one.
        row: Of the last touchdown, in the order of the record's columns; behind the state in userdata.
        memory: The controller's memory, behind that.
        rates: Of its integrated states, held between ticks, behind that.
        time: `mjData.time`.
        timestep: `mjModel.opt.timestep`.
        warnings: Kind and number of each of MuJoCo's warnings in turn.
        qpos: See MuJoCo for this and all that follow.
        qvel: See there.
        qacc: See there.
        ctrl: See there.
        applied: Forces at the degrees of freedom; that at hip x is a push's, N.
        readings: Data of all sensors.
        contype: Contact bits of geoms.
        conaffinity: The same.
        geom_solref: Softness of contacts, two numbers a geom.
        jnt_solref: Softness of the joints' limits, two numbers a joint.
        eq_solref: Softness of equality constraints, two numbers each.
        eq_data: `EQ_DATA` numbers of each, the flexion first at which a lock holds.
        eq_active: Whether each is switched on.

        legs: The robot's legs, in the order in which they stand.
        leg_count: Their number.
        order: For each of the robot's `places` its index in qpos.
        coordinates: Number of these.
        angles: Number of the robot's angles, and of its joints with motors.
        hip: Actuator between the legs; -1: there is none.
        slots: Floats of one foot's contacts in the sensor data.
        sensed: Floats of all sensor data.
        actuators: Number of actuators.
        geoms: Number of geoms.
        joints: Number of joints.
        locks: Number of equality constraints.
        x: Starts of the ground's segments, m; with the three that follow it is a `terrain.profile.Profile`.
        z: Heights there, m.
        gradient: dz/dx.
        segments: Number of segments, as far as the ground was built.
        rises: Steps up at the starts of segments, m.
        pieces: For each segment the geom that is its ground.
        firsts: For each segment the first one that shares its geom.
        lasts: The last one.
        risers: For each segment the geom that is the riser at its start; -1: there is none.
        sills: For each segment the geom of the lower ground behind that riser; -1: there is none.
        marked: Number of geoms of the ground whose contact bits are set, then these geoms.

        leg_length: Of a leg, m.
        lowest_hip: Height of the hip over the ground below which the robot has fallen, m.
        foot_radius: Of the sphere that stands on the ground, m.
        rolling_radius: On which a standing foot rolls, m: 0 where the sphere's centre is held.
        weight: Of the robot, N.
        reach: Distance of the scuffing rule, m.
        delay: Time of the scuffing rule, s.
        stall_time: Longest time without touchdown, s.
        averaged: Least time over which the stance foot's normal force is averaged, s.
        airborne: Time without contact after which a stance foot is off the ground, s.
        sustained: Time for which friction must be asked for to count, s.
        start: Where the ground begins, x in m.
        end: Where it ends, x in m.
        steps: Touchdowns after which the walk is finished.
        distance: Position of the stance foot at which it is finished, x in m.
        scuffs: Whether the scuffing rule says when the swing foot collides; else it always does.
        stepped: Whether there are steps in the ground.
        deepest: No foot is deeper in the ground than this in the first step of a contact, m.
        longest: Longest physics step, s.
        shortest: Length of the step that makes an impact, s.
        sliding: Length of the steps in which the swing foot slides on a riser's face, s: no longer step is made there.
        lands: Whether steps end at impacts; else they all are of one length, and MuJoCo's own.
        radius: Of round feet, m; 0: point feet.
        feet: Whether feet turn about ankles.
        box: Whether these stand on all of their soles.
        behind: Distance from the ankle to the heel of a massless sole, m; infinity without one.
        ahead: Distance from the ankle to its toe, m.
        knee_opens: Whether the stop alone holds the knee of the leg that leaves the ground; see `Robot.knee_opens`.
        knee_stiffness: Of the servo at the stance knee, N m/rad; 0: there is none, and the stance knee is locked.
        knee_damping: N m s/rad.
        foot_stiffness: Of the servo of the swing foot, N m/rad.
        foot_damping: N m s/rad.

        parameters: Of the controller's law; see `mjbiped.control.controller.Law` for this and all that follow.
        torque: See there.
        touchdown: See there.
        slope_estimate: See there.
        next_discontinuity: Not called here.
        tick: See there.
        knee_strike: See there.
        failed: A float that is not zero once a law has raised an exception.
        room: `motors.SPARE` floats and more, into which `torque` writes.
        control_period: Time between two ticks of the controller, s; 0: it ticks at every physics step.
        memory_size: Floats of the controller's memory.
        states: Number of its integrated states.
        sampled: Whether its law has a tick.
        support: See `Controller.support`.
        pushes: Pushes at the hip, alone in a list; see `disturbances.pushes.Pushes`.

        sample_period: Time between two samples, s; each is taken at the first physics step from then on.
        samples: Rows of samples, one behind the other, which whoever takes them counts in `State.samples`.
        rows: Rows of touchdowns, the same.
        sample_room: Number of rows of samples that there is room for; more are not written.
        row_room: Number of rows of touchdowns.
        sample_width: Floats of a sample; the controller's integrated states stand at its end.
        row_width: Floats of a touchdown.
        estimate_at: Index in a touchdown of the slope estimate before its update; that after it follows.
    """

    data: int
    state: Any
    whole: Floats
    row: Floats
    memory: Floats
    rates: Floats
    time: Floats
    timestep: Floats
    warnings: Any
    qpos: Floats
    qvel: Floats
    qacc: Floats
    ctrl: Floats
    applied: Floats
    readings: Floats
    contype: Any
    conaffinity: Any
    geom_solref: Floats
    jnt_solref: Floats
    eq_solref: Floats
    eq_data: Floats
    eq_active: Any
    legs: Sequence[Leg]
    leg_count: int
    order: Floats
    coordinates: int
    angles: int
    hip: int
    slots: int
    sensed: int
    actuators: int
    geoms: int
    joints: int
    locks: int
    x: Floats
    z: Floats
    gradient: Floats
    segments: int
    rises: Floats
    pieces: Floats
    firsts: Floats
    lasts: Floats
    risers: Floats
    sills: Floats
    marked: Floats
    leg_length: float
    lowest_hip: float
    foot_radius: float
    rolling_radius: float
    weight: float
    reach: float
    delay: float
    stall_time: float
    averaged: float
    airborne: float
    sustained: float
    start: float
    end: float
    steps: float
    distance: float
    scuffs: bool
    stepped: bool
    deepest: float
    longest: float
    shortest: float
    sliding: float
    lands: bool
    radius: float
    feet: bool
    box: bool
    behind: float
    ahead: float
    knee_opens: bool
    knee_stiffness: float
    knee_damping: float
    foot_stiffness: float
    foot_damping: float
    parameters: Any
    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    knee_strike: Any
    failed: Floats
    room: Floats
    control_period: float
    memory_size: int
    states: int
    sampled: bool
    support: int
    pushes: Sequence[Pushes]
    sample_period: float
    samples: Floats
    rows: Floats
    sample_room: int
    row_room: int
    sample_width: int
    row_width: int
    estimate_at: int


leg_at = reader(Leg)
state_at = reader(State)
constants_at = reader(Constants)
pushes_at = reader(Pushes)


def stance_leg(c: Any, u: Any) -> Any:
    """The leg that stands."""
    return leg_at(c.legs, int(u.stance))


def swing_index(c: Any, u: Any) -> int:
    """Number of the leg that stands next."""
    return int((int(u.stance) + 1) % c.leg_count)


def swing_leg(c: Any, u: Any) -> Any:
    """The leg that stands next."""
    return leg_at(c.legs, swing_index(c, u))


def foot_of(leg: Leg, q: Any) -> tuple[float, float]:
    """Place of a leg's foot, x and z in m, by the robot's coordinates: of one with a sole, of that below the ankle."""
    x, z = end_of_leg(leg, q[X], q[Z], q[leg.hip], q[leg.knee] if leg.knee >= 0 else 0.0)
    if leg.sole < 0:
        return x, z
    angle = q[leg.hip] + leg.offset + q[leg.sole]
    return x - leg.height * math.sin(angle), z - leg.height * math.cos(angle)


def end_of_leg(leg: Leg, x: float, z: float, angle: float, flexion: float) -> tuple[float, float]:
    """Place of a leg's end, x and z in m, by the hip's, the hinge's angle and the knee's flexion in rad."""
    angle += leg.offset
    upper = angle + leg.turn
    x, z = x - leg.upper * math.sin(upper), z - leg.upper * math.cos(upper)
    if leg.knee < 0:
        return x, z
    lower = angle + flexion + leg.bend
    return x - leg.lower * math.sin(lower), z - leg.lower * math.cos(lower)


def angles_of(c: Any, q: Any, count: int, tilt: float, slope: float) -> tuple[float, float, float]:
    """Stance leg, swing thigh and swing shank from a slope's normal, rad; a straight leg is thigh and shank in one.

    A stance leg whose knee is bent has the angle of the line from its foot to the hip.

    Args:
        c: The walk's constants.
        q: The robot's coordinates.
        count: Touchdowns so far, which tell the legs' roles.
        tilt: Of the line from stance foot to hip, from the stance thigh, rad.
        slope: Of the ground, rad.
    """
    swinging = leg_at(c.legs, (count + 1) % c.leg_count)
    thigh = upper_angle(c, q, count + 1)
    shank = thigh + q[swinging.knee] if swinging.knee >= 0 else thigh
    return upper_angle(c, q, count) + tilt - slope, thigh - slope, shank - slope


def upper_angle(c: Any, q: Any, count: int) -> float:
    """Angle from the vertical of the upper segment of the leg that stands after so many touchdowns, rad."""
    leg, laps = leg_at(c.legs, count % c.leg_count), count // c.leg_count
    return float(q[leg.hip] + (leg.offset + laps * leg.lap))


def rates_of(c: Any, rates: Any, stance: int, share: float) -> tuple[float, float, float]:
    """Rates of these angles, rad/s; `share` is that of the stance knee's rate."""
    standing, swinging = leg_at(c.legs, stance), leg_at(c.legs, (stance + 1) % c.leg_count)
    thigh = rates[swinging.hip]
    shank = thigh + rates[swinging.knee] if swinging.knee >= 0 else thigh
    return turning_of(standing, rates, share), thigh, shank


def turning_of(leg: Leg, rates: Any, share: float) -> float:
    """Rate of a stance leg's line from foot to hip, rad/s: its thigh's, while the knee is locked."""
    rate: float = rates[leg.hip]
    return rate + share * rates[leg.knee] if leg.knee >= 0 else rate


def put(into: Any, three: tuple[float, float, float]) -> None:
    """Write three angles, or their rates."""
    into[0], into[1], into[2] = three
