"""The ankle: the torque that a flat, massless sole transmits, and the servo that holds a swing foot with mass.

The ground's force acts at x = -τ / F_n ahead of the ankle (`mjbiped.records.loads`). The sole stands flat while that
point, the centre of pressure, lies on it: -behind ≤ x ≤ ahead, or -ahead F_n ≤ τ ≤ behind F_n. Nothing is transmitted
where the ground does not press. The servo holds the sole of a swing foot parallel to that of the foot that stands.
"""

from __future__ import annotations

import math

RESPONSE = 60.0
"""Natural frequency of the servo, in sqrt(gravity / leg length): a foot that lands with an error of 5 degrees presses
with a fifth of the weight before it lies flat."""

GREATEST_ERROR = 0.08
"""Greatest angle between both soles, rad, that the torque grows with: a foot that lands across an edge must be able to
turn to lie on it."""


def moment_about_ankle(torque: float, height: float, along: float) -> float:
    """Moment of the ground's force about an ankle over a flat sole, N m: -x F_n for a force at x ahead of the ankle.

    Args:
        torque: Of the ankle, N m.
        height: Of the ankle over the sole, m.
        along: Force of the ground along the sole, forward, N.
    """
    return torque + height * along


def bounded(torque: float, force: float, behind: float, ahead: float) -> float:
    """The ankle torque that a sole transmits of one that is asked for, N m, by the normal force that acts.

    Args:
        torque: Torque asked for, N m.
        force: Normal force of the ground, N.
        behind: Distance from the ankle back to the heel, m; infinite without a sole.
        ahead: Distance from the ankle forward to the toe, m.
    """
    if behind == math.inf:
        return torque
    pressed = max(force, 0.0)
    return min(max(torque, -ahead * pressed), behind * pressed)


def bounded_by_own_force(
    torque: float, force: float, force_without: float, behind: float, ahead: float
) -> tuple[float, float]:
    """The ankle torque that a sole transmits, where the normal force depends on that torque; and that force, N.

    The force is linear in the torque, because the accelerations are: F(τ) = F(0) + τ dF/dτ.

    Args:
        torque: Torque asked for, N m, and not zero.
        force: Normal force under that torque, N.
        force_without: Normal force without a torque of the ankle, N.
        behind: Distance from the ankle back to the heel, m.
        ahead: Distance from the ankle forward to the toe, m.
    """
    if force_without <= 0.0:
        return 0.0, force_without
    end, gain = behind if torque > 0.0 else -ahead, (force - force_without) / torque
    share = 1.0 - end * gain
    if share <= 0.0:  # the force grows faster with the torque than the bound asks for
        return torque, force
    greatest = end * force_without / share
    given = min(torque, greatest) if torque > 0.0 else max(torque, greatest)
    return given, force_without + given * gain


def servo_gains(inertia: float, leg_length: float, gravity: float) -> tuple[float, float]:
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
