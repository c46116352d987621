"""Contact events: what the engine remembers from one physics step to the next, and how it exchanges the legs.

All of it stands in `mjData.userdata`, at the indices named below, so that a walk can be copied, saved and resumed with
MuJoCo's own state functions, and nothing depends on how often a callback fires at the same time. The functions work on
any mutable sequence of floats; they know neither MuJoCo's objects nor the controller. They run in plain Python and
compiled, bit by bit the same.

One physics step from t to t + h:

1. `observe` (in the control callback at t): counts the work of the step before, exchanges the legs if a touchdown was
   noted in it, lets the swing foot collide when the scuffing rule says so, and looks for an end of the walk;
2. the controller ticks;
3. MuJoCo resolves the contacts;
4. `read_contacts` (in the sensor callback): notes touchdown, friction and penetration as the contact sensors show them;
5. `step_size.step_length` (there too) says how long this step is: it ends where the swing foot meets the ground.

The support transfer comes one call after the contact was resolved: the rates are then already those after the impact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, MutableSequence, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.contact_forces import Felt, friction_ratio
from mjbiped.records.columns import TOUCHDOWNS, index_of
from mjbiped.records.pressure import BINS, note_pressure
from mjbiped.records.rows import TOUCHED, write_touchdown
from mjbiped.rules.scuffing import swing_foot_collides, swing_foot_is_drawn_in
from mjbiped.rules.termination import FALLEN_HIP, LIGHT_CONTACT, SLIPPED_FOOT, Limits, Outcome
from mjbiped.terrain.profile import Profile, height_of, height_over, segment_stood_on

# --- indices in userdata ----------------------------------------------------------------------------------------------
(
    RUNNING,  # 0 in zeroed userdata: then nothing acts
    TIME,  # of the last observation, s
    PLANNED,  # length of the physics step from then on that its contacts are made for, s; see `step_size`
    PLANNED_NEXT,  # the same of the step after it, s
    PLAIN,  # 1: its effective step is as long as the step itself
    PLAIN_NEXT,  # the same of the step after it
    EFFECTIVE_STEP,  # time for which the accelerations act in it, s
    LAST_STEP,  # length of the step before, s; 0 just after an impact
    LEFT_LAG,  # what the legs' rates in `qvel` lack to be those of that time, rad/s; see `leapfrog`
    RIGHT_LAG,
    LEFT_LAG_NEXT,  # the same after the step from then on
    RIGHT_LAG_NEXT,
    SMOOTH,  # 1: the last step's accelerations are those of a motion without an impact
    LEFT_ACCELERATION,  # of the legs in it, rad/s²
    RIGHT_ACCELERATION,
    SHOWN,  # 1: `qvel` is what MuJoCo's velocity stage is to see
    QVEL,  # first of four: the state's rates meanwhile
    _QVEL_Z,
    _QVEL_LEFT,
    _QVEL_RIGHT,
    STANCE,  # 0 left, 1 right
    TRANSFER_TIME,  # of the last support transfer, s
    NEXT_CONTROL,  # when the controller ticks next, s
    NEXT_SAMPLE,  # when a sample is due, s
    SAMPLES,  # that wait to be taken from the recording; see `callbacks.Recording`
    ROWS,  # of touchdowns that wait there
    TRANSFERRED,  # 1: there was a support transfer that the controller does not know of yet
    CONTACT_ENABLED,  # 1: the swing foot collides
    SLOPE,  # of the ground under the stance foot, rad
    FOOT_X,  # stance foot at the support transfer, m
    FOOT_Z,
    FOOT_ANGLE,  # stance leg at the support transfer, rad
    NOTED,  # 1: touchdown resolved in the last step
    ANKLE,  # torque held, N m
    HIP,
    LEFT,  # leg angles and rates of the last observation
    RIGHT,
    LEFT_RATE,
    RIGHT_RATE,
    WORK_ABSOLUTE,  # since the start, J
    WORK_NET,
    WORK_POSITIVE,
    PEAK_ANKLE,  # since the start, N m
    PEAK_HIP,
    SLIP,  # greatest in this step: distance that the stance foot slid along the ground, m
    SLIDES,  # steps in which it slid farther than `SLID`
    PENETRATION,  # m
    FRICTION,  # greatest |F_t| / F_n in this step, of those that last; see `weigh`
    RATIO,  # |F_t| / F_n in the physics step last resolved
    LEAST_RATIO,  # least of those since a ratio was last taken
    RATIO_TIME,  # how long that is ago, s
    FORCE,  # F_n of the stance foot in the physics step last resolved, N
    IMPULSE,  # of F_n since the last stretch ended over which it is averaged, N s
    STRETCH,  # how long that is ago, s
    WITHOUT_CONTACT,  # how long the stance foot has had none, s
    NORMAL_FORCE,  # least average in this step, N
    ANKLE_IMPULSE,  # of its torque over the same stretch, N m s
    PRESSURE_AHEAD,  # greatest distances of the centre of pressure from the ankle in this step, m
    PRESSURE_BEHIND,
    FACE_IMPACTS,  # 1: the swing foot struck a vertical face in this step
    NEXT_PUSH,  # when the next push begins, or the present one has begun, s
    PUSH_IMPULSE,  # of it, N s
    PUSHES,  # that have ended
    PUSHING,  # 1: a push is under way
    PUSH_LEFT,  # of its impulse, N s
    PUSH,  # force at the hip along x, N
    COUNT,  # touchdowns so far
    OUTCOME,
    RECORD,  # which of its model's records holds for this walk where the callbacks are compiled; see `native`
    PRESSURE_TIMES,  # first of the times by places of the centre of pressure, s; see `records.pressure`
) = range(70)
LAST_TOUCHDOWN = PRESSURE_TIMES + BINS  # first index of the last touchdown's row, in the order of `columns.TOUCHDOWNS`

# of the touchdown's row, each the first of two indices: what the controller is told
TOLD_Q_BEFORE, TOLD_Q, TOLD_DQ = (LAST_TOUCHDOWN + index_of(TOUCHDOWNS, name) for name in ("q_before", "q", "dq"))
ESTIMATE_BEFORE = LAST_TOUCHDOWN + index_of(TOUCHDOWNS, "slope_estimate_before")
ESTIMATE_AFTER = LAST_TOUCHDOWN + index_of(TOUCHDOWNS, "slope_estimate")
CONTROLLER_MEMORY = LAST_TOUCHDOWN + TOUCHED
"""The controller's memory begins here; behind it stand the rates of its integrated states, which end userdata."""

