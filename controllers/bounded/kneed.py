"""The tracking law on a sole for the biped with knees: what the ankle cannot give is left to the stance leg."""

from __future__ import annotations

from dataclasses import dataclass

from mjbiped.controllers.bounded.bounded_ankle import OnSole
from mjbiped.controllers.kneed import KneedController
from mjbiped.robots.kneed import KneedBiped


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
