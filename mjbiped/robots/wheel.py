"""The rimless wheel: a hub with massless spokes, which rolls down a slope without a motor.

One spoke stands at a time. The wheel is an inverted pendulum on it until the next spoke strikes the ground:

    (M l^2 + I) ddq = M g l sin(q + slope) + tau,    dq' = dq (M l^2 cos 2 alpha + I) / (M l^2 + I)

M is the mass, I the inertia about the hub, l the length of a spoke, 2 alpha the angle between two spokes, q the angle
of the stance spoke from the ground's normal (rad, positive forward), tau the torque of the ankle (N m). The impact
keeps the angular momentum about the foot that strikes (McGeer 1990; Coleman, Chatterjee and Ruina 1997).
docs/validation.md checks it in steady rolling.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mjbiped.dynamics.linkage import Linkage
from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies, Limb, Segment, linkage_with
from mjbiped.robots.chain import Array
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains


@dataclass(frozen=True)
class RimlessWheel(Robot):
    """A wheel of equal massless spokes without a rim, whose hub has mass and inertia.

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