MISSED = 0.02
"""No foot is so far off the ground at its touchdown, or so deep in it, in leg lengths: contacts give 0.01 at most."""
SLID = 1e-3  # leg lengths in a step: a foot that slides farther does not stand
FEWEST_AVERAGED = 5.0  # physics steps in such a stretch, at least: the foot loses contact for single ones
AIRBORNE = (
    0.06  # in sqrt(leg length / gravity): without contact for so long the foot is airborne; sliding hops last half
)


SLIDING_WORDS = (
    f"the stance foot slid by more than {SLID:g} leg lengths in a step: impacts and work there are not those of a foot "
    "that stands"
)

_FINISHED, _FELL = float(Outcome.FINISHED), float(Outcome.FELL)
_STALLED, _SLIPPED = float(Outcome.STALLED), float(Outcome.SLIPPED)
_LEFT_TERRAIN, _DIVERGED = float(Outcome.LEFT_TERRAIN), float(Outcome.DIVERGED)


class State(NamedTuple):
    """How the robot stands and moves.

    Attributes:
        qpos: Hip x, hip z (m), left and right leg (rad).
        qvel: Their rates.
    """

    qpos: Sequence[float]
    qvel: Sequence[float]


def begin(u: MutableSequence[float], state: State, slope: float, foot: tuple[float, float], timestep: float) -> None:
    """Fill zeroed userdata for a walk that starts on the left leg.

    Args:
        u: Userdata.
        state: At the start.
        slope: Of the ground under the stance foot, rad.
        foot: Stance foot, x and z in m.
        timestep: Of the first step, s.
    """
    u[RUNNING] = 1.0
    u[TIME] = -1.0
    u[PLANNED_NEXT] = timestep
    u[NORMAL_FORCE] = u[LEAST_RATIO] = math.inf
    u[PRESSURE_AHEAD] = u[PRESSURE_BEHIND] = -math.inf
    u[SLOPE] = slope
    u[FOOT_X], u[FOOT_Z] = foot
    _, _, u[LEFT], u[RIGHT] = state.qpos
    _, _, u[LEFT_RATE], u[RIGHT_RATE] = state.qvel
    u[FOOT_ANGLE] = u[LEFT]


