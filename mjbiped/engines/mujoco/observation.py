"""Observation of a walk after each physics step: impacts, support transfer, load and slip of the stance foot, end.

`observe` exchanges the legs if a touchdown was noted in the step before, notes a knee strike, lets the swing foot
collide when the scuffing rule says so, looks for an end of the walk, and says which foot leaves the ground in the next
step.

The support transfer comes in the step after the contact was resolved: the rates are then already those after the
impact.
"""

from __future__ import annotations

import math

from mjbiped.disturbances.chance import following
from mjbiped.dynamics.modes import bent_leg
from mjbiped.engines.mujoco.collisions import NOBODY, lift
from mjbiped.engines.mujoco.constants import (
    Constants,
    angles_of,
    foot_of,
    leg_at,
    pushes_at,
    rates_of,
    sole_angle,
    stance_leg,
    swing_index,
    swing_leg,
)
from mjbiped.engines.mujoco.feet import (
    gaps,
    intrusion,
    see_stance_foot,
    stand_flat,
    weigh,
)
from mjbiped.engines.mujoco.motors import lean_on, write_touchdown
from mjbiped.engines.mujoco.state import MARK, State, X, Z, put
from mjbiped.numerics.blocks import borrowed, numbers
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.rules.termination import SLIPPED_FOOT, Outcome
from mjbiped.terrain.profile import height_of, height_over, height_over_ground, segment_stood_on

MISSED = 0.02
"""A foot that is farther than this from the ground at its touchdown has been lost, in leg lengths: contacts let it come
0.01 deep at most."""
SLID = 1e-3  # a stance foot that slides farther in a gait step counts as sliding, in leg lengths
OPENED = 1e-4  # a knee that is bent less rests against its stop and cannot strike it, rad

SQUEEZED = 20.0  # weights: no walk presses so hard for 5 ms, but between two geoms
INTRUDES = 5e-3  # an edge that stands higher in a foot would have turned a foot with a sole, m

INTRUSION_WORDS = (
    f"an edge of the ground stood more than {1e3 * INTRUDES:g} mm inside a foot, between its pads: a foot with a sole "
    'would stand otherwise there; see underside="box"'
)
SQUEEZING_WORDS = (
    f"contacts pressed on the feet with more than {SQUEEZED:g} weights for 5 ms: a foot was held between two pieces of "
    "ground, and the motion there is none"
)
SLIDING_WORDS = (
    f"the stance foot slid by more than {SLID:g} leg lengths in a step: impacts and work there are not those of a foot "
    "that stands"
)

_FINISHED, _FELL = float(Outcome.FINISHED), float(Outcome.FELL)
_STALLED, _SLIPPED = float(Outcome.STALLED), float(Outcome.SLIPPED)
_LEFT_TERRAIN, _DIVERGED = float(Outcome.LEFT_TERRAIN), float(Outcome.DIVERGED)


def begin(c: Constants, u: State, slope: float, height: float) -> None:
    """Fill a zeroed state for a walk that starts on the first leg, which is straight, with its foot at x = 0.

    Args:
        c: The walk's constants; MuJoCo's data hold the robot's coordinates and rates.
        u: State.
        slope: Of the ground under the stance foot, rad.
        height: Of that ground, m.
    """
    qpos, qvel = borrowed(c.qpos, c.nq), borrowed(c.qvel, c.nq)
    for index in range(c.nq):
        u.q[index], u.rates[index] = qpos[index], qvel[index]
    u.mark, u.time, u.asked, u.lifted = MARK, -1.0, -1.0, NOBODY
    u.planned, u.plain = c.longest, 0.0 if c.lands else 1.0
    u.slope, u.reach = slope, leg_at(c.legs, 0).reach
    u.foot_x, u.foot_z = c.radius * math.sin(slope), height + c.radius * math.cos(slope)
    u.foot_angle = u.q[leg_at(c.legs, 0).hip]
    u.next_push, u.push_impulse = following(pushes_at(c.pushes, 0), 0, 0.0)
    u.stood = u.level = slope
    begin_step(u)
    swing = swing_leg(c, u)
    u.opened = 1.0 if swing.knee >= 0 and u.q[swing.knee] > OPENED else 0.0
    see_posture(c, u)


