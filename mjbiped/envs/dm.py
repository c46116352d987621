"""The tasks as environments of dm_control."""

from __future__ import annotations

import copy
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import dm_env
import mujoco
import numpy as np
from dm_control import _render
from dm_control import mujoco as dm_mujoco
from dm_control.mujoco import wrapper
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from mjbiped.envs import feeling
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import STATE


class Physics(dm_mujoco.Physics):  # type: ignore[misc]  # dm_control has no types
    """The robot on its ground, with the controller in it.

    A `step` is one control period: the physics steps within it are of changing lengths, for they end at touchdowns. An
    episode on other ground has another `model` and `data`; on ground of more than 40 segments they are exchanged
    within an episode, too.
    """

    def __init__(self, walkers: Walkers) -> None:
        """Show a robot that has begun an episode.

        Args:
            walkers: Just this one robot.
        """
        self._walkers = walkers
        super().__init__(self._wrapped())

    def _wrapped(self) -> Any:
        return wrapper.MjData(self._walkers.simulation().data)

    def _show(self) -> None:
        """Let model and data be those of the robot now."""
        if self._walkers.simulation().data is not self.data.ptr:
            self._reload_from_data(self._wrapped())

    def begin(self, random: np.random.Generator) -> None:
        """Begin an episode, whose ground and start are drawn from `random`."""
        self._walkers.begin(0, random)
        self._show()

    def _make_rendering_contexts(self) -> None:
        """Let dm_control draw on a platform that works: without a display it would choose a window system's."""
        platform = ensure_gl()
        for names, renderer in _render._ALL_RENDERERS:
            if platform in names and platform != _render.BACKEND:
                _render.Renderer, _render.BACKEND = renderer(), platform
        super()._make_rendering_contexts()

    # --- what dm_control asks for -------------------------------------------------------------------------------------

    def timestep(self) -> float:
        """Time of a `step`, the control period, s."""
        return self._walkers.task.control_period

    def set_control(self, control: NDArray[np.float64]) -> None:
        """Choose the ankle and hip torque of the next step, N m; what is beyond the action's bounds is cut off."""
        self._walkers.act(control)

    def step(self, nstep: int = 1) -> None:
        """Go on by so many control periods; once the robot has fallen, nothing moves any more."""
        for _ in range(nstep):
            self._walkers.step()
        self._show()

    @contextmanager
    def reset_context(self) -> Iterator[Physics]:
        """In the block an episode is begun with `begin`."""
        yield self
        self.after_reset()

    def reset(self, keyframe_id: int | None = None) -> None:
        """Set the robot back to the start of its episode; there are no keyframes."""
        self._walkers.restart(0)

    def after_reset(self) -> None:
        """Compute what depends on the state, for pictures."""
        self.forward()

    def get_state(self, sig: int | None = None) -> NDArray[np.float64]:
        """All that the future depends on, the controller's memory included; for `sig` see `mujoco.mj_getState`."""
        state: NDArray[np.float64] = self._walkers.state() if sig is None else super().get_state(sig)
        return state

    def set_state(self, physics_state: NDArray[np.float64], sig: int | None = None) -> None:
        """Set the robot back to a state of this episode, see `get_state`.

        Raises:
            InputError: It is none, or `sig` asks for the controller's memory alone, or for what is no finite number.
        """
        if sig is None:
            self._walkers.set_state(physics_state)
            self._show()
            return
        if int(sig) & int(mujoco.mjtState.mjSTATE_USERDATA):
            raise InputError("sig: the controller's memory is set with all the rest alone; leave sig out")
        size = mujoco.mj_stateSize(self.model.ptr, int(sig))
        super().set_state(STATE.array("state", physics_state, (size,)), sig)

    def copy(self, share_model: bool = False) -> Physics:
        """A robot in the same state, which goes on by itself; the model is never shared, for it changes in a walk."""
        return type(self)(copy.deepcopy(self._walkers))

    def __getstate__(self) -> Any:
        """The robots; all else is built of them."""
        return self._walkers

    def __setstate__(self, state: Any) -> None:
        """Show the robots again."""
        self._contexts_lock = threading.Lock()
        self.__init__(state)  # type: ignore[misc]

    def free(self) -> None:
        """Let the model go; nothing may be asked any more."""
        super().free()
        self._walkers.close()

    # --- the robot ----------------------------------------------------------------------------------------------------

    def joint_angles(self) -> NDArray[np.float64]:
        """Stance and swing leg from the normal of the ground under the stance foot, rad."""
        return self._felt("joint_angles")

    def joint_rates(self) -> NDArray[np.float64]:
        """Their rates, rad/s."""
        return self._felt("joint_rates")

    def touchdown(self) -> bool:
        """Whether the swing foot touched down in the last control period."""
        return bool(self._felt("touchdown")[0])

    def time_since_touchdown(self) -> float:
        """Time since the last support transfer, or since the start, s."""
        return float(self._felt("time_since_touchdown")[0])

    def last_touchdown(self) -> NDArray[np.float64]:
        """The last touchdown's posture: angles in the old roles against the old ground, then in the new ones, rad."""
        return self._felt("last_touchdown")

    def torque(self) -> NDArray[np.float64]:
        """Torques that ankle and hip hold, N m."""
        return self._felt("torque")

    def hip_position(self) -> float:
        """Place of the hip, x in m."""
        return float(self._walkers.value(feeling.HIP_X)[0])

    def slope(self) -> float:
        """Slope under the stance foot, rad, positive downhill."""
        return float(self._walkers.value(feeling.SLOPE)[0])

    def ground_heights(self) -> NDArray[np.float64]:
        """Heights of the ground ahead over the stance foot's, m, 0.1 to 1 leg length ahead of it."""
        return self._walkers.ground_seen(0)[1:]

    def outcome(self) -> Outcome:
        """How the episode has ended, or that the robot walks."""
        return self._walkers.outcome(0)

    def ended(self) -> bool:
        """Whether the episode has ended."""
        return bool(self._walkers.value(feeling.OUTCOME)[0])

    def reward_terms(self) -> dict[str, float]:
        """The terms of the last step's reward."""
        terms = {"progress": feeling.PROGRESS, "economy": feeling.ECONOMY}
        return {name: float(self._walkers.value(index)[0]) for name, index in terms.items()}

    def reward(self) -> float:
        """The reward of the last step."""
        return float(self._walkers.value(feeling.REWARD)[0])

    def walk(self) -> Walk:
        """The record of the episode so far, as `mjbiped.walk` would give it."""
        return self._walkers.walk()

    def _felt(self, name: str) -> NDArray[np.float64]:
        return self._walkers.felt[0, feeling.OBSERVED[name]].copy()


