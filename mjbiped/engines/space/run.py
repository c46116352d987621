"""A walk of a robot in space in any physics: its rows, its peaks and its end."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.disturbances.chance import following
from mjbiped.engines.base import Run, Show
from mjbiped.engines.plan import Plan
from mjbiped.records.columns import Cancellation, Columns, never_cancelled, tables_of, width
from mjbiped.records.loads import BINS, note_pressure
from mjbiped.robots.footing import Footing, first_footing
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.space import Array
from mjbiped.rules.sole import bounded
from mjbiped.rules.termination import FALLEN_HIP, LIGHT_CONTACT, STALL_TIME, Outcome


class Pushing:
    """Pushes of a walk, of which one acts at a time.

    Attributes:
        force: Force on the hip now: forward, to the left and upward, N.
        change: Time of its next change, s.
    """

    def __init__(self, plan: Plan) -> None:
        """Begin before the first push."""
        self._schedule, direction = plan.disturbances.schedule, plan.disturbances.push_direction
        self._along = np.array([math.cos(direction), math.sin(direction), 0.0])
        self._number, self.force = 0, np.zeros(3)
        self.change, self._impulse = following(self._schedule, 0, 0.0)

    def advance(self, time: float) -> None:
        """Begin or end the push that is due at a time, s."""
        if time < self.change - 1e-9:
            return
        if self.force.any():
            self._number += 1
            self.force = np.zeros(3)
            self.change, self._impulse = following(self._schedule, self._number, self.change)
        else:
            self.force = self._along * self._impulse / self._schedule.duration
            self.change += self._schedule.duration


class SpaceRun(Run):
    """A walk that has been started; subclasses move the robot through one step after the other.

    Attributes:
        robot: The robot that walks.
        law: What drives it.
        footing: Where it stands.
        q: Angles at the beginning of the step.
        dq: Rates then.
        memory: The controller's.
        time: Since the start, s.
        work: Absolute, net and positive work of all motors, and the absolute work of the motor about the heading, J.
        pushing: The pushes.
    """

    def __init__(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> None:
        """Set the robot on the ground; see `Engine.start`."""
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        assert isinstance(plan.robot, InSpace)
        self.robot, self.law, self.pushing = plan.robot, plan.driver, Pushing(plan)
        self.pendulum = math.sqrt(self.robot.leg_length / self.robot.gravity)
        self.q, self.dq = np.array(plan.q), np.array(plan.dq)
        y = 0.5 * self.robot.hip_width
        self.footing = first_footing(np.array([0.0, y, plan.terrain.height_at(0.0, y)]), plan.terrain.normal_at(0.0, y))
        self.memory = [0.0] * self.law.memory_size
        self.law.start(self.memory, plan.q, plan.dq)
        self.time, self.next_sample, self.bound_time, self.count = 0.0, 0.0, 0.0, 0
        self.work = np.zeros(4)
        self.peak = np.zeros(len(self.robot.joints))
        self.pressure = [0.0] * (2 + BINS)
        self.knees = "knee" in self.robot.joints
        self._begin_step()

    def _begin_step(self) -> None:
        """Forget what is told of each step by itself."""
        self.least_force, self.friction, self.slip, self.depth = math.inf, 0.0, 0.0, 0.0
        self.pressure[0] = self.pressure[1] = -math.inf
        self.free = self.knees
        self.of_knee: dict[str, ArrayLike] = {"flexion": 0.0, "stubs": 0.0} if self.knees else {}

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

    def posture(self, q: Array) -> Array:
        """The posture `qpos` now, in the order of the robot's `places`, of angles from the ground's normal."""
        return self.footing.posture(self.robot, q)

    def judged(self, hip: Array, since: float) -> Outcome:
        """Whether the walk ends at a place of the hip, m, at a time since the touchdown, s."""
        height = hip[2] - self.plan.terrain.height_at(hip[0], hip[1])
        if height * self.footing.normal[2] < FALLEN_HIP * self.robot.leg_length:
            return Outcome.FELL
        return Outcome.STALLED if since > STALL_TIME * self.pendulum else Outcome.WALKING

    def finished(self) -> Outcome:
        """Whether the last touchdown was the last that was asked for, or left the ground that is known."""
        terms, x = self.plan.terms, self.footing.place[0]
        if x > self.plan.terrain.end:
            return Outcome.LEFT_TERRAIN
        enough = terms.steps is not None and self.count >= terms.steps
        far = terms.distance is not None and x >= terms.distance
        return Outcome.FINISHED if enough or far else Outcome.WALKING

    @property
    def on_sole(self) -> bool:
        """Whether a sole bounds a torque."""
        return self.robot.sole is not None or self.robot.sole_width is not None

    def transmitted(self, asked: Array, force: float) -> Array:
        """Torques that the sole transmits of those asked for, N m, under a normal force of the ground, N."""
        given, (behind, ahead) = asked.copy(), self.robot.sole or (math.inf, math.inf)
        half = math.inf if self.robot.sole_width is None else 0.5 * self.robot.sole_width
        given[0], given[-1] = bounded(asked[0], force, behind, ahead), bounded(asked[-1], force, half, half)
        return given

    def powers(self, torque: Array, dq: Array) -> Array:
        """Powers that `work` adds up, W, shape (4,)."""
        power = torque * self.robot.joint_rates(dq)
        return np.array([np.abs(power).sum(), power.sum(), np.maximum(power, 0.0).sum(), abs(power[-1])])

    def note_load(self, torque: Array, along: Array, time: float) -> None:
        """Add a stretch of time (s) to the record of the ground's force, in its own frame (N), under torques (N m)."""
        forward, aside, normal = along.tolist()
        np.maximum(self.peak, np.abs(torque), out=self.peak)
        self.least_force = min(self.least_force, normal)
        light = LIGHT_CONTACT * self.robot.weight
        if normal > light:
            self.friction = max(self.friction, math.hypot(forward, aside) / normal)
        note_pressure(self.pressure, float(torque[0]), normal, light, self.robot.leg_length, time)

    def knee_strikes(self, since: float, q: Array, before: Array, after: Array) -> None:
        """Tell the law and the record that the swing knee has struck its stop.

        Args:
            since: Time since the touchdown, s.
            q: Angles.
            before: Rates before the strike.
            after: Rates after it.
        """
        self.free = False
        self.of_knee |= {"knee_strike": since, "knee_q": q, "knee_dq_before": before, "knee_dq": after}
        self.law.on_knee_strike(self.memory, since, tuple(q), tuple(after))

    def note_flexion(self, q: Array) -> None:
        """Note the flexion of the swing knee."""
        if self.knees:
            self.of_knee["flexion"] = max(float(q[2] - q[1]), float(np.asarray(self.of_knee["flexion"])))

    def sample_due(self, until: float) -> bool:
        """Whether a sample is to be recorded up to a time, s."""
        return self.sampled and self.next_sample <= until + 1e-9

    def sample(self, q: Array, dq: Array, asked: Array, torque: Array) -> None:
        """Record the sample that is due."""
        footing, columns = self.footing, tables_of(type(self.robot)).samples
        values = {
            "time": self.next_sample, "q": q, "dq": dq, "torque": torque, "ankle_asked": asked[0],
            "slope": footing.slope, "slope_estimate": self.law.slope_estimate(self.memory), "stance": footing.stance,
            "qpos": self.posture(q), "lateral_slope": footing.lateral,
            "lateral_estimate": footing.to_left * self.law.lateral_estimate(self.memory),
            "locked": float(not self.free),
        }  # fmt: skip
        states = self.memory[: len(self.law.states)]
        none = np.empty((0, width(tables_of(type(self.robot)).touchdowns)))
        self.recorder.add(none, np.append(row(columns, values), states)[None])
        self.next_sample += self.plan.terms.sample_period or math.inf

    def touchdown(self, new: Footing, before: tuple[Array, Array], after: tuple[Array, Array]) -> Outcome:
        """Exchange the legs: tell the controller, record the row, and tell how the walk goes on."""
        estimates = self.law.slope_estimate(self.memory), self.footing.to_left * self.law.lateral_estimate(self.memory)
        self.footing, (self.q, self.dq) = new, after
        self.count += 1
        self.law.on_touchdown(self.memory, tuple(before[0]), tuple(self.q), tuple(self.dq))
        values = {
            "time": self.time, "qpos": self.posture(self.q), "x": new.place[0], "y": new.place[1],
            "z": new.place[2], "stance": new.stance, "slope": new.slope, "lateral_slope": new.lateral,
            "q_before": before[0], "dq_before": before[1], "q": self.q, "dq": self.dq, "work_absolute": self.work[0],
            "work_net": self.work[1], "work_positive": self.work[2], "roll_work": self.work[3], "slip": self.slip,
            "penetration": self.depth, "friction": self.friction, "strikes": 0.0, "slope_estimate_before": estimates[0],
            "slope_estimate": self.law.slope_estimate(self.memory), "lateral_estimate_before": estimates[1],
            "lateral_estimate": new.to_left * self.law.lateral_estimate(self.memory), "normal_force": self.least_force,
            "pressure_ahead": self.pressure[0], "pressure_behind": self.pressure[1], "sole_bound_time": self.bound_time,
            **self.of_knee,
        }  # fmt: skip
        columns = tables_of(type(self.robot)).touchdowns
        self.recorder.add(row(columns, values)[None])
        self._begin_step()
        return self.finished()


def row(columns: Columns, values: dict[str, ArrayLike]) -> Array:
    """Values by their columns' names as the numbers of a row, in the order of the columns; NaN where there is none."""
    parts = [np.ravel(values.get(name, np.full(column.width, math.nan))) for name, column in columns.items()]
    return np.concatenate(parts).astype(np.float64)
