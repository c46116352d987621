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
from mjbiped.control.controller import ROOM
from mjbiped.numerics.jit import compiled
from mjbiped.robots.compass import Compass, acceleration
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

LONGEST = 3.0  # s, of a gait step


class Known(NamedTuple):
    """What stays fixed within a gait step, all arrays of floats where it may change between two.

    Attributes:
        parameters: Of the control law.
        constants: Of the robot.
        memory: Of the controller.
        made: Room for what its law writes.
        now: Time (s), sine and cosine of the slope, the slope (rad), stance foot x and z (m).
        rule: Leg length, reach (m) and delay (s) of the scuffing rule.
        x: Starts of the terrain's segments, m.
        z: Heights there, m.
        gradient: dz/dx.
    """

    parameters: Any
    constants: Any
    memory: Any
    made: Any
    now: Any
    rule: tuple[float, float, float]
    x: Any
    z: Any
    gradient: Any


class Torque(NamedTuple):
    """The one function that is compiled with the equations."""

    torque: Any


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
        self._rates = compiled(rates, Torque, (law.torque,), inlined=())
        self._clearance = compiled(clearance, Torque, (law.torque,), inlined=())
        self._known = Known(
            np.array(law.parameters, dtype=np.float64),
            robot.constants,
            np.zeros(controller.memory_size),
            np.zeros(2 + len(controller.states) + ROOM),
            np.zeros(6),
            (robot.leg_length, rule.reach * robot.leg_length, rule.delay),
            *(np.array(values, dtype=np.float64) for values in (terrain.x, terrain.z, terrain.gradients)),
        )

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
            self._rates(known, y, out)
            return out.copy()

        def guard(t: float, y: NDArray[np.float64]) -> float:
            known.now[0] = t
            self._clearance(known, y, value)
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


def rates(laws: Torque, known: Known, y: Any, out: Any) -> None:
    """Equation (1), the controller's states, and the net work of ankle and hip."""
    q1, q2, dq1, dq2 = y[0], y[1], y[2], y[3]
    own = len(y) - 6
    for index in range(own):
        known.memory[index] = y[4 + index]
    result = known.made
    laws.torque(known.parameters, known.memory, known.now[0], y[:2], y[2:4], result)
    ankle, hip = result[0], result[1]
    ddq1, ddq2 = acceleration(known.constants, q1, q2, dq1, dq2, known.now[1], known.now[2], ankle - hip, hip)
    out[0], out[1], out[2], out[3] = dq1, dq2, ddq1, ddq2
    for index in range(own):
        out[4 + index] = result[2 + index]
    out[4 + own], out[5 + own] = ankle * dq1, hip * (dq2 - dq1)


def clearance(_: Torque, known: Known, y: Any, out: Any) -> None:
    """Height of the swing foot over the ground, m; 1 before it collides."""
    length, reach, delay = known.rule
    stance, swing = y[0] + known.now[3], y[1] + known.now[3]
    ahead = length * (math.sin(stance) - math.sin(swing))
    out[0] = 1.0
    if ahead >= reach and known.now[0] > delay:
        x = known.now[4] + ahead
        segment = max(np.searchsorted(known.x, x, "right") - 1, 0)
        ground = known.z[segment] + known.gradient[segment] * (x - known.x[segment])
        out[0] = known.now[5] + length * (math.cos(stance) - math.cos(swing)) - ground
