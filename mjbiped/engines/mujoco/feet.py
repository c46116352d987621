"""Contact of the feet: contact forces, touchdown, and the stance foot's load, friction and pressure.

A foot that is a body stands once the ground bears it both behind and ahead of the ankle; then the legs exchange their
roles. Until then both ankles are driven as in the step before. The slope is the angle of the standing foot, without
use of contact normals or of the terrain.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from mjbiped.engines.mujoco.constants import Constants, Leg, foot_of, heel_and_toe, sole_angle, stance_leg, swing_leg
from mjbiped.engines.mujoco.options import AUTO, BOXES, Options
from mjbiped.engines.mujoco.state import State
from mjbiped.numerics.blocks import Floats, Numbers, numbers
from mjbiped.records.loads import note_pressure
from mjbiped.robots.bodies import Foot
from mjbiped.rules.sole import GREATEST_ERROR, servo_torque
from mjbiped.rules.termination import LIGHT_CONTACT
from mjbiped.terrain.profile import height_over_ground, segment_under

READING = 11
"""Number of floats in one slot of a contact sensor: found, force (3), distance, position (3), normal (3)."""
FOUND, FORCE_SHOWN, DISTANCE, POSITION, NORMAL = 0, 1, 4, 5, 8

SMALLEST_UPWARD_NORMAL = 0.7  # below it, a contact is with a riser's face or a heightfield's inner edge


class Felt(NamedTuple):
    """Contact forces on the ground and depth of one foot; how the ground bears a sole stands behind them.

    Attributes:
        pressure: Sum of the normal forces of all contacts, N.
        forward: Force of the foot on the ground along x, without that on risers' faces, N.
        downward: Force of the foot on the ground along -z, without that on risers' faces, N.
        depth: Depth of the deepest contact with the ground, m.
        ground: Whether the foot touches the ground.
        face: Whether the foot touches a riser's face.
        moment: Of the normal forces of the ground about the point below the ankle, as an ankle's torque, N m.
        behind: Distance of the farthest contact with the ground behind the ankle, m; 0: there is none.
        ahead: Distance of the farthest one ahead of it, m.
        shear: Sum of the ground's friction forces, N; how contacts share it is undetermined.
    """

    pressure: float
    forward: float
    downward: float
    depth: float
    ground: bool
    face: bool
    moment: float = 0.0
    behind: float = 0.0
    ahead: float = 0.0
    shear: float = 0.0


def felt(c: Constants, u: State, readings: Numbers, leg: Leg) -> Felt:
    """Sum the contacts of a leg's foot over the slots of its contact sensor.

    The axes of a contact's frame are its normal, which points from the foot into the ground, the robot's lateral axis,
    and the direction perpendicular to both. Where two pieces of ground join, each bears part of the force and the
    frames tilt with the foot's distance from the joint; forces are therefore added as vectors.

    Args:
        c: The walk's constants.
        u: State.
        readings: MuJoCo's `sensordata`.
        leg: With the foot.
    """
    foot_x, foot_z = foot_of(leg, u.q)
    angle = sole_angle(leg, u.q) if leg.sole >= 0 else 0.0
    sine, cosine = math.sin(angle), math.cos(angle)
    pressure = forward = downward = depth = moment = shear = behind = ahead = 0.0
    ground = face = False
    for slot in range(leg.contacts, leg.contacts + c.slots, READING):
        if readings[slot + FOUND] > 0.0:
            force, along = readings[slot + FORCE_SHOWN], readings[slot + FORCE_SHOWN + 2]
            normal_x, normal_z = readings[slot + NORMAL], readings[slot + NORMAL + 2]
            pressure += force
            if -normal_z < SMALLEST_UPWARD_NORMAL:
                face = True
                continue
            ground = True
            depth = max(depth, -readings[slot + DISTANCE])
            forward += force * normal_x - along * normal_z
            downward -= force * normal_z + along * normal_x
            x, z = readings[slot + POSITION] - foot_x, readings[slot + POSITION + 2] - foot_z
            lever = x * cosine - z * sine
            moment -= lever * force
            behind, ahead = max(behind, -lever), max(ahead, lever)
            shear += along
    return Felt(pressure, forward, downward, depth, ground, face, moment, behind, ahead, shear)


def friction_ratio(foot: Felt, slope: float, light: float) -> float:
    """Friction ratio |F_t| / F_n of a foot on a slope (rad); 0 where F_n <= `light` (N), for it is noise there."""
    sine, cosine = math.sin(slope), math.cos(slope)
    normal = foot.downward * cosine - foot.forward * sine
    return abs(foot.forward * cosine + foot.downward * sine) / normal if normal > light else 0.0


LONGEST = 1e-4  # physics step, s
NEAR = 1e-4
"""Of heel and toe, the second one counts as landing this high over the ground, m: the first one, which bears load
already, is out of contact for single physics steps."""
MOST = 0.5  # of the weight that a foot bears which stands alone
PLAUSIBLE = GREATEST_ERROR
"""Difference of a foothold's angle from that of the ground so far up to which it is believed at once, rad: a foot of 24
cm on an edge of 2 cm is tilted by more."""


def for_feet(options: Options, foot: Foot) -> Options:
    """The engine's settings for feet that turn about ankles: short steps of one length, since no touchdown ends one.

    A box would meet heightfields in single points.
    """
    ground = BOXES if foot.box and options.ground == AUTO else options.ground
    return replace(options, timestep=min(options.timestep, LONGEST), lands=False, ground=ground)


def gaps(c: Constants, leg: Leg, q: Floats) -> tuple[float, float]:
    """Heights of heel and toe over the ground, m."""
    heel_x, heel_z, toe_x, toe_z = heel_and_toe(leg, q)
    return height_over_ground(c, heel_x, heel_z), height_over_ground(c, toe_x, toe_z)


def see_stance_foot(c: Constants, u: State) -> None:
    """Take the slope from the foot that stands, and note how long it stood on one side alone, and how far it tipped."""
    tip = sole_angle(stance_leg(c, u), u.q) - u.stood
    u.slope = u.level + tip
    u.tipped = max(u.tipped, abs(tip))
    if not (u.flat or u.noted):
        u.one_sided += u.effective_step


def stand_flat(u: State, new: float) -> None:
    """Note the angle of a new foothold, rad, and what the feet take the ground's to be.

    An angle far from that of the ground so far is that of a foot on an edge, unless the foothold before was like it.
    """
    if min(abs(new - u.level), abs(new - u.stood)) < PLAUSIBLE:
        u.level = new
    u.stood = new


def intrusion(c: Constants, leg: Leg, q: Floats) -> float:
    """How high edges of the ground stand over the line from a foot's heel to its toe, m; 0: none does."""
    (x, z), angle = foot_of(leg, q), sole_angle(leg, q)
    starts, heights, rises = numbers(c.x, c.segments), numbers(c.z, c.segments), numbers(c.rises, c.segments)
    heel, _, toe, _ = heel_and_toe(leg, q)
    segment, fall, highest = segment_under(c, heel) + 1, math.tan(angle), 0.0
    while segment < c.segments and starts[segment] < toe:
        edge = max(heights[segment], heights[segment] - rises[segment])
        highest = max(highest, edge - (z - fall * (starts[segment] - x)))
        segment += 1
    return highest


