"""A compass biped on its sole: the ankle torque that the sole transmits, and the accelerations under it."""

from __future__ import annotations

import math
from typing import NamedTuple

from mjbiped.control.controller import Memory
from mjbiped.controllers.adaptive import CURVES
from mjbiped.controllers.replanning import POINTS
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.sole import bounded_by_own_force, moment_about_ankle

SUPPORT = CURVES + 2 * POINTS
"""Index in the memory of how far behind and ahead of the ankle the ground bears the foot; see `Controller.support`."""


class Footing(NamedTuple):
    """What presses on the sole, and how large it is.

    Attributes:
        mass: Of the whole robot, kg.
        gravity: m/s².
        behind: Distance behind the ankle on which the law leans, m; infinite without a sole.
        ahead: Distance ahead of the ankle on which the law leans, m; infinite without a sole.
        share: Share of the sole that these are.
        height: Of the ankle over the sole, m.
    """

    mass: float
    gravity: float
    behind: float
    ahead: float
    share: float
    height: float


class Model(NamedTuple):
    """What a law knows of a compass and its sole.

    Attributes:
        constants: Lumped constants of the robot.
        footing: What presses on the sole, and how large it is.
    """

    constants: compass.Constants
    footing: Footing


class Driven(NamedTuple):
    """Torques, and what they do.

    Attributes:
        ankle: Ankle torque, N m.
        hip: Hip torque, N m.
        ddq1: Acceleration of the stance leg, rad/s².
        ddq2: Acceleration of the swing leg, rad/s².
        along: Force of the ground along it, N.
        normal: Force of the ground normal to it, N.
    """

    ankle: float
    hip: float
    ddq1: float
    ddq2: float
    along: float
    normal: float


def model_of(robot: Compass, share: float) -> Model:
    """What a law knows of a compass that leans on a share of its sole."""
    return Model(robot.constants, footing_of(robot, share))


def footing_of(robot: Robot, share: float) -> Footing:
    """What presses on the sole of a robot that leans on a share of it."""
    behind, ahead = robot.sole or (math.inf, math.inf)
    foot = robot.bodies.foot
    height = 0.0 if foot is None else foot.height
    return Footing(robot.total_mass, robot.gravity, share * behind, share * ahead, share, height)


def set_support(memory: Memory, behind: float, ahead: float) -> None:
    """Let the ground bear the stance foot so far behind and ahead of its ankle, m; both zero: on all of its sole."""
    memory[SUPPORT], memory[SUPPORT + 1] = behind, ahead


def standing(model: Model, memory: Memory) -> Model:
    """What the law knows of the robot in the step under way, whose sole is what the ground bears of it."""
    mass, gravity, behind, ahead, share, height = model.footing
    if memory[SUPPORT] + memory[SUPPORT + 1] > 0.0:  # else nothing was told
        behind, ahead = min(behind, share * memory[SUPPORT]), min(ahead, share * memory[SUPPORT + 1])
    return Model(model.constants, Footing(mass, gravity, behind, ahead, share, height))


def holds(footing: Footing, moment: float, normal: float) -> bool:
    """Whether the sole transmits a moment about the ankle, N m, under a normal force, N."""
    return footing.behind == math.inf or -footing.ahead * normal <= moment <= footing.behind * normal


def turned(footing: Footing, along: float, normal: float, slope: tuple[float, float]) -> tuple[float, float]:
    """A force of the ground on a slope, along it and normal to it, N, of one on level ground: gravity leans.

    Args:
        footing: What presses on the sole.
        along: Force along level ground under the same motion relative to the ground, N.
        normal: Force normal to it, N.
        slope: Sine and cosine of the slope, or of its estimate.
    """
    weight = footing.mass * footing.gravity
    return along - weight * slope[0], normal - weight * (1.0 - slope[1])


def driven(
    model: Model,
    legs: compass.Legs,
    dq1: float,
    dq2: float,
    slope: tuple[float, float],
    asked: float,
    offset: float,
    share: float,
) -> Driven:
    """Bound an ankle torque by the sole, and make the swing leg accelerate by `offset + share * ddq1` nevertheless.

    The stance leg is let go: its acceleration follows from the moments about the ankle, which are the sum of both rows
    of (1) and hold no hip torque.

    Args:
        model: What the law knows of the robot.
        legs: Sine and cosine of stance and swing angle.
        dq1: Rate of the stance leg, rad/s.
        dq2: Rate of the swing leg, rad/s.
        slope: Sine and cosine of the slope, or of its estimate.
        asked: Ankle torque that is asked for, N m.
        offset: Acceleration of the swing leg while the stance leg's is zero, rad/s².
        share: Share of the stance leg's acceleration that the swing leg shares.
    """
    constants, footing, (sine, cosine) = model.constants, model.footing, slope
    m11, m12, m22 = compass.mass_terms(constants, legs)
    rest1, rest2 = compass.inverse_dynamics(constants, legs, dq1, dq2, sine, cosine, 0.0, 0.0)
    rest = rest1 + rest2 + (m12 + m22) * offset
    inertia = m11 + m12 + (m12 + m22) * share
    ddq1 = (asked - rest) / inertia
    ddq2 = offset + share * ddq1
    along, normal = ground_force(model, legs, dq1, dq2, ddq1, ddq2, slope)
    ankle = asked
    moment = moment_about_ankle(asked, footing.height, along)
    if asked != 0.0 and moment != 0.0 and not holds(footing, moment, normal):
        free = -rest / inertia
        free_along, free_normal = ground_force(model, legs, dq1, dq2, free, offset + share * free, slope)
        # forces are linear in the torque, and in the moment
        lever = 1.0 + footing.height * (along - free_along) / asked
        sheared = footing.height * free_along
        without = free_normal - sheared / lever * ((normal - free_normal) / asked)
        borne, _ = bounded_by_own_force(moment, normal, without, footing.behind, footing.ahead)
        ankle = (borne - sheared) / lever
        ddq1 = (ankle - rest) / inertia
        ddq2 = offset + share * ddq1
        along, normal = ground_force(model, legs, dq1, dq2, ddq1, ddq2, slope)
    return Driven(ankle, rest2 + m12 * ddq1 + m22 * ddq2, ddq1, ddq2, along, normal)


def ground_force(
    model: Model,
    legs: compass.Legs,
    dq1: float,
    dq2: float,
    ddq1: float,
    ddq2: float,
    slope: tuple[float, float],
) -> tuple[float, float]:
    """Force of the ground on the stance foot, along the ground and normal to it, N; see `driven`."""
    constants, footing = model.constants, model.footing
    level = compass.ground_force(constants, footing.mass, footing.gravity, legs, dq1, dq2, ddq1, ddq2)
    return turned(footing, level[0], level[1], slope)
