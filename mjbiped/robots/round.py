"""The bipeds on round feet: with straight legs, and with knees."""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from mjbiped.dynamics.linkage import Motion, room
from mjbiped.dynamics.modes import land
from mjbiped.errors import InputError
from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.robots.chain import SWING_LOCKED, Array
from mjbiped.robots.compass import StraightLegs
from mjbiped.robots.kneed import KneedLegs
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


@dataclass(frozen=True)
class RoundKneed(KneedLegs):
    """A biped with knees on round feet; by default the machine of McGeer's *Passive walking with knees* (1990), at 1 m.

    A shank carries the centre of its foot's arc, which lies ahead of the thigh's line where the knee is at its stop.
    Angles of thighs and shanks are those that the line from the arc's centre to the hip would have with the knee at its
    stop: there thigh and shank have one angle, and both legs opposite ones while both feet are on a plane. In the heel
    strike the stop alone holds the knee of the leg that leaves the ground: it bends at once if the impact opens it.

    It walks on planes alone: on uneven ground an arc would touch it in two places at once.

    Attributes:
        thigh_mass: Mass of one thigh, kg.
        shank_mass: Mass of one shank with its foot, kg.
        hip_mass: Mass at the hip, kg.
        thigh_length: From the hip to the knee, m.
        shank_length: From the knee through the centre of the foot's arc to the arc, m.
        thigh_centre: From the hip down to the thigh's centre of mass, m.
        shank_centre: From the knee down to the shank's centre of mass, m.
        thigh_inertia: Inertia of a thigh about its centre of mass, kg m^2; it follows mass and length unless given,
            with McGeer's ratio of the radius of gyration to the length.
        shank_inertia: Inertia of a shank about its centre of mass, kg m^2; likewise.
        gravity: Acceleration of gravity, m/s^2.
        shank_offset: Distance of the shank's centre of mass ahead of its line, m; negative behind it.
        stop_angle: Angle by which the shank's line is ahead of the thigh's where the knee is at its stop, rad.
        foot_radius: Radius of the feet, m. Their centres lie on the lines of the shanks.

    Raises:
        InputError: A value is not a finite number of its domain, a centre of mass lies beyond the end of its link, or
            the feet are as large as the shanks are long.
    """

    thigh_mass: Annotated[float, domains.LEG_MASS] = 1.0
    shank_mass: Annotated[float, domains.LEG_MASS] = 0.62
    hip_mass: Annotated[float, domains.HIP_MASS] = 6.76
    thigh_length: Annotated[float, domains.LENGTH] = 0.46
    shank_length: Annotated[float, domains.LENGTH] = 0.54
    thigh_centre: Annotated[float, domains.LENGTH] = 0.20
    shank_centre: Annotated[float, domains.LENGTH] = 0.24
    shank_offset: Annotated[float, domains.Domain(-1e3, 1e3, "m")] = -0.01
    stop_angle: Annotated[float, domains.Domain(-1.0, 1.0, "rad")] = 0.2
    foot_radius: Annotated[float, domains.FOOT_RADIUS] = 0.2

    kind: ClassVar[str] = "round-kneed"
    knee_opens: ClassVar[bool] = True
    gyration: ClassVar[Mapping[str, float]] = {"thigh": 0.135 / 0.46, "shank": 0.186 / 0.54}

    def __post_init__(self) -> None:
        """Check every value, and turn it into a plain float."""
        super().__post_init__()
        if not self.foot_radius < self.shank_length:
            raise InputError(
                f"foot_radius = {self.foot_radius:g}: must be less than shank_length = {self.shank_length:g} m: the "
                "centre of the arc is on the shank"
            )

    @property
    def radius(self) -> float:
        """Radius of the feet, m."""
        return self.foot_radius

    @cached_property
    def _line(self) -> tuple[float, float]:
        """From the arc's centre to the hip while the knee is at its stop, m, and the turn of the thigh from it, rad."""
        shank = (self.shank_length - self.foot_radius) * cmath.exp(-1j * self.stop_angle)
        length, turn = cmath.polar(self.thigh_length + shank)
        return length, -turn

    @property
    def leg_length(self) -> float:
        """Length of a leg whose knee is at its stop, from the hip through the arc's centre to the arc, m."""
        return self._line[0] + self.foot_radius

    @property
    def bodies(self) -> Bodies:
        """Thigh and shank on either side of the hip."""
        turn = self._line[1]
        thigh = Segment("thigh", self.thigh_mass, self.thigh_length, self.thigh_centre, self.thigh_inertia, turn)
        shank = Segment(
            *("shank", self.shank_mass, self.shank_length, self.shank_centre, self.shank_inertia),
            turn=turn - self.stop_angle,
            offset=self.shank_offset,
        )
        return Bodies("kneed_scene.xml", self.hip_mass, (thigh, shank))

    def after_touchdown(self, places: Array) -> Array:
        """States just after a touchdown on a plane, the swing knee bending as the heel strike has left it.

        The rates of both legs tell those before the heel strike, and these the rate of the shank.
        """
        states = super().after_touchdown(places)
        for leg in np.unique(places[..., 0]):
            linkage, motion, after = self.linkages[0], Motion(**room()), []
            for moved in SWING_LOCKED.T.tolist():
                land(linkage, linkage, motion, [-leg, leg, leg, *moved], False)
                after.append(motion.right[:3])
            stance, swing, shank = np.array(after).T
            there = places[..., 0] == leg
            earlier = np.linalg.solve([stance, swing], places[there][..., 1:].T)
            states[there, 5] = np.maximum(states[there, 4], shank @ earlier)
        return states
