"""The planar compass biped, and the base class of bipeds with two equal straight legs on any feet.

Parameters, equations of motion, energy and impact map are those of Table I and equations 1 to 4 and 13.

Each law stands here once, as a module-level function of plain floats that Numba can compile: its first argument is
`Compass.constants`, the robot's lumped parameters. `Compass` wraps the same functions for NumPy.

Symbols: m leg mass, m_H hip mass, a lower length (foot to leg COM), b upper length (leg COM to hip), l = a + b,
J leg inertia about its own COM, g gravity; q1 stance and q2 swing leg from the ground's normal, rad, positive forward;
slope positive downhill. Forces are generalised forces B tau, N m. docs/model.md derives the equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.numerics.trigonometry import sine_cosine
from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.model import solve_pair
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains


@dataclass(frozen=True)
class StraightLegs(Robot):
    """A biped whose legs are rigid; subclasses add what their feet need. The defaults are Table I of the paper.

    Attributes:
        leg_mass: Mass of one leg, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the foot to the leg's centre of mass, m.
        upper_length: From the leg's centre of mass to the hip, m.
        leg_inertia: Inertia of a leg about its centre of mass, kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.

    Raises:
        InputError: A value is not a finite number of its domain; see `mjbiped.utils.domains`.
    """

    leg_mass: Annotated[float, domains.LEG_MASS] = 5.0
    hip_mass: Annotated[float, domains.HIP_MASS] = 0.0
    lower_length: Annotated[float, domains.LENGTH] = 0.5
    upper_length: Annotated[float, domains.LENGTH] = 0.5
    leg_inertia: Annotated[float, domains.INERTIA] = None  # type: ignore[assignment]  # a number after __post_init__
    gravity: Annotated[float, domains.GRAVITY] = 9.81

    angles: ClassVar[tuple[str, ...]] = ("stance", "swing")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip")
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "left", "right")
    collides_from_lift_off: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        domains.check_fields(self)
        if self.leg_inertia is None:
            object.__setattr__(self, "leg_inertia", self.leg_mass * self.leg_length**2 / 12)
        domains.LEG.check("lower_length + upper_length", self.leg_length)

    @property
    def leg_length(self) -> float:
        """Length l = a + b of a leg, from the hip down to the foot, m."""
        return self.lower_length + self.upper_length

    @property
    def total_mass(self) -> float:
        """Mass of the whole robot, kg."""
        return 2 * self.leg_mass + self.hip_mass

    @property
    def bodies(self) -> Bodies:
        """A leg on either side of the hip."""
        leg = Segment("leg", self.leg_mass, self.leg_length, self.upper_length, self.leg_inertia)
        return Bodies("scene.xml", self.hip_mass, (leg,))


Constants: TypeAlias = tuple[float, float, float, float, float, float, float]
"""Lumped parameters: stance inertia m a^2 + J + (m_H + m) l^2, coupling m b l and swing inertia m b^2 + J in kg m^2;
gravity moments g [m a + (m_H + m) l] and g m b in N m; impact terms (2 m a + m_H l) l and J - m a b in kg m^2."""

Array: TypeAlias = NDArray[np.float64]


Legs: TypeAlias = tuple[float, float, float, float]
"""Sine and cosine of the stance leg's, then of the swing leg's angle, so that each is taken once."""


def legs_of(q1: float, q2: float) -> Legs:
    """Sine and cosine of either angle."""
    (s1, c1), (s2, c2) = sine_cosine(q1), sine_cosine(q2)
    return s1, c1, s2, c2


def between_legs(legs: Legs) -> tuple[float, float]:
    """Sine and cosine of q1 - q2."""
    s1, c1, s2, c2 = legs
    return s1 * c2 - c1 * s2, c1 * c2 + s1 * s2


def swing_foot(length: float, legs: Legs) -> tuple[float, float]:
    """The swing foot from the stance foot, m: along the ground, and along its normal, H of eq. (4) on a plane."""
    s1, c1, s2, c2 = legs
    return length * (s1 - s2), length * (c1 - c2)


def mass_terms(constants: Constants, legs: Legs) -> tuple[float, float, float]:
    """Entries (m11, m12, m22) of the symmetric mass matrix M(q) of eq. (1), kg m^2."""
    _, cosine = between_legs(legs)
    return constants[0], -constants[1] * cosine, constants[2]


def coriolis_terms(constants: Constants, legs: Legs, dq1: float, dq2: float) -> tuple[float, float]:
    """The vector C(q, dq) dq of eq. (1), N m."""
    sine, _ = between_legs(legs)
    coupling = constants[1] * sine
    return -coupling * dq2 * dq2, coupling * dq1 * dq1


def gravity_terms(constants: Constants, legs: Legs) -> tuple[float, float, float, float]:
    """(gc1, gc2, gs1, gs2) of eq. (13), N m: g(q, slope) = g_c(q) sin(slope) + g_s(q) cos(slope)."""
    g1, g2 = constants[3], constants[4]
    s1, c1, s2, c2 = legs
    return -g1 * c1, g2 * c2, -g1 * s1, g2 * s2


def joint_torques(force1: float, force2: float) -> tuple[float, float]:
    """Ankle and hip torque, B^-1 f, that make the generalised forces f on stance and swing leg; all in N m."""
    return force1 + force2, force2  # B = [[1, -1], [0, 1]]


def acceleration(
    constants: Constants,
    q1: float,
    q2: float,
    dq1: float,
    dq2: float,
    sin_slope: float,
    cos_slope: float,
    force1: float,
    force2: float,
) -> tuple[float, float]:
    """Leg accelerations of eq. (1), M^-1 (B tau - C dq - g), rad/s^2; `force1`, `force2` are B tau in N m."""
    legs = legs_of(q1, q2)
    m11, m12, m22 = mass_terms(constants, legs)
    c1, c2 = coriolis_terms(constants, legs, dq1, dq2)
    gc1, gc2, gs1, gs2 = gravity_terms(constants, legs)
    f1 = force1 - c1 - gc1 * sin_slope - gs1 * cos_slope
    f2 = force2 - c2 - gc2 * sin_slope - gs2 * cos_slope
    return solve_pair(m11, m12, m22, f1, f2)


def inverse_dynamics(
    constants: Constants,
    legs: Legs,
    dq1: float,
    dq2: float,
    sin_slope: float,
    cos_slope: float,
    ddq1: float,
    ddq2: float,
) -> tuple[float, float]:
    """Generalised forces B tau of eq. (1), M ddq + C dq + g, that make the legs accelerate as given, N m."""
    m11, m12, m22 = mass_terms(constants, legs)
    c1, c2 = coriolis_terms(constants, legs, dq1, dq2)
    gc1, gc2, gs1, gs2 = gravity_terms(constants, legs)
    force1 = (c1 + gc1 * sin_slope + gs1 * cos_slope) + m11 * ddq1 + m12 * ddq2
    force2 = (c2 + gc2 * sin_slope + gs2 * cos_slope) + m12 * ddq1 + m22 * ddq2
    return force1, force2


def kinetic_energy(constants: Constants, q1: float, q2: float, dq1: float, dq2: float) -> float:
    """Kinetic energy dq' M dq / 2, J."""
    m11, m12, m22 = mass_terms(constants, legs_of(q1, q2))
    return 0.5 * (m11 * dq1 * dq1 + m22 * dq2 * dq2) + m12 * dq1 * dq2


