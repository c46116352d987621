"""Bipeds in space: the legs of planar robots, set apart by a hip of some width, on feet that roll, too.

`Compass3D` has the straight legs of Table I, `Kneed3D` those of `mjbiped.KneedBiped`. Angles are the pitch angles of
the planar robot, and the roll behind them; `mjbiped.robots.space` has the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from mjbiped.robots.abduction import abducting
from mjbiped.robots.compass import Compass, StraightLegs
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.robots.space import Array, SpatialLinkage
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain

Width = Annotated[float, Domain(1e-9, 10.0, "m")]
_SOLE_WIDTH = Domain(1e-6, 10.0, "m")


@dataclass(frozen=True)
class Compass3D(InSpace, StraightLegs):
    """A compass biped in space; the defaults are Table I of the paper, with legs 10 cm apart.

    Attributes:
        leg_mass: Mass of one leg, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the foot to the leg's centre of mass, m.
        upper_length: From the leg's centre of mass to the hip, m.
        leg_inertia: Inertia of a leg about its centre of mass, across it, kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.
        hip_width: Distance between the legs, m.
        axial_inertia: Inertia of a leg about its own line, kg m^2.
        sole: Distances from the ankle to the heel and to the toe of a flat, massless sole, m, or one for both. They
            bound the ankle's torque; without a sole it is not bounded.
        sole_width: Width of that sole, m, by which the torque about the heading is bounded; None: it is not.
    """

    hip_width: Width = 0.1
    axial_inertia: Annotated[float, domains.INERTIA] = 0.01
    sole: Annotated[tuple[float, float] | None, domains.SOLE] = None
    sole_width: Annotated[float | None, _SOLE_WIDTH] = None

    kind: ClassVar[str] = "compass3d"
    in_plane: ClassVar[type[Robot]] = Compass
    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "roll")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "ankle_roll")
    places: ClassVar[tuple[str, ...]] = (*StraightLegs.places, "hip_y", "roll", "yaw")
    groupings: ClassVar[Mapping[int, tuple[int, ...]]] = {2: (0, 1)}
    knee_lock: ClassVar[Array] = np.eye(3)


@dataclass(frozen=True)
class Abducting3D(Compass3D):
    """A `Compass3D` whose hips abduct: a motor turns both legs aside, each by half of the abduction.

    Its gaits are those of the legs without abduction. Attributes are those of `Compass3D`.
    """

    kind: ClassVar[str] = "abducting3d"
    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "abduction", "roll")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "abduction", "ankle_roll")
    hips: ClassVar[tuple[str, ...]] = ("left_abduction", "right_abduction")
    places: ClassVar[tuple[str, ...]] = (*StraightLegs.places, *hips, "hip_y", "roll", "yaw")
    knee_lock: ClassVar[Array] = np.insert(np.eye(3), 2, 0.0, axis=0)

    @cached_property
    def in_space(self) -> Mapping[int, SpatialLinkage]:
        """The equations, by the number of angles without the roll: without the abduction, and with it."""
        plain = super().in_space
        return {**plain, 3: abducting(plain[2], self.bodies.leg[0])}

    @cached_property
    def input_matrix(self) -> Array:
        """B, shape (4, 4): the abduction has a motor of its own, too."""
        return np.eye(4) - np.eye(4, k=1) * [[1.0], [0.0], [0.0], [0.0]]

    def pitches(self, q: Array) -> Array:
        """The pitch angles among all angles, rad."""
        return q[:2]

    def opening(self, q: Array) -> float:
        """The angle by which either leg is turned aside, rad."""
        return float(0.5 * q[2])

    def landed(self, q: Array, dq: Array, turn: float = 0.0) -> tuple[Array, Array]:
        """All angles and rates after a touchdown, in which no joint is locked."""
        return self._linkage(q).touchdown(q, dq, turn)

    def accelerations(self, forces: Array, q: Array, dq: Array, pull: Array, *, locked: bool) -> Array:
        """Accelerations of all angles, none of which is locked; see `InSpace.accelerations`."""
        return self._linkage(q).accelerations(forces, q, dq, pull)


@dataclass(frozen=True)
class Kneed3D(InSpace, KneedBiped):
    """A biped in space with knees; the defaults are the legs of `mjbiped.KneedBiped`, 10 cm apart.

    Attributes:
        thigh_mass: Mass of one thigh, kg.
        shank_mass: Mass of one shank, kg.
        hip_mass: Mass at the hip, kg.
        thigh_length: From the hip to the knee, m.
        shank_length: From the knee to the foot, m.
        thigh_centre: From the hip down to the thigh's centre of mass, m.
        shank_centre: From the knee down to the shank's centre of mass, m.
        thigh_inertia: Inertia of a thigh about its centre of mass, kg m^2.
        shank_inertia: Inertia of a shank about its centre of mass, kg m^2.
        gravity: Acceleration of gravity, m/s^2.
        hip_width: Distance between the legs, m.
        axial_inertia: Inertia of a straight leg about its own line, kg m^2.
        sole: Distances from the ankle to the heel and to the toe of a flat, massless sole, m, or one for both. They
            bound the ankle's torque; without a sole it is not bounded.
        sole_width: Width of that sole, m, by which the torque about the heading is bounded; None: it is not.
    """

    hip_width: Width = 0.1
    axial_inertia: Annotated[float, domains.INERTIA] = 0.01
    sole_width: Annotated[float | None, _SOLE_WIDTH] = None

    kind: ClassVar[str] = "kneed3d"
    in_plane: ClassVar[type[Robot]] = KneedBiped
    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "shank", "roll")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "knee", "ankle_roll")
    places: ClassVar[tuple[str, ...]] = (*KneedBiped.places, "hip_y", "roll", "yaw")
    groupings: ClassVar[Mapping[int, tuple[int, ...]]] = {2: (0, 0, 1, 1), 3: (0, 0, 1, 2), 4: (0, 1, 2, 3)}
    knee_lock: ClassVar[Array] = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
