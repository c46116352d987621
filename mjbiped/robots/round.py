"""The compass biped on round feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.errors import InputError
from mjbiped.robots.model import Model
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
        foot_radius: Radius of the feet, m. Their centres lie on the legs.
        leg_inertia: Inertia of a leg about its centre of mass, kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.

    Raises:
        InputError: A value is not a finite number of its domain, or the feet are as large as the legs are long.
    """

    leg_mass: Annotated[float, domains.LEG_MASS] = 5.0
    hip_mass: Annotated[float, domains.HIP_MASS] = 0.0
    lower_length: Annotated[float, domains.LENGTH] = 0.5
    upper_length: Annotated[float, domains.LENGTH] = 0.5
    foot_radius: Annotated[float, domains.FOOT_RADIUS] = 0.2
    leg_inertia: Annotated[float, domains.INERTIA] = None  # type: ignore[assignment]  # a number after __post_init__
    gravity: Annotated[float, domains.GRAVITY] = 9.81

    kind: ClassVar[str] = "round"

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        domains.check_fields(self)
        self.uniform_rods()
        domains.LEG.check("lower_length + upper_length", self.leg_length)
        if not self.foot_radius < self.leg_length:
            raise InputError(
                f"foot_radius = {self.foot_radius:g}: must be less than the leg's length, {self.leg_length:g} m: the "
                "centre of the arc is on the leg"
            )

    @property
    def radius(self) -> float:
        """Radius of the feet, m."""
        return self.foot_radius

    @property
    def model(self) -> Model:
        """Refuse: people's compiled laws have the equations of robots that stand on a point.

        Raises:
            InputError: Always.
        """
        raise InputError("robot.model is for robots that stand on a point or a sole; a RoundCompass rolls")
