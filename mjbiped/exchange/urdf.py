"""A robot as URDF, the format of robots in ROS and many simulators."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.exchange.links import WORLD, Link, Rod, end_of, joined, links_of
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains
from mjbiped.utils.files import saved
from mjbiped.version import __version__

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
