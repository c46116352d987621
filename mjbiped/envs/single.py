"""The tasks as environments of Gymnasium, one robot each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from mjbiped.envs import feeling
from mjbiped.envs.pictures import Camera
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import HIGHEST, SEEN, Walkers
from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.records.record import Walk
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import PIXELS, SEED, known_name

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise MjbipedError("Gymnasium is not installed: pip install 'mjbiped[gym]'") from error

TERMS = {"reward_progress": feeling.PROGRESS, "reward_economy": feeling.ECONOMY, "x_position": feeling.HIP_X}
"""Entries of `info`, by their indices in `feeling`."""


class Settings(TypedDict, total=False):
    """Settings of a task, which `CompassWalkEnv` describes."""

    residual: bool
    privileged: bool
    terrain: Terrain | Mapping[str, Any]
    control_period: float


def task_of(name: str, settings: Settings) -> WalkTask:
    """Make the task of a name; settings that are None have their defaults.

    Raises:
        InputError: There is no such setting, or its value is outside its domain.
    """
    for key in settings:
        known_name("setting", key, Settings.__annotations__)
    given: Any = {key: value for key, value in settings.items() if value is not None}
    return WalkTask(name, **given)


def action_space() -> Any:
    """Space of actions: ankle and hip torque, as shares of the greatest."""
    return gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)


def observation_space(task: WalkTask) -> Any:
    """Space of observations, in a privileged task with those of the ground."""
    seen = SEEN if task.privileged else 0
    low, high = ([*felt, *[end] * seen] for felt, end in ((feeling.LOWEST, -HIGHEST), (feeling.HIGHEST, HIGHEST)))
    return gymnasium.spaces.Box(np.array(low), np.array(high), dtype=np.float64)


def observations(walkers: Walkers) -> NDArray[np.float64]:
    """Observations of all robots, shape (robots, size of the space)."""
    felt = walkers.felt
    if not walkers.task.privileged:
        return felt.copy()
    return np.column_stack([felt, [walkers.ground_seen(index) for index in range(len(felt))]])


class CompassWalkEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """A compass biped walks on ground that it does not see.

    ## Description

    Two straight legs of 1 m and 5 kg are joined at the hip: the robot of Table I of Pu et al., *Adaptive Passive Biped
    Dynamic Walking on Unknown Uneven Terrain*. It walks in a plane. A motor at the ankle turns the stance leg against
    the ground, one at the hip the legs against each other. It feels its joints and touchdowns, and neither gravity's
    direction nor the ground. The aim is to walk on, as fast as the passive gait on 2° does, with little work.

    The physics is MuJoCo with the contact events of `mjbiped.walk`: with `residual=True` and zero actions the walk is
    bitwise that of the adaptive controller there. As in `mjbiped.walk` the swing foot passes through the ground until
    it is 0.2 m ahead of the stance foot, for legs without knees must scuff.

    | id | ground |
    |---|---|
    | `mjbiped/CompassWalk-v0` | level |
    | `mjbiped/CompassWalkSlopes-v0` | every 1.5 m the slope turns downhill by 0.3° |
    | `mjbiped/CompassWalkStairs-v0` | treads of 1.8 m, steps of 20 mm down |
    | `mjbiped/CompassWalkRandom-v0` | other ground in each episode: slopes of −3° to 3°, steps of −20 to 5 mm |

    ## Action space

    `Box(-1, 1, (2,), float32)`. Each number is a part of the greatest torque that an action can ask for; it is held for
    a control period of 20 ms. Numbers beyond are cut off.

    | number | action | torque at 1 | at 1 with `residual=True` |
    |---|---|---|---|
    | 0 | ankle: turns the stance leg forward | 11.85 N m | 3.555 N m |
    | 1 | hip: turns the swing leg forward against the stance leg | 7.9 N m | 2.37 N m |

    With `residual=True` the action is added to the torques of the adaptive controller; the sum is cut off at what the
    motors give, 35.55 N m at the ankle and 23.7 N m at the hip.

    ## Observation space

    `Box((12,), float64)`; with `privileged=True` 23 numbers. The bounds are far beyond what a walk comes to. Angles
    are measured from the normal of the ground under the stance foot, positive forward.

    | number | observation | unit |
    |---|---|---|
    | 0, 1 | angle of stance leg, swing leg | rad |
    | 2, 3 | their rates | rad/s |
    | 4 | 1 if the swing foot touched down in the last control period, else 0 | |
    | 5 | time since the last touchdown, or since the start | s |
    | 6, 7 | last touchdown: old stance leg and leg that landed, from the old ground's normal | rad |
    | 8, 9 | last touchdown: new stance leg and new swing leg, from the new ground's normal | rad |
    | 10, 11 | torque that ankle and hip hold | N m |
    | 12 | privileged: slope under the stance foot, positive downhill | rad |
    | 13 to 22 | privileged: height of the ground 0.1, 0.2, ... 1.0 m ahead of the stance foot, over its own | m |

    ## Rewards

    Every step gives `reward_progress + reward_economy`, from 0 to 1. Both stand in `info`.

    | term | value |
    |---|---|
    | `reward_progress` | 0.75 · min(max(v / v₀, 0), 1) |
    | `reward_economy` | 0.25 / (1 + w / w₀) |

    Here v is the hip's speed, averaged over about a step (exponentially, with the gait's period of 0.765 s, from v₀
    on), and v₀ that of the passive gait, 0.494 m/s; w is the absolute work of both motors in this control period, and
    w₀ a tenth of the weight times the way at v₀.

    `info` holds `x_position` (of the hip, m) and `outcome` ("walking", or how the walk ended), too.

    ## Starting state

    The passive gait on 2° just after its touchdown, left foot at x = 0, each rate times a random number from 0.95 to
    1.05.

    ## Episode end

    An episode is *terminated* when the walk ends as in `mjbiped.walk`: the hip comes lower than half a leg over the
    ground, no touchdown comes for 3.2 s, the stance foot slips by 0.1 m, the ground ends, or the physics diverges. It
    is *truncated* after 1000 steps (20 s).

    ## Arguments

    | argument | default | meaning |
    |---|---|---|
    | `residual` | `False` | add actions to the adaptive controller's torques |
    | `privileged` | `False` | observe the ground, too |
    | `terrain` | `{}` | parameters of the ground's preset, such as `{"rise": -0.03}`, or a `mjbiped.Terrain` |
    | `control_period` | `0.02` | time between two actions, s, a multiple of 4 ms |
    | `render_mode` | `None` | `"rgb_array"`: `render` gives a picture |
    | `width`, `height` | `640`, `480` | its size, pixels |

    An environment can be pickled and copied in the middle of an episode; the copy goes on by itself, bitwise the same.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012 (Gymnasium's own kind)

    def __init__(
        self,
        task: str = "walk_level",
        *,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        **settings: Unpack[Settings],
    ) -> None:
        """Make the environment; the class's table describes the arguments.

        Args:
            task: One of `mjbiped.envs.TASKS`.
            render_mode: "rgb_array" if `render` shall give pictures.
            width: Width of pictures, pixels.
            height: Height of pictures, pixels.
            **settings: Settings of the task.

        Raises:
            InputError: A value is outside its domain.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode = {shown(render_mode)}: must be None or 'rgb_array'")
        chosen = task_of(task, settings)
        self.walkers = Walkers(chosen)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / chosen.control_period)}
        self.action_space = action_space()
        self.observation_space = observation_space(chosen)
        self._most = np.array(chosen.limits)
        self._size = PIXELS.check("width", width), PIXELS.check("height", height)
        self._camera: Camera | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begin an episode; the same seed gives the same one. There are no options."""
        super().reset(seed=None if seed is None else SEED.check("seed", seed))
        self.walkers.begin(0, self.np_random)
        return observations(self.walkers)[0], self._info()

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Hold an action for a control period; see the class."""
        walkers = self.walkers
        walkers.act(action, self._most)
        walkers.step()
        reward, over = float(walkers.value(feeling.REWARD)[0]), bool(walkers.value(feeling.OUTCOME)[0])
        return observations(walkers)[0], reward, over, False, self._info()

    def _info(self) -> dict[str, Any]:
        told = {name: float(self.walkers.value(at)[0]) for name, at in TERMS.items()}
        return {**told, "outcome": self.walkers.outcome(0).words}

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the robot, RGB, shape (height, width, 3); None without `render_mode`.

        Raises:
            RenderError: No OpenGL platform works.
        """
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs render_mode='rgb_array', given to gymnasium.make")
            return None
        if self._camera is None:
            self._camera = Camera(*self._size)
        return self._camera.picture(self.walkers.plan(), self.walkers.simulation())

    def walk(self) -> Walk:
        """Return the record of the episode so far, with the measures, figures and videos of any walk.

        Its outcome is "interrupted" while the robot walks, and "time limit" after 20 s.
        """
        return self.walkers.walk()

    def close(self) -> None:
        """Release the renderer, the threads and the simulations."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self.walkers.close()

    def __getstate__(self) -> dict[str, Any]:
        """Return all attributes but the camera."""
        return {**self.__dict__, "_camera": None}
