"""The tasks as environments of dm_control."""

from __future__ import annotations

import copy
import time
import warnings
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from mjbiped.envs.observation import observed
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.rendering.gl import ensure_gl
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import STATE
from mjbiped.utils.mujoco import mujoco

try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's, where there is no display
        from dm_control import _render
        from dm_control import mujoco as dm_mujoco
        from dm_control.mujoco import wrapper
        from dm_control.rl import control
        from dm_env import specs
except ModuleNotFoundError as error:
    raise MjbipedError(
        f"mjbiped.envs.load needs dm_control, and {error.name} is not installed: pip install dm-control. Where its "
        "labmaze cannot be installed (Python 3.13), pip install --no-deps dm-control dm-env, and dm-tree absl-py "
        "glfw lxml pyopengl pyparsing, are enough. The environments of Gymnasium need none of it: "
        "pip install 'mjbiped[gym]'"
    ) from error


class Physics(dm_mujoco.Physics):  # type: ignore[misc]  # dm_control has no types
    """The physics of an episode: the robot, its ground, and the controller in it.

    A `step` is one control period: the physics steps within it vary in length, because they end at touchdowns. An
    episode on other ground has another `model` and `data`; on ground of more than 40 segments they are also exchanged
    within an episode.
    """

    def __init__(self, walkers: Walkers) -> None:
        """Show a robot that has begun an episode.

        Args:
            walkers: A row of one robot.
        """
        self._walkers = walkers
        super().__init__(self._wrapped())

    def _wrapped(self) -> object:
        return wrapper.MjData(self._walkers.walker().run.simulation.data)

    def _show(self) -> None:
        """Take over the model and data that the robot has now."""
        if self._walkers.walker().run.simulation.data is not self.data.ptr:
            self._reload_from_data(self._wrapped())

    def begin(self, random: np.random.Generator) -> None:
        """Begin an episode, which is drawn from `random`."""
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
        """Choose the torques of the next step, N m, ankle first, clipped to the action's bounds."""
        self._walkers.act(control)

    def step(self, nstep: int = 1) -> None:
        """Simulate `nstep` control periods; after a fall nothing moves any more."""
        timer, began = self.data.timer[mujoco.mjtTimer.mjTIMER_STEP], time.perf_counter()
        for _ in range(nstep):
            self._walkers.step()
        timer.number += nstep  # MuJoCo counts its own steps alone
        timer.duration += time.perf_counter() - began
        self._show()

    @contextmanager
    def reset_context(self) -> Iterator[Physics]:
        """Enclose the beginning of an episode, which `begin` draws."""
        yield self
        self.after_reset()

    def reset(self, keyframe_id: int | None = None) -> None:
        """Set the robot back to the start of its episode; there are no keyframes."""
        self._walkers.place(0, self._walkers.walker().episode)

    def after_reset(self) -> None:
        """Compute the quantities that pictures need from the state."""
        self.forward()

    def get_state(self, sig: int | None = None) -> NDArray[np.float64]:
        """Return the whole state with the controller's memory, or the parts `sig` of `mujoco.mj_getState`."""
        state: NDArray[np.float64] = self._walkers.state() if sig is None else super().get_state(sig)
        return state

    def set_state(self, physics_state: NDArray[np.float64], sig: int | None = None) -> None:
        """Set the robot back to a state of this episode that `get_state` returned.

        Raises:
            InputError: It is no such state, `sig` asks for the controller's memory alone, or a number is not finite.
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
        """Return an independent robot in the same state; the model, which changes in a walk, is never shared."""
        return copy.deepcopy(self)

    def __reduce__(self) -> tuple[object, ...]:
        """Return the robots, from which everything else is built."""
        return type(self), (self._walkers,)

    def free(self) -> None:
        """Release the model; the physics cannot be used any more."""
        super().free()
        self._walkers.close()

    # --- the robot ----------------------------------------------------------------------------------------------------

    def joint_angles(self) -> NDArray[np.float64]:
        """Angles of stance leg, swing leg (thigh, shank) from the normal of the ground under the stance foot, rad."""
        return self._felt("joint_angles")

    def joint_rates(self) -> NDArray[np.float64]:
        """Rates of these angles, rad/s."""
        return self._felt("joint_rates")

    def touchdown(self) -> bool:
        """Whether the swing foot touched down in the last control period."""
        return bool(self._felt("touchdown")[0])

    def time_since_touchdown(self) -> float:
        """Time since the last support transfer, or since the start, s."""
        return float(self._felt("time_since_touchdown")[0])

    def last_touchdown(self) -> NDArray[np.float64]:
        """Angles at the last touchdown, rad: in the old roles from the old ground's normal, then in the new ones."""
        return self._felt("last_touchdown")

    def torque(self) -> NDArray[np.float64]:
        """Torques that the joints hold, N m."""
        return self._felt("torque")

    def knee_locked(self) -> bool:
        """Whether the swing knee has struck its stop and is locked; straight legs count as never locked."""
        return "knee" in self._walkers.task.model.joints and bool(self._felt("knee_locked")[0])

    def hip_position(self) -> float:
        """Place of the hip, x in m."""
        return float(self._walkers.each[0].x_position)

    def slope(self) -> float:
        """Slope under the stance foot, rad, positive downhill."""
        return float(self._walkers.each[0].slope)

    def ground_heights(self) -> NDArray[np.float64]:
        """Heights of the ground 0.1 to 1 leg length ahead of the stance foot, above the stance foot, m."""
        return self._walkers.ground_seen()[1:]

    def drawn(self) -> dict[str, float]:
        """Numbers that were drawn for the episode, by names such as "robot.leg_mass"."""
        return dict(self._walkers.walker().episode.drawn)

    def outcome(self) -> Outcome:
        """Outcome of the episode; `Outcome.WALKING` while it lasts."""
        return self._walkers.outcome()

    def ended(self) -> bool:
        """Whether the episode has ended."""
        return self.outcome() not in (Outcome.WALKING, Outcome.TIME_LIMIT)

    def reward_terms(self) -> dict[str, float]:
        """The terms of the last step's reward."""
        return {name: getattr(self._walkers.each[0], f"reward_{name}") for name in ("progress", "economy")}

    def reward(self) -> float:
        """The reward of the last step."""
        return float(self._walkers.each[0].reward)

    def walk(self) -> Walk:
        """The record of the episode so far, as `mjbiped.walk` would give it."""
        return self._walkers.walk()

    def _felt(self, name: str) -> NDArray[np.float64]:
        return self._walkers.felt[0, observed(len(self._walkers.task.model.joints))[name]].copy()


