"""The bodies that a robot consists of, and the linkage that they make while it stands on one foot."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.dynamics.linkage import BASE, END, HIP, MASS, POINTS, Linkage
from mjbiped.dynamics.modes import FLAT, HEEL, TOE


class Segment(NamedTuple):
    """A segment of a leg.

    Attributes:
        name: Of what is seen of it in the robot's file in `models/`, behind the leg's name and "_".
        mass: kg.
        length: From its upper end to its lower end, m.
        centre: From its upper end down to its centre of mass, m.
        inertia: About its centre of mass, kg m^2.
        turn: Angle of its line, from end to end, when all joints of the leg are at zero, rad.
        offset: Of its centre of mass ahead of that line, m.
        axial: Inertia about its line, kg m^2; None: no motion of the robot turns the segment about its line.
    """

    name: str
    mass: float
    length: float
    centre: float
    inertia: float
    turn: float = 0.0
    offset: float = 0.0
    axial: float | None = None

    def place(self, distance: float, ahead: float = 0.0) -> tuple[float, float]:
        """Place x, z of a point from the segment's upper end while all joints are at zero, m.

        Args:
            distance: Down the segment's line, m.
            ahead: Ahead of that line, m.
        """
        sine, cosine = math.sin(self.turn), math.cos(self.turn)
        return 0.0 - distance * sine + ahead * cosine, 0.0 - distance * cosine - ahead * sine


class Limb(NamedTuple):
    """A leg by its names in the robot's file in `models/`; its foot and its contact sensor bear the leg's name, too.

    Attributes:
        name: Of the leg.
        hinge: Joint that turns its upper segment.
        ankle: Motor that turns it against the ground.
        across: Where it is seen across the walking direction, leg lengths.
        offset: Angle of its upper segment when that of the hinge is zero, rad, where legs share a hinge.
        lap: What is added to that with each round in which all legs have stood, rad.
        aside: Where its hinge is to the left of the hip's middle, m.
    """

    name: str
    hinge: str
    ankle: str
    across: float
    offset: float = 0.0
    lap: float = 0.0
    aside: float = 0.0


SIDES = (Limb("left", "left", "left_ankle", 0.04), Limb("right", "right", "right_ankle", -0.04))
"""The legs of a biped."""


class Foot(NamedTuple):
    """A foot that turns about the end of its leg, the ankle, where its centre of mass is.

    Attributes:
        mass: kg.
        inertia: About the ankle, kg m^2.
        height: Of the ankle over the sole, m.
        behind: From below the ankle back to the heel, m.
        ahead: From below the ankle forward to the toe, m.
        box: Whether it stands on all of its sole, or only on heel and toe.
    """

    mass: float
    inertia: float
    height: float
    behind: float
    ahead: float
    box: bool


class Bodies(NamedTuple):
    """A robot's bodies.

    Attributes:
        scene: File in `models/` that holds the robot and its surroundings.
        hip_mass: Point mass at the hip, kg.
        leg: The segments of each leg, from the hip down: one, or two with a knee between them.
        limbs: The legs, in the order in which they stand.
        foot: Of each leg; None: legs end in points or arcs.
        hip_inertia: Inertia of what the hip carries, kg m^2; 0 where the hip does not turn.
    """

    scene: str
    hip_mass: float
    leg: tuple[Segment, ...]
    limbs: tuple[Limb, ...] = SIDES
    foot: Foot | None = None
    hip_inertia: float = 0.0

    def feet(self, limb: Limb) -> list[str]:
        """Names of the geoms with which a leg meets the ground."""
        if self.foot is None:
            return [f"{limb.name}_foot"]
        return [f"{limb.name}_sole"] if self.foot.box else [f"{limb.name}_heel", f"{limb.name}_toe"]


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
