"""Takes in the state of a walk at a new time: impacts that were made, the stance foot's load, slip, the walk's end.

One physics step from t to t + h:

1. `observe` (in the first callback at t, before contacts are made): exchanges the legs if a touchdown was noted in the
   step before, notes a knee strike, lets the swing foot collide when the scuffing rule says so, looks for an end of
   the walk, and says which foot leaves the ground in the step to come;
2. MuJoCo makes contacts and constraints;
3. the controller ticks (`motors.control`);
4. MuJoCo finds the forces;
5. `bearing.read_contacts` notes touchdown, friction and penetration as the contact sensors show them;
6. `step_size.step_length` says how long this step is: it ends where the swing foot meets the ground, or the knee its
   stop.

The support transfer comes in the step after the contact was resolved: the rates are then already those after the
impact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, MutableSequence, Sequence
from typing import Any

from mjbiped.disturbances.pushes import following
from mjbiped.engines.mujoco.bearing import least_normal_force, weigh
from mjbiped.engines.mujoco.feet import (
    begin_flat,
    gaps,
    lands_flat,
    see_stance_foot,
    sole_angle,
    stand_flat,
)
from mjbiped.engines.mujoco.servo import lean_on
from mjbiped.engines.mujoco.state import (
    Constants,
    X,
    Z,
    angles_of,
    end_of_leg,
    foot_of,
    put,
    rates_of,
    stance_of,
    swing_of,
)
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.rules.termination import SLIPPED_FOOT, Limits, Outcome
from mjbiped.terrain.profile import Profile, height_of, height_over, height_over_ground, segment_stood_on

MISSED = 0.02
"""A foot that is farther than this from the ground at its touchdown has been lost, in leg lengths: contacts let it come
0.01 deep at most."""
SLID = 1e-3  # a stance foot that slides farther in a gait step counts as sliding, in leg lengths
OPENED = 1e-4  # a knee that is bent less rests against its stop and cannot strike it, rad
NOBODY = -1.0  # in `State.lifted`: no foot leaves the ground in this step
SHORTEST = 1e-9  # no step is shorter, s

SLIDING_WORDS = (
    f"the stance foot slid by more than {SLID:g} leg lengths in a step: impacts and work there are not those of a foot "
    "that stands"
)

_FINISHED, _FELL = float(Outcome.FINISHED), float(Outcome.FELL)
_STALLED, _SLIPPED = float(Outcome.STALLED), float(Outcome.SLIPPED)
_LEFT_TERRAIN, _DIVERGED = float(Outcome.LEFT_TERRAIN), float(Outcome.DIVERGED)


def begin(
    constants: Constants, u: Any, qpos: Sequence[float], qvel: Sequence[float], slope: float, height: float
) -> None:
    """Fill a zeroed state for a walk that starts on the first leg, which is straight, with its foot at x = 0.

    Args:
        constants: The walk's.
        u: State.
        qpos: The robot's coordinates.
        qvel: Their rates.
        slope: Of the ground under the stance foot, rad.
        height: Of that ground, m.
    """
    legs = constants.places.legs
    for index in range(len(qpos)):
        u.q[index], u.rates[index] = qpos[index], qvel[index]
    u.running, u.time, u.asked = 1.0, -1.0, -1.0
    u.planned_next, u.plain_next = constants.timestep, 0.0 if constants.lands else 1.0
    u.slope, u.reach = slope, legs[0].reach
    radius = constants.radius
    u.foot_x, u.foot_z, u.foot_angle = radius * math.sin(slope), height + radius * math.cos(slope), u.q[legs[0].hip]
    u.next_push, u.push_impulse = following(constants.pushes, 0, 0.0)
    begin_flat(u)
    begin_step(u)
    swing = legs[swing_of(u, legs)]
    u.opened = 1.0 if swing.knee >= 0 and u.q[swing.knee] > OPENED else 0.0
    see_posture(constants, u)


def begin_step(u: Any) -> None:
    """Begin anew what is told of one gait step alone; the new swing foot leaves the ground."""
    u.slip = u.penetration = u.friction = u.face_impacts = 0.0
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


def observe(
    parts: Any,
    constants: Constants,
    u: Any,
    row: MutableSequence[float],
    time: float,
    qpos: Sequence[float],
    qvel: Sequence[float],
) -> None:
    """Take in the state at a new time; see the module.

    On a copy of the state it says what the controller will be told when it ticks, and whether the walk is over.

    Args:
        parts: See `motors.Parts`.
        constants: The walk's.
        u: State.
        row: Of the last touchdown.
        time: Now, s; later than the last observation.
        qpos: The robot's coordinates now.
        qvel: Their rates in MuJoCo.
    """
    limits, profile, legs = constants.limits, constants.places.profile, constants.places.legs
    turn_to(u, time, qpos, qvel)
    if constants.feet:
        see_stance_foot(constants, u)
    if constants.servo.stiffness > 0.0:
        lean_on(legs[stance_of(u)], u)
    if u.struck:
        note_strike(constants, u)
    if u.struck or not u.noted:
        weigh(u, limits, u.moment if constants.feet else u.torque[0])
    swing = legs[swing_of(u, legs)]
    if swing.knee >= 0:
        u.flexion = max(u.flexion, u.q[swing.knee])
        if u.q[swing.knee] > OPENED and not u.locked:
            u.opened = 1.0
    if u.noted:
        transfer(parts, constants, u, row)
    u.bent = 0.0  # a knee that was locked for a touchdown is free again: the touchdown is made, or did not come
    see_posture(constants, u)
    stance = legs[stance_of(u)]
    foot_x, foot_z = foot_of(stance, u.q)
    x, z = foot_of(legs[swing_of(u, legs)], u.q)
    u.clear = (
        min(gaps(constants, legs[swing_of(u, legs)], u.q)) if constants.feet else height_over_ground(profile, x, z)
    )
    u.collides = u.enabled
    if not constants.scuffs:
        u.enabled = u.collides = 1.0
    elif swing_foot_is_drawn_in(limits.reach, x - foot_x):
        u.enabled = u.collides = 0.0
    elif not u.enabled and swing_foot_collides(
        limits.reach,
        limits.delay,
        time - u.transfer_time,
        x - foot_x,
        u.clear if constants.feet else z - height_over(profile, x),
    ):
        u.enabled = 1.0
    judge(u, limits, profile, (u.q[X], u.q[Z]), (foot_x, foot_z), u.q[stance.hip])
    lift(constants, u, x)


def turn_to(u: Any, time: float, qpos: Sequence[float], qvel: Sequence[float]) -> None:
    """Make what was the step to come the step under way, and read the state from MuJoCo."""
    u.turns = 0.0 if u.noted or u.struck or u.time < 0.0 else 1.0
    u.last_step = time - u.time if u.turns else 0.0
    u.time, u.planned, u.plain, u.smooth = time, u.planned_next, u.plain_next, u.smooth_next
    u.strikes, u.prepared = u.strikes_next, 0.0
    if u.strikes:
        u.locked = 1.0
    u.old_tilt, u.old_share, u.old_slope = u.tilt, u.share, u.slope
    for index in range(len(qpos)):
        u.old_q[index], u.old_rates[index], u.lag[index] = u.q[index], u.rates[index], u.lag_next[index]
        u.q[index], u.rates[index] = qpos[index], qvel[index] + u.lag[index]
        u.acceleration[index] = u.qacc[index]


def see_posture(constants: Constants, u: Any) -> None:
    """Note the angles by role, and their rates."""
    legs, stance = constants.places.legs, stance_of(u)
    put(u.angles, angles_of(legs, u.q, int(u.count), u.tilt, u.slope))
    put(u.turning, rates_of(legs, u.rates, stance, u.share))


def lift(constants: Constants, u: Any, x: float) -> None:
    """Say which foot leaves the ground in the step to come, and passes through it; see `contacts.refuses`.

    That of the stance leg does where the other one lands. A swing knee that is free is then locked as it is: with the
    touchdown, the leg becomes one body. Not so where the stop alone holds knees: no bent leg lands there.

    Args:
        constants: The walk's.
        u: State.
        x: Place of the swing foot, m.
    """
    legs, swing = constants.places.legs, swing_of(u, constants.places.legs)
    u.lifted = NOBODY
    if constants.feet:
        if lands_flat(constants, u, x):
            u.lifted = u.stance
        else:
            for index in range(len(constants.places.order)):
                u.rates_before[index] = u.rates[index]
        return
    if not (u.collides and -constants.deepest < u.clear < 0.0):
        return
    leg = legs[swing]
    later_x, later_z = end_of_leg(
        leg, _later(u, X), _later(u, Z), _later(u, leg.hip), _later(u, leg.knee) if leg.knee >= 0 else 0.0
    )
    straight = leg.knee < 0 or u.locked != 0.0
    if height_over_ground(constants.places.profile, later_x, later_z) > u.clear:
        u.lifted = float(swing)
    elif x > u.foot_x and (straight or not (u.touching or constants.knee_opens)):
        # a foot that drags along with its knee bent goes on so
        u.lifted = u.stance
        if not straight:
            u.bent, u.bend = 1.0, u.q[leg.knee]


def _later(u: Any, index: int) -> float:
    return float(u.q[index] + SHORTEST * u.rates[index])


def judge(
    u: Any, limits: Limits, profile: Profile, hip: tuple[float, float], foot: tuple[float, float], stance: float
) -> None:
    """Note how far the stance foot has slid, and whether the walk is over.

    Args:
        u: State.
        limits: Limits at which the walk ends.
        profile: The ground.
        hip: Its place, x and z in m.
        foot: Place of the stance foot, m.
        stance: What stands on it, from the vertical, rad: the foot rolls with that.
    """
    hip_x, hip_z = hip
    foot_x, foot_z = foot
    length, slope = limits.leg_length, u.slope  # a foot that sinks into the ground, or rolls, does not slip
    distance = (foot_x - u.foot_x) * math.cos(slope) - (foot_z - u.foot_z) * math.sin(slope)
    slip = abs(distance - limits.rolling_radius * (stance - u.foot_angle))
    up = (foot_x - u.foot_x) * math.sin(slope) + (foot_z - u.foot_z) * math.cos(slope)
    if slip > u.slip:
        if u.slip <= SLID * length < slip:
            u.slides += 1.0
        u.slip = slip
    if not u.outcome:
        if (hip_z - height_over(profile, hip_x)) * math.cos(slope) < limits.lowest_hip:
            u.outcome = _FELL
        elif u.time - u.transfer_time > limits.stall_time:
            u.outcome = _STALLED
        elif max(slip, abs(up)) > SLIPPED_FOOT * length:
            u.outcome = _SLIPPED
        elif up < -MISSED * length and height_over(profile, foot_x) - foot_z > MISSED * length:
            u.outcome = _DIVERGED  # the stance foot has slid under a step of the ground
        elif not limits.start < hip_x < limits.end:
            u.outcome = _LEFT_TERRAIN


def warned(warnings: Mapping[str, int], u: Any) -> dict[str, int]:
    """Warnings of a walk, with that of steps in which the stance foot slid, if there were any."""
    slides = int(u.slides)
    return {**warnings, **({SLIDING_WORDS: slides} if slides else {})}


def note_strike(constants: Constants, u: Any) -> None:
    """The knee has struck its stop in the step before; the controller is told at its next tick."""
    legs, stance, count = constants.places.legs, stance_of(u), int(u.count)
    u.strike_time, u.strike_untold = u.time - u.transfer_time, 1.0
    put(u.strike_q, angles_of(legs, u.old_q, count, u.old_tilt, u.slope))
    put(u.strike_rates, rates_of(legs, u.old_rates, stance, u.old_share))
    put(u.struck_q, angles_of(legs, u.q, count, u.tilt, u.slope))
    put(u.struck_rates, rates_of(legs, u.rates, stance, u.share))


def transfer(parts: Any, constants: Constants, u: Any, row: MutableSequence[float]) -> None:
    """Exchange the legs' roles and write the touchdown's row; the estimates are not known before the controller's tick.

    No row tells of a foot that is not on the ground: the walk has then diverged.

    The slope is that of the segment that the foot stands on: no contact's normal, which at an edge can be any.
    The contact step itself counts for no work: half of it belongs to either step's roles.

    The new stance knee stays locked as it is, straight or bent, or is held so by its servo from now on.
    """
    limits, profile, legs = constants.limits, constants.places.profile, constants.places.legs
    old, new, count = stance_of(u), swing_of(u, legs), int(u.count)
    x, z = foot_of(legs[new], u.q)
    segment = segment_stood_on(profile, x, z)
    if not (constants.feet or abs(z - height_of(profile, segment, x)) <= MISSED * limits.leg_length):
        u.outcome, u.noted = _DIVERGED, 0.0
        return
    dq_before = u.turning
    put(dq_before, rates_of(legs, u.rates_before if constants.feet else u.old_rates, old, u.old_share))
    put(u.told_before, angles_of(legs, u.q, count, u.tilt, u.slope))
    stand_on(constants, u, new)
    slope = -math.atan(profile.gradient[segment])
    if constants.feet:
        stand_flat(u, sole_angle(legs[new], u.q))
        slope = u.level
    put(u.told_q, angles_of(legs, u.q, count + 1, u.tilt, slope))
    put(u.told_dq, rates_of(legs, u.rates, new, u.share))
    u.stance, u.slope, u.transfer_time, u.transferred = float(new), slope, u.time, 1.0
    u.foot_x, u.foot_z, u.foot_angle = x, z, u.q[legs[new].hip]
    u.count += 1.0
    write_row(parts, constants, u, row, dq_before)
    # until the controller ticks: the motors that drive other joints now are off, the hip's goes on
    u.ankle = 0.0
    put(u.torque, (0.0, -u.torque[1], 0.0))
    begin_step(u)
    judge_touchdown(u, limits)


def write_row(parts: Any, constants: Constants, u: Any, row: MutableSequence[float], dq_before: Any) -> None:
    """Write down the touchdown that has just exchanged the legs."""
    servo = constants.servo.stiffness > 0.0
    hold, hold_work = (u.peak_hold, u.work_hold) if servo else (math.nan, math.nan)
    see_places(constants, u)
    parts.write_touchdown(
        row,
        0,
        time=u.time,
        qpos=u.posture,
        x=u.foot_x - constants.radius * math.sin(u.slope),
        z=u.foot_z - constants.radius * math.cos(u.slope),
        stance=u.stance,
        slope=u.slope,
        q_before=u.told_before,
        dq_before=dq_before,
        q=u.told_q,
        dq=u.told_dq,
        work_absolute=u.work_absolute,
        work_net=u.work_net,
        work_positive=u.work_positive,
        slip=u.slip,
        penetration=u.penetration,
        friction=u.friction,
        strikes=u.face_impacts,
        slope_estimate_before=math.nan,
        slope_estimate=math.nan,
        normal_force=least_normal_force(u),
        pressure_ahead=u.pressure[0],
        pressure_behind=u.pressure[1],
        sole_bound_time=u.bound_time,
        knee_strike=u.strike_time,
        knee_q=u.strike_q,
        knee_dq_before=u.strike_rates,
        knee_dq=u.struck_rates,
        flexion=u.flexion,
        stubs=u.stubs,
        stance_knee_torque=hold,
        stance_knee_work=hold_work,
        tipped=u.tipped,
        one_sided=u.one_sided,
        slap=u.time - u.touched,
        support_behind=u.support_behind,
        support_ahead=u.support_ahead,
    )


def see_places(constants: Constants, u: Any) -> None:
    """Note the posture in the record's order."""
    for index in range(len(constants.places.order)):
        u.posture[index] = u.q[constants.places.order[index]]


def stand_on(constants: Constants, u: Any, new: int) -> None:
    """Note how the line from foot to hip stands of a leg that becomes the stance leg, bent or straight."""
    leg = constants.places.legs[new]
    u.rest = u.bend if u.bent else 0.0
    if constants.servo.stiffness > 0.0:
        lean_on(leg, u)
    elif u.bent:
        u.reach, lean = bent_leg(leg.upper, leg.lower, u.bend)
        u.tilt = u.bend - lean
    else:
        u.reach, u.tilt = leg.reach, 0.0


def judge_touchdown(u: Any, limits: Limits) -> None:
    """Note whether the walk is over with the touchdown just counted."""
    if not u.outcome:
        if u.count >= limits.steps or u.foot_x >= limits.distance:
            u.outcome = _FINISHED
        elif u.foot_x >= limits.end:
            u.outcome = _LEFT_TERRAIN
