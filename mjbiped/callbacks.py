"""What MuJoCo's callbacks do in a walk, as functions of plain numbers: the same source as Python and compiled.

`mjbiped.physics` calls them with lists from Python callbacks, `mjbiped.native` compiles them into C callbacks that work
on MuJoCo's own arrays. They allocate nothing and know neither MuJoCo's objects nor a controller's.
"""

from __future__ import annotations

from collections.abc import Callable, MutableSequence, Sequence
from typing import Any, NamedTuple

from mjbiped import events
from mjbiped.events import Limits
from mjbiped.profile import Floats, Profile, height_over


class World(NamedTuple):
    """What does not change in a walk, beside the controller's parameters.

    Attributes:
        limits: What the walk is judged by.
        profile: The ground.
        feet: Geoms of the left and the right foot.
        contacts: Places in the sensor data where the left and the right foot's contacts begin.
        slots: Floats of one foot's contacts.
        risers: 1 for each geom that is a riser, 0 for the others.
        deepest: No foot is deeper in the ground than this in the first step of a contact, m.
        control_period: Time between two ticks of the controller, s.
        memory_size: Floats of the controller's memory.
    """

    limits: Limits
    profile: Profile
    feet: tuple[int, int]
    contacts: tuple[int, int]
    slots: int
    risers: Floats
    deepest: float
    control_period: float
    memory_size: int


class Laws(NamedTuple):
    """A controller's functions; see `controllers.Law` and `mjbiped.laws`."""

    torque: Callable[..., Sequence[float]]
    touchdown: Callable[..., None]
    slope_estimate: Callable[..., float]


def control(
    laws: Laws,
    parameters: Any,
    world: World,
    timestep: float,
    u: MutableSequence[float],
    memory: MutableSequence[float],
    ctrl: MutableSequence[float],
    time: float,
    qpos: Sequence[float],
    qvel: Sequence[float],
) -> bool:
    """`mjcb_control`: one tick per new time; a second call at the same time changes nothing.

    Args:
        laws: The controller's.
        parameters: Theirs.
        world: The walk's.
        timestep: Of the physics, s.
        u: Userdata up to the controller's memory.
        memory: The controller's memory.
        ctrl: To be filled: left ankle, right ankle, hip, N m.
        time: Now, s.
        qpos: Hip x, hip z (m), left and right leg (rad).
        qvel: Their rates.

    Returns:
        Whether anything was changed.
    """
    if not (u[events.RUNNING] and time > u[events.TIME]):
        return False
    events.observe(u, world.limits, world.profile, time, qpos, qvel)
    due = time > u[events.NEXT_CONTROL] - timestep / 2.0
    if due or (u[events.TOUCHED] and u[events.OUTCOME]):  # the last touchdown is told at once: its row is whole
        _tick(laws, parameters, world, u, memory, time)
    right = bool(u[events.STANCE])
    ctrl[0] = 0.0 if right else u[events.ANKLE]
    ctrl[1] = u[events.ANKLE] if right else 0.0
    ctrl[2] = -u[events.HIP] if right else u[events.HIP]
    return True


def _tick(
    laws: Laws,
    parameters: Any,
    world: World,
    u: MutableSequence[float],
    memory: MutableSequence[float],
    time: float,
) -> None:
    """One tick of the digital controller: its events, its law, and one Euler step of its integrated states."""
    slope = u[events.SLOPE]
    if u[events.STANCE]:
        q1, q2 = u[events.RIGHT] - slope, u[events.LEFT] - slope
        dq1, dq2 = u[events.RIGHT_RATE], u[events.LEFT_RATE]
    else:
        q1, q2 = u[events.LEFT] - slope, u[events.RIGHT] - slope
        dq1, dq2 = u[events.LEFT_RATE], u[events.RIGHT_RATE]
    if u[events.TOUCHED]:
        u[events.TOUCHED] = 0.0
        u[events.ESTIMATE_BEFORE] = laws.slope_estimate(parameters, memory)
        # the contact switch holds the touchdown's posture and time for a controller that ticks later
        laws.touchdown(
            parameters,
            memory,
            u[events.TOLD_Q_BEFORE],
            u[events.TOLD_Q_BEFORE + 1],
            u[events.TOLD_Q],
            u[events.TOLD_Q + 1],
            u[events.TOLD_DQ],
            u[events.TOLD_DQ + 1],
        )
        u[events.ESTIMATE_AFTER] = laws.slope_estimate(parameters, memory)
    values = laws.torque(parameters, memory, time - u[events.EXCHANGE_TIME], q1, q2, dq1, dq2)
    for index in range(len(values) - 2):
        memory[index] += world.control_period * values[2 + index]
    ankle, hip = values[0], values[1]
    u[events.ANKLE], u[events.HIP] = ankle, hip
    if not u[events.OUTCOME]:
        if abs(ankle) > u[events.PEAK_ANKLE]:
            u[events.PEAK_ANKLE] = abs(ankle)
        if abs(hip) > u[events.PEAK_HIP]:
            u[events.PEAK_HIP] = abs(hip)
    u[events.NEXT_CONTROL] = time + world.control_period


def sense(world: World, u: MutableSequence[float], readings: Sequence[float]) -> None:
    """`mjcb_sensor` at the acceleration stage, after MuJoCo has filled its own contact sensors.

    Args:
        world: The walk's.
        u: Userdata.
        readings: Sensor data.
    """
    if not u[events.RUNNING]:
        return
    stance = 1 if u[events.STANCE] else 0
    own, other = world.contacts[stance], world.contacts[1 - stance]
    events.feel(u, world.limits, readings[own : own + world.slots], readings[other : other + world.slots])


def refuses(world: World, u: Sequence[float], places: Any, first: int, second: int) -> bool:
    """`mjcb_contactfilter`: whether a pair of geoms does not collide.

    The swing foot passes through everything until it is armed (scuffing rule); the stance foot passes through
    risers, and through the ground from the step on that resolves the other foot's touchdown, as it does after the
    exchange. A solver with a convex friction cone would drag a foot that leaves the ground obliquely.

    Args:
        world: The walk's.
        u: Userdata.
        places: Of all geoms, an array of shape (geoms, 3), m.
        first: One geom.
        second: The other.
    """
    if not u[events.RUNNING]:
        return False
    right = 1 if u[events.STANCE] else 0
    stance, swing = world.feet[right], world.feet[1 - right]
    armed = bool(u[events.ARMED])
    if swing in (first, second):
        return not armed
    if not armed or stance not in (first, second):
        return False
    if world.risers[first] or world.risers[second]:
        return True
    return bool(-world.deepest < places[swing, 2] - height_over(world.profile, places[swing, 0]) < 0.0)