def lands_flat(c: Constants, u: State, x: float) -> bool:
    """Whether the swing foot, below whose ankle the sole is at x (m), comes to stand in this step."""
    if not (u.collides and x > u.foot_x):
        return False
    heel, toe = gaps(c, swing_leg(c, u), u.q)
    return -c.deepest < min(heel, toe) < 0.0 and max(heel, toe) < NEAR


def stands(c: Constants, u: State, foot: Felt) -> bool:
    """Whether the swing foot has come to stand; notes its first contact.

    It has where the ground bears the foot on both sides of its ankle. A foot with an edge close to its ankle may never
    be borne so: it stands once it bears most of the weight and the other foot has borne none for a while.
    """
    if max(foot.behind, foot.ahead) > 0.0:
        u.down = u.time
        if math.isnan(u.touched):
            u.touched = u.time
    elif u.time - u.down > c.airborne:
        u.touched = math.nan
    alone = u.without_contact >= c.airborne and foot.pressure > MOST * c.weight
    return bool(alone or min(foot.behind, foot.ahead) > 0.0)


def swing_foot_torque(c: Constants, u: State) -> float:
    """Torque of the ankle's motor that holds the swing foot, N m, on the leg as that of the stance ankle."""
    stance, swing = stance_leg(c, u), swing_leg(c, u)
    rate = (u.rates[swing.hip] + u.rates[swing.sole]) - (u.rates[stance.hip] + u.rates[stance.sole])
    # joints tell angles from the foot that stands, which may tip
    return servo_torque(c.foot_stiffness, c.foot_damping, sole_angle(swing, u.q) - u.slope, rate)


