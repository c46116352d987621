"""The rimless wheel, whose rolling is known in closed form, by a compass biped that always holds out the next spoke.

A wheel of massless spokes, an angle 2 α apart, and a mass at the hub rolls down a slope γ. From one spoke to the next
its rate ω just after an impact obeys ω' = cos 2α √(ω² + 4 (g/l) sin α sin γ), with the fixed point ω = cot 2α √(4 (g/l)
sin α sin γ) (McGeer 1990; Coleman, Chatterjee and Ruina 1997; Tedrake, Underactuated Robotics). The compass biped has
such spokes where its legs have next to no mass and its hip motor brings the swing leg, soon after each touchdown, to
the angle of the next spoke and keeps it there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy

import mjbiped
from controllers import Controller
from mjbiped.dynamics.linkage import END, MASS
from mjbiped.robots.compass import Array, Compass, coriolis_terms, gravity_terms, legs_of, mass_terms
from mjbiped.robots.round import RoundCompass

ALPHA = math.pi / 8  # eight spokes
SLOPE = 0.08  # rad; with ALPHA Tedrake's example
RATE = 60.0  # 1/s, at which the next spoke is approached: e^-30 of the way is left at a touchdown
START = 1.5  # rad/s: not the fixed point
STEPS = 6


def rolling_rate(alpha: float, slope: float, stiffness: float) -> float:
    """Rate of the steadily rolling wheel just after an impact, rad/s; the stiffness is g/l, 1/s^2."""
    return math.sqrt(4 * stiffness * math.sin(alpha) * math.sin(slope)) / math.tan(2 * alpha)


def rates(alpha: float, slope: float, stiffness: float, start: float, steps: int) -> Array:
    """Rates of the wheel just before and just after its next impacts, shape (steps, 2), rad/s."""
    found, rate = [], start
    for _ in range(steps):
        before = math.sqrt(rate**2 + 4 * stiffness * math.sin(alpha) * math.sin(slope))
        rate = math.cos(2 * alpha) * before
        found.append((before, rate))
    return np.array(found)


@dataclass(frozen=True)
class NextSpoke(Controller):
    """Holds the swing leg an angle 2 `alpha` ahead of the stance leg by computed hip torque.

    Attributes:
        robot: Whose model it is.
        slope: Of the plane, rad; unlike the laboratory's own controllers this one is told it.
        alpha: Half the angle between two spokes, rad.
    """

    robot: Compass
    slope: float = SLOPE
    alpha: float = ALPHA
    rate: ClassVar[float] = RATE

    def torque(self, memory: Sequence[float], t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        """Ankle and hip torque, N m."""
        constants, legs = self.robot.constants, legs_of(q[0], q[1])
        m11, m12, m22 = mass_terms(constants, legs)
        c1, c2 = coriolis_terms(constants, legs, dq[0], dq[1])
        gc1, gc2, gs1, gs2 = gravity_terms(constants, legs)
        sine, cosine = math.sin(self.slope), math.cos(self.slope)
        first, second = c1 + gc1 * sine + gs1 * cosine, c2 + gc2 * sine + gs2 * cosine
        ahead = self.rate**2 * (q[0] - 2 * self.alpha - q[1]) + 2 * self.rate * (dq[0] - dq[1])
        # the swing leg is to turn as the stance leg does, and ahead of it; both rows' sum is free of the hip torque
        stance = -(first + second + (m12 + m22) * ahead) / (m11 + 2 * m12 + m22)
        return 0.0, m12 * stance + m22 * (stance + ahead) + second


def wheel(mass_ratio: float) -> Compass:
    """The robot: legs of 1 m with a share of the hip's mass."""
    return Compass(mass_ratio * 1e3, 1e3, lower_length=0.5, upper_length=0.5, leg_inertia=0.0)