def begin_step(u: State) -> None:
    """Begin anew what is told of one gait step alone; the new swing foot leaves the ground."""
    u.slip = u.penetration = u.friction = u.face_impacts = u.contact_force = 0.0
    u.impulse = u.ankle_impulse = u.shear_impulse = u.stretch = u.without_contact = u.ratio_time = 0.0
    u.normal_force = u.least_ratio = math.inf
    u.pressure[0] = u.pressure[1] = -math.inf
    u.noted = u.enabled = u.collides = u.struck = 0.0
    u.locked = u.bent = u.opened = u.flexion = u.stubs = u.peak_hold = 0.0
    u.touching, u.strike_time = 1.0, math.nan
    u.flat, u.tipped, u.one_sided, u.touched = 1.0, 0.0, 0.0, math.nan
    u.down = -math.inf
    for three in (u.strike_q, u.strike_rates, u.struck_rates):
        put(three, (math.nan, math.nan, math.nan))


def observe(c: Constants, u: State, time: float) -> None:
    """Take in the state at a new time; see the module.

    On a copy of the state it says what the controller will be told when it ticks, and whether the walk is over.

    Args:
        c: The walk's constants; MuJoCo's data hold the robot's coordinates and rates.
        u: State.
        time: Now, s; later than the last observation.
    """
    turn_to(c, u, time)
    if c.feet:
        see_stance_foot(c, u)
    if c.knee_stiffness > 0.0:
        lean_on(stance_leg(c, u), u)
    if u.struck:  # the controller is told of it at its next tick
        stance, count = int(u.stance), int(u.count)
        u.strike_time, u.strike_untold = u.time - u.transfer_time, 1.0
        put(u.strike_q, angles_of(c, u.old_q, count, u.old_tilt, u.slope))
        put(u.strike_rates, rates_of(c, u.old_rates, stance, u.old_share))
        put(u.struck_q, angles_of(c, u.q, count, u.tilt, u.slope))
        put(u.struck_rates, rates_of(c, u.rates, stance, u.share))
    if u.struck or not u.noted:
        weigh(c, u, u.moment if c.feet else u.torque[0])
    swing = swing_leg(c, u)
    if swing.knee >= 0:
        u.flexion = max(u.flexion, u.q[swing.knee])
        if u.q[swing.knee] > OPENED and not u.locked:
            u.opened = 1.0
    if u.noted:
        transfer(c, u)
    u.bent = 0.0  # a knee that was locked for a touchdown is free again: the touchdown is made, or did not come
    see_posture(c, u)
    foot_x, foot_z = foot_of(stance_leg(c, u), u.q)
    x, z = foot_of(swing_leg(c, u), u.q)
    u.clear = min(gaps(c, swing_leg(c, u), u.q)) if c.feet else height_over_ground(c, x, z)
    u.collides = u.enabled
    if not c.scuffs:
        u.enabled = u.collides = 1.0
    elif swing_foot_is_drawn_in(c.reach, x - foot_x):
        u.enabled = u.collides = 0.0
    elif not u.enabled:
        clear = u.clear if c.feet else z - height_over(c, x)
        if swing_foot_collides(c.reach, c.delay, time - u.transfer_time, x - foot_x, clear):
            u.enabled = 1.0
    judge(c, u, foot_x, foot_z)
    lift(c, u, 0.0)


def turn_to(c: Constants, u: State, time: float) -> None:
    """Make what was the step to come the step under way, and read the state from MuJoCo."""
    qpos, qvel = borrowed(c.qpos, c.nq), borrowed(c.qvel, c.nq)
    u.turns = 0.0 if u.noted or u.struck or u.time < 0.0 else 1.0
    u.last_step = time - u.time if u.turns else 0.0
    u.time = time
    if u.strikes:
        u.locked = 1.0
    u.old_tilt, u.old_share, u.old_slope = u.tilt, u.share, u.slope
    for index in range(c.nq):
        u.old_q[index], u.old_rates[index] = u.q[index], u.rates[index]
        u.q[index], u.rates[index] = qpos[index], qvel[index] + u.lag[index]
        u.qvel[index], u.acceleration[index] = qvel[index], u.qacc[index]


def see_posture(c: Constants, u: State) -> None:
    """Note the angles by role, and their rates."""
    put(u.angles, angles_of(c, u.q, int(u.count), u.tilt, u.slope))
    put(u.turning, rates_of(c, u.rates, int(u.stance), u.share))


