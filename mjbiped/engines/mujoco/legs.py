"""The legs of a robot in MuJoCo: where their parts are, and angles and places by the robot's coordinates."""

from __future__ import annotations

import math

from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.state import State, X, Z
from mjbiped.numerics.blocks import Block, Floats, reader


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