class Task(control.Task):  # type: ignore[misc]  # dm_control has no types
    """One of the tasks.

    Attributes:
        settings: What it is.
    """

    def __init__(self, settings: WalkTask, random: int | np.random.RandomState | None = None) -> None:
        """Take the settings.

        Args:
            settings: See `WalkTask`.
            random: Seed of what is drawn for the episodes, or a generator to draw it from; by default it differs from
                time to time.
        """
        self.settings = settings
        if isinstance(random, np.random.RandomState):
            random = int(random.randint(2**31))
        self._random = np.random.default_rng(random)

    @property
    def random(self) -> np.random.Generator:
        """What episodes are drawn from; dm_control's wrappers draw from it, too."""
        return self._random

    def initialize_episode(self, physics: Physics) -> None:
        """Draw ground and start."""
        physics.begin(self._random)

    def before_step(self, action: NDArray[np.float64], physics: Physics) -> None:
        """Hand the action on."""
        physics.set_control(action)

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """Ankle and hip torque, N m."""
        most = np.array(self.settings.limits)
        return specs.BoundedArray((2,), np.float64, -most, most, name="ankle\thip")

    def get_observation(self, physics: Physics) -> OrderedDict[str, NDArray[np.float64]]:
        """What the robot feels, and where the task is privileged, the ground."""
        felt = physics._walkers.felt[0].copy()
        observation = OrderedDict((name, felt[part]) for name, part in feeling.OBSERVED.items())
        if self.settings.privileged:
            seen = physics._walkers.ground_seen(0)
            observation["ground_slope"], observation["ground_heights"] = seen[:1], seen[1:]
        return observation

    def get_reward(self, physics: Physics) -> float:
        """From 0 to 1; docs/environments.md has its terms."""
        return physics.reward()

    def get_termination(self, physics: Physics) -> float | None:
        """0 where the walk has ended, None where it goes on."""
        return 0.0 if physics.ended() else None


def environment(
    settings: WalkTask, random: int | np.random.RandomState | None, options: Mapping[str, Any]
) -> dm_env.Environment:
    """The environment of a task.

    Args:
        settings: The task.
        random: See `Task`.
        options: Of `dm_control.rl.control.Environment`.
    """
    walkers = Walkers(settings)
    walkers.begin(0, np.random.default_rng(0))  # so that there is a model; `reset` begins anew
    physics = Physics(walkers)
    return control.Environment(physics, Task(settings, random), time_limit=settings.time_limit, **options)