def judge(c: Constants, u: State, foot_x: float, foot_z: float) -> None:
    """Note how far the stance foot has slid, and whether the walk is over.

    Args:
        c: The walk's constants.
        u: State.
        foot_x: Place of the stance foot, m.
        foot_z: Its height, m.
    """
    hip_x, hip_z, length, slope = u.q[X], u.q[Z], c.leg_length, u.slope
    # a foot that sinks into the ground, or rolls with what stands on it, does not slip
    distance = (foot_x - u.foot_x) * math.cos(slope) - (foot_z - u.foot_z) * math.sin(slope)
    slip = abs(distance - c.rolling_radius * (u.q[stance_leg(c, u).hip] - u.foot_angle))
    up = (foot_x - u.foot_x) * math.sin(slope) + (foot_z - u.foot_z) * math.cos(slope)
    if slip > u.slip:
        if u.slip <= SLID * length < slip:
            u.slides += 1.0
        u.slip = slip
    if not u.outcome:
        if (hip_z - height_over(c, hip_x)) * math.cos(slope) < c.lowest_hip:
            u.outcome = _FELL
        elif u.time - u.transfer_time > c.stall_time:
            u.outcome = _STALLED
        elif max(slip, abs(up)) > SLIPPED_FOOT * length:
            u.outcome = _SLIPPED
        elif up < -MISSED * length and height_over(c, foot_x) - foot_z > MISSED * length:
            u.outcome = _DIVERGED  # the stance foot has slid under a step of the ground
        elif not c.start < hip_x < c.end:
            u.outcome = _LEFT_TERRAIN


def transfer(c: Constants, u: State) -> None:
    """Exchange the legs' roles and write the touchdown's row; the estimates are not known before the controller's tick.

    No row tells of a foot that is not on the ground: the walk has then diverged.

    The slope is that of the segment that the foot stands on: no contact's normal, which at an edge can be any.
    The contact step itself counts for no work: half of it belongs to either step's roles.

    The new stance knee stays locked as it is, straight or bent, or is held so by its servo from now on.
    """
    old, new, count = int(u.stance), swing_index(c, u), int(u.count)
    leg = leg_at(c.legs, new)
    x, z = foot_of(leg, u.q)
    segment = segment_stood_on(c, x, z)
    if not (c.feet or abs(z - height_of(c, segment, x)) <= MISSED * c.leg_length):
        u.outcome, u.noted = _DIVERGED, 0.0
        return
    put(u.turning, rates_of(c, u.rates_before if c.feet else u.old_rates, old, u.old_share))
    put(u.told_before, angles_of(c, u.q, count, u.tilt, u.slope))
    u.rest = u.bend if u.bent else 0.0
    if c.knee_stiffness > 0.0:
        lean_on(leg, u)
    elif u.bent:
        u.reach, lean = bent_leg(leg.upper, leg.lower, u.bend)
        u.tilt = u.bend - lean
    else:
        u.reach, u.tilt = leg.reach, 0.0
    slope = -math.atan(numbers(c.gradient, c.segments)[segment])
    if c.feet:
        stand_flat(u, sole_angle(leg, u.q))
        slope = u.level
        u.intrusion = intrusion(c, leg, u.q)
        u.intrusions += 1.0 if u.intrusion > INTRUDES else 0.0
    put(u.told_q, angles_of(c, u.q, count + 1, u.tilt, slope))
    put(u.told_dq, rates_of(c, u.rates, new, u.share))
    u.stance, u.slope, u.transfer_time, u.transferred = float(new), slope, u.time, 1.0
    u.foot_x, u.foot_z, u.foot_angle = x, z, u.q[leg.hip]
    u.count += 1.0
    write_touchdown(c, u)
    u.squeezes += 1.0 if u.contact_force > SQUEEZED * c.weight else 0.0
    # until the controller ticks: the motors that drive other joints now are off, the hip's goes on
    u.ankle = 0.0
    put(u.torque, (0.0, -u.torque[1], 0.0))
    begin_step(u)
    if not u.outcome:
        if u.count >= c.steps or u.foot_x >= c.distance:
            u.outcome = _FINISHED
        elif u.foot_x >= c.end:
            u.outcome = _LEFT_TERRAIN
