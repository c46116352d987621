"""Definitions of ROS 2 messages, which a recording carries so that programs without ROS can read it."""

from __future__ import annotations

from collections.abc import Iterator

JOINT_STATE = "sensor_msgs/msg/JointState"
MARKER = "visualization_msgs/msg/Marker"
STRING = "std_msgs/msg/String"
TF = "tf2_msgs/msg/TFMessage"

_RULE = "=" * 80

_FIELDS = {
    "builtin_interfaces/Time": "int32 sec, uint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec, uint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp, string frame_id",
    "std_msgs/ColorRGBA": "float32 r, float32 g, float32 b, float32 a",
    "geometry_msgs/Point": "float64 x, float64 y, float64 z",
    "geometry_msgs/Vector3": "float64 x, float64 y, float64 z",
    "geometry_msgs/Quaternion": "float64 x, float64 y, float64 z, float64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position, geometry_msgs/Quaternion orientation",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform"
    ),
    "sensor_msgs/CompressedImage": "std_msgs/Header header, string format, uint8[] data",
    "visualization_msgs/UVCoordinate": "float32 u, float32 v",
    "visualization_msgs/MeshFile": "string filename, uint8[] data",
    STRING: "string data",
    JOINT_STATE: "std_msgs/Header header, string[] name, float64[] position, float64[] velocity, float64[] effort",
    TF: "geometry_msgs/TransformStamped[] transforms",
    MARKER: (
        "std_msgs/Header header, string ns, int32 id, int32 type, int32 action, geometry_msgs/Pose pose, "
        "geometry_msgs/Vector3 scale, std_msgs/ColorRGBA color, builtin_interfaces/Duration lifetime, "
        "bool frame_locked, geometry_msgs/Point[] points, std_msgs/ColorRGBA[] colors, string texture_resource, "
        "sensor_msgs/CompressedImage texture, visualization_msgs/UVCoordinate[] uv_coordinates, string text, "
        "string mesh_resource, visualization_msgs/MeshFile mesh_file, bool mesh_use_embedded_materials"
    ),
}
"""Fields of messages as ROS 2 Humble and later have them."""


def definition_of(message: str) -> str:
    """Return the definition of a message with those of its parts, as MCAP files hold it."""
    first, *parts = dict.fromkeys(_with_parts(message))
    return "\n".join([_lines(first), *(f"{_RULE}\nMSG: {part}\n{_lines(part)}" for part in parts)])


def _with_parts(message: str) -> Iterator[str]:
    """Yield a message, and the messages that its fields are, each as often as it occurs."""
    yield message
    for field in _FIELDS[message].split(", "):
        kind = field.split()[0].removesuffix("[]")
        if kind in _FIELDS:
            yield from _with_parts(kind)


def _lines(message: str) -> str:
    return _FIELDS[message].replace(", ", "\n")
