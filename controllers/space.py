"""The paper's adaptive law in space: all angles, and three unknown numbers of gravity's direction in place of two.

Tracking (14), adaptation (17) and re-planning are those of the plane, with the matrices of `mjbiped.robots.space`.
Gravity's direction in the ground's frame has three components, in which the equations are linear as (13) is in two, so
the Lyapunov function falls as before: dV_a/dt = -z_1' K_1 z_1 - z_2' K_2 z_2. The update (27) turns the estimate by the
rotation between the attitudes that the leg which has not moved has in the old ground's frame and in the new one's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from mjbiped.control.controller import Controller, Memory
from mjbiped.controllers.replanning import transition, transition_at
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.space import Array
from mjbiped.robots.three_d import InSpace, pull_of
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain

_PULL, _REPLANNED, _CURVES, _POINTS = slice(0, 3), 3, 4, 6


@dataclass(frozen=True)
class SpatialController(Controller):
    """Imitates a gait in space on ground whose slopes, along the heading and across it, are unknown.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated.
        position_gain: K_1, 1/s.
        velocity_gain: K_2, 1/s.
        adaptation_gain: gamma of (17), s^2.
        replanning_delay: zeta, the end of the transition in periods of the gait; None: no transition.
        estimate_update: Whether (27) acts at touchdowns.
        update_threshold: epsilon of (27), rad.
        replanning_threshold: Distance from the limit cycle, rad and rad/s, from which on a step is re-planned.
    """

    robot: InSpace
    gait: Gait
    position_gain: Annotated[float, domains.GAIN] = 5.0
    velocity_gain: Annotated[float, domains.GAIN] = 12.0
    adaptation_gain: Annotated[float, Domain(1e-9, 1e9, "s^2")] = 0.3
    replanning_delay: Annotated[float | None, Domain(1e-3, 1.0, "gait periods")] = 0.8
    estimate_update: bool = True
    update_threshold: Annotated[float, Domain(0.0, 1e3, "rad")] = 2e-3
    replanning_threshold: Annotated[float, Domain(0.0, 1e6, "rad and rad/s")] = 1e-2

    states: ClassVar[tuple[str, ...]] = ("downhill", "into_ground", "aside")

    def __post_init__(self) -> None:
        """Check every number."""
        domains.check_fields(self)

    @property
    def joints(self) -> tuple[str, ...]:  # type: ignore[override]
        """The robot's."""
        return self.robot.joints

    @property
    def memory_size(self) -> int:  # type: ignore[override]
        """Estimates, whether the step is re-planned, and six control points of each angle."""
        return _CURVES + _POINTS * len(self.robot.angles)

    @cached_property
    def _transition_time(self) -> float:
        return (self.replanning_delay or 0.0) * self.gait.period

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with level ground as the estimate."""
        memory[_PULL] = pull_of(0.0).tolist()
        self._plan(memory, np.array(q), np.array(dq))

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Turn the estimate by (27), and plan the new step (IV-B)."""
        downhill, into, aside = memory[_PULL]
        direction = np.array([downhill, -aside, -into])  # the swing side is the other one now
        turned = max(abs(q_before[0] - q[1]), abs(q_before[-1] + q[-1]))
        if self.estimate_update and turned > self.update_threshold:
            direction = attitude(q[1], q[-1]) @ attitude(q_before[0], -q_before[-1]).T @ direction
            direction /= np.linalg.norm(direction)
        memory[_PULL] = [float(direction[0]), float(-direction[2]), float(direction[1])]
        self._plan(memory, np.array(q), np.array(dq))

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> tuple[float, ...]:
        """Torques (14), and rates (17) of the estimates."""
        angles, rates = np.array(q), np.array(dq)
        linkage = self.robot.in_space[len(angles) - 1]
        target, speed, acceleration = self.reference(memory, t)
        z1, dz1 = target - angles, speed - rates
        k1, k2 = self.position_gain, self.velocity_gain
        z2 = dz1 + k1 * z1
        M, G = linkage.mass_matrix(angles), linkage.gravity_forces(angles)
        wanted = acceleration + (k1 * k2 + 1.0) * z1 + (k1 + k2) * dz1
        forces = M @ wanted + linkage.coriolis_forces(angles, rates) + G @ np.array(memory[_PULL])
        adapted = self.adaptation_gain * np.linalg.solve(M, G).T @ z2
        return (*np.linalg.solve(self.robot.input_matrix, forces).tolist(), *adapted.tolist())

    def reference(self, memory: Memory, t: float) -> tuple[Array, Array, Array]:
        """Tracked angles, rates and accelerations at time t of the step: the transition until it ends, then the gait."""
        n = len(self.robot.angles)
        if memory[_REPLANNED] and t < self._transition_time:
            curves = [transition_at(memory, _CURVES + _POINTS * i, self._transition_time, t) for i in range(n)]
            q, dq, ddq = np.array(curves).T
        else:
            q, dq, ddq = np.reshape(motion_at(self.gait.tables[0], t), (3, n))
        return q, dq, ddq

    def slope_estimate(self, memory: Memory) -> float:
        """The estimate of the slope along the heading, rad."""
        return math.atan2(memory[0], memory[1])

    def lateral_estimate(self, memory: Memory) -> float:
        """The estimate of the slope towards the swing side, rad."""
        return math.atan2(memory[2], memory[1])

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The transition's end."""
        return self._transition_time if memory[_REPLANNED] and t < self._transition_time else math.inf

    def _plan(self, memory: Memory, q: Array, dq: Array) -> None:
        """Lay transition curves if the step starts off the limit cycle."""
        n = len(q)
        off = np.abs(np.concatenate([q, dq]) - self.gait.start).max()
        memory[_REPLANNED] = float(self._transition_time > 0.0 and off > self.replanning_threshold)
        if not memory[_REPLANNED]:
            return
        ddq = self.robot.in_space[n - 1].accelerations(np.zeros(n), q, dq, pull_of(self.gait.slope))
        end = np.reshape(motion_at(self.gait.tables[0], self._transition_time), (3, n))
        for i in range(n):
            points = transition(self._transition_time, (q[i], dq[i], ddq[i]), tuple(end[:, i]))
            memory[_CURVES + _POINTS * i : _CURVES + _POINTS * (i + 1)] = [float(point) for point in points]


def attitude(pitch: float, roll: float) -> Array:
    """Rotation of a leg in the ground's frame (heading, swing side, normal), shape (3, 3)."""
    c, s, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
    return np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