class Task(control.Task):  # type: ignore[misc]  # dm_control has no types
    """A task of dm_control.

    Attributes:
        settings: Settings of the task.
    """

    def __init__(self, settings: WalkTask, random: int | np.random.RandomState | None = None) -> None:
        """Note the settings, and seed the generator.

        Args:
            settings: Settings of the task.
            random: Seed of the episodes, or a generator that draws it; by default each task has another one.
        """
        self.settings = settings
        if isinstance(random, np.random.RandomState):
            random = int(random.randint(2**31))
        self._random = np.random.default_rng(random)
        self._parts = observed(len(settings.model.joints), settings.privileged)

    @property
    def random(self) -> np.random.Generator:
        """Generator of the episodes, from which dm_control's wrappers draw too."""
        return self._random

    def initialize_episode(self, physics: Physics) -> None:
        """Draw the episode."""
        physics.begin(self._random)

    def before_step(self, action: NDArray[np.float64], physics: Physics) -> None:
        """Set the torques of the action."""
        physics.set_control(action)

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """Bounds of an action: torques of the joints, N m."""
        most = np.array(self.settings.limits)
        return specs.BoundedArray(most.shape, np.float64, -most, most, name="\t".join(self.settings.model.joints))

    def get_observation(self, physics: Physics) -> OrderedDict[str, NDArray[np.float64]]:
        """Observe what the robot feels, and in a privileged task the ground."""
        felt = physics._walkers.observations()[0]
        return OrderedDict((name, felt[part]) for name, part in self._parts.items())

    def get_reward(self, physics: Physics) -> float:
        """Reward of the last step, from 0 to 1; docs/environments.md describes its terms."""
        return physics.reward()

    def get_termination(self, physics: Physics) -> float | None:
        """Discount: 0 if the walk has ended, None while it goes on."""
        return 0.0 if physics.ended() else None
