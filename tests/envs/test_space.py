"""Environments of robots in space: Gymnasium's checker, the walk of the adaptive controller, refusals."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import mjbiped
from mjbiped.envs import IN_SPACE
from mjbiped.envs.space import SpaceEnv
from mjbiped.errors import InputError

GROUND = {"name": "level", "lateral_deg": 1.0}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "name", [name if "Compass" in name else pytest.param(name, marks=pytest.mark.slow) for name in IN_SPACE]
)
def test_gymnasiums_checker_has_nothing_to_say(name: str) -> None:
    env = gymnasium.make(name, time_limit=0.1)
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_without_actions_an_episode_is_the_adaptive_controllers_walk() -> None:
    env = SpaceEnv(residual=True, terrain=GROUND, time_limit=1.2)
    env.reset(seed=3)
    shown, over = [], False
    while not over:
        seen, reward, fell, late, info = env.step(np.zeros(3, dtype=np.float32))
        shown.append((seen[6], reward))
        over = fell or late
    episode, task = env.walk(), env.task
    law, start = task.controller.inner, episode.settings["initial"]
    walk = mjbiped.walk(law, episode.terrain, engine=task.engine, initial=start, steps=2)
    rows = len(episode.touchdowns["time"])
    assert (info["outcome"], rows) == ("time limit", 1)
    for name, column in episode.touchdowns.items():
        if "lateral_estimate" not in name:
            np.testing.assert_array_equal(column, walk.touchdowns[name][:rows], err_msg=name)
    touched, rewards = np.array(shown).T
    assert np.flatnonzero(touched).tolist() == [int(episode.touchdowns["time"][0] / task.control_period)]
    assert ((rewards > 0.5) & (rewards <= 1.0)).all()


def test_what_does_not_fit_is_refused_in_words() -> None:
    for given in ({"kind": "compass"}, {"privileged": True}):
        with pytest.raises(InputError, match="robots in space"):
            SpaceEnv(**given)
    with pytest.raises(mjbiped.InputError, match="mjbiped/Compass3D-v0"):
        gymnasium.make("mjbiped/CompassWalk-v0", robot="compass3d")
    env = gymnasium.make("mjbiped/Compass3D-v0", disable_env_checker=True).unwrapped
    with pytest.raises(mjbiped.MjbipedError, match="reset"):
        env.step(np.zeros(3, dtype=np.float32))
    env.reset(seed=0)
    with pytest.raises(mjbiped.InputError, match=r"expected shape \(3,\): ankle, hip, ankle_roll"):
        env.step(np.zeros(2))
