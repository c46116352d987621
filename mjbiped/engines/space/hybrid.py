"""A robot in space by the equations of motion and impact maps, integrated from touchdown to touchdown."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy

from mjbiped.engines.plan import Plan
from mjbiped.engines.space.run import SpaceRun
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.robots.space import Array, joined
from mjbiped.rules.scuffing import swing_foot_collides
from mjbiped.rules.termination import Outcome

LONGEST = 0.02  # longest step of the integrator, s: no event is missed within it


class HybridSpaceRun(SpaceRun):
    """A walk by DOP853 of SciPy, whose dense output locates the events."""

    def __init__(
        self, plan: Plan, tolerance: float, *, summarised: bool = False, cancellation: Cancellation = never_cancelled
    ) -> None:
        """Set the robot on the ground; see `Engine.start`.

        Args:
            plan: The checked walk.
            tolerance: Relative and absolute tolerance of an integration step.
            summarised: Keep only what `Run.summary` needs.
            cancellation: Called repeatedly during the walk.
        """
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        self.tolerance = tolerance
        self.next_sample = 0.0

    def step(self) -> Outcome:
        """Integrate to the next touchdown; see `SpaceRun.step`."""
        robot, n, since = self.robot, len(self.q), 0.0
        state = np.concatenate([self.q, self.dq, self.memory[: len(self.law.states)], self.work])
        free = len(robot.in_space) > 1  # a knee bends
        while True:
            stop = self.law.next_discontinuity(self.memory, since)
            reached = self._glide(state, since, min(stop, since + 20 * self.pendulum), free)
            self._record(reached, since, free)
            state, since, happened = reached.y[:, -1], float(reached.t[-1]), _happened(reached)
            if happened == "knee":
                state[n : 2 * n] = self._locked(state[:n], state[n : 2 * n])
                self.law.on_knee_strike(self.memory, since, tuple(state[:n]), tuple(state[n : 2 * n]))
                free = False
            elif happened == "land":
                break
            elif happened:
                self.time += since
                return Outcome.FELL if happened == "fall" else Outcome.STALLED
        self.time += since
        self.memory[: len(self.law.states)] = state[2 * n : -3].tolist()
        self.work = state[-3:]
        return self._land(state[:n], state[n : 2 * n])

    def _torque(self, t: float, y: Array) -> tuple[Array, Array]:
        n, joints = len(self.q), len(self.robot.joints)
        memory = [*y[2 * n : -3].tolist(), *self.memory[len(self.law.states) :]]
        out = np.array(self.law.torque(memory, t, tuple(y[:n].tolist()), tuple(y[n : 2 * n].tolist())))
        return out[:joints], out[joints:]

    def _accelerations(self, torque: Array, q: Array, dq: Array, free: bool) -> Array:
        robot, n = self.robot, len(q)
        forces = robot.input_matrix @ torque
        if free or len(robot.in_space) == 1:
            return robot.in_space[n - 1].accelerations(forces, q, dq, self.footing.pull)
        lock = robot.knee_lock
        ddq = robot.in_space[2].accelerations(lock.T @ forces, q[[0, 1, 3]], dq[[0, 1, 3]], self.footing.pull)
        return np.asarray(lock @ ddq)

    def _glide(self, state: Array, since: float, until: float, free: bool) -> Any:
        """Integrate until an event or a time."""
        n, robot, reach = len(self.q), self.robot, self.plan.terms.scuffing.reach * self.robot.leg_length
        terrain, rule, footing = self.plan.terrain, self.plan.terms.scuffing, self.footing

        def rates(t: float, y: Array) -> Array:
            torque, estimates = self._torque(t, y)
            power = torque * robot.joint_rates(y[n : 2 * n])
            np.maximum(self.peak, np.abs(torque), out=self.peak)
            works = [np.abs(power).sum(), power.sum(), np.maximum(power, 0.0).sum()]
            return np.concatenate(
                [y[n : 2 * n], self._accelerations(torque, y[:n], y[n : 2 * n], free), estimates, works]
            )

        def land(t: float, y: Array) -> float:
            place = footing.swing_foot(robot, y[:n])
            gap = float(place[2] - terrain.height_at(place[0], place[1]))
            ahead = float((place - footing.place) @ footing.forward)
            if robot.collides_from_lift_off:
                return gap if not free and ahead > 0.0 else 1.0
            return gap if swing_foot_collides(reach, rule.delay, t, ahead, 1.0) else 1.0

        def knee(t: float, y: Array) -> float:
            return float(y[2] - y[1]) if free and t > 1e-3 else 1.0

        def fall(t: float, y: Array) -> float:
            axle, upright = footing.axes(y[n - 1])
            line = math.sin(y[0]) * footing.forward + math.cos(y[0]) * upright
            hip = footing.place + robot.leg_length * line + 0.5 * robot.hip_width * axle
            return -1.0 if self.judged(hip, t) is not Outcome.WALKING else 1.0

        events: list[Any] = [land, knee, fall]
        for event in events:
            event.terminal, event.direction = True, -1
        return scipy.integrate.solve_ivp(
            rates, (since, until), state, "DOP853", rtol=self.tolerance, atol=self.tolerance,
            max_step=LONGEST * self.pendulum, events=events, dense_output=True,
        )  # fmt: skip

    def _locked(self, q: Array, dq: Array) -> Array:
        """Rates after the knee has struck its stop."""
        lock = self.robot.knee_lock
        return np.asarray(lock @ joined(self.robot.in_space[3], lock, q, dq))

    def _record(self, reached: Any, since: float, free: bool) -> None:
        """Take the loads at the integrator's nodes, and the samples that are due."""
        n, robot = len(self.q), self.robot
        linkage = robot.in_space[n - 1]
        for before, t, y in zip(reached.t[:-1], reached.t[1:], reached.y.T[1:], strict=True):
            torque, _ = self._torque(t, y)
            ddq = self._accelerations(torque, y[:n], y[n : 2 * n], free)
            self.note_load(torque[0], linkage.ground_force(y[:n], y[n : 2 * n], ddq, self.footing.pull), t - before)
        period = self.plan.terms.sample_period
        while self.sampled and period is not None and self.next_sample <= self.time + reached.t[-1]:
            t = max(self.next_sample - self.time, since)
            y = reached.sol(t)
            self.sample(self.next_sample, y[:n], y[n : 2 * n], self._torque(t, y)[0])
            self.next_sample += period

    def _land(self, q: Array, dq: Array) -> Outcome:
        """Make the impact, and exchange the legs."""
        robot, terrain = self.robot, self.plan.terrain
        place = self.footing.swing_foot(robot, q)
        place[2] = terrain.height_at(place[0], place[1])
        new, turn = self.footing.next(place, terrain.normal_at(place[0], place[1]), q[-1])
        axle, _ = self.footing.axes(q[-1])
        straight = [0, 1, len(q) - 1]
        after, rates = robot.in_space[2].touchdown(q[straight], dq[straight], turn)
        after[-1] = new.roll_of(-axle)
        spread = robot.knee_lock
        self.touchdown(new, (q, dq), (spread @ after, spread @ rates))
        return self.finished()


def _happened(reached: Any) -> str:
    names = ("land", "knee", "fall")
    found = [name for name, times in zip(names, reached.t_events, strict=True) if times.size]
    return found[0] if found else ""
