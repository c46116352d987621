"""A walk of a robot in space in any physics: its rows, its peaks and its end."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.engines.base import Run, Show
from mjbiped.engines.plan import Plan
from mjbiped.robots.footing import Footing, first_footing
from mjbiped.records.columns import Cancellation, Columns, never_cancelled, tables_of, width
from mjbiped.records.loads import BINS, note_pressure
from mjbiped.robots.space import Array
from mjbiped.robots.three_d import InSpace
from mjbiped.rules.termination import FALLEN_HIP, LIGHT_CONTACT, STALL_TIME, Outcome

STATES = 3
"""Number of estimates, of gravity's direction, that a record has room for."""


class SpaceRun(Run):
    """A walk that has been started; subclasses move the robot through one step after the other.

    Attributes:
        robot: The robot that walks.
        footing: Where it stands.
        memory: The controller's.
        time: Since the start, s.
    """

    def __init__(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> None:
        """Set the robot on the ground; see `Engine.start`."""
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        assert isinstance(plan.robot, InSpace)
        self.robot, self.law = plan.robot, plan.driver
        self.pendulum = math.sqrt(self.robot.leg_length / self.robot.gravity)
        self.q, self.dq = np.array(plan.q), np.array(plan.dq)
        y = 0.5 * self.robot.hip_width
        self.footing = first_footing(np.array([0.0, y, plan.terrain.height_at(0.0, y)]), plan.terrain.normal_at(0.0, y))
        self.memory = [0.0] * self.law.memory_size
        self.law.start(self.memory, plan.q, plan.dq)
        self.time, self.count = 0.0, 0
        self.work = np.zeros(3)
        self.peak = np.zeros(len(self.robot.joints))
        self.pressure: list[float] = [-math.inf, -math.inf, *([0.0] * BINS)]
        self.least_force, self.friction, self.slip, self.depth = math.inf, 0.0, 0.0, 0.0

    @abstractmethod
    def step(self) -> Outcome:
        """Walk to the next touchdown, or to the end; `Outcome.WALKING` where the walk goes on."""

    def walk(self, show: Show) -> Outcome:
        """Walk to the end; see `Run.walk`."""
        while True:
            self.recorder.cancellation()
            outcome = self.step()
            show(1, float(self.footing.place[0]))
            if outcome is not Outcome.WALKING:
                return outcome

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return self.peak

    def pressure_times(self) -> NDArray[np.float64]:
        """Time that the centre of pressure spent in each bin, s."""
        return np.array(self.pressure[2:])

    def settings(self) -> dict[str, Any]:
        """The engine's settings."""
        return {"warnings": {}}

    def judged(self, hip: Array, since: float) -> Outcome:
        """Whether the walk ends at a place of the hip, m, at a time since the touchdown, s."""
        height = hip[2] - self.plan.terrain.height_at(hip[0], hip[1])
        if height * self.footing.normal[2] < FALLEN_HIP * self.robot.leg_length:
            return Outcome.FELL
        return Outcome.STALLED if since > STALL_TIME * self.pendulum else Outcome.WALKING

    def finished(self) -> Outcome:
        """Whether the last touchdown was the last that was asked for."""
        terms = self.plan.terms
        enough = terms.steps is not None and self.count >= terms.steps
        far = terms.distance is not None and self.footing.place[0] >= terms.distance
        return Outcome.FINISHED if enough or far else Outcome.WALKING

    def note_load(self, torque: float, along: Array, time: float) -> None:
        """Add a stretch of time to the record of the ground's force: ankle torque, N m, and force in the ground's frame."""
        forward, aside, normal = along
        self.least_force = min(self.least_force, float(normal))
        light = LIGHT_CONTACT * self.robot.weight
        if normal > light:
            self.friction = max(self.friction, float(math.hypot(forward, aside) / normal))
        note_pressure(self.pressure, torque, float(normal), light, self.robot.leg_length, time)

    def sample(self, time: float, q: Array, dq: Array, torque: Array) -> None:
        """Record a sample."""
        footing, columns = self.footing, tables_of(type(self.robot)).samples
        values = {
            "time": time, "q": q, "dq": dq, "torque": torque, "ankle_asked": torque[0], "slope": footing.slope,
            "slope_estimate": self.law.slope_estimate(self.memory), "stance": footing.stance,
            "qpos": footing.posture(self.robot, q), "lateral_slope": footing.lateral,
            "lateral_estimate": footing.to_left * lateral_estimate(self.law, self.memory), "locked": 1.0,
        }  # fmt: skip
        states = self.memory[: len(self.law.states)]
        none = np.empty((0, width(tables_of(type(self.robot)).touchdowns)))
        self.recorder.add(none, np.append(row(columns, values), states)[None])

    def touchdown(self, new: Footing, before: tuple[Array, Array], after: tuple[Array, Array]) -> None:
        """Exchange the legs: tell the controller, and record the row."""
        estimates = self.law.slope_estimate(self.memory), self.footing.to_left * lateral_estimate(self.law, self.memory)
        self.footing, (self.q, self.dq) = new, after
        self.count += 1
        self.law.on_touchdown(self.memory, tuple(before[0]), tuple(self.q), tuple(self.dq))
        values = {
            "time": self.time, "qpos": new.posture(self.robot, self.q), "x": new.place[0], "y": new.place[1],
            "z": new.place[2], "stance": new.stance, "slope": new.slope, "lateral_slope": new.lateral,
            "q_before": before[0], "dq_before": before[1], "q": self.q, "dq": self.dq, "work_absolute": self.work[0],
            "work_net": self.work[1], "work_positive": self.work[2], "slip": self.slip, "penetration": self.depth,
            "friction": self.friction, "strikes": 0.0, "slope_estimate_before": estimates[0],
            "slope_estimate": self.law.slope_estimate(self.memory), "lateral_estimate_before": estimates[1],
            "lateral_estimate": new.to_left * lateral_estimate(self.law, self.memory), "normal_force": self.least_force,
            "pressure_ahead": self.pressure[0], "pressure_behind": self.pressure[1], "sole_bound_time": 0.0,
        }  # fmt: skip
        columns = tables_of(type(self.robot)).touchdowns
        self.recorder.add(row(columns, values)[None])
        self.least_force, self.friction, self.slip, self.depth = math.inf, 0.0, 0.0, 0.0
        self.pressure[0] = self.pressure[1] = -math.inf


def lateral_estimate(law: Any, memory: list[float]) -> float:
    """The law's estimate of the slope towards the swing side, rad; NaN where it makes none."""
    return float(law.lateral_estimate(memory)) if hasattr(law, "lateral_estimate") else math.nan


def row(columns: Columns, values: dict[str, ArrayLike]) -> Array:
    """Values by their columns' names as the numbers of a row, in the order of the columns; NaN where there is none."""
    parts = [np.ravel(values.get(name, np.full(column.width, math.nan))) for name, column in columns.items()]
    return np.concatenate(parts).astype(np.float64)
