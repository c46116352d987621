"""Records in readers of other people: of MCAP's makers, one that shares no code with them, pandas, and PyArrow."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow.parquet
import pytest
from mcap.reader import make_reader
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.exchange import export_walk
from mjbiped.exchange.ros import joint_rates, urdf_of


def recorded(walk: mjbiped.Walk, folder: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times (ns) and messages by topic."""
    export_walk(walk, folder / "walk.mcap")
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([folder / "walk.mcap"]) as reader:
        for connection, time, raw in reader.messages():
            found.setdefault(connection.topic, []).append((time, reader.deserialize(raw, connection.msgtype)))
    return found


def stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)


def test_joint_states_and_torques_are_the_samples(walk: mjbiped.Walk, tmp_path: Path) -> None:
    topics = recorded(walk, tmp_path)
    times, states = zip(*topics["/joint_states"], strict=True)
    assert np.array(times) / 1e9 == pytest.approx(walk.samples["time"], abs=5e-10)
    assert [stamp(state) for state in states] == list(times)
    assert all(tuple(state.name) == walk.robot.places for state in states)
    assert np.array([state.position for state in states]).tolist() == walk.samples["qpos"].tolist()
    assert np.array([state.velocity for state in states]) == pytest.approx(joint_rates(walk.robot, walk.samples))
    torques = [message for _, message in topics["/torques"]]
    assert tuple(torques[0].name) == walk.robot.joints
    assert np.array([message.effort for message in torques]).tolist() == walk.samples["torque"].tolist()


def matrices(message: Any) -> Iterator[tuple[str, str, NDArray[np.float64]]]:
    """Parent, child and homogeneous matrix of each transform."""
    for each in message.transforms:
        turn, move = each.transform.rotation, each.transform.translation
        sine, cosine = 2.0 * turn.y * turn.w, 1.0 - 2.0 * turn.y**2
        matrix = np.array([[cosine, 0, sine, move.x], [0, 1, 0, move.y], [-sine, 0, cosine, move.z], [0, 0, 0, 1]])
        yield each.header.frame_id, each.child_frame_id, matrix


def test_transforms_lead_to_the_feet(walk: mjbiped.Walk, tmp_path: Path) -> None:
    messages = recorded(walk, tmp_path)["/tf"]
    assert len(messages) == len(walk.samples["time"])
    robot = walk.robot
    for row in (0, 17, len(messages) - 1):
        time, message = messages[row]
        places = {"world": np.eye(4)}
        for parent, child, matrix in matrices(message):
            places[child] = places[parent] @ matrix
        assert stamp(message.transforms[0]) == time
        ends = [link for link in places if link.startswith(("left", "right")) or link == "wheel"]
        last = ends[len(robot.bodies.leg) - 1 :: len(robot.bodies.leg)]
        down = np.array([0.0, 0.0, -robot.bodies.leg[-1].length, 1.0])
        feet = np.array([(places[link] @ down)[[0, 2]] for link in last])
        assert feet == pytest.approx(robot.limbs(walk.samples["qpos"][row])[: len(feet), -1], abs=1e-12)


def test_robot_and_ground_stand_at_the_beginning(tmp_path: Path) -> None:
    terrain = mjbiped.Terrain.from_segments([(1.0, 2.0, 0.0), (0.5, 2.0, -0.02), (1.0, 0.0, 0.0)])
    walk = mjbiped.walk(Unpowered(), terrain, steps=2, engine="hybrid")
    topics = recorded(walk, tmp_path)
    ((at, description),), ((_, ground),) = topics["/robot_description"], topics["/ground"]
    assert (at, description.data) == (0, urdf_of(walk.robot))
    points = np.array([[point.x, point.y, point.z] for point in ground.points])
    hips = walk.samples["qpos"][:, 0]
    assert points[[0, -1], 0] == pytest.approx([hips.min() - 1.0, hips.max() + 1.0])
    after = points[[0, 2, 4]]  # first points of three segments
    assert after[:, 2] == pytest.approx(terrain.height(after[:, 0]), abs=1e-12)
    assert points[1, 2] - points[2, 2] == pytest.approx(0.02, abs=1e-12)
    assert (ground.type, ground.pose.orientation.w, ground.header.frame_id) == (4, 1.0, "world")


def test_rates_are_those_at_which_postures_change(walk: mjbiped.Walk) -> None:
    time, qpos, rates = walk.samples["time"], walk.samples["qpos"], joint_rates(walk.robot, walk.samples)
    changed = (qpos[2:] - qpos[:-2]) / (time[2:] - time[:-2])[:, None]
    jumps = [
        *walk.touchdowns["time"],
        *(walk.touchdowns.get("knee_strike", 0.0) + np.append(0, walk.touchdowns["time"][:-1])),
    ]
    smooth = np.array([all(abs(each - jump) > 0.011 for jump in jumps) for each in time[1:-1]])
    # central differences err by h^2/6 of the third derivative: h = 5 ms, some 400 rad/s^3 in a shank
    assert changed[smooth] == pytest.approx(rates[1:-1][smooth], abs=2e-3)


def test_recording_tells_its_walk(walk: mjbiped.Walk, tmp_path: Path) -> None:
    export_walk(walk, tmp_path / "walk.mcap")
    with (tmp_path / "walk.mcap").open("rb") as stream:
        reader = make_reader(stream)
        (told,) = reader.iter_metadata()
        assert reader.get_header().profile == "ros2"
    assert (told.name, told.metadata["outcome"]) == ("mjbiped", walk.outcome)
    assert json.loads(told.metadata["settings"]) == walk.settings


# ---- tables ----------------------------------------------------------------------------------------------------------


def test_csv_holds_all_digits(walk: mjbiped.Walk, tmp_path: Path) -> None:
    export_walk(walk, tmp_path / "walk.csv")
    for file, expected in zip(("walk.csv", "walk_touchdowns.csv"), walk.to_pandas(), strict=True):
        # pandas' own reader of numbers errs in the last digit
        pandas.testing.assert_frame_equal(pandas.read_csv(tmp_path / file), expected, rtol=1e-15, atol=0.0)
        assert "," in (tmp_path / file).read_text(encoding="utf-8").splitlines()[0]


def test_parquet_holds_units_too(walk: mjbiped.Walk, tmp_path: Path) -> None:
    export_walk(walk, tmp_path / "walk.parquet")
    for file, expected in zip(("walk.parquet", "walk_touchdowns.parquet"), walk.to_pandas(), strict=True):
        read = pandas.read_parquet(tmp_path / file)
        pandas.testing.assert_frame_equal(read, expected, check_exact=True)
        assert read.attrs["units"] == expected.attrs["units"]
    table = pyarrow.parquet.read_table(tmp_path / "walk.parquet")
    assert table["q_stance"].to_pylist() == walk.samples["q"][:, 0].tolist()
