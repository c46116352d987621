"""The bodies that a robot consists of, for engines that build it of rigid bodies."""

from __future__ import annotations

from typing import NamedTuple

from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot


class Segment(NamedTuple):
    """A segment of a leg.

    Attributes:
        name: Of its bodies in the robot's file in `models/`, behind "left_" and "right_".
        mass: kg.
        length: From its upper end to its lower end, m.
        centre: From its upper end down to its centre of mass, m.
        inertia: About its centre of mass, kg m^2.
    """

    name: str
    mass: float
    length: float
    centre: float
    inertia: float


class Bodies(NamedTuple):
    """A robot's bodies.

    Attributes:
        scene: File in `models/` that holds the robot and its surroundings.
        hip_mass: Point mass at the hip, kg.
        leg: The segments of either leg, from the hip down: one, or two with a knee between them.
        collides_from_lift_off: Whether the swing foot meets the ground in all of the swing; else the scuffing rule says
            from when on.
    """

    scene: str
    hip_mass: float
    leg: tuple[Segment, ...]
    collides_from_lift_off: bool


def bodies_of(robot: Robot) -> Bodies:
    """The bodies of a robot.

    Raises:
        TypeError: Nothing is known of bodies of such a robot.
    """
    if isinstance(robot, KneedBiped):
        thigh = Segment("thigh", robot.thigh_mass, robot.thigh_length, robot.thigh_centre, robot.thigh_inertia)
        shank = Segment("shank", robot.shank_mass, robot.shank_length, robot.shank_centre, robot.shank_inertia)
        return Bodies("kneed_scene.xml", robot.hip_mass, (thigh, shank), collides_from_lift_off=True)
    if isinstance(robot, Compass):
        leg = Segment("leg", robot.leg_mass, robot.leg_length, robot.upper_length, robot.leg_inertia)
        return Bodies("scene.xml", robot.hip_mass, (leg,), collides_from_lift_off=False)
    raise TypeError(f"a {type(robot).__name__} has no bodies")
