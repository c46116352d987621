"""The servo that holds a swing foot which is a body: the ankle's motor, by the angles and rates of the joints.

The motor holds the sole parallel to that of the foot that stands. Both engines use this law.
"""

from __future__ import annotations

import math

RESPONSE = 60.0
"""Natural frequency of the servo, in sqrt(gravity / leg length): a foot that lands with an error of 5 degrees presses
with a fifth of the weight before it lies flat."""

GREATEST_ERROR = 0.08
"""Greatest angle between both soles, rad, that the torque grows with: a foot that lands across an edge must be able to
turn to lie on it."""


def gains(inertia: float, leg_length: float, gravity: float) -> tuple[float, float]:
    """Stiffness (N m/rad) and damping (N m s/rad) of the servo, critically damped.

    Args:
        inertia: Of the foot about its ankle, kg m^2.
        leg_length: m.
        gravity: m/s^2.
    """
    frequency = RESPONSE * math.sqrt(gravity / leg_length)
    return inertia * frequency**2, 2.0 * inertia * frequency


def servo_torque(stiffness: float, damping: float, error: float, rate: float) -> float:
    """Torque of the motor, N m, on the leg; the opposite acts on the foot.

    Args:
        stiffness: N m/rad.
        damping: N m s/rad.
        error: Angle of the swing foot's sole less that of the stance foot's, rad.
        rate: Its rate, rad/s.
    """
    return stiffness * min(max(error, -GREATEST_ERROR), GREATEST_ERROR) + damping * rate
