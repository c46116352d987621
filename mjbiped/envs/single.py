"""The tasks as environments of Gymnasium, one robot each."""

from __future__ import annotations

import atexit
import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.envs.observation import bounds
from mjbiped.envs.tasks import WalkTask, planar_task
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError, MjbipedError, RenderError, shown
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.robots.compass import Compass
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import PIXELS, SEED
from mjbiped.utils.mujoco import mujoco

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise MjbipedError("Gymnasium is not installed: pip install 'mjbiped[gym]'") from error

TERMS = "reward_progress", "reward_economy", "x_position"
"""Fields of `mjbiped.envs.observation.Felt` that are entries of `info`."""


def action_space(task: WalkTask) -> Any:
    """Space of actions: torques of the joints, as shares of the greatest."""
    return gymnasium.spaces.Box(-1.0, 1.0, (len(task.limits),), np.float32)


def observation_space(task: WalkTask) -> Any:
    """Space of observations, in a privileged task with those of the ground."""
    low, high = bounds(len(task.limits), task.privileged)
    return gymnasium.spaces.Box(low, high, dtype=np.float64)


class WalkEnv(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """A biped walks on ground that it does not see.

    ## Description

    Two straight legs of 1 m and 5 kg are joined at the hip: the robot of Table I of Pu et al., *Adaptive Passive Biped
    Dynamic Walking on Unknown Uneven Terrain*. It walks in a plane. A motor at the ankle turns the stance leg against
    the ground, one at the hip the legs against each other. The other robot has knees, with a motor at the swing knee.
    It feels its joints and touchdowns, and neither gravity's direction nor the ground. The aim is to walk on, as fast
    as the gait that it begins with, with little work.

    The physics is MuJoCo with the contact events of `mjbiped.walk`: with `residual=True` and zero actions the walk is
    bitwise that of the adaptive controller there. As in `mjbiped.walk` a straight swing leg's foot passes through the
    ground until it is 0.2 m ahead of the stance foot, for legs without knees must scuff.

    | id | ground |
    |---|---|
    | `mjbiped/CompassWalk-v0` | level |
    | `mjbiped/CompassWalkSlopes-v0` | every 1.5 m the slope turns downhill by 0.3° |
    | `mjbiped/CompassWalkStairs-v0` | treads of 1.8 m, steps of 20 mm down |
    | `mjbiped/CompassWalkRandom-v0` | other ground in each episode: slopes of −3° to 3°, steps of −20 to 5 mm |
    | `mjbiped/KneedWalk-v0` | legs with knees, level |
    | `mjbiped/KneedWalkSlopes-v0` | legs with knees, every 1.5 m the slope turns downhill by 0.3° |
    | `mjbiped/KneedWalkStairs-v0` | legs with knees, treads of 1.8 m, steps of 20 mm down |
    | `mjbiped/KneedWalkRandom-v0` | legs with knees, other ground in each episode |

    ## Action space

    `Box(-1, 1, (2,), float32)`, with knees `(3,)`. Each number is a part of the greatest torque that an action can ask
    for; it is held for a control period of 20 ms. Numbers beyond are cut off. The torques are those of the robot of
    Table I; other robots' are in proportion to weight and leg length, with knees half as great again.

    | number | action | torque at 1 | at 1 with `residual=True` |
    |---|---|---|---|
    | 0 | ankle: turns the stance leg forward | 11.85 N m | 3.555 N m |
    | 1 | hip: turns the swing leg forward against the stance leg | 7.9 N m | 2.37 N m |
    | 2 | with knees, swing knee: bends it | 11.85 N m | 3.555 N m |

    With `residual=True` the action is added to the torques of the adaptive controller; the sum is cut off at what the
    motors give, 35.55 N m at the ankle and the knee, and 23.7 N m at the hip.

    ## Observation space

    `Box((12,), float64)`, with knees 18 numbers; with `privileged=True` 11 more. The bounds are far beyond what a walk
    comes to. Angles are measured from the normal of the ground under the stance foot, positive forward.

    The numbers are the fields of `mjbiped.envs.observation.FIELDS`, in their order; docs/environments.md has the table:
    angles of the legs and their rates, whether the swing foot has just touched down, the time since then, the angles at
    that touchdown, the torques that the joints hold, with knees whether the swing knee is locked, and where
    `privileged` slope and heights of the ground.

    Where sensors err by `disturbances`, the angles and rates are those that the controller reads.

    ## Rewards

    Every step gives `reward_progress + reward_economy`, from 0 to 1. Both stand in `info`.

    | term | value |
    |---|---|
    | `reward_progress` | 0.75 · min(max(v / v₀, 0), 1) |
    | `reward_economy` | 0.25 / (1 + w / w₀) |

    Here v is the hip's speed, averaged over about a step (exponentially, with the gait's period, 0.765 s or with knees
    1.007 s, from v₀ on), and v₀ that of the gait, 0.494 m/s either way; w is the absolute work of all motors in this
    control period, and w₀ a tenth of the weight times the way at v₀.

    `info` holds `x_position` (of the hip, m), `outcome` ("walking", or how the walk ended), and the numbers that were
    drawn for the episode, such as `terrain.seed`.

    ## Starting state

    The passive gait on 2°, or with knees a gait of 8 cm clearance on level ground, just after its touchdown, left foot
    at x = 0, the rates of either leg times a random number from 0.95 to 1.05.

    ## Episode end

    An episode is *terminated* when the walk ends as in `mjbiped.walk`: the hip comes lower than half a leg over the
    ground, no touchdown comes for 3.2 s, the stance foot slips by 0.1 m, the ground ends, or the physics diverges. It
    is *truncated* after `time_limit`, with the outcome "time limit".

    ## Arguments

    | argument | default | meaning |
    |---|---|---|
    | `residual` | `False` | add actions to the adaptive controller's torques |
    | `privileged` | `False` | observe the ground, too |
    | `robot` | of the id | a `mjbiped.Compass` or `mjbiped.KneedBiped`, its name, or its parameters |
    | `terrain` | `{}` | parameters of the ground's preset, its name, a `mjbiped.Terrain`, or a `Curriculum` |
    | `disturbances` | `None` | a `mjbiped.Disturbances`, or its parameters |
    | `control_period` | `0.02` | time between two actions, s, a multiple of 4 ms |
    | `time_limit` | `20` | longest episode, s |
    | `render_mode` | `None` | `"rgb_array"`: `render` gives a picture |
    | `width`, `height` | `640`, `480` | its size, pixels |

    Parameters of robot, terrain and disturbances may be distributions, `{"leg_mass": {"uniform": [4.5, 5.5]}}`, from
    which each episode draws.

    An environment can be pickled and copied in the middle of an episode; the copy goes on by itself, bitwise the same.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012 (Gymnasium's own kind)

    def __init__(
        self,
        task: str = "walk_level",
        *,
        kind: str = Compass.kind,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        **settings: object,
    ) -> None:
        """Make the environment; the class's table describes the arguments.

        Args:
            task: One of `mjbiped.envs.TASKS`.
            kind: Name of the robot where the setting `robot` does not give it: "compass" or "kneed".
            render_mode: "rgb_array" if `render` shall give pictures.
            width: Width of pictures, pixels.
            height: Height of pictures, pixels.
            **settings: Settings of the task.

        Raises:
            InputError: A value is outside its domain.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode = {shown(render_mode)}: must be None or 'rgb_array'")
        chosen = planar_task(task, kind, settings)
        self.walkers = Walkers(chosen, scenery=render_mode is not None)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / chosen.control_period)}
        self.action_space = action_space(chosen)
        self.observation_space = observation_space(chosen)
        self._most = np.array(chosen.limits)
        self._camera = Camera(PIXELS.check("width", width), PIXELS.check("height", height))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        """Begin an episode; the same seed gives the same one. There are no options."""
        super().reset(seed=None if seed is None else SEED.check("seed", seed))
        self.walkers.begin(0, self.np_random, anew=seed is not None)
        return self.walkers.observations()[0], self._info(self.walkers.outcome())

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        """Hold an action for a control period; see the class."""
        walkers = self.walkers
        walkers.act(action, self._most)
        walkers.step()
        reward, outcome = walkers.each[0].reward, walkers.outcome()
        truncated = outcome is Outcome.TIME_LIMIT
        over = outcome is not Outcome.WALKING and not truncated
        return walkers.observations()[0], reward, over, truncated, self._info(outcome)

    def _info(self, outcome: Outcome) -> dict[str, object]:
        told = {name: getattr(self.walkers.each[0], name) for name in TERMS}
        return {**told, "outcome": outcome.words, **self.walkers.walker().episode.drawn}

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the robot, RGB, shape (height, width, 3); None without `render_mode`.

        Raises:
            RenderError: No OpenGL platform works.
        """
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs render_mode='rgb_array', given to gymnasium.make")
            return None
        return self._camera.picture(self.walkers.walker().run.simulation)

    def walk(self) -> Walk:
        """Return the record of the episode so far, with the measures, figures and videos of any walk.

        Its outcome is "interrupted" while the robot walks, and "time limit" at the end of the longest episode.
        """
        return self.walkers.walk()

    def close(self) -> None:
        """Release the renderer, the threads and the simulations."""
        self._camera.close()
        self.walkers.close()


class Camera:
    """Draws a robot from a camera that moves with it."""

    def __init__(self, width: int, height: int) -> None:
        """Note the size of pictures, pixels; nothing is built yet."""
        self._size = height, width
        self._model: mujoco.MjModel | None = None
        self._renderer: Any = None

    def picture(self, simulation: Simulation) -> NDArray[np.uint8]:
        """Draw the robot of a simulation with scenery as it stands, RGB, shape (height, width, 3).

        Raises:
            RenderError: No OpenGL platform works.
        """
        if simulation.model is not self._model:
            self._open(simulation.model)
        self._data.qpos[:] = simulation.data.qpos
        mujoco.mj_forward(simulation.model, self._data)
        self._renderer.update_scene(self._data, "track")
        pixels: NDArray[np.uint8] = self._renderer.render()
        return pixels

    def _open(self, model: mujoco.MjModel) -> None:
        """Make a renderer of a model, and data of its own."""
        platform, first = ensure_gl(), self._renderer is None
        self.close()
        self._model, self._data = model, mujoco.MjData(model)
        model.vis.global_.offheight, model.vis.global_.offwidth = self._size
        try:
            self._renderer = mujoco.Renderer(model, *self._size, max_geom=model.ngeom + 100)
        except Exception as error:  # ImportError, RuntimeError, mujoco.FatalError, PyOpenGL's own
            size = f"{self._size[1]} x {self._size[0]}"
            raise RenderError(f"OpenGL platform {platform} cannot draw {size} pixels: {error}") from error
        if first:  # at exit it must go before the OpenGL platform, which its first renderer has registered by now
            atexit.register(_close, weakref.ref(self))

    def close(self) -> None:
        """Release the renderer."""
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = self._model = None

    def __reduce__(self) -> tuple[object, ...]:
        """Return what makes another camera, with a renderer of its own."""
        return Camera, self._size[::-1]


def _close(left: weakref.ref[Camera]) -> None:
    """Close a camera that a program has left open when it ends."""
    camera = left()
    if camera is not None:
        camera.close()
