"""Mistakes in robots, grounds, curricula, policies, actions and seeds are named before an episode goes on."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

import mjbiped
from mjbiped.envs import Curriculum, PolicyController
from mjbiped.envs.single import WalkEnv
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.vector import WalkVectorEnv

NAME = "mjbiped/CompassWalk-v0"


def task(**settings: Any) -> Callable[[], object]:
    return lambda: WalkTask("walk_level", **settings)


def curriculum(**changed: Any) -> Callable[[], object]:
    terms = {"easy": {"name": "stairs", "rise": (-0.01, 0.0)}, "hard": {"rise": (-0.06, 0.0)}, **changed}
    return lambda: WalkTask("walk_level", terrain=Curriculum(**terms))


def policy(action: Any, **settings: Any) -> Callable[[], object]:
    def walk() -> object:
        controller = PolicyController(lambda _: action, WalkTask("walk_level", **settings))
        return mjbiped.walk(controller, mjbiped.Terrain.level(), engine=mjbiped.Mujoco(control_period=0.02), steps=1)

    return walk


REFUSED: dict[str, Callable[[], object]] = {
    "did you mean 'kneed'": task(robot="kned"),
    "has no legs to walk with": task(robot="wheel"),
    "leg_mas": task(robot={"leg_mas": 4.0}),
    "leg_mass = -1.0": task(robot={"leg_mass": {"uniform": [-1.0, 4.0]}}),
    "leg_mass = -0.199": task(robot={"leg_mass": {"normal": [1.0, 0.3]}}),
    "did you mean 'rise'": task(terrain={"name": "stairs", "raise": 0.1}),
    "control_period cannot be drawn": task(disturbances={"control_period": {"uniform": [0.004, 0.02]}}),
    "control_period = 0.02: must be a multiple of": task(disturbances={"control_period": 0.016}),
    "control_period = 2.0: must be from 0.004 to 1 s": task(control_period=2.0),
    "in `hard`": curriculum(hard={"raise": -0.1}),
    "`by` 'luck'": curriculum(by="luck"),
    "expected 2 numbers from -1 to 1: ankle, hip": policy([0.0]),
    "observes the ground, which no controller sees": policy([0.0, 0.0], privileged=True),
    r"control_period = 0\.012 of disturbances or controller contradicts": policy([0.0, 0.0], control_period=0.012),
    "render_mode": lambda: WalkEnv(render_mode="human"),
    "did you mean 'terrain'": lambda: WalkEnv(terain={}),
    "of one vector are not drawn": lambda: gymnasium.make_vec(NAME, num_envs=2, render_mode="rgb_array"),
    "one for each of the 2 robots": lambda: WalkVectorEnv(2).reset(seed=[1, 2, 3]),
    "seed = '4'": lambda: WalkVectorEnv(2).reset(seed=[3, "4"]),  # type: ignore[list-item]
    "reset_mask": lambda: WalkVectorEnv(2).reset(options={"reset_mask": np.array([False, False])}),
    r"shape \(1, 2\) or \(2,\): ankle, hip": lambda: WalkEnv().step(1.0),  # type: ignore[arg-type]
    r"call reset\(\) first": lambda: WalkVectorEnv(2).step(np.zeros((2, 2), dtype=np.float32)),
}


@pytest.mark.parametrize("words", REFUSED)
def test_mistakes_are_named(words: str) -> None:
    with pytest.raises(mjbiped.MjbipedError, match=words):
        REFUSED[words]()
