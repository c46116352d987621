"""A robot in space by the equations of motion and impact maps, integrated from touchdown to touchdown."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from mjbiped.engines.plan import Plan
from mjbiped.engines.space.run import SpaceRun
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.robots.space import Array, joined
from mjbiped.rules.scuffing import swing_foot_collides
from mjbiped.rules.termination import Outcome

LONGEST = 0.06  # longest step of the integrator, in sqrt(leg length / gravity): no event is missed within it
LIFTING = 0.15  # in the same units: in this time the swing foot of a leg with a knee leaves the ground
SETTLED = 1e-12  # of the weight: change of a bounded normal force at which its search ends
_WORKS = 4  # of `SpaceRun.work`
_EVENTS = ("land", "knee", "stub", "fall")


class HybridSpaceRun(SpaceRun):
    """A walk by DOP853 of SciPy, whose dense output locates the events.

    A state is of angles, rates, the law's states and works. A swing foot that touches the ground while its knee is bent
    cannot bear the robot: the walk ends there.
    """

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
        self.tolerance, self.states = tolerance, len(self.law.states)

    def step(self) -> Outcome:
        """Integrate to the next touchdown; see `SpaceRun.step`."""
        n, began, since = len(self.q), self.time, 0.0
        state = np.concatenate([self.q, self.dq, self.memory[: self.states], self.work])
        while True:
            self.pushing.advance(self.time)
            ends = self.law.next_discontinuity(self.memory, since), self.pushing.change - began
            reached = self._glide(state, since, min(*ends, since + 20.0 * self.pendulum))
            self._record(reached, began)
            state, since = reached.y[:, -1], float(reached.t[-1])
            self.time = began + since
            self.memory[: self.states] = state[2 * n : -_WORKS].tolist()
            self.work = state[-_WORKS:]
            happened = next((name for name, t in zip(_EVENTS, reached.t_events, strict=True) if t.size), "")
            q, dq = state[:n], state[n : 2 * n].copy()
            if happened == "land":
                return self._land(q, dq)
            if happened == "knee":
                after = self.robot.knee_lock @ joined(self.robot.in_space[n - 1], self.robot.knee_lock, q, dq)
                self.knee_strikes(since, q, dq, after)
                state[n : 2 * n] = after
            elif happened:
                outcome = self.judged(self.footing.hip(self.robot, q), since)
                return Outcome.FELL if outcome is Outcome.WALKING else outcome

    def _asked(self, t: float, y: Array) -> tuple[Array, Array]:
        """Torques that the law asks for at a time of the step, and the rates of its states."""
        n, joints = len(self.q), len(self.robot.joints)
        memory = [*y[2 * n : -_WORKS].tolist(), *self.memory[self.states :]]
        out = np.array(self.law.torque(memory, t, tuple(y[:n].tolist()), tuple(y[n : 2 * n].tolist())))
        return out[:joints], out[joints:]

    def _moved(self, torque: Array, q: Array, dq: Array) -> tuple[Array, Array]:
        """Accelerations under torques, and the force of the ground in its own frame, N."""
        robot, push = self.robot, self.footing.turned(self.pushing.force)
        whole = robot.in_space[len(q) - 1]
        forces = robot.input_matrix @ torque
        if push.any():
            forces += whole.pushed(q, push)
        ddq = robot.accelerations(forces, q, dq, self.footing.pull, locked=not self.free)
        return ddq, whole.ground_force(q, dq, ddq, self.footing.pull) - push

    def _driven(self, asked: Array, q: Array, dq: Array) -> tuple[Array, Array, Array]:
        """Torques that the sole transmits, and what `_moved` tells of them."""
        ddq, along = self._moved(asked, q, dq)
        if not self.on_sole or (self.transmitted(asked, along[2]) == asked).all():
            return asked, ddq, along
        # the normal force is linear in the torques
        bases = np.eye(len(asked))[[0, -1]]
        gains = [self._moved(asked + base, q, dq)[1][2] - along[2] for base in bases]
        force, before = along[2], math.inf
        torque = asked
        while abs(force - before) > SETTLED * self.robot.weight:
            torque, before = self.transmitted(asked, force), force
            force = along[2] + (torque - asked)[[0, -1]] @ gains
        return torque, *self._moved(torque, q, dq)

    def _glide(self, state: Array, since: float, until: float) -> Any:
        """Integrate until an event or a time."""
        n = len(self.q)

        def rates(t: float, y: Array) -> Array:
            asked, estimates = self._asked(t, y)
            torque, ddq, _ = self._driven(asked, y[:n], y[n : 2 * n])
            return np.concatenate([y[n : 2 * n], ddq, estimates, self.powers(torque, y[n : 2 * n])])

        events: list[Any] = list(self._events())
        for event in events:
            event.terminal, event.direction = True, -1
        return scipy.integrate.solve_ivp(
            rates, (since, until), state, "DOP853", rtol=self.tolerance, atol=self.tolerance,
            max_step=LONGEST * self.pendulum, events=events, dense_output=True,
        )  # fmt: skip

    def _events(self) -> tuple[Callable[[float, Array], float], ...]:
        """Functions that fall through zero where something happens, in the order of `_EVENTS`."""
        n, robot, rule, footing = len(self.q), self.robot, self.plan.terms.scuffing, self.footing
        terrain, reach = self.plan.terrain, rule.reach * robot.leg_length

        def foot(y: Array) -> tuple[float, float]:
            place = footing.swing_foot(robot, y[:n])
            return float(place[2] - terrain.height_at(place[0], place[1])), float(
                (place - footing.place) @ footing.forward
            )

        def land(t: float, y: Array) -> float:
            if robot.collides_from_lift_off and self.free:
                return 1.0
            gap, ahead = foot(y)
            collides = (
                ahead > 0.0 if robot.collides_from_lift_off else swing_foot_collides(reach, rule.delay, t, ahead, 1.0)
            )
            return gap if collides else 1.0

        def knee(t: float, y: Array) -> float:
            return float(y[2] - y[1]) if self.free and t > 1e-3 else 1.0

        def stub(t: float, y: Array) -> float:
            return foot(y)[0] if self.free and t > LIFTING * self.pendulum else 1.0

        def fall(t: float, y: Array) -> float:
            return -1.0 if self.judged(footing.hip(robot, y[:n]), t) is not Outcome.WALKING else 1.0

        return land, knee, stub, fall

    def _record(self, reached: Any, began: float) -> None:
        """Take the loads at the integrator's nodes, and the samples that are due."""
        n = len(self.q)
        for before, t, y in zip(reached.t[:-1], reached.t[1:], reached.y.T[1:], strict=True):
            asked, _ = self._asked(t, y)
            torque, _, along = self._driven(asked, y[:n], y[n : 2 * n])
            self.bound_time += (t - before) * bool((torque != asked).any())
            self.note_load(torque, along, t - before)
            self.note_flexion(y[:n])
        while self.sample_due(began + reached.t[-1]):
            t = min(max(self.next_sample - began, reached.t[0]), reached.t[-1])
            y = reached.sol(t)
            self.memory[: self.states] = y[2 * n : -_WORKS].tolist()
            asked, _ = self._asked(t, y)
            self.sample(y[:n], y[n : 2 * n], asked, self._driven(asked, y[:n], y[n : 2 * n])[0])

    def _land(self, q: Array, dq: Array) -> Outcome:
        """Make the impact, and exchange the legs."""
        robot, terrain = self.robot, self.plan.terrain
        place = self.footing.swing_foot(robot, q)
        place[2] = terrain.height_at(place[0], place[1])
        axle, upright = self.footing.axes(q[-1])
        new, turn = self.footing.next(place, terrain.normal_at(place[0], place[1]), axle, upright)
        after, rates = robot.landed(q, dq, turn)
        after[-1] = new.roll_of(-axle)
        return self.touchdown(new, (q, dq), (after, rates))
