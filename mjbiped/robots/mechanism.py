"""The linkage that a robot's bodies make while it stands on one foot."""

from __future__ import annotations

import cmath
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mjbiped.dynamics.linkage import BASE, END, HIP, MASS, POINTS, Linkage
from mjbiped.dynamics.modes import FLAT, HEEL, TOE
from mjbiped.robots.bodies import Bodies, Foot

UPPER, LOWER, FEET = (0, 1), (3, 2), (2, 3)
"""Segments of the stance leg, then of the swing leg; and both feet where they are bodies."""

Levers = NDArray[np.complex128]
"""Of a point, one for each segment, m: the real part along its line, the imaginary one a right angle ahead."""


def linkages_of(bodies: Bodies, radius: float, gravity: float) -> tuple[Linkage, ...]:
    """The linkage of a biped on its flat foot and, of feet that are bodies, on its toe and on its heel.

    Of these feet there are nine: first with the swing foot in the air, then with its toe down, then with its heel.

    Args:
        bodies: The robot's.
        radius: Of round feet, m.
        gravity: m/s^2.
    """
    edges = (FLAT,) if bodies.foot is None else (FLAT, TOE, HEEL)
    return tuple(_linkage_on(edge, down, bodies, radius, gravity) for down in edges for edge in edges)


def linkage_with(
    masses: Sequence[tuple[float, float, int, Levers]],
    hip: Levers,
    end: Levers,
    base: Levers,
    *,
    angles: int,
    gravity: float,
    radius: float = 0.0,
    knees: bool = False,
) -> Linkage:
    """The linkage of some bodies.

    Args:
        masses: Of each body its mass (kg), its inertia about its centre of mass (kg m^2), the segment that it turns
            with (-1: a point mass), and the levers of its centre of mass.
        hip: Levers of the hip.
        end: Levers of the swing foot.
        base: Levers of the stance foot's ankle.
        angles: Number of the angles of a state.
        gravity: m/s^2.
        radius: Of round feet, m.
        knees: Whether there are knees.
    """
    products, first, whole = np.zeros((len(hip), len(hip)), dtype=np.complex128), np.zeros_like(hip), 0.0
    for mass, inertia, segment, levers in masses:
        products += mass * np.outer(levers.conj(), levers)
        first, whole = first + mass * levers, whole + mass
        if segment >= 0:
            products[segment, segment] += inertia
    points = np.zeros((POINTS, len(hip)))
    for place, levers in ((HIP, hip), (END, end), (BASE, base), (MASS, first)):
        points[place], points[place + 1] = levers.real, levers.imag
    return Linkage(
        segments=len(hip),
        angles=angles,
        knees=knees,
        mass=whole,
        gravity=gravity,
        radius=radius,
        between=0.0,
        even=products.real.tolist(),
        odd=products.imag.tolist(),
        levers=points.tolist(),
    )


def _linkage_on(edge: int, down: int, bodies: Bodies, radius: float, gravity: float) -> Linkage:
    """The linkage of a biped as its stance foot stands, and with an edge of the swing foot down, or none."""
    leg, foot, chain = bodies.leg, bodies.foot, (UPPER, LOWER)
    base = np.zeros(2 * len(leg) + 2 * (foot is not None), dtype=np.complex128)
    lines = [(part.length - (radius if part is leg[-1] else 0.0)) * cmath.exp(1j * part.turn) for part in leg]
    if foot is not None and edge != FLAT:
        base[FEET[0]] = _ankle_from(foot, edge)
    hip = base.copy()
    for k, line in enumerate(lines):
        hip[chain[k][0]] += line
    masses, end = [(bodies.hip_mass, 0.0, -1, hip)], hip.copy()
    for side in (0, 1):
        end = hip.copy()
        for k, (part, line) in enumerate(zip(leg, lines, strict=True)):
            centre = end.copy()
            centre[chain[k][side]] -= complex(part.centre, -part.offset) * cmath.exp(1j * part.turn)
            # from the stance foot up and down again
            masses.insert(len(masses) if side else 0, (part.mass, part.inertia, chain[k][side], centre))
            end[chain[k][side]] -= line
        if foot is not None:  # a swing foot in the air is held parallel to the other one
            masses.append((foot.mass, foot.inertia if side == 0 or down != FLAT else 0.0, FEET[side], end))
    if foot is not None and down != FLAT:
        end = end.copy()
        end[FEET[1]] -= _ankle_from(foot, down)
    angles = len(leg) + 1 + 2 * (foot is not None)
    return linkage_with(masses, hip, end, base, angles=angles, radius=radius, gravity=gravity, knees=len(leg) > 1)


def _ankle_from(foot: Foot, edge: int) -> complex:
    """Levers of a foot's ankle from its toe, or from its heel, m."""
    return complex(foot.height, -foot.ahead if edge == TOE else foot.behind)
