"""The torque that an ankle can transmit through a flat, massless sole.

The ground's force acts at x = -τ / F_n ahead of the ankle (`mjbiped.records.loads`). The sole stands flat while that
point, the centre of pressure, lies on it: -behind ≤ x ≤ ahead, or -ahead F_n ≤ τ ≤ behind F_n. Nothing is transmitted
where the ground does not press.
"""

from __future__ import annotations

import math


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
