"""Lagrange's equations from the places of masses, by SymPy: the derivation that the project's own is held against."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

Body = tuple[Any, Any, Any, sp.Matrix]
"""Mass (kg), inertia about its centre of mass (kg m^2), angular rate (rad/s), and place (x, z), m."""
RELATIVE = 1e-12
"""Rounding of a few dozen operations; the terms differ by a factor of about 1e2 at most."""


def close(actual: object, expected: object, scale: float | None = None, relative: float = RELATIVE) -> None:
    """Check that numbers are equal to `relative` of the largest expected one, or of `scale`."""
    size = float(np.max(np.abs(np.asarray(expected)))) if scale is None else scale
    np.testing.assert_allclose(np.asarray(actual), np.asarray(expected), rtol=0, atol=relative * size)


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
