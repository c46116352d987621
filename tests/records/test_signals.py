"""One table tells how every signal of a walk is drawn: whoever adds a row sees it in figures, reports and videos."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from report_pages import packed

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import loads, signals
from mjbiped.records.signals import PANELS, SIGNALS, Signal, panels_of, signals_of, torques_of, values_of
from mjbiped.rendering.overlay import Chart
from mjbiped.reports.walk import report_walk
from mjbiped.robots.kinds import KINDS
from mjbiped.robots.robot import Robot
from mjbiped.utils.palette import IN_WORDS, ORANGE


@pytest.fixture(scope="module")
def straight(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.stairs(rise=-0.02), engine="hybrid", steps=4)


@pytest.fixture(scope="module")
def kneed() -> mjbiped.Walk:
    robot = mjbiped.KneedBiped()
    law = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))
    return mjbiped.walk(law, mjbiped.Terrain.incline(2.0), engine="hybrid", steps=3)


@pytest.mark.parametrize("robot", KINDS.values())
def test_every_angle_and_joint_of_every_robot_is_drawn(robot: type[Robot]) -> None:
    drawn = signals_of(robot)
    expected = [f"{column}_{part}" for column in ("q", "dq") for part in robot.angles]
    expected += [f"{column}_{joint}" for column in ("torque", "power") for joint in robot.joints]
    assert {*expected} <= {*drawn}
    assert [name for _, found in panels_of(robot) for name in found] == [
        name for panel in PANELS for name, signal in drawn.items() if signal.panel == panel
    ]
    assert len(torques_of(robot)) == len(robot.joints)


@pytest.mark.parametrize("robot", KINDS.values())
def test_lines_of_a_panel_differ_for_colour_blind_eyes(robot: type[Robot]) -> None:
    for _, found in panels_of(robot):
        assert len({signal.colour for signal in found.values()}) == len(found)
        assert {signal.colour for signal in found.values()} <= {*IN_WORDS}  # of Okabe and Ito


def test_a_thigh_is_called_one_where_there_is_a_shank() -> None:
    assert signals_of(mjbiped.Compass)["q_swing"].name == "swing leg"
    assert signals_of(mjbiped.KneedBiped)["q_swing"].name == "swing thigh"


def test_values_are_those_of_the_record_in_the_panels_unit(straight: mjbiped.Walk, kneed: mjbiped.Walk) -> None:
    samples = kneed.samples
    q, torque = samples["q"], samples["torque"]
    assert values_of(kneed, "torque_knee") == pytest.approx(torque[:, 2])
    assert values_of(kneed, "slope") == pytest.approx(np.degrees(samples["slope"]))
    assert values_of(kneed, "flexion") == pytest.approx(np.degrees(q[:, 2] - q[:, 1]))
    assert values_of(kneed, "torque_stance_knee") == pytest.approx(loads.knee_torque(kneed), nan_ok=True)
    rate = samples["dq"][:, 2] - samples["dq"][:, 1]
    assert values_of(kneed, "power_knee") == pytest.approx(torque[:, 2] * rate)
    farthest = 100.0 * 0.5 * straight.robot.leg_length
    assert np.nanmax(np.abs(values_of(straight, "pressure"))) <= farthest
    assert signals.knee_strikes(kneed) == pytest.approx(
        np.append(0.0, kneed.touchdowns["time"][:-1]) + kneed.touchdowns["knee_strike"]
    )
    assert not len(signals.knee_strikes(straight))


def test_a_new_signal_is_one_row(straight: mjbiped.Walk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    row = Signal(
        "slope", "twice the slope", "2φ", ORANGE, signals.SOLID, lambda walk: 2.0 * walk.samples["slope"], "slope"
    )
    monkeypatch.setitem(SIGNALS, "twice", row)
    lines = [str(line.get_label()) for axes in plot_walk(straight).axes for line in axes.lines]
    assert "twice the slope 2φ" in lines
    report_walk(straight, tmp_path / "walk.html", video=False)
    content = packed((tmp_path / "walk.html").read_text())
    assert "twice the slope" in [line["name"] for line in content["plots"]["time"]["data"]]
    assert "twice the slope" in [name for name, *_ in content["data"]["told"]]
    frame = np.zeros((100, 640, 3), dtype=np.uint8)
    Chart(straight, 0.0, 2.0, 640, 100).draw(frame, 1.0)
    assert (np.abs(frame.astype(int) - (230, 159, 0)).max(axis=2) < 30).sum() > 100  # orange, as nothing else is


def test_the_report_of_a_walk_with_knees_shows_them(kneed: mjbiped.Walk, tmp_path: Path) -> None:
    report_walk(kneed, tmp_path / "walk.html", video=False)
    page = (tmp_path / "walk.html").read_text()
    content = packed(page)
    over_time = content["plots"]["time"]
    names = [(line["name"], line["yaxis"]) for line in over_time["data"]]
    titles = [note["text"].removeprefix("<b>").removesuffix("</b>") for note in over_time["layout"]["annotations"]]
    assert titles == [panel.title for panel in PANELS.values()]
    for name, panel in (
        ("stance knee", "torque"),
        ("swing knee", "knee_torque"),
        ("swing knee", "flexion"),
        ("knee strike", "flexion"),
        ("swing shank", "angle"),
        ("swing shank", "rate"),
        ("swing knee", "power"),
    ):
        assert (name, f"y{1 + [*PANELS].index(panel)}") in names
    phases = [line["name"] for line in content["plots"]["phases"]["data"]]
    assert {"stance leg", "swing thigh", "swing shank"} <= {*phases}
    legs, half = content["data"]["legs"], len(kneed.samples["time"]) // 3
    limbs = kneed.robot.limbs(kneed.samples["qpos"][half])[1 - kneed.samples["stance"][half]]
    assert np.array(legs["swing leg now"])[:, :, half] == pytest.approx(limbs, abs=1e-4)
    assert "greatest flexion (°)" in page


def test_a_sole_is_drawn_where_there_is_one(straight: mjbiped.Walk, controller: AdaptiveController) -> None:
    """Its ends beside the centre of pressure, and the torque asked for where it transmits less."""
    robot = mjbiped.Compass(sole=(0.03, 0.05))
    walk = mjbiped.walk(controller, mjbiped.Terrain.stairs(rise=-0.01), engine="hybrid", robot=robot, steps=6)
    lines = {name: line for each in signals.lines_of(walk) for name, line in each.values.items()}
    assert {*lines["toe"]} == {5.0}
    assert {*lines["heel"]} == {-3.0}
    asked, given = lines["torque_asked"], walk.samples["torque"][:, 0]
    bound = np.isfinite(asked)
    assert bound.any()
    assert (np.abs(given[bound]) < np.abs(asked[bound])).all()
    assert (given[~bound] == walk.samples["ankle_asked"][~bound]).all()
    without = list(signals.lines_of(straight))
    assert not {"toe", "heel", "torque_asked"} & {name for each in without for name in each.values}
    assert not any(name in each.missing for each in without for name in ("toe", "heel", "ankle, asked for"))
