"""A robot as URDF, the format of robots in ROS and many simulators."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS, SMALLEST_INERTIA
from mjbiped.robots.bodies import Foot, Limb
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains
from mjbiped.utils.files import saved
from mjbiped.version import __version__

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


_THICK, _TIP = 0.018, 0.024  # radii of rods and of their feet as they are seen, leg lengths
_COLOURS = ("0.0 0.45 0.7 1", "0.9 0.62 0.0 1", "0.15 0.15 0.18 1")  # left, right, other links
_EFFORT, _RATE = 1e4, domains.RATE.high  # URDF wants limits; these limit nothing


def export_urdf(robot: Robot, path: str | Path) -> None:
    """Write a robot as URDF, with the slides `hip_x` and `hip_z` between world and hip, which keep it in its plane.

    The joints are the numbers of postures (`Robot.places`), the feet spheres: those of point feet of 50 micrometres.
    URDF has no gravity, no motors between two legs and no locks of knees: those are not in the file.

    Args:
        robot: The robot.
        path: File to write, `.urdf`.

    Raises:
        RecordError: The file cannot be written.
    """
    with saved(Path(path)) as unfinished:
        unfinished.write_text(urdf_of(robot), encoding="utf-8")


def urdf_of(robot: Robot) -> str:
    """Return the URDF of a robot as text."""
    root = Element("robot", name=f"mjbiped_{robot.kind}")
    root.append(ElementTree.Comment(f" Written by mjbiped {__version__}: kg, m, rad, x forward, z up. "))
    SubElement(root, "link", name=WORLD)
    for link in links_of(robot):
        _add_link(root, link, robot.leg_length, robot.radius)
        _add_joint(root, link)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_link(root: Element, link: Link, length: float, radius: float) -> None:
    """Add a link of a robot with legs of a length and feet of a radius: its mass, what is seen of it, and its feet."""
    element = SubElement(root, "link", name=link.name)
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=joined((link.centre[0], 0.0, link.centre[1])))
    SubElement(inertial, "mass", value=joined((link.mass,)))
    moment = joined((link.inertia,))
    SubElement(inertial, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0")
    for rod in link.rods:
        colour = _COLOURS[(rod.across < 0.0) if rod.across else 2]
        middle = _shape(element, "visual", end_of(rod, 0.5), pitch=rod.angle)
        SubElement(middle, "cylinder", length=joined((rod.length,)), radius=joined((_THICK * length,)))
        _paint(element, colour)
        if rod.foot:
            SubElement(_shape(element, "visual", end_of(rod)), "sphere", radius=joined((_TIP * length,)))
            _paint(element, colour)
            foot = end_of(Rod(rod.angle, 0.0, rod.length - radius, foot=True))
            SubElement(_shape(element, "collision", foot), "sphere", radius=joined((radius + FOOT_RADIUS,)))


def _shape(link: Element, use: str, place: tuple[float, float, float], pitch: float = 0.0) -> Element:
    """Add a shape at a place in the link's frame, and return the element of its geometry."""
    element = SubElement(link, use)
    SubElement(element, "origin", xyz=joined(place), rpy=joined((0.0, pitch, 0.0)))
    return SubElement(element, "geometry")


def _paint(link: Element, colour: str) -> None:
    """Colour the shape that was added last."""
    material = SubElement(link[-1], "material", name=f"rgba_{colour.replace(' ', '_')}")
    SubElement(material, "color", rgba=colour)


def _add_joint(root: Element, link: Link) -> None:
    """Add the joint above a link."""
    kind = "prismatic" if link.slides else "revolute" if link.bends else "continuous"
    joint = SubElement(root, "joint", name=link.joint, type=kind)
    SubElement(joint, "parent", link=link.parent)
    SubElement(joint, "child", link=link.name)
    SubElement(joint, "origin", xyz=joined((link.place[0], 0.0, link.place[1])))
    SubElement(joint, "axis", xyz=joined(link.axis))
    if kind != "continuous":
        low, high = (-domains.PLACE.high, domains.PLACE.high) if link.slides else (0.0, math.pi)
        limits = {"lower": low, "upper": high, "effort": _EFFORT, "velocity": _RATE}
        SubElement(joint, "limit", {name: joined((value,)) for name, value in limits.items()})
