"""What bipeds with two equal straight legs have in common, on whatever feet they stand."""

from __future__ import annotations

from typing import ClassVar

from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.robot import Robot


class StraightLegs(Robot):
    """A biped whose legs are rigid; subclasses are frozen dataclasses of these parameters and of their feet.

    Attributes:
        leg_mass: Mass of one leg, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the foot to the leg's centre of mass, m.
        upper_length: From the leg's centre of mass to the hip, m.
        leg_inertia: Inertia of a leg about its centre of mass, kg m^2.
    """

    leg_mass: float
    hip_mass: float
    lower_length: float
    upper_length: float
    leg_inertia: float

    angles: ClassVar[tuple[str, ...]] = ("stance", "swing")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip")
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "left", "right")
    collides_from_lift_off: ClassVar[bool] = False

    def uniform_rods(self) -> None:
        """Let legs whose inertia is not given be uniform rods."""
        if self.leg_inertia is None:
            object.__setattr__(self, "leg_inertia", self.leg_mass * self.leg_length**2 / 12)

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
