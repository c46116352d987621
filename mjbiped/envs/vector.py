"""Environment of Gymnasium with many robots, stepped in the threads of this process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.envs.single import TERMS, action_space, observation_space
from mjbiped.envs.tasks import planar_task
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError, shown
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import SEED, STEPS, WALKS, WORKERS, entries
from mjbiped.utils.parallel import cores

from gymnasium.utils import seeding  # isort: skip  # `single` says what to install where it is missing
from gymnasium.vector import AutoresetMode, VectorEnv  # isort: skip
from gymnasium.vector.utils import batch_space  # isort: skip

_WORDS = np.array([outcome.words for outcome in Outcome])


class WalkVectorEnv(VectorEnv[NDArray[np.float64], NDArray[np.float32], NDArray[Any]]):
    """Many robots of `mjbiped.envs.single.WalkEnv`, each on ground of its own.

    `gymnasium.make_vec("mjbiped/CompassWalkRandom-v0", num_envs=64)` makes it. Each robot walks bitwise as in an
    environment of its own with the seed `seed + index`, whatever the number of threads. After the end of its episode
    the next `step` resets it and ignores its action (`AutoresetMode.NEXT_STEP`). The terms of the reward, `x_position`
    and `outcome` are arrays in `info`.
    """

    metadata: dict[str, object] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012 (Gymnasium types it so)

    def __init__(
        self,
        num_envs: int = 1,
        task: str = "walk_level",
        *,
        kind: str = Compass.kind,
        max_episode_steps: int | None = None,
        threads: int | None = None,
        render_mode: None = None,
        **settings: object,
    ) -> None:
        """Make the environment.

        Args:
            num_envs: Number of robots.
            task: One of `mjbiped.envs.TASKS`.
            kind: Name of the robot where the setting `robot` does not give it: "compass" or "kneed".
            max_episode_steps: Number of steps after which an episode is truncated, in the place of `time_limit`.
            threads: Number of threads that step robots at the same time; by default the number of cores.
            render_mode: Gymnasium's keyword; only None, for nothing is drawn.
            **settings: Settings of the task, which `WalkEnv` describes.

        Raises:
            InputError: A value is outside its domain.
        """
        if render_mode is not None:
            raise InputError(
                f"render_mode = {shown(render_mode)}: robots of one vector are not drawn; gymnasium.make_vec(..., "
                'vectorization_mode="sync") draws each'
            )
        chosen = planar_task(task, kind, settings)
        if max_episode_steps is not None:
            longest = STEPS.check("max_episode_steps", max_episode_steps)
            chosen = replace(chosen, time_limit=longest * chosen.control_period)
        self.num_envs = WALKS.check("num_envs", num_envs)
        threads = WORKERS.check("threads", cores() if threads is None else threads)
        self.walkers = Walkers(chosen, num_envs, threads=threads, recorded=False)
        self._drawn: dict[str, NDArray[Any]] = {}
        self.single_action_space, self.single_observation_space = action_space(chosen), observation_space(chosen)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._most = np.array(chosen.limits)
        self._randoms = [seeding.np_random()[0] for _ in range(num_envs)]
        self._ended = np.zeros(num_envs, dtype=bool)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begin episodes.

        Args:
            seed: Seed of the first robot, whose successors seed the others; or one for each. None goes on drawing.
            options: `{"reset_mask": mask}` resets only some of the robots.

        Raises:
            InputError: There is not one seed for each robot, or not one entry in the mask.
        """
        seeds = entries(seed)
        if seeds is None:
            seeds = tuple(seed if seed is None else SEED.check("seed", seed) + k for k in range(self.num_envs))
        if len(seeds) != self.num_envs:
            raise InputError(f"seed: expected one number, or one for each of the {self.num_envs} robots")
        mask = np.ones(self.num_envs, dtype=bool)
        if options and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"], dtype=bool)
            if mask.shape != (self.num_envs,) or not mask.any():
                raise InputError(f"reset_mask: expected {self.num_envs} truth values, of which one at least is true")
        anew = mask & [each is not None for each in seeds]
        for index in np.flatnonzero(anew).tolist():
            self._randoms[index] = seeding.np_random(SEED.check("seed", seeds[index]))[0]
        self._begin(mask, anew)
        self._ended[mask] = False
        return self.walkers.observations(), self._info(self.walkers.columns["outcome"])

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Hold the actions for a control period; robots whose episode ended in the last step begin anew instead."""
        walkers = self.walkers
        walkers.act(actions, self._most)
        walkers.step()
        if self._ended.any():
            self._begin(self._ended, np.zeros_like(self._ended))
        rewards, outcomes = walkers.columns["reward"].copy(), walkers.columns["outcome"].copy()
        rewards[self._ended] = 0.0
        self._ended, truncated = outcomes != 0.0, outcomes == float(Outcome.TIME_LIMIT)
        return walkers.observations(), rewards, self._ended & ~truncated, truncated, self._info(outcomes)

    def _begin(self, mask: NDArray[np.bool_], anew: NDArray[np.bool_]) -> None:
        """Begin episodes of some robots, and note what was drawn for all, in new arrays: infos keep the old ones."""
        for index in np.flatnonzero(mask).tolist():
            self.walkers.begin(index, self._randoms[index], anew=bool(anew[index]))
        each = [self.walkers.walker(index).episode.drawn for index in range(self.num_envs)]
        self._drawn = {name: np.array([drawn[name] for drawn in each]) for name in each[0]}

    def _info(self, outcomes: NDArray[np.float64]) -> dict[str, object]:
        """Arrays of `info`, each with the mask that Gymnasium asks for."""
        info: dict[str, object] = {**{name: self.walkers.columns[name].copy() for name in TERMS}, **self._drawn}
        info["outcome"] = _WORDS[outcomes.astype(np.int64)]
        return {**info, **dict.fromkeys(map("_{}".format, info), np.ones(self.num_envs, dtype=bool))}

    def walk(self, index: int) -> Walk:
        """Return the record of a robot's episode so far: its first 500 touchdowns, without samples."""
        return self.walkers.walk(index)

    def close_extras(self, **kwargs: object) -> None:
        """End the threads, and release the simulations."""
        self.walkers.close()
