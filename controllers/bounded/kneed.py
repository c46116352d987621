"""The tracking law on a sole for the biped with knees: what the ankle cannot give is left to the stance leg."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory
from mjbiped.controllers import kneed
from mjbiped.controllers.bounded.bounded_ankle import slope_law
from mjbiped.controllers.bounded.identifier import MOMENTUM, SLOPE, chain_about_foot, identifier_rates, update_slope
from mjbiped.controllers.bounded.stance import Footing, footing_of, holds, turned
from mjbiped.controllers.kneed import (
    BENT,
    KneedController,
    Segments,
    feel,
    joint_torques,
    own_room,
    plan,
    stand_bent,
    track,
)
from mjbiped.gaits.gait import Branched
from mjbiped.robots.bent_leg import ACROSS, force_beside
from mjbiped.robots.chain import ground_force, weighted
from mjbiped.robots.kneed import KneedBiped
from mjbiped.rules.sole import bounded_by_own_force
from mjbiped.utils import domains


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        tracking: Those of `controllers.kneed`.
        footing: What presses on the sole, and how large it is.
    """

    tracking: kneed.Parameters
    footing: Footing


@dataclass(frozen=True)
class BoundedKneedController(KneedController):
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
    gait: Branched
    replanning: str = "additive"
    sole_share: Annotated[float, domains.SOLE_SHARE] = 0.95

    states: ClassVar[tuple[str, ...]] = ("slope_estimate", "predicted_momentum")

    @cached_property
    def bounded(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(self.parameters, footing_of(self.robot, self.sole_share))

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(
            self.bounded,
            torque_law,
            touchdown_law,
            slope_law,
            next_discontinuity_law,
            knee_strike=knee_strike_law,
        )

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the initial estimate, and plan the first step."""
        memory[SLOPE] = self.initial_slope_estimate
        begin(own_room(self.parameters, self.robot), memory, tuple(q), tuple(dq))
        self.plan_first_step(memory, q, dq)


def torque_law(
    parameters: Parameters, memory: Memory, t: float, *state: float
) -> tuple[float, float, float, float, float]:
    """Torque of ankle, hip and swing knee, and the rates of the slope's estimate and of the predicted momentum."""
    sine, cosine = math.sin(memory[SLOPE]), math.cos(memory[SLOPE])
    segments = track(parameters.tracking, memory, t, sine, cosine, state)
    across = parameters.tracking.standing[ACROSS]
    let_go(parameters.footing, segments, across, sine, cosine)
    ankle, hip, knee = joint_torques(segments.forces)
    about = chain_about_foot(segments.moments, across, segments.q, segments.dq, segments.even, sine, cosine)
    slope_rate, momentum_rate = identifier_rates(parameters.tracking.gains.adaptation, memory, about, ankle)
    return ankle, hip, knee, slope_rate, momentum_rate


def let_go(footing: Footing, segments: Segments, across: float, sine: float, cosine: float) -> None:
    """Let the stance leg go where the sole does not bear the ankle torque that the motion of a chain takes.

    The other segments move as they would have. Their share of the ankle torque, the sum of all rows of the equations
    of motion, changes with the stance leg's acceleration, and so does the normal force: both linearly.

    Args:
        footing: What presses on the sole, and how large it is.
        segments: Chain with its state, M, motion and forces; the last two are changed.
        across: Moment of the stance leg's weight beside its line, N m.
        sine: Sine of the slope, or of its estimate.
        cosine: Cosine of it.
    """
    asked = inertia = 0.0
    for i in range(len(segments.q)):
        asked += segments.forces[i]
        inertia += segments.even[i, 0]
    normal = normal_force(footing, segments, across, sine, cosine)
    if asked == 0.0 or holds(footing, asked, normal):
        return
    wanted = segments.motion[0]
    segments.motion[0] = wanted - asked / inertia
    without = normal_force(footing, segments, across, sine, cosine)
    ankle, _ = bounded_by_own_force(asked, normal, without, footing.behind, footing.ahead)
    change = (ankle - asked) / inertia
    segments.motion[0] = wanted + change
    for i in range(len(segments.q)):
        segments.forces[i] += segments.even[i, 0] * change


def normal_force(footing: Footing, segments: Segments, across: float, sine: float, cosine: float) -> float:
    """Normal force of the ground under a chain that moves, N; the arguments are those of `let_go`."""
    mass, gravity = footing.mass, footing.gravity
    along, normal = ground_force(segments.moments, mass, gravity, segments.q, segments.dq, segments.motion)
    if across != 0.0:
        _, beside = force_beside(across, gravity, segments.q[0], segments.dq[0], segments.motion[0])
        normal += beside
    return turned(footing, along, normal, (sine, cosine))[1]


def touchdown_law(parameters: Parameters, memory: Memory, *postures: float) -> None:
    """Estimate update (27), a new prediction of the momentum, and the plan of the new step (IV-B)."""
    q, dq = postures[3:6], postures[6:]
    thigh, height = feel(parameters.tracking, memory, postures[:3])
    update_slope(parameters.tracking.gains, memory, thigh, q[1])
    begin(parameters.tracking, memory, q, dq)
    plan(parameters.tracking, memory, height, q, dq)


def begin(tracking: kneed.Parameters, memory: Memory, q: tuple[float, ...], dq: tuple[float, ...]) -> None:
    """Let the prediction begin with the momentum that a step begins with."""
    stand_bent(tracking, memory[BENT])
    segments = tracking.free
    for i in range(len(segments.q)):
        segments.q[i], segments.dq[i] = q[i], dq[i]
    weighted(segments.weights, segments.q, segments.q, segments.even, segments.odd)
    moments, across = segments.moments, tracking.standing[ACROSS]
    about = chain_about_foot(moments, across, segments.q, segments.dq, segments.even, 0.0, 1.0)
    memory[MOMENTUM] = about.momentum


def knee_strike_law(parameters: Parameters, memory: Memory, t: float, *state: float) -> None:
    """Follow the branch of the straight knee from now on."""
    kneed.knee_strike_law(parameters.tracking, memory, t, *state)


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The transition's end, then the end of the gait's trajectory, s."""
    return kneed.next_discontinuity_law(parameters.tracking, memory, t)
