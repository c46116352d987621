"""A disturbed control loop at its ticks, at touchdowns and at knee strikes, as functions of blocks and arrays.

They are the law of `SampledController`, in plain Python and as machine code. The loop's own memory stands behind the
controller's: `at` counts from there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

from mjbiped.control.controller import ROOM, Controller, Law, LawController, Memory, Numbers, Room, never
from mjbiped.control.functions import acts_at_ticks, in_python
from mjbiped.disturbances.chance import MOST, STRIKE, TICK, TOUCHDOWN, Sensors, posture_before, sensed
from mjbiped.disturbances.disturbances import LONGEST_DELAY, Disturbances
from mjbiped.numerics.blocks import Floats, call, call_for_float, numbers, reader

(
    TICKS,  # so far
    TOUCHDOWNS,  # so far
    SIDE,  # 1: the left leg stands, -1: the right one
    TICKED,  # time of the last tick in this gait step, s; negative: no tick since the touchdown or knee strike
    BEGUN,  # first of the torques that the motors have at the tick's beginning, N m, one for each joint
) = range(5)

SHOWN = 3 * MOST
"""Room for what the sensors show."""


class Loop(NamedTuple):
    """Parameters of a disturbed loop.

    Attributes:
        inner: The law of the controller in the loop.
        size: Number of floats of the controller's memory; the loop's memory begins behind them.
        joints: Number of motors: ankle, hip and, with knees, the swing knee.
        held: Index in the loop's memory of the torques held until the next tick, N m.
        rates: Index of the held rates of the controller's integrated states, right behind the torques.
        states: Number of integrated states.
        ring: Index in the loop's memory of the delayed torques, those of all joints in turn.
        room: Number of ticks whose torques the ring holds.
        delay: Number of ticks until a torque acts.
        senses: Whether the sensors differ from the truth.
        ticks: Whether the controller itself acts at ticks; see `Controller.on_tick`.
        torque_limits: Greatest torque of each joint's motor, N m; infinity: none.
        remaining: Fraction of the difference between commanded and actual torque that is left after a tick; 0: no lag.
        mean: Mean of that fraction over the tick.
        sensors: Errors of the sensors.
        shown: Room for what the sensors show, `SHOWN` numbers: angles (rad), rates (rad/s), and at a touchdown the
            angles in the old roles.
        given: Room for what the controller's law writes.
    """

    inner: Sequence[Law]
    size: int
    joints: int
    held: int
    rates: int
    states: int
    ring: int
    room: int
    delay: int
    senses: bool
    ticks: bool
    torque_limits: Sequence[float]
    remaining: float
    mean: float
    sensors: Sequence[Sensors]
    shown: Floats
    given: Floats


law_at, sensors_at = reader(Law), reader(Sensors)


def tick(loop: Loop, memory: Room, t: float, q: Numbers, dq: Numbers) -> None:
    """Read the sensors, ask the controller, and set the torques that are held until the next tick.

    The controller's states have changed by the rates of the tick before all the time: now the mean of both ticks' rates
    counts, unless a touchdown or a knee strike lies between the ticks.

    Args:
        loop: The `Loop`.
        memory: Memory, changed in place.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    at = loop.size
    given = numbers(loop.given, loop.joints + loop.states + ROOM)
    if loop.senses:
        number, n, shown = int(memory[at + TICKS]), len(q), numbers(loop.shown, SHOWN)
        sensed(sensors_at(loop.sensors, 0), memory[at + SIDE], (number, TICK), q, dq, shown, 0)
        _ask(loop, memory, t, shown[:n], shown[MOST : MOST + n], given)
    else:
        _ask(loop, memory, t, q, dq, given)
    for joint in range(loop.joints):
        _drive(loop, memory, joint, given[joint])
    since = t - memory[at + TICKED] if memory[at + TICKED] >= 0.0 else 0.0
    for index in range(loop.states):
        rate, held = given[loop.joints + index], at + loop.rates + index
        memory[index] += 0.5 * since * (rate - memory[held])
        memory[held] = rate
    memory[at + TICKED] = t
    memory[at + TICKS] += 1.0


