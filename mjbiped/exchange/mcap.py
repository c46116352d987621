"""A walk as an MCAP recording of ROS 2 messages, which Foxglove, PlotJuggler, Rerun, RViz and ROS 2 replay.

| topic | message | what |
|---|---|---|
| `/robot_description` | String | the robot as URDF, once |
| `/ground` | Marker | the ground's profile as a line, once |
| `/joint_states` | JointState | places and rates of the URDF's joints, at each sample |
| `/tf` | TFMessage | places of the URDF's links, at each sample |
| `/torques` | JointState | torques of the robot's motors as efforts, at each sample |

Times are those of the walk, from 0 s.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.exchange.urdf import WORLD, Link, links_of, urdf_of
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Robot
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.files import saved
from mjbiped.utils.packages import needed

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
        told = {"outcome": walk.outcome, "settings": json.dumps(dict(walk.settings))}
        writer.add_metadata("mjbiped", told)
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
    rows = zip(*(samples[name].tolist() for name in ("dq", "stance", "slope")), samples["qpos"], strict=True)
    return np.array([_rates(robot, *row) for row in rows])


def _rates(robot: Robot, dq: Sequence[float], stance: int, slope: float, qpos: NDArray[np.float64]) -> list[float]:
    """Rates of a posture."""
    # `posture` is linear in the angles behind the hip's place, but for the turns that a wheel has made
    turning, still = (robot.posture((0.0, 0.0), stance, angles)[2:] for angles in (dq, [0.0] * len(dq)))
    down = robot.radius * np.array([math.sin(slope), math.cos(slope)])  # from a round foot's centre to the ground
    x, z = (qpos[:2] - robot.leg_ends(qpos)[stance] + down).tolist()
    return [dq[0] * z, -dq[0] * x, *(after - before for after, before in zip(turning, still, strict=True))]


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
    return {
        "header": _header(time),
        "ns": "ground",
        "type": _LINE_STRIP,
        "pose": {"orientation": {"w": 1.0}},
        "scale": {"x": _THICKNESS * length},
        "color": {"r": 0.45, "g": 0.4, "b": 0.35, "a": 1.0},
        "points": points,
    }


def _header(time: int, frame: str = WORLD) -> Message:
    return {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": frame}


def _nanoseconds(time: float) -> int:
    return round(float(time) * 1e9)