def observe(u: MutableSequence[float], limits: Limits, profile: Profile, time: float, state: State) -> None:
    """Take in the state at a new time; see the module.

    Args:
        u: Userdata.
        limits: What the walk is judged by.
        profile: The ground.
        time: Now, s; later than the last observation.
        state: Now.
    """
    hip_x, hip_z, left, right = state.qpos
    _, _, left_rate, right_rate = state.qvel
    if u[NOTED]:
        _transfer_support(u, limits, profile, time, state)
    else:
        weigh(u, limits)
    u[TIME] = time
    u[LEFT], u[RIGHT], u[LEFT_RATE], u[RIGHT_RATE] = left, right, left_rate, right_rate

    length = limits.leg_length
    stance, swing = by_role(u, left, right)
    foot_x, foot_z = hip_x - length * math.sin(stance), hip_z - length * math.cos(stance)
    swing_x = hip_x - length * math.sin(swing)
    ahead = swing_x - foot_x
    if swing_foot_is_drawn_in(limits.reach, ahead):
        u[CONTACT_ENABLED] = 0.0
    elif not u[CONTACT_ENABLED]:
        clearance = hip_z - length * math.cos(swing) - height_over(profile, swing_x)
        if swing_foot_collides(limits.reach, limits.delay, time - u[TRANSFER_TIME], ahead, clearance):
            u[CONTACT_ENABLED] = 1.0
    judge(u, limits, profile, time, (hip_x, hip_z), (foot_x, foot_z), stance)


def judge(
    u: MutableSequence[float],
    limits: Limits,
    profile: Profile,
    time: float,
    hip: tuple[float, float],
    foot: tuple[float, float],
    stance: float,
) -> None:
    """Note how far the stance foot has slid, and whether the walk is over.

    Args:
        u: Userdata.
        limits: What the walk is judged by.
        profile: The ground.
        time: Now, s.
        hip: Its place, x and z in m.
        foot: Place of the stance foot, m.
        stance: What stands on it, from the vertical, rad: the foot rolls with that.
    """
    hip_x, hip_z = hip
    foot_x, foot_z = foot
    length, slope = limits.leg_length, u[SLOPE]  # a foot that sinks into the ground, or rolls, does not slip
    distance = (foot_x - u[FOOT_X]) * math.cos(slope) - (foot_z - u[FOOT_Z]) * math.sin(slope)
    slip = abs(distance - limits.rolling_radius * (stance - u[FOOT_ANGLE]))
    up = (foot_x - u[FOOT_X]) * math.sin(slope) + (foot_z - u[FOOT_Z]) * math.cos(slope)
    if slip > u[SLIP]:
        if u[SLIP] <= SLID * length < slip:
            u[SLIDES] += 1.0
        u[SLIP] = slip
    if not u[OUTCOME]:
        if (hip_z - height_over(profile, hip_x)) * math.cos(slope) < FALLEN_HIP * length:
            u[OUTCOME] = _FELL
        elif time - u[TRANSFER_TIME] > limits.stall_time:
            u[OUTCOME] = _STALLED
        elif max(slip, abs(up)) > SLIPPED_FOOT * length:
            u[OUTCOME] = _SLIPPED
        elif up < -MISSED * length and height_over(profile, foot_x) - foot_z > MISSED * length:
            u[OUTCOME] = _DIVERGED  # it has slid under a step
        elif not limits.start < hip_x < limits.end:
            u[OUTCOME] = _LEFT_TERRAIN


def by_role(u: Sequence[float], left: float, right: float) -> tuple[float, float]:
    """What belongs to the left and the right leg, as that of the stance and of the swing leg."""
    return (right, left) if u[STANCE] else (left, right)


