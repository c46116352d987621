"""Robots that roll: bipeds on round feet, with straight legs or with knees, and the rimless wheel."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.dynamics.linkage import Linkage, Motion, room
from mjbiped.dynamics.modes import land
from mjbiped.errors import InputError
from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies, Limb, Segment, linkage_with
from mjbiped.robots.chain import SWING_LOCKED, Array
from mjbiped.robots.compass import StraightLegs
from mjbiped.robots.kneed import KneedLegs
from mjbiped.robots.robot import Robot
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


@dataclass(frozen=True)
class RimlessWheel(Robot):
    """A wheel of equal massless spokes without a rim, whose hub has mass and inertia.

    One spoke stands at a time. The wheel is an inverted pendulum on it until the next spoke strikes the ground:

        (M l^2 + I) ddq = M g l sin(q + slope) + tau,    dq' = dq (M l^2 cos 2 alpha + I) / (M l^2 + I)

    M is the mass, I the inertia about the hub, l the length of a spoke, 2 alpha the angle between two spokes, q the
    angle of the stance spoke from the ground's normal (rad, positive forward), tau the torque of the ankle (N m). The
    impact keeps the angular momentum about the foot that strikes (McGeer 1990; Coleman, Chatterjee and Ruina 1997).
    docs/validation.md checks it in steady rolling.

    Only the stance spoke and the next one can touch the ground: a wheel too slow to pass over its stance spoke falls
    back.

    Attributes:
        mass: Mass of the wheel, kg.
        inertia: Inertia about the hub, kg m^2.
        length: Length of a spoke, m.
        spokes: Number of spokes. The first impact stops a wheel with fewer than 5.
        gravity: Acceleration of gravity, m/s^2.

    Raises:
        InputError: A value is not a finite number of its domain.
    """

    mass: Annotated[float, domains.LEG_MASS] = 10.0
    inertia: Annotated[float, domains.INERTIA] = 0.0
    length: Annotated[float, domains.LEG] = 1.0
    spokes: Annotated[int, domains.Count(5, 100)] = 8
    gravity: Annotated[float, domains.GRAVITY] = 9.81

    kind: ClassVar[str] = "wheel"
    angles: ClassVar[tuple[str, ...]] = ("stance",)
    joints: ClassVar[tuple[str, ...]] = ("ankle",)
    places: ClassVar[tuple[str, ...]] = ("hip_x", "hip_z", "turn")
    collides_from_lift_off: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check every value, and convert all but the number of spokes to plain floats."""
        domains.check_fields(self)

    @cached_property
    def linkages(self) -> tuple[Linkage, ...]:
        """The wheel on one spoke; its swing foot is that of the next spoke."""
        spoke, next_foot = np.array([self.length + 0j]), np.array([complex(*self.levers)])
        hub = [(self.mass, self.inertia, 0, spoke)]
        made = linkage_with(hub, spoke, next_foot, np.zeros_like(spoke), angles=1, gravity=self.gravity)
        made.between = self.between
        return (made,)

    @property
    def between(self) -> float:
        """Angle 2 alpha between two spokes, rad."""
        return 2 * math.pi / self.spokes

    @property
    def kept(self) -> float:
        """Ratio of the rate after the impact of a spoke to the rate before it."""
        hub = self.mass * self.length**2
        return (hub * math.cos(self.between) + self.inertia) / (hub + self.inertia)

    @property
    def levers(self) -> tuple[float, float]:
        """Position of the next spoke's foot from the stance foot, m: along and perpendicular to the stance spoke."""
        return self.length * (1 - math.cos(self.between)), self.length * math.sin(self.between)

    @property
    def bodies(self) -> Bodies:
        """The wheel as one rigid body with all spokes."""
        rod = Segment("rod", self.mass, self.length, 0.0, self.inertia)
        spokes = (Limb(f"spoke_{k}", "turn", "ankle", 0.0, -k * self.between, -2 * math.pi) for k in range(self.spokes))
        return Bodies("wheel_scene.xml", 0.0, (rod,), tuple(spokes))

    @property
    def leg_length(self) -> float:
        """Length of a spoke, m."""
        return self.length

    @property
    def total_mass(self) -> float:
        """Mass of the wheel, kg."""
        return self.mass

    def limbs(self, qpos: ArrayLike) -> Array:
        """Positions of hub and foot of each spoke, shape (..., spokes, 2, 2), m; see `Robot.limbs`."""
        places = np.asarray(qpos, dtype=np.float64)
        hub, angles = places[..., None, :2], places[..., 2:] - self.between * np.arange(self.spokes)
        foot = hub - self.length * np.stack([np.sin(angles), np.cos(angles)], axis=-1)
        return np.stack([np.broadcast_to(hub, foot.shape), foot], axis=-2)

    def centre_of_mass(self, qpos: ArrayLike) -> Array:
        """Position x, z of the hub in postures `qpos`, shape (..., 2), m."""
        return np.asarray(qpos, dtype=np.float64)[..., :2]

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        """Posture `qpos` on the foot of a spoke; see `Robot.posture`."""
        hip_x, hip_z, angle = super().posture(foot, 0, angles)
        return hip_x, hip_z, angle + self.between * stance

    def rolling_rate(self, slope: float) -> float:
        r"""Rate just after an impact in steady rolling down a slope (rad), rad/s; 0 if the slope is not downhill.

        .. math:: \omega^2 = \frac{\eta^2}{1 - \eta^2} \frac{4 M g l \sin\alpha \sin\gamma}{M l^2 + I}
        """
        fall = 4 * self.weight * self.length * math.sin(self.between / 2) * math.sin(max(slope, 0.0))
        gained = fall / (self.mass * self.length**2 + self.inertia)
        return self.kept * math.sqrt(gained / (1 - self.kept**2))