FEWEST_AVERAGED = 5.0  # a normal force is averaged over at least so many physics steps: single ones are without contact
AIRBORNE = 0.06
"""A foot is airborne once it has had no contact for this time, in units of sqrt(leg length / gravity). The hops of a
sliding foot last half as long."""
CLEAR = 1e-4  # a swing foot has left the ground once it was higher over it, m


def weigh(c: Constants, u: State, moment: float) -> None:
    """Take the stance foot's force in the physics step before into its averages, and its friction.

    A standing foot loses contact for single physics steps, a sliding one for some milliseconds, and the force of the
    step after makes up for it. So the force is averaged, over stretches of time that end with a step in contact. A foot
    that stays off the ground for longer bears nothing. Of the friction the least counts that some time has: in a step
    of 10 µs, while an impact is being resolved, the foot slides by less than a micrometre at the limit of friction.
    """
    effective_step, force = u.effective_step, u.force
    u.impulse += effective_step * force
    u.shear_impulse += effective_step * u.shear
    u.ankle_impulse += effective_step * moment
    u.stretch += effective_step
    u.load += effective_step * u.pressing
    u.load_time += effective_step
    if u.load_time >= c.averaged:
        u.contact_force = max(u.contact_force, u.load / u.load_time)
        u.load = u.load_time = 0.0
    u.least_ratio = min(u.least_ratio, u.ratio)
    u.ratio_time += effective_step
    if u.ratio_time >= c.sustained:
        u.friction = max(u.friction, u.least_ratio)
        u.least_ratio, u.ratio_time = math.inf, 0.0
    u.without_contact = 0.0 if force > 0.0 else u.without_contact + effective_step
    if u.without_contact >= c.airborne:
        u.normal_force = 0.0
    elif force > 0.0 and u.stretch >= c.averaged:
        average = u.impulse / u.stretch
        if average < u.normal_force:
            u.normal_force = average
        torque, light = u.ankle_impulse / u.stretch, LIGHT_CONTACT * c.weight
        note_pressure(u.pressure, torque, average, light, c.leg_length, u.stretch)
        if u.impulse > 0.0:
            u.friction = max(u.friction, abs(u.shear_impulse) / u.impulse)
        u.impulse = u.ankle_impulse = u.shear_impulse = u.stretch = 0.0


def least_normal_force(u: State) -> float:
    """Of the step that ends, N; that of a step too short for an average is the mean of what there was, or NaN."""
    if u.normal_force < math.inf:
        return float(u.normal_force)
    return float(u.impulse / u.stretch) if u.stretch > 0.0 else math.nan


def read_contacts(c: Constants, u: State, readings: Numbers) -> Felt:
    """Note what the feet feel in the step just resolved; returns what the swing foot does.

    A swing foot that touches the ground and is able to stand makes a touchdown.
    """
    leg = swing_leg(c, u)
    stance, swing = felt(c, u, readings, stance_leg(c, u)), felt(c, u, readings, leg)
    able = stands(c, u, swing) if c.feet else leg.knee < 0 or u.locked != 0.0 or u.bent != 0.0
    x, _ = foot_of(leg, u.q)
    noted = u.enabled != 0.0 and able and x > u.foot_x and swing.ground
    u.noted, u.ratio = 1.0 if noted else 0.0, 0.0
    u.force, u.pressing = stance.pressure, stance.pressure + swing.pressure
    if u.clear > CLEAR:
        u.touching = 0.0
    if u.enabled and swing.face:
        u.face_impacts = 1.0
    if noted:
        u.penetration = max(u.penetration, swing.depth)
        u.support_behind, u.support_ahead = swing.behind, swing.ahead
    elif swing.ground and not u.touching:
        u.stubs += 1.0
        u.touching = 1.0
    if stance.ground and not noted:
        u.penetration = max(u.penetration, stance.depth)
    if c.feet:
        u.moment, u.shear = stance.moment, stance.shear
        u.flat = 1.0 if min(stance.behind, stance.ahead) > 0.0 else 0.0
    elif stance.ground and not noted:  # of feet with two contacts one may be lost in single steps; see `weigh`
        u.ratio = friction_ratio(stance, u.slope, LIGHT_CONTACT * c.weight)
    return swing