def count_work(
    u: MutableSequence[float], legs: tuple[float, float], torque: tuple[float, float], held: bool = False
) -> None:
    """Work of the motors in the step that has led here: the mean of the torques at its ends times what was turned.

    In a leapfrog step's motion that is the work done: the torque of a time acts from the middle of the step before
    to the middle of the step after. The paper's power is τ1 q̇1 + τ2 (q̇2 - q̇1); the ground's slope does not change.

    Args:
        u: Userdata, after the controller's tick.
        legs: Left and right leg at the last observation, rad.
        torque: Of ankle and hip from then on, N m.
        held: Whether motors hold that torque until the next tick, however much it changes there: that of a noisy
            controller would lose half of its work in the mean.
    """
    stance, swing = by_role(u, u[LEFT] - legs[0], u[RIGHT] - legs[1])
    ankle = torque[0] * stance if held else 0.5 * (torque[0] + u[ANKLE]) * stance
    hip = torque[1] * (swing - stance) if held else 0.5 * (torque[1] + u[HIP]) * (swing - stance)
    u[WORK_ABSOLUTE] += abs(ankle) + abs(hip)
    u[WORK_NET] += ankle + hip
    u[WORK_POSITIVE] += (0.0 if ankle < 0.0 else ankle) + (0.0 if hip < 0.0 else hip)


def weigh(u: MutableSequence[float], limits: Limits) -> None:
    """Take the stance foot's force in the physics step before into its averages, and its friction.

    A standing foot loses contact for single physics steps, a sliding one for some milliseconds, and the force of the
    step after makes up for it. So the force is averaged, over stretches of time that end with a step in contact. A foot
    that stays off the ground for longer bears nothing. Of the friction the least counts that some time has: in a step
    of 10 µs, while an impact is being resolved, the foot slides by less than a micrometre at the limit of friction.
    """
    effective_step, force = u[EFFECTIVE_STEP], u[FORCE]
    u[IMPULSE] += effective_step * force
    u[ANKLE_IMPULSE] += effective_step * u[ANKLE]
    u[STRETCH] += effective_step
    u[LEAST_RATIO] = min(u[LEAST_RATIO], u[RATIO])
    u[RATIO_TIME] += effective_step
    if u[RATIO_TIME] >= limits.sustained:
        u[FRICTION] = max(u[FRICTION], u[LEAST_RATIO])
        u[LEAST_RATIO], u[RATIO_TIME] = math.inf, 0.0
    u[WITHOUT_CONTACT] = 0.0 if force > 0.0 else u[WITHOUT_CONTACT] + effective_step
    if u[WITHOUT_CONTACT] >= limits.airborne:
        u[NORMAL_FORCE] = 0.0
    elif force > 0.0 and u[STRETCH] >= limits.averaged:
        average = u[IMPULSE] / u[STRETCH]
        if average < u[NORMAL_FORCE]:
            u[NORMAL_FORCE] = average
        torque, light = u[ANKLE_IMPULSE] / u[STRETCH], LIGHT_CONTACT * limits.weight
        note_pressure(u, PRESSURE_AHEAD, PRESSURE_TIMES, torque, average, light, limits.leg_length, u[STRETCH])
        u[IMPULSE] = u[ANKLE_IMPULSE] = u[STRETCH] = 0.0


def pressure_times(u: Sequence[float]) -> NDArray[np.float64]:
    """How long the centre of pressure was where so far, s; see `mjbiped.records.pressure`."""
    return np.array(u[PRESSURE_TIMES : PRESSURE_TIMES + BINS], dtype=np.float64)


def warned(warnings: Mapping[str, int], u: Sequence[float]) -> dict[str, int]:
    """Warnings of a walk, with that of steps in which the stance foot slid, if there were any."""
    slides = int(u[SLIDES])
    return {**warnings, **({SLIDING_WORDS: slides} if slides else {})}


def least_normal_force(u: Sequence[float]) -> float:
    """Of the step that ends, N; that of a step too short for an average is the mean of what there was, or NaN."""
    if u[NORMAL_FORCE] < math.inf:
        return u[NORMAL_FORCE]
    return u[IMPULSE] / u[STRETCH] if u[STRETCH] > 0.0 else math.nan


