"""A robot as a tree of links and joints, for formats of robotics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS, SMALLEST_INERTIA
from mjbiped.robots.bodies import Foot, Limb
from mjbiped.robots.robot import Robot

WORLD, SLIDER, HIP = "world", "slider", "hip"
"""Names of the links above the legs."""

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)

_POINT_INERTIA = 1e-8  # kg m^2, of links that do not turn; simulators refuse none


class Rod(NamedTuple):
    """A segment as it is seen from its joint.

    Attributes:
        angle: Angle from the link's downward axis, rad, positive forward.
        across: Place across the walking direction, m.
        length: m.
        foot: Whether it ends in a foot.
    """

    angle: float
    across: float
    length: float
    foot: bool


class Link(NamedTuple):
    """A link, and the joint that holds it.

    Attributes:
        name: Name of the link.
        parent: Name of the link that holds it.
        joint: Name of the joint: that of the number in postures (`Robot.places`).
        slides: Whether the joint is a slide, m; else it is a hinge, rad.
        axis: Axis of the joint: X, Y or Z.
        place: Of the joint from that of the parent, x and z in m, while all joints are at zero.
        bends: Whether the joint bends to one side only, as a knee.
        mass: kg.
        centre: Place of the centre of mass from the joint, likewise.
        inertia: About the centre of mass, kg m^2.
        rods: What is seen of the link, and touches the ground.
    """

    name: str
    parent: str
    joint: str
    slides: bool
    axis: tuple[int, int, int]
    place: tuple[float, float] = (0.0, 0.0)
    bends: bool = False
    mass: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    inertia: float = _POINT_INERTIA
    rods: tuple[Rod, ...] = ()


def links_of(robot: Robot) -> list[Link]:
    """Return the links of a robot below the world, parents first.

    Simulators refuse links without mass: those have `SMALLEST_HIP_MASS` of the robot's.
    """
    bodies, least = robot.bodies, SMALLEST_HIP_MASS * robot.total_mass
    links = [
        Link(SLIDER, WORLD, "hip_x", True, X, mass=least),
        Link(HIP, SLIDER, "hip_z", True, Z, mass=max(bodies.hip_mass, least)),
    ]
    for hinge in dict.fromkeys(limb.hinge for limb in bodies.limbs):
        limbs = [limb for limb in bodies.limbs if limb.hinge == hinge]
        parent, place = HIP, (0.0, 0.0)
        for number, segment in enumerate(bodies.leg):
            name = f"{limbs[0].name}_{segment.name}" if len(limbs) == 1 else robot.kind
            length, last = robot.leg_length, number == len(bodies.leg) - 1 and bodies.foot is None
            rods = tuple(Rod(limb.offset + segment.turn, length * limb.across, segment.length, last) for limb in limbs)
            inertia = max(segment.inertia, SMALLEST_INERTIA * segment.mass * length**2)
            moved = (segment.mass, segment.place(segment.centre, segment.offset), inertia)
            joint = f"{limbs[0].name}_knee" if number else hinge
            links.append(Link(name, parent, joint, False, Y, place, number > 0, *moved, rods))
            parent, place = name, segment.place(segment.length)
        if bodies.foot is not None:
            links.append(_foot_of(bodies.foot, limbs[0], parent, place, robot.leg_length))
    return links


def _foot_of(foot: Foot, limb: Limb, parent: str, place: tuple[float, float], length: float) -> Link:
    """A foot that turns about an ankle: rods to its heel and to its toe."""
    ends = (foot.behind, -foot.ahead)
    rods = tuple(
        Rod(math.atan2(end, foot.height), length * limb.across, math.hypot(end, foot.height), True) for end in ends
    )
    name, moved = f"{limb.name}_foot", (foot.mass, (0.0, 0.0), foot.inertia)
    return Link(name, parent, name, False, Y, place, False, *moved, rods)


def end_of(rod: Rod, share: float = 1.0) -> tuple[float, float, float]:
    """Return a point of a rod in the link's frame, at a share of its length from the joint, m."""
    down = share * rod.length
    return 0.0 - down * math.sin(rod.angle), rod.across, -down * math.cos(rod.angle)


def joined(numbers: Iterable[float]) -> str:
    """Write numbers exactly, as XML attributes have them."""
    return " ".join(str(number) for number in numbers)
