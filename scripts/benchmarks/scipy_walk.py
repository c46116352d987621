"""The hybrid walk as it is commonly written: `scipy.integrate.solve_ivp` from touchdown to touchdown.

What the benchmark measures the hybrid engine against, and an independent reference for its accuracy: integrator, event
search and loop are SciPy's and Python's. The right-hand side and the guard are compiled, so that only the way of
integrating differs. It does less than the engine: no absolute work, no peaks, no friction, no falls, no risers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from controllers import Controller
from mjbiped.control.controller import ROOM
from mjbiped.numerics.blocks import numbers, packed, reader
from mjbiped.numerics.machine import compiled
from mjbiped.robots.compass import Compass, acceleration
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

LONGEST = 3.0  # s, of a gait step


class Known(NamedTuple):
    """What stays fixed within a gait step.

    Attributes:
        parameters: Of the control law.
        length: Number of parameters.
        constants: Of the robot.
        memory: Of the controller.
        size: Any of the memory.
        states: Number of the controller's integrated states.
        made: Room for what its law writes.
        now: Time (s), sine and cosine of the slope, the slope (rad), stance foot x and z (m).
        rule: Leg length, reach (m) and delay (s) of the scuffing rule.
        x: Starts of the terrain's segments, m.
        z: Heights there, m.
        gradient: dz/dx.
        segments: Number of segments.
    """

    parameters: Any
    length: int
    constants: Any
    memory: Any
    size: int
    states: int
    made: Any
    now: Any
    rule: Any
    x: Any
    z: Any
    gradient: Any
    segments: int


known_at = reader(Known)


class ScipyWalk:
    """A walk on ground without risers."""

    def __init__(self, controller: Controller, terrain: Terrain, robot: Compass, *, tolerance: float) -> None:
        """Compile the right-hand side and the guard.

        Args:
            controller: One that gives its law.
            terrain: The ground.
            robot: Who walks.
            tolerance: rtol and atol of `solve_ivp`.
        """
        law, rule = controller.law(), ScuffingRule()
        assert law is not None
        self.controller, self.terrain, self.robot, self.tolerance = controller, terrain, robot, tolerance
        taken = "(int64, float64[::1], float64[::1])"
        self._rates = compiled(rates_by(law.torque), f"void{taken}")
        self._clearance = compiled(clearance, f"void{taken}")
        parameters = np.array(law.parameters, dtype=np.float64)
        self._known = Known(
            parameters,
            len(parameters),
            robot.constants,
            np.zeros(controller.memory_size),
            controller.memory_size,
            len(controller.states),
            np.zeros(2 + len(controller.states) + ROOM),
            np.zeros(6),
            (robot.leg_length, rule.reach * robot.leg_length, rule.delay),
            terrain.x,
            terrain.z,
            terrain.gradients,
            len(terrain.x),
        )
        self._block, self._kept = packed(self._known)

    def states(self, start: NDArray[np.float64], steps: int) -> NDArray[np.float64]:
        """Walk.

        Args:
            start: q1, q2, dq1, dq2 at the start.
            steps: Gait steps.

        Returns:
            State (rad, rad/s) after each touchdown, shape (steps, 4).
        """
        known, own = self._known, len(self.controller.states)
        memory, now, length = known.memory, known.now, self.robot.leg_length
        memory[:] = 0.0
        self.controller.start(memory, start[:2].tolist(), start[2:].tolist())
        foot_x, slope = 0.0, self.terrain.slope_at(0.0)
        y = np.concatenate([start, memory[:own], [0.0, 0.0]])
        states = []
        for _ in range(steps):
            now[:] = 0.0, math.sin(slope), math.cos(slope), slope, foot_x, self.terrain.height_at(foot_x)
            y = self._swing(y)
            q1, q2 = y[:2].tolist()
            foot_x += length * (math.sin(q1 + slope) - math.sin(q2 + slope))
            new = self.terrain.slope_at(foot_x)
            rates = self.robot.impact(y[:2], y[2:4])[1].tolist()
            q, slope = (q2 + slope - new, q1 + slope - new), new
            memory[:own] = y[4 : 4 + own]
            self.controller.on_touchdown(memory, (q1, q2), q, rates)
            y = np.concatenate([q, rates, memory[:own], [0.0, 0.0]])
            states.append(y[:4])
        return np.array(states)

    def _swing(self, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """State at the touchdown; no integration goes across a kink of the law."""
        known, out, value = self._known, np.empty_like(y), np.empty(1)
        kinks = [0.0]
        while kinks[-1] < LONGEST:
            kinks.append(min(self.controller.next_discontinuity(known.memory, kinks[-1]), LONGEST))
        first = last = 0.0

        def rhs(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
            known.now[0] = min(max(t, first), last)
            self._rates(self._block.ctypes.data, y, out)
            return out.copy()

        def guard(t: float, y: NDArray[np.float64]) -> float:
            known.now[0] = t
            self._clearance(self._block.ctypes.data, y, value)
            return float(value[0])

        guard.terminal, guard.direction = True, -1  # type: ignore[attr-defined]
        absolute = np.full(len(y), self.tolerance)
        absolute[-2:] = math.inf  # the works follow, as in the engine
        for first, last in zip(kinks[:-1], [math.nextafter(kink, 0.0) for kink in kinks[1:]], strict=True):
            motion = solve_ivp(rhs, (first, last), y, "DOP853", rtol=self.tolerance, atol=absolute, events=guard)
            y = motion.y[:, -1]
            if motion.status == 1:
                return np.asarray(y)
        raise RuntimeError(f"no touchdown within {LONGEST} s")


def rates_by(torque: Callable[..., None]) -> Callable[..., None]:
    """Equation (1), the controller's states, and the net work of ankle and hip, under a law."""

    def rates(known: int, y: Any, out: Any) -> None:
        k = known_at(known, 0)
        memory, made, now = numbers(k.memory, k.size), numbers(k.made, 2 + k.states + ROOM), numbers(k.now, 6)
        for index in range(k.states):
            memory[index] = y[4 + index]
        torque(numbers(k.parameters, k.length), memory, now[0], y[:2], y[2:4], made)
        ankle, hip = made[0], made[1]
        constants: Any = numbers(k.constants, 5)
        motion = y[0], y[1], y[2], y[3]
        ddq1, ddq2 = acceleration(constants, *motion, now[1], now[2], ankle - hip, hip)
        out[0], out[1], out[2], out[3] = y[2], y[3], ddq1, ddq2
        for index in range(k.states):
            out[4 + index] = made[2 + index]
        out[4 + k.states], out[5 + k.states] = ankle * y[2], hip * (y[3] - y[2])

    return rates


def clearance(known: int, y: Any, out: Any) -> None:
    """Height of the swing foot over the ground, m; 1 before it collides."""
    k = known_at(known, 0)
    rule, now = numbers(k.rule, 3), numbers(k.now, 6)
    stance, swing = y[0] + now[3], y[1] + now[3]
    ahead = rule[0] * (math.sin(stance) - math.sin(swing))
    out[0] = 1.0
    if ahead >= rule[1] and now[0] > rule[2]:
        x, starts = now[4] + ahead, numbers(k.x, k.segments)
        segment = max(int(np.searchsorted(starts, x, "right")) - 1, 0)
        ground = numbers(k.z, k.segments)[segment] + numbers(k.gradient, k.segments)[segment] * (x - starts[segment])
        out[0] = now[5] + rule[0] * (math.cos(stance) - math.cos(swing)) - ground
