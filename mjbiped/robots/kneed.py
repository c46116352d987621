"""A planar biped with knees and point feet: parameters, equations of motion, energy and both of its impacts.

From the stance foot up and down again, the segments of its `mjbiped.robots.chain` are stance shank, stance thigh, swing
thigh, swing shank. A straight knee that is locked makes one segment of a leg, so that angles q come in three lengths:

    2: stance leg, swing leg                                 both knees locked, as a compass biped
    3: stance leg, swing thigh, swing shank                  the swing knee free, as in swing
    4: stance shank, stance thigh, swing thigh, swing shank  both free

Angles are from the normal of the ground, rad, positive forward. The knee bends backward: the flexion of the swing knee
is shank less thigh, q[2] - q[1] of three, and is 0 where the knee has struck its stop.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.kneed_legs import KneedLegs
from mjbiped.utils import domains


@dataclass(frozen=True)
class KneedBiped(KneedLegs):
    """A planar biped of two equal legs with knees and point feet; by default light shanks and a heavy hip.

    The defaults walk passively: as much mass is at the hip as in a leg. `halved_rods` is the other robot with knees of
    this laboratory.

    Attributes:
        thigh_mass: Mass of one thigh, kg.
        shank_mass: Mass of one shank, kg.
        hip_mass: Mass at the hip, kg.
        thigh_length: From the hip to the knee, m.
        shank_length: From the knee to the foot, m.
        thigh_centre: From the hip down to the thigh's centre of mass, m. It is at most the thigh's length.
        shank_centre: From the knee down to the shank's centre of mass, m. It is at most the shank's length.
        thigh_inertia: Inertia of a thigh about its centre of mass, kg m^2; it follows mass and length unless given.
            None is replaced by that of a uniform rod, m l^2/12 (which `dataclasses.replace` then keeps).
        shank_inertia: Inertia of a shank about its centre of mass, kg m^2; it follows mass and length unless given.
        gravity: Acceleration of gravity, m/s^2.
        sole: Distances from the ankle to the heel and to the toe of a flat, massless sole, m, or one for both. They
            bound the ankle's torque; without a sole it is not bounded.

    Raises:
        InputError: a value is not a finite number of its domain, or a centre of mass lies beyond the end of its link.
    """

    sole: Annotated[tuple[float, float] | None, domains.SOLE] = None

    kind: ClassVar[str] = "kneed"
    lands_bent: ClassVar[bool] = True

    @classmethod
    def halved_rods(cls) -> KneedBiped:
        """The legs of Table I cut at the knee: uniform rods of 2.5 kg and 0.5 m, and no mass at the hip."""
        return cls(thigh_mass=2.5, shank_mass=2.5, hip_mass=0.0, thigh_centre=0.25, shank_centre=0.25)

    @property
    def leg_length(self) -> float:
        """Length of a straight leg, m."""
        return self.thigh_length + self.shank_length

    @property
    def bodies(self) -> Bodies:
        """Thigh and shank on either side of the hip."""
        thigh = Segment("thigh", self.thigh_mass, self.thigh_length, self.thigh_centre, self.thigh_inertia)
        shank = Segment("shank", self.shank_mass, self.shank_length, self.shank_centre, self.shank_inertia)
        return Bodies("kneed_scene.xml", self.hip_mass, (thigh, shank))
