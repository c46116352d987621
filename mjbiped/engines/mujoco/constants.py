"""Constants of a walk in MuJoCo, which `setup` fills in, among them the indices of each leg in MuJoCo's arrays."""

from __future__ import annotations

import math

from mjbiped.disturbances.chance import Pushes
from mjbiped.engines.mujoco.state import State, X, Z
from mjbiped.numerics.blocks import Block, Floats, reader


class Constants(Block):
    """What does not change in a walk while its scene is the same, and where things are.

    Attributes:
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
        qacc_warmstart: See there.
        ctrl: See there.
        qfrc_applied: Forces at the degrees of freedom; that at hip x is a push's, N.
        sensordata: Data of all sensors.
        geom_contype: Contact bits of geoms.
        geom_conaffinity: The same.
        geom_solref: Softness of contacts, two numbers a geom.
        jnt_solref: Softness of the joints' limits, two numbers a joint.
        eq_solref: Softness of equality constraints, two numbers each.
        eq_data: `EQ_DATA` numbers of each, the flexion first at which a lock holds.
        eq_active: Whether each is switched on.

        legs: The robot's legs, in the order in which they stand.
        leg_count: Their number.
        order: For each of the robot's `places` its index in qpos.
        nq: Number of these.
        angles: Number of the robot's angles, and of its joints with motors.
        hip: Actuator between the legs; -1: there is none.
        slots: Floats of one foot's contacts in the sensor data.
        nsensordata: Floats of all sensor data.
        nu: Number of actuators.
        ngeom: Number of geoms.
        njnt: Number of joints.
        neq: Number of equality constraints.
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
        next_discontinuity: See there; not called here.
        tick: See there.
        knee_strike: See there.
        failed: A float that is not zero once a law has raised an exception.
        room: `motors.SPARE` floats and more, into which `torque` writes.
        control_period: Time between two ticks of the controller, s; 0: it ticks at every physics step.
        memory_size: Floats of the controller's memory.
        states: Number of its integrated states.
        sampled: Whether it is in a loop with disturbances, which holds its torques.
        ticks: Whether its law has a tick.
        support: See `Controller.support`.
        pushes: Pushes at the hip, alone in a list; see `disturbances.chance.Pushes`.

        sample_period: Time between two samples, s; each is taken at the first physics step from then on.
        samples: Rows of samples, one behind the other, which whoever takes them counts in `State.samples`.
        rows: Rows of touchdowns, the same.
        sample_room: Number of rows of samples that there is room for; more are not written.
        row_room: Number of rows of touchdowns.
        sample_width: Floats of a sample; the controller's integrated states stand at its end.
        row_width: Floats of a touchdown.
        estimate_at: Index in a touchdown of the slope estimate before its update; that after it follows.
    """


constants_at = reader(Constants)
pushes_at = reader(Pushes)


class Leg(Block):
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


leg_at = reader(Leg)


def stance_leg(c: Constants, u: State) -> Leg:
    """The leg that stands."""
    return leg_at(c.legs, int(u.stance))


def swing_index(c: Constants, u: State) -> int:
    """Number of the leg that stands next."""
    return int((int(u.stance) + 1) % c.leg_count)


def swing_leg(c: Constants, u: State) -> Leg:
    """The leg that stands next."""
    return leg_at(c.legs, swing_index(c, u))


def foot_of(leg: Leg, q: Floats) -> tuple[float, float]:
    """Place of a leg's foot, x and z in m, by the robot's coordinates: of one with a sole, of that below the ankle."""
    x, z = end_of_leg(leg, q[X], q[Z], q[leg.hip], q[leg.knee] if leg.knee >= 0 else 0.0)
    if leg.sole < 0:
        return x, z
    angle = sole_angle(leg, q)
    return x - leg.height * math.sin(angle), z - leg.height * math.cos(angle)


def sole_angle(leg: Leg, q: Floats) -> float:
    """Angle of a foot's sole, as a slope, rad."""
    return float(q[leg.hip] + leg.offset + q[leg.sole])


def heel_and_toe(leg: Leg, q: Floats) -> tuple[float, float, float, float]:
    """Places of the ends of a sole, x and z of the heel and of the toe, m."""
    (x, z), angle = foot_of(leg, q), sole_angle(leg, q)
    sine, cosine = math.sin(angle), math.cos(angle)
    return x - leg.behind * cosine, z + leg.behind * sine, x + leg.ahead * cosine, z - leg.ahead * sine


def end_of_leg(leg: Leg, x: float, z: float, angle: float, flexion: float) -> tuple[float, float]:
    """Place of a leg's end, x and z in m, by the hip's, the hinge's angle and the knee's flexion in rad."""
    angle += leg.offset
    upper = angle + leg.turn
    x, z = x - leg.upper * math.sin(upper), z - leg.upper * math.cos(upper)
    if leg.knee < 0:
        return x, z
    lower = angle + flexion + leg.bend
    return x - leg.lower * math.sin(lower), z - leg.lower * math.cos(lower)


def angles_of(c: Constants, q: Floats, count: int, tilt: float, slope: float) -> tuple[float, float, float]:
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


def upper_angle(c: Constants, q: Floats, count: int) -> float:
    """Angle from the vertical of the upper segment of the leg that stands after so many touchdowns, rad."""
    leg, laps = leg_at(c.legs, count % c.leg_count), count // c.leg_count
    return float(q[leg.hip] + (leg.offset + laps * leg.lap))


def rates_of(c: Constants, rates: Floats, stance: int, share: float) -> tuple[float, float, float]:
    """Rates of these angles, rad/s; `share` is that of the stance knee's rate."""
    standing, swinging = leg_at(c.legs, stance), leg_at(c.legs, (stance + 1) % c.leg_count)
    thigh = rates[swinging.hip]
    shank = thigh + rates[swinging.knee] if swinging.knee >= 0 else thigh
    return turning_of(standing, rates, share), thigh, shank


def turning_of(leg: Leg, rates: Floats, share: float) -> float:
    """Rate of a stance leg's line from foot to hip, rad/s: its thigh's, while the knee is locked."""
    rate: float = rates[leg.hip]
    return rate + share * rates[leg.knee] if leg.knee >= 0 else rate
