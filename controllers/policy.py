"""A learned policy: a linear feedback whose gains are linear in the time since the touchdown.

It observes what the paper's robot can sense, and remembers one number: the change of slope since the start, which
follows exactly from the postures at touchdowns against the old and the new ground (the paper's (27)).

The memory holds the new stance leg's angle just after the last touchdown and the slope since the start, rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.controller import Law, LawController, Memory, Numbers, Room
from mjbiped.controllers.adaptive import check_imitation
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.gaits.gait import Gait
from mjbiped.robots.compass import Compass

FEATURES = (
    "stance angle",
    "swing angle",
    "stance rate",
    "swing rate",
    "time since touchdown",
    "stance angle after touchdown",
    "slope since the start",
    "constant",
)
"""What an action is made of."""

PERIOD = 0.765
"""Of the passive gait on 2 degrees, s; times are told as parts of it."""
ANGLE = 0.2
"""Half the angle between the legs at that gait's touchdown, rad; angles are told as parts of it."""
SLOPE = 0.035
"""Slope that is told as 1, rad: 2 degrees."""
LATEST = 1.5 * PERIOD
"""Time at which time stands still for the policy, s: a late step must not make its gains grow."""

TORQUE = (35.55 / 3.0, 23.7 / 3.0)
"""Greatest ankle and hip torque in the training, N m."""

STORED = Path(__file__).with_name("policy.csv")
"""The policy that is walked by name. It tells in its first lines how it was trained."""

AFTER, TURNED = 0, 1  # indices in the memory

Value: TypeAlias = Any
"""A number, or an array with one for each of many robots."""


def action(
    weights: Value, t: Value, q1: Value, q2: Value, dq1: Value, dq2: Value, after: Value, turned: Value
) -> tuple[Value, Value]:
    """Torques of ankle and hip as shares of the greatest; of many robots at once where the numbers are arrays.

    Args:
        weights: Of the features: the ankle's constant part and part that goes with time, then the hip's; 32 numbers, or
            arrays with a number for each robot.
        t: Time since the touchdown, at most `LATEST`, s.
        q1: Stance angle, rad.
        q2: Swing angle, rad.
        dq1: Stance rate, rad/s.
        dq2: Swing rate, rad/s.
        after: Angle of the stance leg just after the touchdown, rad; 0 before the first one.
        turned: Slope of the ground since the start, rad.
    """
    phase = 2.0 * (t / PERIOD) - 1.0  # from -1 on, 1 at the end of the gait's step
    # the angle after the touchdown is near 0 on the gait
    features = (q1 / ANGLE, q2 / ANGLE, dq1, dq2, phase, after / ANGLE + 1.0, turned / SLOPE, 1.0)
    ankle = hip = 0.0
    for k in range(len(features)):
        ankle = ankle + (weights[k] + weights[8 + k] * phase) * features[k]
        hip = hip + (weights[16 + k] + weights[24 + k] * phase) * features[k]
    return ankle, hip


@dataclass(frozen=True)
class PolicyController(LawController):
    """Walks by a policy that was learned on random ground, with all torques its own (docs/environments.md).

    It was trained with the robot of Table I and actions held for 20 ms, `Mujoco(timestep=4e-3, control_period=0.02)`.

    Attributes:
        robot: The robot; the policy knows nothing of it.
        gait: Gait on which a walk begins; it is not imitated.
    """

    robot: Compass
    gait: Gait

    memory_size: ClassVar[int] = 2
    with_file: ClassVar[str | None] = "mjbiped.envs.policy:OnnxController"

    def __post_init__(self) -> None:
        """Refuse a robot or a gait of another kind.

        Raises:
            InputError: One is.
        """
        check_imitation(self)

    @cached_property
    def weights(self) -> NDArray[np.float64]:
        """The policy, shape (32,)."""
        return np.loadtxt(STORED, delimiter=",").ravel()

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module, whose parameters are the weights; see `LawController.plain_law`."""
        return Law(self.weights.tolist(), torque, touchdown, slope_estimate, next_discontinuity)


def torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    """Write ankle and hip torque, N m; see `Law.torque`."""
    shares = action(parameters, min(t, LATEST), q[0], q[1], dq[0], dq[1], memory[AFTER], memory[TURNED])
    for joint in range(2):
        out[joint] = min(max(shares[joint] * TORQUE[joint], -TORQUE[joint]), TORQUE[joint])


def touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    """Remember the posture, and by how much the ground has turned; see `Law.touchdown`."""
    memory[AFTER] = q[0]
    memory[TURNED] += slope_change(q_before[0], q[1])


def slope_estimate(parameters: Numbers, memory: Memory) -> float:
    """Return the slope since the start, rad."""
    return memory[TURNED]


def next_discontinuity(parameters: Numbers, memory: Memory, t: float) -> float:
    """Return the time at which the gains stand still, s."""
    return LATEST if t < LATEST else math.inf
