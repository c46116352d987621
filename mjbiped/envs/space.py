"""Environments of robots in space for Gymnasium, one robot each."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import GroundWindows
from mjbiped.engines.space.mujoco import MujocoSpaceRun
from mjbiped.envs.observation import FIELDS, economy_reward, progress_reward
from mjbiped.envs.single import TERMS, Camera, action_space
from mjbiped.envs.tasks import Episode, task_of
from mjbiped.envs.walkers import AFFORDED
from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.records.record import Walk
from mjbiped.robots.in_space import InSpace
from mjbiped.robots.three_d import Compass3D
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import PIXELS, SEED

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise MjbipedError("Gymnasium is not installed: pip install 'mjbiped[gym]'") from error

_FIELDS = [field for field in FIELDS if field.of == "all"]


class SpaceEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """A biped in space walks on ground that it does not see.

    ## Description

    The legs are those of `mjbiped.envs.single.WalkEnv`, 10 cm apart. Beside its planar motors the robot has one at the
    ankle that rolls it about its heading. The physics is MuJoCo as in `mjbiped.walk`; with `residual=True` and zero
    actions the walk is bitwise that of the adaptive controller there, whose torques are held for 2 ms.

    | id | robot |
    |---|---|
    | `mjbiped/Compass3D-v0` | straight legs |
    | `mjbiped/Abducting3D-v0` | straight legs whose hips abduct |
    | `mjbiped/Kneed3D-v0` | legs with knees |

    ## Action space

    `Box(-1, 1, (3,), float32)`, with knees or abduction `(4,)`: torques of ankle, hip, swing knee or abduction
    (positive where it opens the legs), and ankle roll (positive towards the stance side), as parts of the greatest that
    an action can ask for. They are held for a control period of 20 ms.

    ## Observation space

    `Box((17,), float64)`, with knees or abduction `(22,)`: the fields of `mjbiped.envs.observation.FIELDS` that all
    robots have. Angles and rates are those of the robot's planar segments, the abduction and the roll.

    ## Rewards, starting state and episode end

    Those of `mjbiped.envs.single.WalkEnv`.

    ## Arguments

    Those of `mjbiped.envs.single.WalkEnv` without `privileged`. `terrain` also takes ground that falls to one side, as
    {"name": "level", "lateral_deg": 2.0}, and bumps, as {"name": "bumps", "rms": 0.01}.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012 (Gymnasium's own kind)

    def __init__(
        self,
        task: str = "walk_level",
        *,
        kind: str = Compass3D.kind,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        **settings: object,
    ) -> None:
        """Make the environment; the class tells of the arguments.

        Args:
            task: One of `mjbiped.envs.TASKS`.
            kind: Name of the robot where the setting `robot` does not give it.
            render_mode: "rgb_array" if `render` shall give pictures.
            width: Width of pictures, pixels.
            height: Height of pictures, pixels.
            **settings: Settings of the task.

        Raises:
            InputError: A value is outside its domain, or the robot is planar.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode = {shown(render_mode)}: must be None or 'rgb_array'")
        self.task = task_of(task, kind, settings)
        robot = self.task.model
        if not isinstance(robot, InSpace) or self.task.privileged:
            raise InputError(
                f"this environment is of robots in space, without privileged=True, and a {type(robot).__name__} was "
                "given; planar robots walk in mjbiped/CompassWalk-v0 and its neighbours"
            )
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self.task.control_period)}
        self.action_space = action_space(self.task)
        sizes = [field.each * len(robot.joints) + field.more for field in _FIELDS]
        low, high = (np.repeat([getattr(field, end) for field in _FIELDS], sizes) for end in ("low", "high"))
        self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float64)
        self._bounds, self._most = (low, high), np.array(self.task.limits)
        self._camera = Camera(PIXELS.check("width", width), PIXELS.check("height", height))
        self._run: MujocoSpaceRun | None = None
        self._seen: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begin an episode; the same seed gives the same one. There are no options."""
        super().reset(seed=None if seed is None else SEED.check("seed", seed))
        self._episode: Episode = self.task.episode(self.np_random)
        run: Any = self.task.engine.start(self.task.plan(self._episode, recorded=True))
        self._run, self._seen, self._periods = run, None, 0
        self._speed, self._worked, self._steps = self.task.target_speed, 0.0, 0
        self._x, self._told = float(run.data.qpos[run.hip[0]]), np.tile(run.q, 2)
        return self._observe(), self._info(0.0, 0.0)

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Hold an action for a control period; see the class."""
        run, task, place = self._walking(), self.task, self.task.controller.place
        values, joints = np.asarray(action, dtype=np.float64), run.robot.joints
        if values.shape != (len(joints),):
            raise InputError(f"action: expected shape ({len(joints)},): {', '.join(joints)}, got {values.shape}")
        torques = np.clip(values, -1.0, 1.0) * self._most
        run.memory[place : place + len(torques)] = torques.tolist()
        self._periods += 1
        outcome, x = run.advance(self._periods * task.control_period), self._x
        self._x = float(run.data.qpos[run.hip[0]])
        share = min(1.0, task.control_period / task.gait.period)
        self._speed += share * ((self._x - x) / task.control_period - self._speed)
        work, self._worked = run.work[0] - self._worked, run.work[0]
        afforded = AFFORDED * run.robot.weight * task.target_speed * task.control_period
        progress, economy = progress_reward(self._speed, task.target_speed), economy_reward(work, afforded)
        truncated = outcome is Outcome.WALKING and self._periods >= task.max_steps
        run.outcome = Outcome.TIME_LIMIT if truncated else outcome
        over = outcome is not Outcome.WALKING
        if outcome is Outcome.DIVERGED:
            progress = economy = 0.0
        return self._observe(), float(progress + economy), over, truncated, self._info(progress, economy)

    def _walking(self) -> MujocoSpaceRun:
        if self._run is None:
            raise MjbipedError("there is no episode yet; call reset() first")
        return self._run

    def _observe(self) -> NDArray[np.float64]:
        """The fields of an observation, in their order."""
        run = self._walking()
        q, dq = run.seen()
        touched, self._steps = float(run.count > self._steps), run.count
        if touched:
            self._told = np.concatenate([run.recorder.touchdowns()["q_before"][-1], run.q])
        felt = np.concatenate([q, dq, [touched, float(run.data.time) - run.began], self._told, run.torque])
        return np.asarray(np.nan_to_num(felt).clip(*self._bounds))

    def _info(self, *rewards: float) -> dict[str, object]:
        outcome = self._walking().outcome if self._periods else Outcome.WALKING
        told = dict(zip(TERMS, (*map(float, rewards), self._x), strict=True))
        return {**told, "outcome": outcome.words, **self._episode.drawn}

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the robot, RGB, shape (height, width, 3); None without `render_mode`.

        Raises:
            RenderError: No OpenGL platform works.
        """
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs render_mode='rgb_array', given to gymnasium.make")
            return None
        run, x = self._walking(), self._x
        if self._seen is None or not self._seen.inside[0] < x < self._seen.inside[1]:
            length = run.robot.leg_length
            ground = Ground(run.plan.terrain, reach=x + 20.0 * length, half_width=length)
            self._seen = GroundWindows(run.robot, ground, run.timestep, 6.0 * length, scenery=True).about(x)
        shown: Any = SimpleNamespace(model=self._seen.model, data=run.data)
        return self._camera.picture(shown)

    def walk(self) -> Walk:
        """Return the record of the episode so far; see `mjbiped.envs.single.WalkEnv.walk`."""
        return self._walking().record()

    def close(self) -> None:
        """Release the renderer and the simulation."""
        self._camera.close()
        self._run = self._seen = None
