"""A robot as URDF, and a walk as an MCAP recording of ROS 2 messages, for ROS, its viewers and other simulators.

Foxglove, PlotJuggler, Rerun, RViz and ROS 2 replay a recording. Its times are those of the walk, from 0 s:

| topic | message | what |
|---|---|---|
| `/robot_description` | String | the robot as URDF, once |
| `/ground` | Marker | the ground's profile as a line, once |
| `/joint_states` | JointState | places and rates of the URDF's joints, at each sample |
| `/tf` | TFMessage | places of the URDF's links, at each sample |
| `/torques` | JointState | torques of the robot's motors as efforts, at each sample |
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.scene import SMALLEST_HIP_MASS, SMALLEST_INERTIA
from mjbiped.errors import InputError
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed
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
    bodies, least, length = robot.bodies, SMALLEST_HIP_MASS * robot.total_mass, robot.leg_length
    links = [
        Link(SLIDER, WORLD, "hip_x", True, X, mass=least),
        Link(HIP, SLIDER, "hip_z", True, Z, mass=max(bodies.hip_mass, least)),
    ]
    for hinge in dict.fromkeys(limb.hinge for limb in bodies.limbs):
        limbs = [limb for limb in bodies.limbs if limb.hinge == hinge]
        parent, place, leg = HIP, (0.0, 0.0), limbs[0].name
        for number, segment in enumerate(bodies.leg):
            name = f"{leg}_{segment.name}" if len(limbs) == 1 else robot.kind
            last = number == len(bodies.leg) - 1 and bodies.foot is None
            rods = tuple(Rod(limb.offset + segment.turn, length * limb.across, segment.length, last) for limb in limbs)
            inertia = max(segment.inertia, SMALLEST_INERTIA * segment.mass * length**2)
            moved = (segment.mass, segment.place(segment.centre, segment.offset), inertia)
            joint = f"{leg}_knee" if number else hinge
            links.append(Link(name, parent, joint, False, Y, place, number > 0, *moved, rods))
            parent, place = name, segment.place(segment.length)
        if (foot := bodies.foot) is not None:  # it turns about an ankle: rods to its heel and to its toe
            across, ends = length * limbs[0].across, (foot.behind, -foot.ahead)
            rods = tuple(Rod(math.atan2(end, foot.height), across, math.hypot(end, foot.height), True) for end in ends)
            moved = (foot.mass, (0.0, 0.0), foot.inertia)
            links.append(Link(f"{leg}_foot", parent, f"{leg}_foot", False, Y, place, False, *moved, rods))
    return links


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
    """Return the URDF of a robot as text.

    Raises:
        InputError: The robot moves in space.
    """
    if "hip_y" in robot.places:
        raise InputError(
            f"URDF and MCAP are of planar robots, and a {type(robot).__name__} moves in space; export its scene (.xml), "
            "or its record as tables (.csv, .parquet)"
        )
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
    SubElement(inertial, "mass", value=str(link.mass))
    moment = str(link.inertia)
    SubElement(inertial, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0")

    def add(use: str, place: Iterable[float], shape: str, pitch: float = 0.0, **sizes: float) -> Element:
        """Add a shape at a place in the link's frame."""
        part = SubElement(element, use)
        SubElement(part, "origin", xyz=joined(place), rpy=joined((0.0, pitch, 0.0)))
        SubElement(SubElement(part, "geometry"), shape, {name: str(size) for name, size in sizes.items()})
        return part

    for rod in link.rods:
        colour = _COLOURS[(rod.across < 0.0) if rod.across else 2]
        seen = [add("visual", end_of(rod, 0.5), "cylinder", rod.angle, length=rod.length, radius=_THICK * length)]
        if rod.foot:
            seen.append(add("visual", end_of(rod), "sphere", radius=_TIP * length))
            foot = end_of(Rod(rod.angle, 0.0, rod.length - radius, foot=True))
            add("collision", foot, "sphere", radius=radius + FOOT_RADIUS)
        for part in seen:
            material = SubElement(part, "material", name=f"rgba_{colour.replace(' ', '_')}")
            SubElement(material, "color", rgba=colour)


def _add_joint(root: Element, link: Link) -> None:
    """Add the joint above a link."""
    kind = "prismatic" if link.slides else "revolute" if link.bends else "continuous"
    joint = SubElement(root, "joint", name=link.joint, type=kind)
    for role, name in (("parent", link.parent), ("child", link.name)):
        SubElement(joint, role, link=name)
    SubElement(joint, "origin", xyz=joined((link.place[0], 0.0, link.place[1])))
    SubElement(joint, "axis", xyz=joined(link.axis))
    if kind != "continuous":
        low, high = (-domains.PLACE.high, domains.PLACE.high) if link.slides else (0.0, math.pi)
        SubElement(joint, "limit", lower=str(low), upper=str(high), effort=str(_EFFORT), velocity=str(_RATE))


JOINT_STATE = "sensor_msgs/msg/JointState"
MARKER = "visualization_msgs/msg/Marker"
STRING = "std_msgs/msg/String"
TF = "tf2_msgs/msg/TFMessage"

