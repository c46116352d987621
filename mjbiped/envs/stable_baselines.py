"""Many robots as a vector environment of stable-baselines3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.envs.vector import WalkVectorEnv
from mjbiped.errors import InputError, MjbipedError

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise MjbipedError("stable-baselines3 is not installed: pip install 'mjbiped[sb3]'") from error


class WalkVecEnv(VecEnv):  # type: ignore[misc]  # an extra, without types
    """The robots of `mjbiped.envs.vector.WalkVectorEnv` for the learners of stable-baselines3.

    ```python
    env = VecMonitor(WalkVecEnv(64, "walk_random", residual=True))
    PPO("MlpPolicy", env, n_steps=256).learn(100_000)
    ```

    A robot whose episode ends begins another one in the same step, as stable-baselines3 has it: its `info` holds
    `terminal_observation`, `TimeLimit.truncated`, `outcome` and the numbers that were drawn for the ended episode.

    Attributes:
        robots: The environment of Gymnasium.
        task: The robots' task.
    """

    def __init__(self, num_envs: int, task: str = "walk_level", *, threads: int | None = None, **settings: Any) -> None:
        """Make the environment; see `WalkVectorEnv` for the arguments.

        Raises:
            InputError: A value is outside its domain.
        """
        self.robots = WalkVectorEnv(num_envs, task, threads=threads, **settings)
        self.task = self.robots.walkers.task
        super().__init__(num_envs, self.robots.single_observation_space, self.robots.single_action_space)

    def reset(self) -> NDArray[np.float64]:
        """Begin episodes, with the seeds of `seed` where it was called."""
        seeds = None if self._seeds[0] is None else self._seeds
        observed, infos = self.robots.reset(seed=seeds)
        self.reset_infos = [self._info(infos, index) for index in range(self.num_envs)]
        self._reset_seeds()
        return observed

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Take the actions for the next step."""
        self._actions = actions

    def step_wait(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], list[dict[str, object]]]:
        """Hold the actions for a control period; robots whose episode ends begin another one."""
        observed, rewards, terminated, truncated, infos = self.robots.step(self._actions)
        done = terminated | truncated
        told: list[dict[str, object]] = [{} for _ in range(self.num_envs)]
        if done.any():
            for index in np.flatnonzero(done).tolist():
                told[index] = {
                    "terminal_observation": observed[index],
                    "TimeLimit.truncated": bool(truncated[index]),
                    **self._info(infos, index),
                }
            observed, _ = self.robots.reset(options={"reset_mask": done})
        return observed, rewards, done, told

    @staticmethod
    def _info(infos: dict[str, Any], index: int) -> dict[str, object]:
        """One robot's share of the arrays in `info`."""
        return {name: each[index].item() for name, each in infos.items() if not name.startswith("_")}

    def close(self) -> None:
        """End the threads, and release the simulations."""
        self.robots.close()

    def get_attr(self, attr_name: str, indices: int | Sequence[int] | None = None) -> list[object]:
        """Value of an attribute of the environment, which all robots share, once for each."""
        return [getattr(self.robots, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: object, indices: int | Sequence[int] | None = None) -> None:
        """Refuse: the robots share one environment, whose settings are fixed.

        Raises:
            InputError: Always.
        """
        raise InputError(f"{attr_name} cannot be set: give settings when the environment is made")

    def env_method(
        self,
        method_name: str,
        *method_args: object,
        indices: int | Sequence[int] | None = None,
        **method_kwargs: object,
    ) -> list[object]:
        """Call a method that takes a robot's number first, such as `walk`, for each robot."""
        method = getattr(self.robots, method_name)
        return [method(index, *method_args, **method_kwargs) for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[object], indices: int | Sequence[int] | None = None) -> list[bool]:
        """No robot is wrapped by itself."""
        return [False for _ in self._get_indices(indices)]
