"""Bipeds in space: the legs of the planar robots, set apart by a hip of some width, on feet that also roll.

`Compass3D` has the straight legs of Table I, `Kneed3D` those of `mjbiped.KneedBiped`. A state is (s, q_1, ..., q_n), the
roll and the pitch angles of `mjbiped.robots.space`, then their rates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.robots.bodies import Bodies
from mjbiped.robots.compass import StraightLegs
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.space import Array, SpatialLinkage, exchanged
from mjbiped.utils import domains

WIDTH = domains.Domain(1e-9, 10.0, "m")


def spatial(bodies: Bodies, gravity: float, width: float, axial: float, pelvis: float, groups: tuple[int, ...]) -> SpatialLinkage:
    """The linkage in space of a robot's legs.

    Args:
        bodies: The legs and the mass at the hip.
        gravity: m/s^2.
        width: Between the legs, m.
        axial: Inertia of a whole leg about its line, kg m^2, shared by its segments by their masses.
        pelvis: Inertia of what the hip carries about the heading, kg m^2.
        groups: With which pitch angle each segment moves, from the stance foot up and down again.
    """
    leg, n = bodies.leg, 2 * len(bodies.leg)
    lengths = np.array([segment.length for segment in leg])
    up = np.append(lengths[::-1], np.zeros(len(leg)))  # levers of the hip
    levers, masses, lateral = [], [], []
    for k, segment in enumerate(reversed(leg)):  # from the stance foot up to the hip
        arm = np.append(up[:k], segment.length - segment.centre)
        levers.append(np.pad(arm, (0, n - len(arm))))
        masses.append(segment.mass)
        lateral.append(0.0)
    levers, masses, lateral = [*levers, up], [*masses, bodies.hip_mass], [*lateral, width / 2]
    for k, segment in enumerate(leg):  # and down again
        arm = np.append(up[: len(leg)], [-each.length for each in leg[:k]] + [-segment.centre])
        levers.append(np.pad(arm, (0, n - len(arm))))
        masses.append(segment.mass)
        lateral.append(width)
    foot = np.append(up[: len(leg)], -lengths)
    inertia = np.array([segment.inertia for segment in (*reversed(leg), *leg)])
    share = np.array([segment.mass for segment in (*reversed(leg), *leg)])
    along = axial * share / sum(segment.mass for segment in leg)
    moves = np.asarray(groups)[:, None] == np.arange(max(groups) + 1)
    return SpatialLinkage(
        masses=np.array(masses),
        levers=np.array(levers) @ moves,
        lateral=np.array(lateral),
        foot=foot @ moves,
        width=width,
        inertia=inertia @ moves,
        axial=along @ moves,
        pelvis=pelvis,
        gravity=gravity,
    )


@dataclass(frozen=True)
class Compass3D(StraightLegs):
    """A compass biped in space with two equal straight legs; the defaults are Table I of the paper, 10 cm apart.

    Attributes:
        leg_mass: Mass of one leg, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the foot to the leg's centre of mass, m.
        upper_length: From the leg's centre of mass to the hip, m.
        leg_inertia: Inertia of a leg about its centre of mass, across it, kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.
        hip_width: Distance between the legs, m.
        axial_inertia: Inertia of a leg about its own line, kg m^2.
    """

    hip_width: Annotated[float, WIDTH] = 0.1
    axial_inertia: Annotated[float, domains.INERTIA] = 0.01

    kind: ClassVar[str] = "compass3d"
    angles: ClassVar[tuple[str, ...]] = ("roll", "stance", "swing")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "ankle_roll")

    @property
    def pelvis_inertia(self) -> float:
        """Inertia of the hip's mass about the heading, of a uniform rod across, kg m^2."""
        return self.hip_mass * self.hip_width**2 / 12

    @cached_property
    def in_space(self) -> dict[int, SpatialLinkage]:
        """The equations by the number of pitch angles."""
        return {2: spatial(self.bodies, self.gravity, self.hip_width, self.axial_inertia, self.pelvis_inertia, (0, 1))}


@dataclass(frozen=True)
class Kneed3D(KneedBiped):
    """A biped in space with knees; the defaults are the legs of `mjbiped.KneedBiped`, 10 cm apart."""

    hip_width: Annotated[float, WIDTH] = 0.1
    axial_inertia: Annotated[float, domains.INERTIA] = 0.01

    kind: ClassVar[str] = "kneed3d"
    angles: ClassVar[tuple[str, ...]] = ("roll", "stance", "swing", "shank")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "knee", "ankle_roll")

    @cached_property
    def in_space(self) -> dict[int, SpatialLinkage]:
        """The equations by the number of pitch angles: two of straight legs, three with the swing knee free."""
        pelvis = self.hip_mass * self.hip_width**2 / 12
        groups = {2: (0, 0, 1, 1), 3: (0, 0, 1, 2), 4: (0, 1, 2, 3)}
        return {n: spatial(self.bodies, self.gravity, self.hip_width, self.axial_inertia, pelvis, g) for n, g in groups.items()}


def touchdown(linkage: SpatialLinkage, q: Array, dq: Array) -> tuple[Array, Array]:
    """State after the plastic impact of the swing foot, in the legs' new roles."""
    new = exchanged(q)
    return new, np.linalg.solve(linkage.mass_matrix(new), linkage.momenta_after_touchdown(q, dq))
