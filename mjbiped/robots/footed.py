"""The compass biped on flat feet that have mass and turn about an ankle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.errors import InputError
from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies, Foot, Segment
from mjbiped.robots.chain import Array
from mjbiped.robots.compass import Compass
from mjbiped.utils import domains

PADS, BOX = "pads", "box"
"""What a foot stands on: a pad under the heel and one under the toe, or all of a flat sole."""


@dataclass(frozen=True)
class FootedCompass(Compass):
    """A compass biped with feet that are bodies, each on an ankle with a motor.

    A leg and its foot together are the leg of `Compass`: the leg is lighter by the foot, whose centre of mass is the
    ankle. A robot that stands flat, with its other foot parallel to the ground, therefore has the equations of a
    compass biped with a sole, but for the ankle's height. Laws, gaits and references are found for that compass biped
    (`flat`).

    In the hybrid engine the stance foot lies flat, or turns about its toe or heel where the ankle's torque is more than
    the sole bears, and comes down again. On ground of another slope a foot lands on its heel or toe and turns until it
    lies flat.

    In MuJoCo the feet stand, tip and slide on the ground as their contacts make them. A servo holds the swing
    foot parallel to the ground, whose slope it infers from the joints' angles at the last footholds.

    Attributes:
        leg_mass: Mass of one leg with its foot, kg.
        hip_mass: Mass at the hip, kg.
        lower_length: From the ankle to the centre of mass of leg and foot, m.
        upper_length: From that centre of mass to the hip, m.
        leg_inertia: Inertia of leg and foot about their centre of mass, without the foot's own about the ankle,
            kg m^2; a uniform rod's unless given.
        gravity: Acceleration of gravity, m/s^2.
        sole: Distances along the sole from below the ankle to the heel and to the toe, m, or one for both.
        foot_mass: Mass of one foot, kg.
        ankle_height: Height of the ankle over the sole, m.
        underside: "pads" under heel and toe, or a "box" that stands on all of its sole.

    Raises:
        InputError: A value is outside its domain, or a foot is heavier than what the leg's inertia leaves for it.
    """

    sole: Annotated[tuple[float, float] | None, domains.SOLE] = (0.12, 0.12)
    foot_mass: Annotated[float, domains.LEG_MASS] = 0.15
    ankle_height: Annotated[float, domains.LENGTH] = 0.02
    underside: Annotated[str, domains.Words((PADS, BOX))] = PADS

    kind: ClassVar[str] = "footed"
    places: ClassVar[tuple[str, ...]] = (*Compass.places, "left_foot", "right_foot")

    def __post_init__(self) -> None:
        """Check every value, and that the leg without its foot is a possible body."""
        super().__post_init__()
        if self.sole is None or min(self.sole) <= 0.0:
            raise InputError(
                f"sole = {self.sole}: a FootedCompass stands on heel and toe, both farther than 0 from the ankle; a "
                "Compass needs no sole"
            )
        if not (self.foot_mass < self.leg_mass and self._leg_alone.inertia >= 0.0):
            raise InputError(
                f"foot_mass = {self.foot_mass:g} kg: too heavy for a leg of {self.leg_mass:g} kg whose inertia, foot "
                f"included, is {self.leg_inertia:g} kg m^2; give a lighter foot"
            )

    @property
    def flat(self) -> Compass:
        """The compass biped of the same legs on the same soles."""
        return Compass(**{name: getattr(self, name) for name in Compass.parameters()})

    @property
    def mechanism(self) -> Compass:  # type: ignore[override]  # without feet it is of another kind
        """The compass biped of the same legs without feet."""
        return self.flat.mechanism

    @property
    def _leg_alone(self) -> Segment:
        """A leg without its foot."""
        mass = self.leg_mass - self.foot_mass
        from_ankle = self.leg_mass * self.lower_length / mass
        about_ankle = self.leg_inertia + self.leg_mass * self.lower_length**2
        return Segment("leg", mass, self.leg_length, self.leg_length - from_ankle, about_ankle - mass * from_ankle**2)

    @property
    def foot(self) -> Foot:
        """A foot."""
        behind, ahead = self.sole or (0.0, 0.0)
        inertia = self.foot_mass * (behind + ahead) ** 2 / 12
        return Foot(self.foot_mass, inertia, self.ankle_height, behind, ahead, self.underside == BOX)

    @property
    def bodies(self) -> Bodies:
        """A leg and a foot on either side of the hip."""
        return Bodies("footed_scene.xml", self.hip_mass, (self._leg_alone,), foot=self.foot)

    def limbs(self, qpos: ArrayLike) -> Array:
        """Positions of hip, ankle and the sole's point below it; see `Robot.limbs`."""
        points, places = super().limbs(qpos), np.asarray(qpos, dtype=np.float64)
        angles = places[..., 2:4] + places[..., 4:6]
        below = points[..., -1, :] - self.ankle_height * np.stack([np.sin(angles), np.cos(angles)], axis=-1)
        return np.concatenate([points, below[..., None, :]], axis=-2)

    def outline(self, qpos: ArrayLike) -> Array:
        """Lines that figures draw of each leg: its limbs, then along the sole to the heel and to the toe."""
        limbs, foot = self.limbs(qpos), self.foot
        along = (limbs[..., -1, ::-1] - limbs[..., -2, ::-1]) * [-1.0, 1.0] / self.ankle_height
        ends = [limbs[..., -1, :] + distance * along for distance in (-foot.behind, foot.ahead)]
        return np.concatenate([limbs, np.stack(ends, axis=-2)], axis=-2)

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        """Posture with both feet parallel to the ground; see `Robot.posture`."""
        x, z = foot
        ankle = x + self.ankle_height * math.sin(slope), z + self.ankle_height * math.cos(slope)
        posture = super().posture(ankle, stance, angles)
        return (*posture, slope - posture[2], slope - posture[3])