def _transfer_support(u: MutableSequence[float], limits: Limits, profile: Profile, time: float, state: State) -> None:
    """Swap the legs' roles and write the touchdown's row; the estimates are not known before the controller's tick.

    No row tells of a foot that is not on the ground: the walk has then diverged.

    The slope is that of the segment that the foot stands on: no contact's normal, which at an edge can be any.
    The contact step itself counts for no work: half of it belongs to either step's roles.
    """
    hip_x, hip_z, left, right = state.qpos
    _, _, left_rate, right_rate = state.qvel
    old, new = by_role(u, left, right)
    old_rate, new_rate = by_role(u, left_rate, right_rate)
    old_before, new_before = by_role(u, u[LEFT_RATE], u[RIGHT_RATE])
    foot_x, foot_z = hip_x - limits.leg_length * math.sin(new), hip_z - limits.leg_length * math.cos(new)
    segment = segment_stood_on(profile, foot_x, foot_z)
    if not abs(foot_z - height_of(profile, segment, foot_x)) <= MISSED * limits.leg_length:
        u[OUTCOME], u[NOTED] = _DIVERGED, 0.0
        return
    u[STANCE] = 1.0 - u[STANCE]
    u[FOOT_X], u[FOOT_Z] = foot_x, foot_z
    slope_before = u[SLOPE]
    slope = -math.atan(profile.gradient[segment])
    u[FOOT_ANGLE] = new
    u[COUNT] += 1.0
    write_touchdown(
        u,
        LAST_TOUCHDOWN,
        time=time,
        qpos=(hip_x, hip_z, left, right),
        x=foot_x,
        z=foot_z,
        stance=u[STANCE],
        slope=slope,
        q_before=(old - slope_before, new - slope_before),
        dq_before=(old_before, new_before),
        q=(new - slope, old - slope),
        dq=(new_rate, old_rate),
        work_absolute=u[WORK_ABSOLUTE],
        work_net=u[WORK_NET],
        work_positive=u[WORK_POSITIVE],
        slip=u[SLIP],
        penetration=u[PENETRATION],
        friction=u[FRICTION],
        strikes=u[FACE_IMPACTS],
        slope_estimate_before=math.nan,
        slope_estimate=math.nan,
        normal_force=least_normal_force(u),
        pressure_ahead=u[PRESSURE_AHEAD],
        pressure_behind=u[PRESSURE_BEHIND],
    )
    u[SLOPE] = slope
    u[TRANSFER_TIME] = time
    u[TRANSFERRED] = 1.0
    u[NOTED] = u[CONTACT_ENABLED] = 0.0
    # until the controller ticks: the lifted leg's ankle is off, the hip's motor goes on
    u[ANKLE], u[HIP] = 0.0, -u[HIP]
    forget_step(u)
    judge_touchdown(u, limits)


def forget_step(u: MutableSequence[float]) -> None:
    """Begin anew what is told of one step alone."""
    u[SLIP] = u[PENETRATION] = u[FRICTION] = u[FACE_IMPACTS] = 0.0
    u[IMPULSE] = u[ANKLE_IMPULSE] = u[STRETCH] = u[WITHOUT_CONTACT] = u[RATIO_TIME] = 0.0
    u[NORMAL_FORCE] = u[LEAST_RATIO] = math.inf
    u[PRESSURE_AHEAD] = u[PRESSURE_BEHIND] = -math.inf


def judge_touchdown(u: MutableSequence[float], limits: Limits) -> None:
    """Note whether the walk is over with the touchdown just counted."""
    if not u[OUTCOME]:
        if u[COUNT] >= limits.steps or u[FOOT_X] >= limits.distance:
            u[OUTCOME] = _FINISHED
        elif u[FOOT_X] >= limits.end:
            u[OUTCOME] = _LEFT_TERRAIN


def read_contacts(u: MutableSequence[float], limits: Limits, stance: Felt, swing: Felt) -> None:
    """Note what the feet feel in the step just resolved."""
    noted = bool(u[CONTACT_ENABLED]) and swing.ground
    u[NOTED] = 1.0 if noted else 0.0
    if u[CONTACT_ENABLED] and swing.face:
        u[FACE_IMPACTS] = 1.0
    if noted:
        u[PENETRATION] = max(u[PENETRATION], swing.depth)
    feel_stance(u, limits, stance, noted)


def feel_stance(u: MutableSequence[float], limits: Limits, stance: Felt, noted: bool) -> None:
    """Note the stance foot's force, friction and depth in the step just resolved, or in that of the touchdown noted."""
    u[FORCE], u[RATIO] = stance.pressure, 0.0
    if stance.ground and not noted:
        u[PENETRATION] = max(u[PENETRATION], stance.depth)
        u[RATIO] = friction_ratio(stance, u[SLOPE], LIGHT_CONTACT * limits.weight)
