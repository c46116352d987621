"""Lateral state of bipeds in space: slices through the return map, and the lateral basin."""

import json
import math
from pathlib import Path

import numpy as np
from command_line import ran

import mjbiped
from controllers import PassiveController
from mjbiped.gaits.space import start_of
from mjbiped.limit_cycles.map_slices import map_slices

ROBOT, SLOPE = mjbiped.Compass3D(), math.radians(2.0)


def test_slices_meet_in_the_gait_and_are_steps_of_the_engine() -> None:
    slices = map_slices(ROBOT, SLOPE, points=5)
    fixed = slices.fixed_point
    np.testing.assert_allclose(slices.before[:, 2], fixed, rtol=0, atol=1e-15)
    np.testing.assert_allclose(slices.after[:, 2], fixed, rtol=0, atol=1e-9)
    assert slices.outcome == "fell"  # for the roll
    assert 1 < len(slices.walk) < 5
    start = start_of(ROBOT.in_space[2], np.array([*fixed[:2], slices.before[2, 4], *fixed[3:]]))
    ground, law = mjbiped.Terrain.incline(2.0), PassiveController()
    walk = mjbiped.walk(law, ground, engine="hybrid", robot=ROBOT, steps=1, initial=start)
    assert abs(walk.touchdowns["dq"][0, 0] - slices.after[2, 4]) < 1e-9  # the integrators' tolerance


def test_a_sole_holds_a_deviation_within_its_half_width(tmp_path: Path) -> None:
    words = ("--robot", "compass3d", "--sole", 0.12, "--sole-width", 0.08, "--controller", "bounded-ankle")
    sides = ("--rolls-deg=-1.5..20", "--roll-rates=0..0.02", "--grid", 2, "--limit", 1)
    files = (tmp_path / "basin.npz", tmp_path / "basin.png")
    found = json.loads(ran("lateral-basin", *words, *sides, "--out", files[0], "--plot", files[1], "--json"))
    assert (found["walker"], found["starts"], found["share_that_walks_on"]) == ("SidewaysController", 4, 0.5)
    with np.load(files[0]) as data:
        assert (data["steps"] == [[1, 0]] * 2).all()
        assert (data["fallen"] == [[False, True]] * 2).all()
        assert (np.abs(data["deviations"]) < 0.04).tolist() == [[True, False]] * 2
    assert files[1].stat().st_size > 5_000
