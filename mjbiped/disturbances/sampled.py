"""A controller run digitally, with disturbances in the loop between it and the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mjbiped.control.controller import ROOM, Controller, Law, LawController, Memory, never
from mjbiped.control.functions import in_python
from mjbiped.disturbances import loop
from mjbiped.disturbances.disturbances import LONGEST_DELAY, Disturbances


class SampledController(LawController):
    """A controller and its disturbed loop, for an engine that calls `Law.tick`.

    `tick` is called once in each control period, before anything else is asked at that time; `torque` gives what is
    held since then.

    Attributes:
        loop: Parameters of the loop.
    """

    inner: Controller

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
        held = loop.BEGUN + joints
        ring = held + joints + states
        self.memory_size = inner.memory_size + ring + joints * room  # type: ignore[misc]
        self.loop = loop.Loop(
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
            torque_limit=math.inf if given.torque_limit is None else given.torque_limit,
            remaining=math.exp(-lag) if lag else 0.0,
            mean=-math.expm1(-lag) / lag if lag else 0.0,
            sensors=[sensors],
            shown=[0.0] * loop.SHOWN,
            given=[0.0] * (joints + states + ROOM),
        )

    @property
    def plain_law(self) -> Law:
        """The loop's law around the controller's."""
        parameters: Any = self.loop
        functions = loop.torque, loop.touchdown, loop.slope_estimate, never, loop.tick, loop.knee_strike
        return Law(parameters, *functions)

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin a walk; the left leg stands."""
        own = memory[: self.loop.size]
        self.inner.start(own, q, dq)
        memory[: self.loop.size] = own
        memory[self.loop.size + loop.SIDE], memory[self.loop.size + loop.TICKED] = 1.0, -1.0
