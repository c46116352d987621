"""A learned policy walks by its name as it did in training."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import run

import mjbiped
from mjbiped.errors import InputError
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.controller import LearnedController
from scripts.learning.policy import WEIGHTS, Array, actions

import gymnasium  # isort: skip

DOWNHILL = mjbiped.Terrain.from_segments(
    [(0.9, 2.0, 0.0), (0.8, 2.3, 0.0), (9.0, 2.0, 0.0)]
)  # walks with little torque
FILE = Path(__file__).parents[3] / "scripts" / "learning" / "controller.py"


def policy(folder: Path, residual: bool) -> Path:
    """The file of one that does a little, at random."""
    one = np.zeros(1)
    weights = np.random.default_rng(5).normal(0.0, 0.003, WEIGHTS)
    path = folder / "policy.npz"
    Checkpoint(residual, 1, weights, np.zeros((1, 2, 1)), np.zeros((1, 1)), one, one, one).save(path)
    return path


@pytest.mark.parametrize("residual", [True, False], ids=["residual", "free"])
def test_walks_bitwise_as_in_the_environment(residual: bool, tmp_path: Path) -> None:
    controller = LearnedController(str(policy(tmp_path, residual)))
    weights: Array = Checkpoint.load(tmp_path / "policy.npz").weights[None]
    env: Any = gymnasium.make("mjbiped/CompassWalk-v0", residual=residual, terrain=DOWNHILL).unwrapped
    felt, _ = env.reset(seed=4)
    slope = 0.0
    for _ in range(250):  # 5 s
        if felt[4]:
            slope += felt[6] - felt[9]
        row = felt[None]
        told = actions(weights, row[:, 0:2], row[:, 2:4], row[:, 5], row[:, 8], np.array([slope]))
        felt, _, over, _, _ = env.step(told[0])
        if over:
            break
    there = env.walk()
    env.close()
    start, engine = there.settings["initial"], mjbiped.Mujoco(timestep=4e-3, control_period=0.02)
    here = mjbiped.walk(controller, there.terrain, engine=engine, initial=start, steps=201, distance=1.5)
    assert 4 <= here.steps <= there.steps
    for name, column in here.touchdowns.items():
        if not name.startswith("slope_estimate"):  # the environment's controller reckons none
            np.testing.assert_array_equal(column, there.touchdowns[name][: here.steps], err_msg=name)


def test_walks_by_name_in_both_engines(tmp_path: Path) -> None:
    words = ["--controller", f"{FILE}:LearnedController", "--gain", f"checkpoint={policy(tmp_path, True)}"]
    for engine in ("mujoco", "hybrid"):
        result = run("walk", "level", *words, "--engine", engine, "--steps", 2, "--out", tmp_path / f"{engine}.npz")
        assert result.exit_code == 0, result.output
        walk = mjbiped.Walk.load(tmp_path / f"{engine}.npz")
        assert (walk.steps, walk.outcome) == (2, "finished")
        assert walk.settings["controller"]["driven"]["base"]["name"] == "AdaptiveController"


def test_the_slope_estimate_of_a_free_policy_is_the_turn_of_the_ground(tmp_path: Path) -> None:
    """On ground of two slopes, from the touchdown on the second on; exact, as (27) is."""
    controller = LearnedController(str(policy(tmp_path, False)))
    terrain = mjbiped.Terrain.from_segments([(0.3, 2.0, 0.0), (5.0, 3.0, 0.0)])
    walk = mjbiped.walk(controller, terrain, engine=mjbiped.Mujoco(timestep=4e-3, control_period=0.02), steps=2)
    assert walk.steps == 2
    # MuJoCo's foot stands within a fraction of a millimetre of where the leg's angle has it
    np.testing.assert_allclose(np.degrees(walk.touchdowns["slope_estimate"][1:]), 1.0, atol=0.02)


def test_a_file_that_is_no_policy_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="train one: python -m"):
        LearnedController(str(tmp_path / "none.npz"))
    (tmp_path / "text.npz").write_text("nothing")
    with pytest.raises(InputError, match="is no policy that"):
        LearnedController(str(tmp_path / "text.npz"))
    np.savez(tmp_path / "other.npz", weights=np.zeros(3))
    with pytest.raises(InputError, match="is no policy that"):
        LearnedController(str(tmp_path / "other.npz"))
