"""One physics step of a walk, of MuJoCo's own stages, and what happens between them.

The stages one after the other are bitwise `mujoco.mj_step`. In plain Python they are MuJoCo's functions; what they mean
in machine code stands in `native`.

`mjcb_control`, by which the controller drives the robot, is called by MuJoCo in `forward_from_velocity`. In a loop of
somebody's own `mujoco.mj_step` there is nothing but that callback. It then does in one what stands around the stages
here; contacts are as the state of the step before says, which is 0.1 ms old.
"""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.mujoco.collisions import write_contact_bits
from mjbiped.engines.mujoco.leapfrog import show
from mjbiped.engines.mujoco.lifting import lift
from mjbiped.engines.mujoco.motors import NOW, control
from mjbiped.engines.mujoco.observation import observe
from mjbiped.engines.mujoco.record import keep_touchdown
from mjbiped.engines.mujoco.softness import soften
from mjbiped.engines.mujoco.state import MARK, SIZE, state_at
from mjbiped.engines.mujoco.step_size import resolve
from mjbiped.numerics.blocks import borrowed, give_back, numbers, whole_numbers
from mjbiped.utils.mujoco import mujoco

WARNINGS = int(mujoco.mjtWarning.mjNWARNING)
MANY = 1 << 60


def advance(c: Any, model: Any, data: Any, steps: int, until: float) -> int:
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


def advance_ticks(c: Any, model: Any, data: Any, ticks: int) -> None:
    """Make steps from one tick of the controller to a later one, or until the walk ends."""
    u = state_at(c.state, 0)
    for _ in range(ticks):
        advance(c, model, data, 1, math.inf)  # in which it ticks
        advance(c, model, data, MANY, u.next_control)


def look_ahead(c: Any, ahead: Any) -> None:
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


def step(c: Any, u: Any, model: Any, data: Any) -> None:
    """Make one step."""
    time = numbers(c.time, 1)[0]
    if time > u.time:
        arrive(c, u, time)
    soften(c, u)
    write_contact_bits(c, u)
    check(model, data)
    position(model, data)
    qvel = numbers(c.qvel, c.coordinates)
    show(c, u, qvel)
    velocity(model, data)
    for index in range(c.coordinates):
        qvel[index] = u.qvel[index]
    forward_from_velocity(model, data)
    resolve(c, u, u.softened, 1.0)
    integrate(model, data)


def arrive(c: Any, u: Any, time: float) -> None:
    """Take in the state at a new time (s): the controller's states, touchdowns, and the walk's end."""
    if u.time >= 0.0:
        memory, rates = borrowed(c.memory, c.memory_size), numbers(c.rates, c.states)
        for index in range(c.states):
            memory[index] += (time - u.time) * rates[index]
        give_back(c.memory, memory)
    if u.transferred and u.noted:
        keep_touchdown(c, u)  # of which the controller is never told
    observe(c, u, time)


def on_control(c: Any, time: float) -> None:
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


def recall(c: Any) -> None:
    """Have the accelerations of the step before where another state has been set, and no contact forces.

    MuJoCo's states have neither; but they have the accelerations as the solver's next guess.
    """
    qacc, kept = numbers(c.qacc, c.coordinates), numbers(c.warmstart, c.coordinates)
    readings, another = numbers(c.readings, c.sensed), False
    for index in range(c.coordinates):
        another = another or qacc[index] != kept[index]
        qacc[index] = kept[index]
    if another:
        for index in range(c.sensed):
            readings[index] = 0.0


def warned(c: Any) -> bool:
    """Whether MuJoCo has warned of anything in this walk."""
    warnings = whole_numbers(c.warnings, 2 * WARNINGS)
    count = 0
    for kind in range(WARNINGS):
        count += warnings[2 * kind + 1]
    return bool(count != 0)


def check(model: Any, data: Any) -> None:
    """Look for positions and rates that are no numbers."""
    mujoco.mj_checkPos(model, data)
    mujoco.mj_checkVel(model, data)


def position(model: Any, data: Any) -> None:
    """Kinematics, collisions, constraints, and sensors of positions."""
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_sensorPos(model, data)


def velocity(model: Any, data: Any) -> None:
    """Coriolis forces, the constraints' reference accelerations, and sensors of velocities."""
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_sensorVel(model, data)


def forward_from_velocity(model: Any, data: Any) -> None:
    """`mjcb_control`, forces of motors, accelerations, contact forces, and their sensors."""
    mujoco.mj_forwardSkip(model, data, mujoco.mjtStage.mjSTAGE_VEL, 0)


def integrate(model: Any, data: Any) -> None:
    """Look for accelerations that are no numbers, and move the robot."""
    mujoco.mj_checkAcc(model, data)
    mujoco.mj_Euler(model, data)
