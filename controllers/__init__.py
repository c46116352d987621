"""Control laws for bipeds with and without knees: plain functions of a state and a memory, without any simulator."""

from controllers.adaptive import AdaptiveController
from controllers.bounded.bounded_ankle import BoundedAnkleController
from controllers.bounded.kneed import BoundedKneedController
from controllers.bounded.supervisor import SupervisedController
from controllers.comparison.energy_constraint import EnergyConstraintController
from controllers.comparison.kinetic_energy import KineticEnergyController
from controllers.comparison.limit_cycle import LimitCycleController
from controllers.comparison.passivity import PassivityController
from controllers.kneed import KneedController
from controllers.library import LibraryController
from controllers.passive import PassiveController
from controllers.policy import PolicyController
from mjbiped.control.controller import Controller, Law, LawController, Memory, never

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
    "PolicyController",
    "SupervisedController",
    "never",
]
