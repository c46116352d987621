"""Control laws for the compass biped. No simulator in here: plain functions of a state and a memory."""

from controllers.adaptive import AdaptiveController
from controllers.energy_constraint import EnergyConstraintController
from controllers.kinetic_energy import KineticEnergyController
from controllers.limit_cycle import LimitCycleController
from controllers.passive import PassiveController
from controllers.passivity import PassivityController
from mjbiped.control.controller import Controller, Memory

__all__ = [
    "AdaptiveController",
    "Controller",
    "EnergyConstraintController",
    "KineticEnergyController",
    "LimitCycleController",
    "Memory",
    "PassiveController",
    "PassivityController",
]
