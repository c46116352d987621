"""No control: passive walking under gravity alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from controllers.base import Controller, Memory


@dataclass(frozen=True)
class PassiveController(Controller):
    """Zero torque at ankle and hip: the robot is moved by gravity alone (equation (28))."""

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """No torque, whatever the state; see `Controller.torque`."""
        return 0.0, 0.0