_LINE_STRIP = 4  # of visualization_msgs/msg/Marker
_BEYOND = 1.0  # ground that is drawn before and behind the robot, leg lengths
_THICKNESS = 0.01  # of its line, leg lengths

Message = dict[str, Any]


def write_recording(walk: Walk, path: Path) -> None:
    """Write the samples of a walk as an MCAP recording.

    Raises:
        InputError: The walk has no samples, or the library is not installed.
        RecordError: The file cannot be written.
    """
    writer_module, types = (
        needed(name, "ros", "an MCAP recording") for name in ("mcap_ros2.writer", "rosbags.typesys")
    )
    if not len(walk.samples["time"]):
        raise InputError("the walk has no samples to record; walk with a sample period")
    with saved(path) as unfinished, unfinished.open("wb") as stream:
        writer, ros = writer_module.Writer(stream), types.get_typestore(types.Stores.ROS2_HUMBLE)
        definitions = {kind: ros.generate_msgdef(kind, ros_version=2)[0] for kind in (STRING, MARKER, JOINT_STATE, TF)}
        schemas = {kind: writer.register_msgdef(kind, text) for kind, text in definitions.items()}
        for time, topic, kind, message in _messages(walk):
            writer.write_message(topic, schemas[kind], message, log_time=time)
        writer.add_metadata("mjbiped", {"outcome": walk.outcome, "settings": json.dumps(dict(walk.settings))})
        writer.finish()


def _messages(walk: Walk) -> Iterator[tuple[int, str, str, Message]]:
    """Yield all messages in the order of time: time in ns, topic, kind, content."""
    robot, samples = walk.robot, walk.samples
    links = links_of(robot)
    first = _nanoseconds(samples["time"][0])
    yield first, "/robot_description", STRING, {"data": urdf_of(robot)}
    yield first, "/ground", MARKER, _ground(walk.terrain, samples["qpos"][:, 0], robot.leg_length, first)
    rates = joint_rates(robot, samples)
    for row, time in enumerate(map(_nanoseconds, samples["time"])):
        qpos = samples["qpos"][row].tolist()
        states = {"name": list(robot.places), "position": qpos, "velocity": rates[row].tolist()}
        yield time, "/joint_states", JOINT_STATE, {"header": _header(time), **states}
        places = dict(zip(robot.places, qpos, strict=True))
        yield time, "/tf", TF, {"transforms": [_transform(time, link, places) for link in links]}
        torques = {"name": list(robot.joints), "effort": samples["torque"][row].tolist()}
        yield time, "/torques", JOINT_STATE, {"header": _header(time), **torques}


def joint_rates(robot: Robot, samples: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the rates of the postures `qpos` in a walk's samples, shape (n, len(places)), m/s and rad/s.

    The robot turns about its stance foot, which stands, or about the point on which a round one rolls.
    """
    rows = []
    for dq, stance, slope, qpos in zip(*(samples[name] for name in ("dq", "stance", "slope", "qpos")), strict=True):
        leg, angles = int(stance), dq.tolist()
        # `posture` is linear in the angles behind the hip's place, but for the turns that a wheel has made
        turning, still = (robot.posture((0.0, 0.0), leg, each)[2:] for each in (angles, [0.0] * len(angles)))
        down = robot.radius * np.array([math.sin(slope), math.cos(slope)])  # from a round foot's centre to the ground
        x, z = (qpos[:2] - robot.leg_ends(qpos)[leg] + down).tolist()
        rows.append([angles[0] * z, -angles[0] * x, *np.subtract(turning, still).tolist()])
    return np.array(rows)


def _transform(time: int, link: Link, places: Mapping[str, float]) -> Message:
    """Place of a link in that which holds it."""
    place = places[link.joint]
    half, moved = (0.0, place) if link.slides else (0.5 * place, 0.0)
    x, y, z = (part * moved for part in link.axis)
    translation = {"x": x + link.place[0], "y": y, "z": z + link.place[1]}
    transform = {"translation": translation, "rotation": {"y": math.sin(half), "w": math.cos(half)}}
    return {"header": _header(time, link.parent), "child_frame_id": link.name, "transform": transform}


def _ground(terrain: Terrain, hips: NDArray[np.float64], length: float, time: int) -> Message:
    """The ground under a walk as a line; what is left out is zero or empty."""
    low, high = float(hips.min()) - _BEYOND * length, float(hips.max()) + _BEYOND * length
    points = [{"x": x, "z": z} for x, z in np.transpose(terrain.outline(low, high)).tolist()]
    drawn = {"scale": {"x": _THICKNESS * length}, "color": {"r": 0.45, "g": 0.4, "b": 0.35, "a": 1.0}}
    placed = {"header": _header(time), "pose": {"orientation": {"w": 1.0}}}
    return {**placed, "ns": "ground", "type": _LINE_STRIP, **drawn, "points": points}


def _header(time: int, frame: str = WORLD) -> Message:
    return {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": frame}


def _nanoseconds(time: float) -> int:
    return round(float(time) * 1e9)
