"""The paper's tracking law on a sole: a bounded ankle torque costs tracking of the stance leg, not of the swing leg.

Its laws are those of every chain of segments, with straight legs and with knees, and of recovery steps where one is
planned (`mjbiped.controllers.bounded.supervisor`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.control.controller import Law, Memory, Numbers, Room
from mjbiped.control.tracking import Tracking
from mjbiped.controllers import replanning
from mjbiped.controllers.adaptive import KneedController, PaperSettings, knee_strike
from mjbiped.controllers.bounded.identifier import SLOPE, begin_prediction, identifier_rates, slope_estimate
from mjbiped.controllers.bounded.recovery import planned, recover
from mjbiped.controllers.bounded.stance import footing_of, stand
from mjbiped.controllers.dynamics import observe
from mjbiped.controllers.layout import SOLE_SHARE
from mjbiped.controllers.room import FORCE, LOCKED, RECOVERING, SUPPORT, TORQUE
from mjbiped.controllers.slope_estimator import feel, felt_change
from mjbiped.controllers.tracking import track
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains


def move(parameters: Numbers, memory: Numbers, t: float, share: float, slope: tuple[float, float], room: Room) -> float:
    """Write the torques of the step that the memory plans, and the accelerations that the law's model has under them.

    Args:
        parameters: Of the law; see `mjbiped.controllers.layout`.
        memory: Of the controller.
        t: Time since the touchdown, s.
        share: Share of the sole on which the law leans.
        slope: Sine and cosine of the slope's estimate.
        room: Has the state; see `stance.stand`.

    Returns:
        The ankle torque, N m.
    """
    if memory[RECOVERING] != 0.0:
        return recover(parameters, memory, t, share, slope, room)
    n, _, _ = track(parameters, memory, t, slope, room)
    ankle = 0.0
    for i in range(n):
        ankle += room[FORCE + i]
    return stand(parameters, memory, ankle, 0.0, share, slope, room)


def torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    """Write joint torques, and rates of the slope's estimate and of the predicted momentum; see `Law.torque`."""
    joints = len(q)
    sine, cosine = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    observe(joints, q, dq, out)
    out[TORQUE + joints - 1] = 0.0  # of a locked knee
    ankle = move(parameters, memory, t, parameters[SOLE_SHARE], (sine, cosine), out)
    for joint in range(joints):
        out[joint] = out[TORQUE + joint]
    out[joints], out[joints + 1] = identifier_rates(parameters, memory, ankle, sine, cosine, out)


def touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    """Update the estimate by (27), predict the momentum anew, and plan the new step (IV-B); see `Law.touchdown`."""
    rise = feel_step(parameters, memory, q_before, q, dq)
    replanning.plan(parameters, memory, rise, q, dq)


def feel_step(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> float:
    """Update the estimate by (27), and predict the momentum anew; return the rise to the new foothold, m."""
    thigh, rise = feel(parameters, memory, q_before)
    memory[SLOPE] += felt_change(parameters, thigh, q[1])
    memory[LOCKED] = 0.0
    begin_prediction(parameters, memory, q, dq)
    return rise


def next_discontinuity(parameters: Numbers, memory: Numbers, t: float) -> float:
    """Return the time at which a recovery step is on its constraint, or the kinks of the tracking law, s."""
    if memory[RECOVERING] == 0.0:
        return replanning.next_discontinuity(parameters, memory, t)
    time = planned(memory).time
    return time if t < time else math.inf


@dataclass(frozen=True)
class OnSole(PaperSettings, Tracking):
    """Settings and first step of the tracking law on a sole, of robots with and without knees.

    Attributes:
        sole_share: Share of the sole on which the law leans; the rest is left to errors of its model.
        replanning: See `PaperSettings`, as for all attributes not named here.
    """

    replanning: str = "additive"
    sole_share: Annotated[float, domains.Domain(0.01, 1.0)] = 0.95

    states: ClassVar[tuple[str, ...]] = ("slope_estimate", "predicted_momentum")
    functions: ClassVar[Law] = Law((), torque, touchdown, slope_estimate, next_discontinuity, knee_strike=knee_strike)

    def scalars(self) -> dict[int, float]:
        """Return the scalars among the parameters, by their indices."""
        return {**super().scalars(), **footing_of(self.robot, self.sole_share)}

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Begin with the initial estimate, and plan the first step."""
        memory[SLOPE] = self.initial_slope_estimate
        begin_prediction(self.parameters, memory, q, dq)
        self.plan_first_step(memory, q, dq)


@dataclass(frozen=True)
class BoundedAnkleController(OnSole):
    """Imitates a gait as `AdaptiveController` does, with an ankle torque that the robot's sole transmits.

    Where the tracking law (14) asks the ankle for more than the sole bears, the swing leg still follows its reference,
    and the stance leg moves as it must. The slope comes from what the angular momentum about the foot does
    (`controllers.bounded.identifier`), since tracking errors are no longer the slope's alone. Without a sole it differs
    from `AdaptiveController` in the identifier only. On feet with mass the sole is what the ground bears of it in
    this step (`Controller.support`), and the ankle's height over it counts.

    Attributes:
        robot: Robot model of the law, with the sole on which it leans; it may differ from the robot that walks.
        gait: Gait that is imitated.
        adaptation_gain: gamma of the slope identifier.
        replanning: See `AdaptiveController`, as for all attributes not named here.
        sole_share: Share of the sole on which the law leans; the rest is left to errors of its model.
    """

    robot: Compass

    for_joints: ClassVar[Mapping[str, str]] = {
        "abduction": "mjbiped.controllers.bounded.placement:PlacementController",
        "ankle_roll": "mjbiped.controllers.bounded.sideways:SidewaysController",
        "knee": "mjbiped.controllers.bounded.bounded_ankle:BoundedKneedController",
    }
    support: ClassVar[int] = SUPPORT


@dataclass(frozen=True)
class BoundedKneedController(OnSole, KneedController):
    """Imitates a gait with knees as `KneedController`, with an ankle torque that the robot's sole transmits.

    It is to that as `BoundedAnkleController` is to `AdaptiveController`: where the sole does not bear what is asked
    for, swing thigh and shank still follow their reference, and the slope comes from the angular momentum about the
    foot, which a knee strike does not change.

    Attributes:
        robot: Robot model of the law, with the sole on which it leans; it may differ from the robot that walks.
        gait: See `KneedController`, as for all attributes not named here.
        adaptation_gain: gamma of the slope identifier.
        sole_share: Share of the sole on which the law leans; the rest is left to errors of its model.
    """

    robot: KneedBiped
