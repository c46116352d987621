"""One physics step of a walk, of MuJoCo's own stages, and what happens between them.

The stages one after the other are bitwise `mujoco.mj_step`. What they mean in machine code stands in `native`.

`mjcb_control`, by which the controller drives the robot, is called by MuJoCo in `mj_forwardSkip`. In a loop of
somebody's own `mujoco.mj_step` there is nothing but that callback. It then does in one what stands around the stages
here; contacts are as the state of the step before says, which is 0.1 ms old.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.mujoco.collisions import lift, write_contact_bits
from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.leapfrog import show
from mjbiped.engines.mujoco.motors import NOW, control
from mjbiped.engines.mujoco.observation import observe
from mjbiped.engines.mujoco.record import keep_touchdown
from mjbiped.engines.mujoco.softness import soften
from mjbiped.engines.mujoco.state import MARK, SIZE, State, state_at
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


def look_ahead(c: Constants, ahead: Any) -> None:
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
