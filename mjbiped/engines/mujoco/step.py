r"""One physics step of a walk: MuJoCo's own stages, and the operations between them.

The stages one after the other are bitwise `mujoco.mj_step`. `callback` defines them for machine code.

`mjcb_control`, by which the controller drives the robot, is called by MuJoCo in `mj_forwardSkip`. In a user's
own loop of `mujoco.mj_step` only that callback runs. It then does all the operations at once, with contacts as of the
state one step before, which is 0.1 ms old.

**Second order.** MuJoCo's Euler step, with the accelerations a that the solver found at its beginning,

.. math:: v' = v + k \, a, \qquad x' = x + t \, v'

is a leapfrog: v' belongs to the middle of the step, and all that MuJoCo computes from the rates would be half a step
late. The current rates are v + t a / 2, with t and a of the step before. The controller and the
record receive them, and MuJoCo's Coriolis forces are computed from them. Where a sliding foot loses the ground and
touches it again, a is an impulse over t, which v already contains. So a may differ from the acceleration of the step
before by no more than the size of that acceleration and g / l, as with slope limiters.

**Held foot.** A contact's damping of 1 / k brings the foot's velocity J v' to rest, with J of the step's *beginning*:
MuJoCo's reference acceleration leaves the change of J out. When the leg turns by t dq, a foot at rest therefore moves
by t² l dq² / 2 in each step: upward, until its contact is lost, and backward. Moreover, damping stops the lowest point
of the foot's sphere, so that the sphere rolls on. So the solver is shown a velocity that is larger by the effect of the
turning and by the velocity of a rolling sphere's centre. It removes both, and the foot stays in place.

MuJoCo reads `qvel` in its velocity stage, for the Coriolis forces and the contacts' damping, and again in the
integrator. So the velocity stage alone is *shown* other rates. They differ from the state's rates by the lag of the
legs, and by a velocity of the hip, of which no Coriolis force depends. An impact's step is MuJoCo's own.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from mjbiped.engines.mujoco.collisions import lift, soften, write_contact_bits
from mjbiped.engines.mujoco.constants import Constants, stance_leg, turning_of
from mjbiped.engines.mujoco.motors import NOW, control, keep_touchdown
from mjbiped.engines.mujoco.observation import observe
from mjbiped.engines.mujoco.state import MARK, SIZE, State, X, Z, state_at
from mjbiped.engines.mujoco.step_size import resolve
from mjbiped.numerics.blocks import borrowed, give_back, numbers, whole_numbers
from mjbiped.utils.mujoco import mujoco

WARNINGS = int(mujoco.mjtWarning.mjNWARNING)
VELOCITY = int(mujoco.mjtStage.mjSTAGE_VEL)
MANY = 1 << 60


def advance(c: Constants, model: object, data: object, steps: int, until: float) -> int:
    """Make steps until the walk ends, MuJoCo warns, or the record or the time is full.

    Args:
        c: The walk's `Constants`.
        model: The mjModel.
        data: The mjData.
        steps: Number of steps, at most.
        until: Time from which on no step begins, s.

    Returns:
        Number of steps that were made.
    """
    u, time = state_at(c.state, 0), numbers(c.time, 1)
    for made in range(steps):
        if u.mark != MARK or u.outcome or warned(c) or time[0] > until - NOW:
            return made
        step(c, u, model, data)
    return steps


def advance_ticks(c: Constants, model: object, data: object, ticks: int) -> None:
    """Make steps from one tick of the controller to a later one, or until the walk ends."""
    u = state_at(c.state, 0)
    for _ in range(ticks):
        advance(c, model, data, 1, math.inf)  # in which it ticks
        advance(c, model, data, MANY, u.next_control)


def look_ahead(c: Constants, ahead: Constants) -> None:
    """Say on a copy of the state what the controller will be told at its next tick, and whether the walk is over.

    Args:
        c: The walk's `Constants`.
        ahead: The same, but for the state and the row of the last touchdown, which are overwritten.
    """
    count = SIZE + c.row_width
    source, into = numbers(c.whole, count), numbers(ahead.whole, count)
    for index in range(count):
        into[index] = source[index]
    seen, time = state_at(ahead.state, 0), numbers(c.time, 1)[0]
    if seen.mark == MARK and not seen.outcome and time > seen.time and not warned(c):
        observe(ahead, seen, time)


def step(c: Constants, u: State, model: object, data: object) -> None:
    """Make one step."""
    time = numbers(c.time, 1)[0]
    if time > u.time:
        arrive(c, u, time)
    soften(c, u)
    write_contact_bits(c, u)
    mujoco.mj_checkPos(model, data)
    mujoco.mj_checkVel(model, data)
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_sensorPos(model, data)
    qvel = numbers(c.qvel, c.nq)
    show(c, u, qvel)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_sensorVel(model, data)
    for index in range(c.nq):
        qvel[index] = u.qvel[index]
    mujoco.mj_forwardSkip(model, data, VELOCITY, 0)  # calls `mjcb_control`
    resolve(c, u, u.softened, 1.0)
    mujoco.mj_checkAcc(model, data)
    mujoco.mj_Euler(model, data)


def arrive(c: Constants, u: State, time: float) -> None:
    """Take in the state at a new time (s): the controller's states, touchdowns, and the walk's end."""
    if u.time >= 0.0:
        memory, rates = borrowed(c.memory, c.memory_size), numbers(c.rates, c.states)
        for index in range(c.states):
            memory[index] += (time - u.time) * rates[index]
        give_back(c.memory, memory)
    if u.transferred and u.noted:
        keep_touchdown(c, u)  # of which the controller is never told
    observe(c, u, time)


def on_control(c: Constants, time: float) -> None:
    """`mjcb_control` of a walk at a time (s)."""
    u = state_at(c.state, 0)
    if u.mark != MARK:
        return
    if time > u.time:  # in a loop of somebody's own
        if u.time >= 0.0:
            recall(c)
            resolve(c, u, u.acted, 2.0)
        arrive(c, u, time)
        control(c, u, time)
        lift(c, u, c.longest)  # what is written here acts in the next step
        soften(c, u)
        write_contact_bits(c, u)
    else:
        control(c, u, time)


def recall(c: Constants) -> None:
    """Have the accelerations of the step before where another state has been set, and no contact forces.

    MuJoCo's states have neither; but they have the accelerations as the solver's next guess.
    """
    qacc, kept = numbers(c.qacc, c.nq), numbers(c.qacc_warmstart, c.nq)
    readings, another = numbers(c.sensordata, c.nsensordata), False
    for index in range(c.nq):
        another = another or qacc[index] != kept[index]
        qacc[index] = kept[index]
    if another:
        for index in range(c.nsensordata):
            readings[index] = 0.0


def warned(c: Constants) -> bool:
    """Whether MuJoCo has warned of anything in this walk."""
    warnings = whole_numbers(c.warnings, 2 * WARNINGS)
    count = 0
    for kind in range(WARNINGS):
        count += warnings[2 * kind + 1]
    return bool(count != 0)


def show(c: Constants, u: State, qvel: MutableSequence[float]) -> None:
    """Let rates be what MuJoCo's velocity stage is to see, so that the stance foot ends the step where it was.

    Args:
        c: The walk's constants.
        u: State, after the observation of this time.
        qvel: The robot's rates, to be changed.
    """
    if u.plain:
        return
    stance, slope, length = stance_leg(c, u), u.old_slope if c.scuffs else u.slope, u.planned
    turning, lag = turning_of(stance, qvel, u.share), turning_of(stance, u.lag, u.share)
    leg = u.q[stance.hip] + stance.offset + u.tilt
    if u.last_step > 0.0:
        turning += lag * (1.0 + length / u.last_step)  # in the middle of this step, by the acceleration before it
    sine, cosine = math.sin(leg), math.cos(leg)
    turned = leg + length * turning
    # what turning makes of the foot's velocity: in the mean of the step, less what it seems to make at its beginning
    mean_x, mean_z = (sine - math.sin(turned)) / length, (cosine - math.cos(turned)) / length
    # of the sphere beyond the foot, and of the foot by what it is shown more than it turns
    rolling = c.foot_radius * turning + c.rolling_radius * lag
    for index in range(2, c.nq):
        qvel[index] += u.lag[index]
    qvel[X] += u.reach * (mean_x + cosine * (turning + lag)) + rolling * math.cos(slope)
    qvel[Z] += u.reach * (mean_z - sine * (turning + lag)) - rolling * math.sin(slope)
