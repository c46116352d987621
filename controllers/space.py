"""The paper's adaptive law in space: all angles, and three unknown numbers of gravity's direction in place of two.

Tracking (14), adaptation (17) and re-planning are those of the plane, with the matrices of `mjbiped.robots.space`.
Gravity's direction in the ground's frame has three components, in which the equations are linear as (13) is in two, so
the Lyapunov function falls as before: dV_a/dt = -z_1' K_1 z_1 - z_2' K_2 z_2. The update (27) turns the estimate by the
rotation between the attitudes that the leg which has not moved has in the old ground's frame and in the new one's.

With knees the law follows the trajectory of the actual knee, bent or straight. A re-planned curve would keep a
straight leg straight, so re-planning is additive then: the curve leads from the distance to the gait to zero, and is
added to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from mjbiped.control.controller import Memory
from mjbiped.control.tracking import Tracking
from mjbiped.controllers.replanning import transition, transition_at
from mjbiped.errors import InputError
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import motion_at, reference_discontinuity
from mjbiped.robots.in_space import InSpace, pull_of
from mjbiped.robots.robot import Robot
from mjbiped.robots.space import Array, SpatialLinkage
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain

_PULL, _REPLANNED, _STRUCK, _CURVES, _POINTS = slice(0, 3), 3, 4, 5, 6


class Sideways(NamedTuple):
    """What leads a robot to the side in place of a tracked roll.

    Attributes:
        moment: Torque about the heading, N m.
        fall_rate: Rate of the estimate aside, 1/s.
        opening: Acceleration of the abduction where the robot has one, rad/s^2.
    """

    moment: float
    fall_rate: float
    opening: float = 0.0


@dataclass(frozen=True)
class SpatialController(Tracking):
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
        initial_slope_estimate: Estimate of the slope along the heading at the walk's start, rad.
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
    initial_slope_estimate: Annotated[float, domains.SLOPE] = 0.0

    states: ClassVar[tuple[str, ...]] = ("downhill_estimate", "into_ground_estimate", "aside_estimate")

    def __post_init__(self) -> None:
        """Check every number, and that robot and gait go together.

        Raises:
            InputError: A number is outside its domain, or the gait is of another kind of robot.
        """
        domains.check_fields(self)
        domains.check_kind("robot", self.robot, InSpace)  # type: ignore[type-abstract]  # no object of it is made
        if self.gait.robot.angles != self.robot.angles:
            raise InputError(
                f"gait: a {type(self.robot).__name__} needs a gait in space of its own (mjbiped.find_gait_in_space), "
                f"got one of a {type(self.gait.robot).__name__}"
            )

    @classmethod
    def drives(cls, robot: Robot) -> bool:
        """Whether the robot walks in space."""
        return isinstance(robot, InSpace)

    @property
    def joints(self) -> tuple[str, ...]:  # type: ignore[override]  # a class attribute elsewhere
        """The robot's."""
        return self.robot.joints

    @property
    def memory_size(self) -> int:  # type: ignore[override]  # a class attribute elsewhere
        """Estimates, two switches, and six control points of each angle."""
        return _CURVES + _POINTS * len(self.robot.angles)

    @cached_property
    def _transition_time(self) -> float:
        return (self.replanning_delay or 0.0) * self.gait.period

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate."""
        memory[_PULL] = pull_of(self.initial_slope_estimate).tolist()
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

    def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Follow the trajectory of the straight knee from now on."""
        memory[_STRUCK] = 1.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> tuple[float, ...]:
        """Torques (14), and rates (17) of the estimates."""
        robot, angles, rates = self.robot, np.array(q), np.array(dq)
        if self._straight(memory):
            angles, rates = robot.straightened(angles), robot.straightened(rates)
        linkage = robot.in_space[len(angles) - 1]
        target, speed, acceleration = self.reference(memory, t)
        z1, dz1, led = target - angles, speed - rates, self._led_sideways(memory, t, linkage, angles, rates)
        pitches = len(robot.pitches(angles))
        if led is not None:
            z1[-1] = dz1[-1] = 0.0
        k1, k2 = self.position_gain, self.velocity_gain
        M, G = linkage.mass_matrix(angles), linkage.gravity_forces(angles)
        load = linkage.coriolis_forces(angles, rates) + G @ np.array(memory[_PULL])
        wanted = acceleration + (k1 * k2 + 1.0) * z1 + (k1 + k2) * dz1
        felt = dz1 + k1 * z1
        if led is not None:
            felt[pitches:] = 0.0
            wanted[pitches:-1] = led.opening
        adapted = self.adaptation_gain * np.linalg.solve(M, G).T @ felt
        if led is not None:
            wanted[-1], adapted[2] = (led.moment - load[-1] - M[-1, :-1] @ wanted[:-1]) / M[-1, -1], led.fall_rate
        return (*(robot.motors[len(angles)] @ (M @ wanted + load)).tolist(), *adapted.tolist())

    def _led_sideways(self, memory: Memory, t: float, linkage: SpatialLinkage, q: Array, dq: Array) -> Sideways | None:
        """What leads the robot to the side where the roll is not tracked; else None.

        Args:
            memory: Of the controller.
            t: Time of the step, s.
            linkage: Of the segments that move.
            q: Their angles, rad.
            dq: Their rates, rad/s.
        """
        return None

    def imitated(self, memory: Memory, t: float) -> Array:
        """The gait's angles, rates and accelerations at time t, shape (3, n), of the knee that the robot has now."""
        return np.reshape(motion_at(self.gait.tables[1 if self._straight(memory) else 0], t), (3, -1))

    def reference(self, memory: Memory, t: float) -> tuple[Array, Array, Array]:
        """Tracked angles, rates and accelerations at time t of the step: of straight legs once the knee has struck."""
        motion = self.imitated(memory, t)
        if memory[_REPLANNED] != 0.0 and t < self._transition_time:
            curve = np.array([transition_at(memory, first, self._transition_time, t) for first in self._curves]).T
            if self._straight(memory):
                curve = self.robot.straightened(curve.T).T
            motion = motion + curve if self._additive else curve
        return motion[0], motion[1], motion[2]

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Tracked angles and rates of all segments."""
        q, dq, _ = self.reference(memory, t)
        if self._straight(memory):
            return (self.robot.knee_lock @ q).tolist(), (self.robot.knee_lock @ dq).tolist()
        return q.tolist(), dq.tolist()

    def transition_end(self, memory: Memory) -> float:
        """Time at which the re-planned transition of the step ends, s; 0 where the step was not re-planned."""
        return self._transition_time if memory[_REPLANNED] else 0.0

    def slope_estimate(self, memory: Memory) -> float:
        """The estimate of the slope along the heading, rad."""
        return math.atan2(memory[0], memory[1])

    def lateral_estimate(self, memory: Memory) -> float:
        """The estimate of the slope towards the swing side, rad."""
        return math.atan2(memory[2], memory[1])

    def next_discontinuity(self, memory: Memory, t: float) -> float:
        """The transition's end, then the trajectory's."""
        if memory[_REPLANNED] and t < self._transition_time:
            return self._transition_time
        return reference_discontinuity(self.gait.tables[-1], 0, t)

    @property
    def _additive(self) -> bool:
        """Whether a transition is added to the gait."""
        return self.gait.knee_strike is not None

    @cached_property
    def _curves(self) -> range:
        """Indices in the memory at which the transition of each angle begins."""
        return range(_CURVES, _CURVES + _POINTS * len(self.robot.angles), _POINTS)

    def _straight(self, memory: Memory) -> bool:
        """Whether a knee has struck its stop."""
        return self.gait.knee_strike is not None and memory[_STRUCK] != 0.0

    def _plan(self, memory: Memory, q: Array, dq: Array) -> None:
        """Lay transition curves if the step starts off the limit cycle."""
        n, duration = len(q), self._transition_time
        memory[_STRUCK] = 0.0
        away = np.concatenate([q, dq]) - self.gait.start
        memory[_REPLANNED] = float(duration > 0.0 and np.abs(away).max() > self.replanning_threshold)
        if not memory[_REPLANNED]:
            return
        if self._additive:
            begins, ends = (away[:n], away[n:], np.zeros(n)), np.zeros((3, n))
        else:
            pull = pull_of(self.gait.slope)
            begins = (q, dq, self.robot.in_space[n - 1].accelerations(np.zeros(n), q, dq, pull))
            ends = np.reshape(motion_at(self.gait.tables[0], duration), (3, n))
        for i, first in enumerate(self._curves):
            angle, rate, acceleration = (float(part[i]) for part in begins)
            memory[first : first + _POINTS] = transition(duration, (angle, rate, acceleration), (*ends[:, i].tolist(),))


def attitude(pitch: float, roll: float) -> Array:
    """Rotation of a leg in the ground's frame (heading, swing side, normal), shape (3, 3)."""
    c, s, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
    rolled, pitched = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]), np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.asarray(rolled @ pitched)
