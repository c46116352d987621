"""How a report says that a walk is made again: both ways give bitwise the same record."""

from __future__ import annotations

import math
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import run

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController
from mjbiped.control.registry import make_controller
from mjbiped.reports.repeat import command_of, python_of

HYBRID = mjbiped.Hybrid()


def walks() -> dict[str, mjbiped.Walk]:
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2))
    heavy = mjbiped.Compass(hip_mass=5.0)
    return {
        "adaptive": mjbiped.walk(AdaptiveController(robot, gait), mjbiped.Terrain.mixed(), engine=HYBRID, steps=2),
        "settings": mjbiped.walk(
            AdaptiveController(
                robot,
                mjbiped.find_passive_gait(robot, math.radians(2.3)),
                position_gain=6.25,
                replanning_delay=None,
                estimate_update=False,
                replanning_threshold=0.02,
            ),
            mjbiped.Terrain.random(seed=3, slope_deg=(-1.0, 2.0)),
            engine=mjbiped.Mujoco(timestep=5e-4),
            steps=2,
            distance=0.5,
            initial="rest",
            scuffing=mjbiped.ScuffingRule(reach=0.15),
        ),
        "passive": mjbiped.walk(
            PassiveController(), mjbiped.Terrain.incline(2.0), engine=HYBRID, steps=2, robot=heavy, initial="rest"
        ),
        "compared": mjbiped.walk(
            make_controller("energy-constraint", robot, {"slope_source": "two_point"}),
            mjbiped.Terrain.stairs(rise=-0.02, count=3),
            engine=HYBRID,
            steps=2,
        ),
        "policy": mjbiped.walk(make_controller("policy", robot, {}), mjbiped.Terrain.mixed(), engine=HYBRID, steps=2),
    }


def walk_with_knees(which: str) -> mjbiped.Walk:
    level, robot = mjbiped.Terrain.level(), mjbiped.KneedBiped()
    if which == "knees":
        passive = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.0)))
        late = mjbiped.Disturbances(delay=0.002, pushes=((0.3, 1.0),))
        return mjbiped.walk(passive, level, engine=HYBRID, steps=2, disturbances=late)
    if which == "halved rods":
        return mjbiped.walk(
            make_controller("adaptive", mjbiped.KneedBiped.halved_rods(), {}), level, engine=HYBRID, steps=2
        )
    if which == "heavy":
        heavy = mjbiped.KneedBiped(hip_mass=7.0)
        return mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(3.0), robot=heavy, engine=HYBRID, steps=2)
    held = mjbiped.Mujoco(stance_knee="motor")
    return mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(2.5), robot=robot, engine=held, steps=1)


@pytest.mark.slow
@pytest.mark.parametrize("which", ["knees", pytest.param("halved rods", marks=pytest.mark.slow), "heavy", "held"])
def test_the_command_makes_the_same_record_with_knees(which: str, tmp_path: Path) -> None:
    walk = walk_with_knees(which)
    command = command_of(walk)
    assert command is not None
    result = run(*shlex.split(command)[1:], "--out", tmp_path / "again.npz", "--quiet")
    assert result.exit_code == 0, result.stderr
    assert mjbiped.Walk.load(tmp_path / "again.npz") == walk, command


@pytest.mark.parametrize("which", ["adaptive", "settings", "passive", "compared", "policy"])
def test_the_command_makes_the_same_record(which: str, tmp_path: Path) -> None:
    walk = walks()[which]
    command = command_of(walk)
    assert command is not None
    program, *words = shlex.split(command)
    assert program == "mjbiped"
    result = run(*words, "--out", tmp_path / "again.npz", "--quiet")
    assert result.exit_code == 0, result.stderr
    again = mjbiped.Walk.load(tmp_path / "again.npz")
    assert again == walk, command


@pytest.mark.slow
def test_the_program_makes_the_same_record(tmp_path: Path) -> None:
    walk = walks()["settings"]
    walk.save(tmp_path / "it's.npz")
    program = python_of(walk, "it's.npz")
    assert program is not None
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=120
    )
    assert "the same, bit by bit: True" in done.stdout


def test_what_no_command_makes_is_not_given_one(controller: AdaptiveController) -> None:
    custom = mjbiped.Terrain.from_segments([(2.0, 0.0, 0.0)])
    assert command_of(mjbiped.walk(controller, custom, engine="hybrid", steps=1)) is None
    bare = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1, sample_period=None)
    assert command_of(bare) is None