def potential_energy(constants: Constants, q1: float, q2: float, slope: float) -> float:
    """Potential energy, J, zero at the height of the stance foot."""
    return constants[3] * math.cos(q1 + slope) - constants[4] * math.cos(q2 + slope)


def impact_rates(constants: Constants, q1: float, q2: float, dq1: float, dq2: float) -> tuple[float, float]:
    """Rates (dq1_plus, dq2_plus) after the swing foot's plastic impact, the legs exchanged (eq. 2), rad/s.

    The angular momentum of the robot about the impact point and that of the leg that leaves the ground about the hip
    are conserved. `dq1_plus` belongs to the new stance leg, which is the old swing leg. The posture is that at
    touchdown; its legs need not be symmetric, so that the map holds on any ground.
    """
    cosine = math.cos(q1 - q2)
    m11, m12, m22 = mass_terms(constants, legs_of(q2, q1))
    about_point = constants[5] * cosine * dq1 + constants[6] * dq2  # less the momentum about the hip
    about_hip = constants[6] * dq1
    return solve_pair(m11, m12, m22, about_point, about_hip)


@dataclass(frozen=True)
class Compass(StraightLegs):
    """A planar compass biped with two equal straight legs and point feet; the defaults are Table I of the paper.

    The command line tells the first sentence about each attribute.

    Attributes:
        leg_mass: Mass of one leg, kg. The symbol is m.
        hip_mass: Mass at the hip, kg. The symbol of this point mass, the upper body, is m_H.
        lower_length: From the foot to the leg's centre of mass, m. The symbol is a.
        upper_length: From the leg's centre of mass to the hip, m. The symbol is b.
        leg_inertia: Inertia of a leg about its centre of mass, kg m^2; a uniform rod's unless given. The symbol is J.
            None is replaced by the rod's m l^2/12 (which `dataclasses.replace` then keeps).
        gravity: Acceleration of gravity, m/s^2. The symbol is g.
        sole: Distances from the ankle to the heel and to the toe of a flat, massless sole, m, or one for both. They
            bound the ankle's torque; without a sole it is not bounded.

    Raises:
        InputError: a value is not a finite number of its domain; see `mjbiped.utils.domains`.
    """

    sole: Annotated[tuple[float, float] | None, domains.SOLE] = None

    kind: ClassVar[str] = "compass"

    @cached_property
    def constants(self) -> Constants:
        """The lumped parameters that the functions of this module take; see `Constants`."""
        m, mH, a, b = self.leg_mass, self.hip_mass, self.lower_length, self.upper_length
        J, l, g = self.leg_inertia, self.leg_length, self.gravity  # noqa: E741 - the paper's symbol
        return (
            m * a * a + J + (mH + m) * l * l,
            m * b * l,
            m * b * b + J,
            g * (m * a + (mH + m) * l),
            g * m * b,
            (2 * m * a + mH * l) * l,
            J - m * a * b,
        )

    def impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """State (q_plus, dq_plus), each of shape (2,), after the swing foot's impact, with the legs exchanged (eq. 2).

        The angles stay relative to the normal that `q` was measured from; where the ground's slope changes under the
        new stance foot, subtract the change from both (eq. 2).
        """
        q1, q2 = domains.ANGLE.array("q", q, (2,)).tolist()
        dq1, dq2 = domains.RATE.array("dq", dq, (2,)).tolist()
        return np.array([q2, q1]), np.array(impact_rates(self.constants, q1, q2, dq1, dq2))

    def to_dict(self) -> dict[str, Any]:
        """Kind and parameters; of a compass biped itself no kind: records had no other robots once."""
        return self._told() if self.kind == Compass.kind else super().to_dict()
