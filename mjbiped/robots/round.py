"""The compass biped on round feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.errors import InputError
from mjbiped.robots.straight_legs import StraightLegs
from mjbiped.utils import domains


@dataclass(frozen=True)
class RoundCompass(StraightLegs):
    """A compass biped on round feet, after McGeer (1990): two equal straight legs that end in circular arcs.

    It walks on planes alone: on uneven ground an arc would touch it in two places at once.

    Attributes:
        leg_mass: Mass of one leg, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the foot's lowest point, while the leg is upright, to the leg's centre of mass, m.
        upper_length: From the leg's centre of mass to the hip, m.
        leg_inertia: Inertia of a leg about its centre of mass, kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.
        foot_radius: Radius of the feet, m. Their centres lie on the legs.

    Raises:
        InputError: A value is not a finite number of its domain, or the feet are as large as the legs are long.
    """

    foot_radius: Annotated[float, domains.FOOT_RADIUS] = 0.2

    kind: ClassVar[str] = "round"

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        super().__post_init__()
        if not self.foot_radius < self.leg_length:
            raise InputError(
                f"foot_radius = {self.foot_radius:g}: must be less than the leg's length, {self.leg_length:g} m: the "
                "centre of the arc is on the leg"
            )

    @property
    def radius(self) -> float:
        """Radius of the feet, m."""
        return self.foot_radius
