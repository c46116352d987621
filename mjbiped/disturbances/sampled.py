"""A controller run digitally, with disturbances in the loop between it and the robot."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

from mjbiped.control import adapters
from mjbiped.control.compiled import MachineCode, compilable_law, refused_in_words
from mjbiped.control.controller import ROOM, Controller, Law, Memory
from mjbiped.disturbances import loop as laws
from mjbiped.disturbances.disturbances import LONGEST_DELAY, Disturbances
from mjbiped.disturbances.loop import Loop


class SampledController(Controller):
    """A controller and its disturbed loop, for an engine that calls `tick`.

    `tick` is called once in each control period, before anything else is asked at that time; `torque` gives what is
    held since then.

    Attributes:
        inner: The controller proper.
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
        self.inner = inner
        # class variables of other laws; of this class there is an object for each controller
        self.states = inner.states  # type: ignore[misc]
        self.joints = inner.joints  # type: ignore[misc]
        self.support = inner.support  # type: ignore[misc]
        self.robot, self.gait = inner.robot, inner.gait
        room = LONGEST_DELAY + 1 if delay else 0
        held = laws.BEGUN + joints
        ring = held + joints + states
        shown = ring + joints * room
        self.memory_size = inner.memory_size + shown + laws.SHOWN + joints + states + ROOM  # type: ignore[misc]
        self.loop = Loop(
            size=inner.memory_size,
            joints=joints,
            held=held,
            rates=held + joints,
            states=states,
            ring=ring,
            room=room,
            delay=delay,
            shown=shown,
            senses=any(sensors[:-1]),
            sensors=sensors,
            torque_limit=math.inf if given.torque_limit is None else given.torque_limit,
            remaining=math.exp(-lag) if lag else 0.0,
            mean=-math.expm1(-lag) / lag if lag else 0.0,
        )

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin a walk; the left leg stands."""
        self._tell(self.inner.start, memory, q, dq)
        memory[self.loop.size + laws.SIDE] = 1.0

    def tick(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Read the sensors, ask the controller, and set the torques that are held."""
        laws.tick(self._ask, self.inner, self.loop, memory, t, q, dq)

    def _ask(
        self, inner: Controller, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float], place: int
    ) -> None:
        values = adapters.torque(inner, memory[: self.loop.size], t, tuple(q), tuple(dq))
        memory[place : place + len(values)] = values

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Torques and rates of states that are held since the last tick."""
        first = self.loop.size + self.loop.held
        return tuple(memory[first : first + self.loop.joints + self.loop.states])

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Exchange the motors' roles, and pass the posture that the sensors show to the controller."""
        laws.touchdown(self._tell, self.inner.on_touchdown, self.loop, memory, q_before, q, dq)

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Pass the state that the sensors show to the controller."""
        laws.knee_strike(self._tell, self.inner.on_knee_strike, self.loop, memory, t, q, dq)

    def slope_estimate(self, memory: Memory) -> float:
        """The controller's estimate of the slope, rad."""
        return self.inner.slope_estimate(memory[: self.loop.size])

    def _tell(self, method: Callable[..., None], memory: Memory, *arguments: Any) -> None:
        """Call a method of the controller, which changes its own part of the memory."""
        own = list(memory[: self.loop.size])
        method(own, *(each if isinstance(each, float) else tuple(each) for each in arguments))
        memory[: self.loop.size] = own

    @cached_property
    def _code(self) -> MachineCode | None:
        """Machine code of the inner controller, called by address; None where its laws cannot be compiled."""
        law = compilable_law(self.inner)
        if law is None:
            return None
        with refused_in_words(self.inner, law):
            return MachineCode(law, self.loop.states, self.loop.size, joints=self.loop.joints)

    def law(self) -> Law | None:
        """The loop's laws around the controller's machine code; None where there is none."""
        if self._code is None:
            return None
        from mjbiped.disturbances import compiled

        return compiled.law_of(self._code.law, self.loop)
