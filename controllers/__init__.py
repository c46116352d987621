"""Control laws for bipeds with and without knees: plain functions of a state and a memory, without any simulator.

`controllers` is the short name of `mjbiped.controllers`, which no package of a user's can hide.
"""

from mjbiped.control.controller import Controller, Law, LawController, Memory, never
from mjbiped.controllers.adaptive import AdaptiveController, KneedController
from mjbiped.controllers.bounded.bounded_ankle import BoundedAnkleController, BoundedKneedController
from mjbiped.controllers.bounded.placement import PlacementController
from mjbiped.controllers.bounded.sideways import SidewaysController
from mjbiped.controllers.bounded.supervisor import SupervisedController
from mjbiped.controllers.comparison.energy_constraint import EnergyConstraintController
from mjbiped.controllers.comparison.kinetic_energy import KineticEnergyController
from mjbiped.controllers.comparison.limit_cycle import LimitCycleController
from mjbiped.controllers.comparison.passivity import PassivityController
from mjbiped.controllers.library import LibraryController
from mjbiped.controllers.passive import PassiveController
from mjbiped.controllers.policy import PolicyController
from mjbiped.controllers.space import SpatialController
from mjbiped.utils.packages import second_name

__all__ = [
    "AdaptiveController",
    "BoundedAnkleController",
    "BoundedKneedController",
    "Controller",
    "EnergyConstraintController",
    "KineticEnergyController",
    "KneedController",
    "Law",
    "LawController",
    "LibraryController",
    "LimitCycleController",
    "Memory",
    "PassiveController",
    "PassivityController",
    "PlacementController",
    "PolicyController",
    "SidewaysController",
    "SpatialController",
    "SupervisedController",
    "never",
]

if __name__ == "controllers":
    second_name("mjbiped.controllers", __name__)
