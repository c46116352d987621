"""No control: passive walking under gravity alone."""

from __future__ import annotations

from dataclasses import dataclass

from mjbiped.control.controller import Unpowered


@dataclass(frozen=True)
class PassiveController(Unpowered):
    """Zero torque at ankle and hip: the robot is moved by gravity alone (equation (28))."""
