"""The hybrid walk as it is commonly written: `scipy.integrate.solve_ivp` from touchdown to touchdown.

What the benchmark measures the hybrid engine against, and an independent reference for its accuracy: integrator, event
search and loop are SciPy's and Python's. The right-hand side and the guard are compiled, so that only the way of
integrating differs. It does less than the engine: no absolute work, no peaks, no friction, no falls, no risers.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from controllers import Controller
from mjbiped.control.compiled import MachineCode
from mjbiped.control.controller import ROOM
from mjbiped.numerics import machine
from mjbiped.numerics.blocks import call, numbers, packed, reader
from mjbiped.robots.compass import Compass, acceleration
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

LONGEST = 3.0  # s, of a gait step


class Known(NamedTuple):
    """What stays fixed within a gait step, see `mjbiped.numerics.blocks`.

    Attributes:
        torque: Address of the control law.
        parameters: Address of its record.
        states: Number of the controller's integrated states.
        segments: Number of the terrain's segments.
        constants: Of the robot.
        memory: Of the controller.
        made: Room for what its law writes.
        now: Time (s), sine and cosine of the slope, the slope (rad), stance foot x and z (m).
        rule: Leg length, reach (m) and delay (s) of the scuffing rule.
        x: Starts of the terrain's segments, m.
        z: Heights there, m.
        gradient: dz/dx.
    """

    torque: int
    parameters: int
    states: int
    segments: int
    constants: Any
    memory: Any
    made: Any
    now: Any
    rule: Any
    x: Any
    z: Any
    gradient: Any


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
        self._rates = machine.compiled(rates, "void(int64, int64, int64)")
        self._clearance = machine.compiled(clearance, "float64(int64, int64)")
        self._code = MachineCode(law, len(controller.states), controller.memory_size)
        self._known = Known(
            self._code.law.torque,
            self._code.law.record,
            len(controller.states),
            len(terrain.x),
            robot.constants,
            np.zeros(controller.memory_size),
            np.zeros(2 + len(controller.states) + ROOM),
            np.zeros(6),
            (robot.leg_length, rule.reach * robot.leg_length, rule.delay),
            terrain.x,
            terrain.z,
            terrain.gradients,
        )
        self._copy, self._kept = packed(self._known)

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
        known, out, at = self._known, np.empty_like(y), self._copy.ctypes.data
        kinks = [0.0]
        while kinks[-1] < LONGEST:
            kinks.append(min(self.controller.next_discontinuity(known.memory, kinks[-1]), LONGEST))
        first = last = 0.0

        def rhs(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
            known.now[0] = min(max(t, first), last)
            self._rates(at, y.ctypes.data, out.ctypes.data)
            return out.copy()

        def guard(t: float, y: NDArray[np.float64]) -> float:
            known.now[0] = t
            return float(self._clearance(at, y.ctypes.data))

        guard.terminal, guard.direction = True, -1  # type: ignore[attr-defined]
        absolute = np.full(len(y), self.tolerance)
        absolute[-2:] = math.inf  # the works follow, as in the engine
        for first, last in zip(kinks[:-1], [math.nextafter(kink, 0.0) for kink in kinks[1:]], strict=True):
            motion = solve_ivp(rhs, (first, last), y, "DOP853", rtol=self.tolerance, atol=absolute, events=guard)
            y = motion.y[:, -1]
            if motion.status == 1:
                return np.asarray(y)
        raise RuntimeError(f"no touchdown within {LONGEST} s")


def rates(at: int, y_at: int, out_at: int) -> None:
    """Equation (1), the controller's states, and the net work of ankle and hip, in machine code alone."""
    known = known_at(at, 0)
    own, now, memory = known.states, numbers(known.now, 6), numbers(known.memory, known.states)
    y, out, made = numbers(y_at, 6 + own), numbers(out_at, 6 + own), numbers(known.made, 2 + own)
    for index in range(own):
        memory[index] = y[4 + index]
    call(known.torque, known.parameters, memory, now[0], numbers(y_at, 2), numbers(y_at + 16, 2), made)
    ankle, hip = made[0], made[1]
    q1, q2, dq1, dq2 = y[0], y[1], y[2], y[3]
    constants = numbers(known.constants, 5)
    ddq1, ddq2 = acceleration(constants, q1, q2, dq1, dq2, now[1], now[2], ankle - hip, hip)
    out[0], out[1], out[2], out[3] = dq1, dq2, ddq1, ddq2
    for index in range(own):
        out[4 + index] = made[2 + index]
    out[4 + own], out[5 + own] = ankle * dq1, hip * (dq2 - dq1)


def clearance(at: int, y_at: int) -> float:
    """Height of the swing foot over the ground, m; 1 before it collides; in machine code alone."""
    known = known_at(at, 0)
    y, now, rule = numbers(y_at, 2), numbers(known.now, 6), numbers(known.rule, 3)
    length, reach, delay = rule[0], rule[1], rule[2]
    stance, swing = y[0] + now[3], y[1] + now[3]
    ahead = length * (math.sin(stance) - math.sin(swing))
    if ahead < reach or now[0] <= delay:
        return 1.0
    x, starts = now[4] + ahead, numbers(known.x, known.segments)
    segment = max(np.searchsorted(starts, x, "right") - 1, 0)
    height = numbers(known.z, known.segments)[segment]
    ground = height + numbers(known.gradient, known.segments)[segment] * (x - starts[segment])
    above: float = now[5] + length * (math.cos(stance) - math.cos(swing)) - ground
    return above
