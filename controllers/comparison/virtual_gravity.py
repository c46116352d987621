"""Walking as if on another slope: gravity replaced by that of the imitated slope, and the energy that belongs to it."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.control.controller import Numbers
from mjbiped.robots import compass


def energy_error(constants: Any, slope: float, energy: float, q1: float, q2: float, dq: Numbers) -> float:
    r"""Error of the energy that the robot would have on a slope.

    .. math:: E - E_{ref} = T(q, \dot q) + V(q, \varphi) - E_{ref}

    Args:
        constants: Begin with the lumped `compass.Constants` of the controller's robot model.
        slope: phi, whose gravity counts; of the imitated slope or of the ground, rad.
        energy: E_ref about the stance foot, J.
        q1: Stance angle, rad.
        q2: Swing angle, rad.
        dq: Rates of both, rad/s.

    Returns:
        E - E_ref, J.
    """
    kinetic = compass.kinetic_energy(constants, q1, q2, dq[0], dq[1])
    return kinetic + compass.potential_energy(constants, q1, q2, slope) - energy


def shaped_torque(
    constants: Any, slope: float, imitated_slope: float, q1: float, q2: float, force1: float, force2: float
) -> tuple[float, float]:
    r"""Potential energy shaping (Spong's controlled symmetry) with further forces u.

    .. math:: \tau = B^{-1} [g(q, \varphi) - g(q, \varphi_r) + u] \quad\Rightarrow\quad
              \frac{d}{dt} [T + V(q, \varphi_r)] = u^T \dot q

    Args:
        constants: Begin with the lumped `compass.Constants` of the controller's robot model.
        slope: phi, of the ground, rad.
        imitated_slope: phi_r, rad.
        q1: Stance angle from that ground's normal, rad.
        q2: Swing angle, rad.
        force1: u on the stance leg, N m.
        force2: u on the swing leg, N m.

    Returns:
        Ankle and hip torque, N m.
    """
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, compass.legs_of(q1, q2))
    sine = math.sin(slope) - math.sin(imitated_slope)
    cosine = math.cos(slope) - math.cos(imitated_slope)
    return compass.joint_torques(gc1 * sine + gs1 * cosine + force1, gc2 * sine + gs2 * cosine + force2)
