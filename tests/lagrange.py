"""Lagrange's equations from the places of masses, by SymPy: the derivation that the project's own is held against."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

Body = tuple[Any, Any, Any, sp.Matrix]
"""Mass (kg), inertia about its centre of mass (kg m^2), angular rate (rad/s), and place (x, z), m."""


def lagrange(q: sp.Matrix, dq: sp.Matrix, bodies: Sequence[Body], gravity: Any) -> dict[str, Any]:
    """The equations M ddq + h + g = force of bodies in a plane.

    Args:
        q: Coordinates.
        dq: Their rates.
        bodies: Of what the robot consists.
        gravity: m/s^2.

    Returns:
        By name: the matrix M; h, what the rates make; g, what gravity makes; kinetic energy T and potential energy V;
        and the momentum (x, z).
    """
    speeds = [place.jacobian(q) * dq for *_, place in bodies]
    moving = list(zip(bodies, speeds, strict=True))
    T = sum(mass * v.dot(v) / 2 + inertia * rate**2 / 2 for (mass, inertia, rate, _), v in moving)
    V = sum((mass * gravity * place[1] for mass, *_, place in bodies), sp.Integer(0))
    return {
        "M": sp.hessian(T, list(dq)),
        "h": sp.Matrix([T]).jacobian(dq).jacobian(q) * dq - sp.Matrix([T]).jacobian(q).T,
        "g": sp.Matrix([V]).jacobian(q).T,
        "T": T,
        "V": V,
        "momentum": sum((mass * v for (mass, *_), v in moving), sp.zeros(2, 1)),
    }