def roll(mass_ratio: float, engine: mjbiped.Engine, steps: int = STEPS) -> tuple[Array, Array]:
    """Let the wheel roll in an engine.

    Returns:
        The stance leg's rates just before and after each touchdown, and those of the closed form, both of shape
        (steps, 2), rad/s.
    """
    robot = wheel(mass_ratio)
    walk = mjbiped.walk(
        NextSpoke(robot, SLOPE),
        mjbiped.Terrain.incline(math.degrees(SLOPE)),
        engine=engine,
        steps=steps,
        initial=(-ALPHA, ALPHA, START, 0.0),
    )
    found = np.column_stack([walk.touchdowns["dq_before"][:, 0], walk.touchdowns["dq"][:, 0]])
    return found, rates(ALPHA, SLOPE, robot.gravity / robot.leg_length, START, steps)


def strike_coefficients(mass_ratio: float) -> tuple[float, float]:
    """Stance rate after over before an impact with the legs 2 α apart and locked: of the impact map, of the chain's."""
    straight = wheel(mass_ratio)
    kneed = mjbiped.KneedBiped(straight.leg_mass, straight.leg_mass, straight.hip_mass)
    q, dq = [ALPHA, -ALPHA], [1.0, 1.0]
    return float(straight.impact(q, dq)[1][0]), float(kneed.heel_impact(q, dq)[1][0])


LIGHT_LEGS = RoundCompass(leg_mass=1e-9, hip_mass=1.0, lower_length=0.5, upper_length=0.5, foot_radius=0.0, gravity=1.0)
TABLE_ONE = RoundCompass(foot_radius=0.0)
HALVES = (0.05, 0.1, 0.2, 0.3)
"""Half of the angle between the legs, rad."""


def closed_form(half: float) -> float:
    """Ratio of the push-off's work to that of the hip's torque with massless legs."""
    return 0.25 / math.cos(half) ** 4


def pushed(robot: RoundCompass, half: float, rate: float, impulse: float) -> tuple[float, float]:
    """Push off along the trailing leg before the heel strike of legs that turn at one rate.

    Args:
        robot: On point feet.
        half: Half of the angle between the legs, rad.
        rate: Of both legs before it, rad/s.
        impulse: Along the trailing leg, N s.

    Returns:
        Work of the impulse, and kinetic energy after the heel strike, J.
    """
    linkage, q = robot.linkages[0], np.array([half, -half])
    moments, reach = (np.array(linkage.levers[point]) for point in (MASS, END))
    # coordinates are the stance foot's place and the angles of both legs
    free = np.zeros((4, 4))
    free[:2, :2], free[2:, 2:] = linkage.mass * np.eye(2), linkage.even * np.cos(q[:, None] - q)
    free[:2, 2:] = moments * np.cos(q), -moments * np.sin(q)
    free[2:, :2] = free[:2, 2:].T
    before = np.array([0.0, 0.0, rate, rate])
    along = np.array([math.sin(half), math.cos(half), 0.0, 0.0])  # of the trailing leg
    change = np.linalg.solve(free, impulse * along)
    work = 0.5 * impulse * float(along @ change)  # the foot stood before
    # the foot that strikes stands from now on
    stands = np.hstack([np.eye(2), [reach * np.cos(q), -reach * np.sin(q)]])
    equations = np.block([[free, -stands.T], [stands, np.zeros((2, 2))]])
    after = np.linalg.solve(equations, [*(free @ (before + change)), 0.0, 0.0])[[3, 2]]
    return work, robot.kinetic_energy(q[::-1], after)


def ratio(robot: RoundCompass, half: float) -> float:
    """Work of the push-off over that of the hip's torque, on one walk: one rate before the strike, one step."""
    rate = 1.0
    energy = robot.kinetic_energy([half, -half], [rate, rate])
    _, unaided = pushed(robot, half, rate, 0.0)
    enough = robot.total_mass * robot.leg_length * rate
    impulse = scipy.optimize.brentq(lambda p: pushed(robot, half, rate, p)[1] - energy, 0.0, enough, xtol=1e-15)
    work, _ = pushed(robot, half, rate, float(impulse))
    return work / (energy - unaided)
