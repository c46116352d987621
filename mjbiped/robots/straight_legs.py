"""What bipeds with two equal straight legs have in common, on whatever feet they stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.robots.bodies import Bodies, Segment
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