def _ask(loop: Loop, memory: Room, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    """Let the controller act at its tick, and write its torques and rates of states."""
    law = law_at(loop.inner, 0)
    if loop.ticks:
        call(law.tick, law.parameters, memory, t, q, dq)
    call(law.torque, law.parameters, memory, t, q, dq, out)


def torque(loop: Loop, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:  # noqa: ARG001
    """Write the torques and rates of states that are held since the last tick."""
    first = loop.size + loop.held
    for index in range(loop.joints + loop.states):
        out[index] = memory[first + index]


def slope_estimate(loop: Loop, memory: Memory) -> float:
    """The controller's estimate of the slope, rad."""
    law = law_at(loop.inner, 0)
    return call_for_float(law.slope_estimate, law.parameters, memory)


def _drive(loop: Loop, memory: Room, joint: int, torque: float) -> None:
    """Pass a commanded torque through the motor's limit, delay and lag."""
    at = loop.size
    number, limit = int(memory[at + TICKS]), numbers(loop.torque_limits, loop.joints)[joint]
    asked, begun, held = limited(torque, limit), at + BEGUN + joint, at + loop.held + joint
    if loop.delay > 0:
        first = at + loop.ring + joint
        memory[first + loop.joints * (number % loop.room)] = asked
        asked = memory[first + loop.joints * ((number - loop.delay) % loop.room)]  # zeros at the beginning
    if loop.remaining > 0.0:
        memory[held] = limited(asked + (memory[begun] - asked) * loop.mean, limit)
        memory[begun] = asked + (memory[begun] - asked) * loop.remaining
    else:
        memory[held] = asked


def touchdown(loop: Loop, memory: Room, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    """Exchange the motors' roles at a support transfer, read the sensors, and tell the controller.

    The motors are those of the hip and of each leg's ankle and knee: what still waits for the ankle that leaves the
    ground, or for the knee that is locked now, moves nothing, and a torque between the legs has the other sign in
    their new roles.

    Args:
        loop: The `Loop`.
        memory: Memory, changed in place.
        q_before: Angles in the old roles, rad.
        q: Angles in the new ones, rad.
        dq: Their rates, rad/s.
    """
    at, n, law, shown = loop.size, len(q), law_at(loop.inner, 0), numbers(loop.shown, SHOWN)
    number, side, before = int(memory[at + TOUCHDOWNS]), -memory[at + SIDE], 2 * MOST
    memory[at + TOUCHDOWNS], memory[at + SIDE], memory[at + TICKED] = number + 1.0, side, -1.0
    for first in (at + BEGUN, at + loop.held):
        _reassign(loop, memory, first)
    for tick in range(loop.room):
        _reassign(loop, memory, at + loop.ring + loop.joints * tick)
    if not loop.senses:
        call(law.touchdown, law.parameters, memory, q_before, q, dq)
        return
    sensors = sensors_at(loop.sensors, 0)
    posture_before(sensors, side, number, q_before, q, shown, before)
    sensed(sensors, side, (number, TOUCHDOWN), q, dq, shown, 0)
    call(law.touchdown, law.parameters, memory, shown[before : before + n], shown[:n], shown[MOST : MOST + n])


def knee_strike(loop: Loop, memory: Room, t: float, q: Numbers, dq: Numbers) -> None:
    """Read the sensors when the swing knee strikes its stop, and tell the controller; motors hold their torques.

    Args:
        loop: The `Loop`.
        memory: Memory, changed in place.
        t: Time since the support transfer, s.
        q: Angles, rad.
        dq: Their rates, rad/s.
    """
    n, law, shown = len(q), law_at(loop.inner, 0), numbers(loop.shown, SHOWN)
    memory[loop.size + TICKED] = -1.0
    if not loop.senses:
        call(law.knee_strike, law.parameters, memory, t, q, dq)
        return
    number = int(memory[loop.size + TOUCHDOWNS])
    sensed(sensors_at(loop.sensors, 0), memory[loop.size + SIDE], (number, STRIKE), q, dq, shown, 0)
    call(law.knee_strike, law.parameters, memory, t, shown[:n], shown[MOST : MOST + n])


def _reassign(loop: Loop, memory: Room, first: int) -> None:
    """Exchange the roles of the torques of ankle, hip and swing knee, as many as there are, from an index on."""
    for joint in range(loop.joints):
        memory[first + joint] = -memory[first + joint] if joint == 1 else 0.0


def limited(torque: float, limit: float) -> float:
    """Clip a torque to a motor's limit in both directions, N m; NaN stays NaN."""
    if torque > limit:
        return limit
    return -limit if torque < -limit else torque


class Around(LawController):
    """A controller put around another one, whose memory is the first part of its own.

    Attributes:
        inner: The other controller.
    """

    inner: Controller

    def _surround(self, inner: Controller, more: int) -> None:
        """Take over what another controller has, with a memory of so many numbers more."""
        own = {name: getattr(inner, name) for name in ("states", "joints", "support", "robot", "gait")}
        for name, value in {**own, "inner": inner, "memory_size": inner.memory_size + more}.items():
            object.__setattr__(self, name, value)

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Start the other controller; the memory's further numbers stay zero."""
        own = memory[: self.inner.memory_size]
        self.inner.start(own, q, dq)
        memory[: self.inner.memory_size] = own


class SampledController(Around):
    """A controller run digitally, with disturbances in the loop between it and the robot.

    `tick` is called once in each control period, before anything else is asked at that time; `torque` gives what is
    held since then.

    Attributes:
        loop: Parameters of the loop.
    """

    def __init__(self, inner: Controller, disturbances: Disturbances, period: float) -> None:
        """Put the disturbances around a controller.

        Args:
            inner: The controller.
            disturbances: The disturbances.
            period: Time between two ticks, s.

        Raises:
            InputError: The delay does not fit the period.
        """
        given, states, joints = disturbances, len(inner.states), len(inner.joints)
        sensors = given.sensors
        delay = given.delay_ticks(period)
        lag = 0.0 if given.motor_bandwidth is None else 2.0 * math.pi * given.motor_bandwidth * period
        room = LONGEST_DELAY + 1 if delay else 0
        held = BEGUN + joints
        ring = held + joints + states
        self._surround(inner, ring + joints * room)
        self.loop = Loop(
            inner=[in_python(inner)],
            size=inner.memory_size,
            joints=joints,
            held=held,
            rates=held + joints,
            states=states,
            ring=ring,
            room=room,
            delay=delay,
            senses=any(sensors[:5]),
            ticks=acts_at_ticks(inner),
            torque_limits=given.torque_limits(inner.joints),
            remaining=math.exp(-lag) if lag else 0.0,
            mean=-math.expm1(-lag) / lag if lag else 0.0,
            sensors=[sensors],
            shown=[0.0] * SHOWN,
            given=[0.0] * (joints + states + ROOM),
        )

    @cached_property
    def plain_law(self) -> Law:
        """The loop's law around the controller's."""
        parameters: Any = self.loop
        return Law(parameters, torque, touchdown, slope_estimate, never, tick, knee_strike)

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Begin a walk; the left leg stands."""
        super().start(memory, q, dq)
        memory[self.loop.size + SIDE], memory[self.loop.size + TICKED] = 1.0, -1.0
