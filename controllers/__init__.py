"""Control laws for the compass biped. No simulator in here: plain functions of a state and a memory."""

from controllers.adaptive import AdaptiveController
from controllers.base import Controller, Memory
from controllers.passive import PassiveController

__all__ = ["AdaptiveController", "Controller", "Memory", "PassiveController"]
