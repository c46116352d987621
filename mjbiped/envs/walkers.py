"""Robots that walk episodes of a task, for the environments of dm_control and of Gymnasium."""

from __future__ import annotations

import math
import time
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.engines.compiling import compiles
from mjbiped.engines.mujoco.run import MujocoRun
from mjbiped.engines.mujoco.simulation import BLOCK, WHOLE_STATE, Simulation
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan
from mjbiped.envs import feeling
from mjbiped.envs.tasks import AHEAD, Episode, WalkTask
from mjbiped.envs.ticks import Ticks
from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.records.record import Walk
from mjbiped.rules.termination import Outcome
from mjbiped.utils.mujoco import mujoco

SEEN = 1 + len(AHEAD)
"""Numbers of the privileged part of an observation."""
HIGHEST = 100.0
"""Bound to which heights of observed ground are clipped, m."""
_AHEAD = np.array(AHEAD)
_NO_EPISODE = "there is no episode yet; call reset() first"
AFFORDED = 0.1
"""Work over weight and distance (the gait's, at full speed) at which the reward's second term is a half: three times
the adaptive controller's on level ground."""


def _alike(first: Episode, second: Episode) -> bool:
    """Whether two episodes are those of the same objects, so that their simulation can be used again."""
    return all(getattr(first, name) is getattr(second, name) for name in ("robot", "terrain", "disturbances"))


def _checksum(numbers: NDArray[np.float64]) -> float:
    """Checksum that tells a robot's state from other numbers."""
    return float(zlib.crc32(np.ascontiguousarray(numbers).tobytes()))


class Walkers:
    """A row of robots, each on ground of its own.

    Attributes:
        task: Their task.
        joints: Number of joints with motors.
        actions: Torques for the next control period, N m, shape (robots, joints); `act` writes them.
    """

    def __init__(self, task: WalkTask, count: int = 1, *, threads: int = 1, recorded: bool = True) -> None:
        """Prepare a row without episodes; `begin` sets a robot on the ground.

        Args:
            task: Their task.
            count: Number of robots.
            threads: Number of threads that step robots at the same time.
            recorded: Whether the samples of walks are kept.
        """
        self.task = task
        self._recorded, self._threads = recorded, threads
        self.joints = joints = len(task.model.joints)
        self._ticks = Ticks(count, feeling.sizes_of(joints), threads=threads, ticks=task.ticks)
        self.actions = self._ticks.inputs
        self._out = self._ticks.out
        self._shapes = ((count, joints), *([(joints,)] if count == 1 else []))  # of actions
        self._runs: list[MujocoRun | None] = [None] * count
        self._episodes: list[Episode | None] = [None] * count
        self._inside, self._bounded = np.tile((-math.inf, math.inf), (count, 1)), False
        # what is recorded waits in a simulation's own rows until it is taken
        samples = math.ceil(task.control_period / DEFAULT_SAMPLE_PERIOD) + 1
        self._taken_every = max(1, BLOCK // samples - 1)
        self._since_taken = 0
        self._compiled, self._interpreting = False, 0.0  # time spent on interpreting, s

    def begin(self, index: int, random: np.random.Generator) -> None:
        """Begin an episode of a robot.

        Args:
            index: Number of the robot.
            random: Generator that draws the episode.
        """
        self._place(index, self.task.episode(random))

    def _place(self, index: int, episode: Episode) -> None:
        task = self.task
        plan = task.plan(episode, recorded=self._recorded)
        before, old = self._runs[index], self._episodes[index]
        if episode is not old:  # one that begins again goes on as before: others hold its model and data
            spent = math.inf if len(self._runs) > 1 else self._interpreting
            self._compiled = self._compiled or compiles(plan, spent)
        same = before.simulation if before is not None and old is not None and _alike(old, episode) else None
        if same is not None and same.compiled != self._compiled:
            same = None
        run = MujocoRun(plan, task.engine, before=same, compile=self._compiled)
        self._runs[index], self._episodes[index] = run, episode
        self._ticks.put(index, run.simulation, task.controller.place)
        self._note_inside(index)
        kept, target = self._ticks.kept[index], task.target_speed * task.control_period
        kept[feeling.TARGET] = target
        kept[feeling.AFFORDED] = AFFORDED * plan.robot.weight * target
        kept[feeling.SHARE] = min(1.0, task.control_period / task.gait.period)
        kept[feeling.TICKS] = task.ticks
        feeling.sense_by(episode.disturbances.sensors, kept)
        kept[feeling.LAST_WORK] = kept[feeling.LAST_COUNT] = kept[feeling.TICK_NUMBER] = 0.0
        self.actions[index] = 0.0
        self._ticks.look(index)
        kept[feeling.AVERAGE] = target

    def restart(self, index: int) -> None:
        """Begin the episode of a robot again, on the same ground and from the same state."""
        self._place(index, self.episode(index))

    def act(self, actions: ArrayLike, scale: float | NDArray[np.float64] = 1.0) -> None:
        """Choose the actions of the next control period.

        Args:
            actions: Torques of the joints; a row for each of several robots.
            scale: Torque that 1 stands for, N m.

        Raises:
            InputError: The actions have another shape, or are no numbers.
        """
        try:
            if np.shape(actions) not in self._shapes:
                raise ValueError("another shape")
            np.multiply(actions, scale, out=self.actions)
        except (TypeError, ValueError) as error:  # put into words here: this is called some 25 000 times per second
            wanted = f"shape {self.actions.shape}, {self.named_joints} of each robot"
            if len(self.actions) == 1:
                wanted = f"{('two', 'three')[self.joints - 2]} numbers, of {self.named_joints}"
            raise InputError(f"action = {shown(actions)}: expected {wanted}") from error

    def step(self) -> None:
        """Simulate a control period of all robots with their actions.

        Raises:
            MjbipedError: A robot has not begun an episode.
        """
        if None in self._runs:
            raise MjbipedError(_NO_EPISODE)
        ticks, out, began = self._ticks, self._out, time.perf_counter()
        ticks.advance()
        if not self._compiled:
            self._interpreting += time.perf_counter() - began
        self._since_taken += 1
        if self._recorded and self._since_taken >= self._taken_every:
            self._since_taken = 0
            for index in range(len(out)):
                self._take(index)
        if self._bounded:
            x, (low, high) = out[:, feeling.HIP_X], self._inside.T
            for index in np.flatnonzero((x <= low) | (x >= high)).tolist():
                if ticks.move_on(index):
                    self._note_inside(index)

    def _note_inside(self, index: int) -> None:
        """Note the places of a robot's hip between which its present ground suffices."""
        self._inside[index] = self.simulation(index).inside
        self._bounded = bool(np.isfinite(self._inside).any())

    def _run(self, index: int) -> MujocoRun:
        run = self._runs[index]
        if run is None:
            raise MjbipedError(_NO_EPISODE)
        return run

    def _take(self, index: int) -> None:
        """Move the recorded samples of a robot's walk to its recorder."""
        run = self._run(index)
        run.simulation.take(run.recorder)

    @property
    def named_joints(self) -> str:
        """The joints in words: "ankle and hip"."""
        *first, last = self.task.model.joints
        return f"{', '.join(first)} and {last}"

    @property
    def felt(self) -> NDArray[np.float64]:
        """Observations of the robots, shape (robots, numbers), which `step` overwrites; see `feeling.observed`."""
        return self._out[:, feeling.FELT :]

    def value(self, which: int) -> NDArray[np.float64]:
        """One number of all robots by its index in `feeling`, which `step` overwrites."""
        return self._out[:, which]

    def told(self) -> NDArray[np.float64]:
        """Copy all numbers: a row for each index in `feeling`, a column for each robot."""
        return self._out.T.copy()

    def outcome(self, index: int) -> Outcome:
        """Outcome of a robot's episode; `Outcome.WALKING` while it lasts."""
        outcome = Outcome(int(self._out[index, feeling.OUTCOME]))
        return Outcome.TIME_LIMIT if outcome is Outcome.WALKING and self._is_late(index) else outcome

    def _is_late(self, index: int) -> bool:
        """Whether a robot has walked for the longest time of an episode."""
        late: bool = self.simulation(index).data.time > self.task.time_limit - 0.5 * self.task.control_period
        return late

    def ground_seen(self, index: int) -> NDArray[np.float64]:
        """Privileged part of an observation, shape (`SEEN`,).

        The slope under the stance foot (rad, positive downhill), then the ground's heights over that of the stance foot
        (m) at the places `AHEAD`.
        """
        plan, out = self.plan(index), self._out[index]
        places = out[feeling.FOOT_X] + _AHEAD * plan.robot.leg_length
        heights = plan.terrain.height(places) - self._ticks.now(index).foot_z
        return np.append(out[feeling.SLOPE], heights).clip(-HIGHEST, HIGHEST)

    def episode(self, index: int = 0) -> Episode:
        """What a robot's episode began with."""
        episode = self._episodes[index]
        if episode is None:
            raise MjbipedError(_NO_EPISODE)
        return episode

    def plan(self, index: int = 0) -> Plan:
        """Plan of a robot's episode."""
        return self._run(index).plan

    def simulation(self, index: int = 0) -> Simulation:
        """Simulation of a robot's episode; its model changes on long grounds."""
        return self._run(index).simulation

    def walk(self, index: int = 0) -> Walk:
        """Return the record of a robot's episode so far.

        Its outcome is "interrupted" while it walks, and "time limit" once it has walked for the longest time.
        """
        run = self._run(index)
        outcome = run.simulation.outcome
        lasting = Outcome.TIME_LIMIT if self._is_late(index) else Outcome.INTERRUPTED
        run.outcome = lasting if outcome is Outcome.WALKING else outcome
        run.simulation.finish(run.recorder)
        return run.record()

    def state(self, index: int = 0) -> NDArray[np.float64]:
        """Return everything that a robot's future depends on, with its controller's memory, for `set_state`."""
        simulation, ticks = self.simulation(index), self._ticks
        whole = np.empty(mujoco.mj_stateSize(simulation.model, WHOLE_STATE))
        mujoco.mj_getState(simulation.model, simulation.data, whole, WHOLE_STATE)
        numbers = np.concatenate([whole, ticks.kept[index], ticks.out[index]])
        return np.append(numbers, _checksum(numbers))

    def set_state(self, state: NDArray[np.float64], index: int = 0) -> None:
        """Set a robot back to a state of the same episode; what is recorded goes on from there.

        Raises:
            InputError: `state` did not return it: it holds the controller's memory and the quantities that end a
                walk, which other numbers would contradict.
        """
        simulation, ticks = self.simulation(index), self._ticks
        size = mujoco.mj_stateSize(simulation.model, WHOLE_STATE)
        ends = np.cumsum([size, ticks.kept.shape[1], ticks.out.shape[1]]).tolist()
        state = np.asarray(state, dtype=np.float64)
        if state.shape != (ends[-1] + 1,):
            raise InputError(f"state: expected shape {(ends[-1] + 1,)}, got {state.shape}")
        if state[-1] != _checksum(state[:-1]):
            raise InputError("state: it is none that was got from an episode; give one as it was got, unchanged")
        simulation.data.warning.number[:] = 0
        whole, ticks_kept, ticks_out, _ = np.split(state, ends)
        mujoco.mj_setState(simulation.model, simulation.data, whole, WHOLE_STATE)
        ticks.move_on(index)
        self._note_inside(index)
        ticks.look(index)
        ticks.kept[index], ticks.out[index] = ticks_kept, ticks_out

    def close(self) -> None:
        """End the threads, and release the simulations."""
        self._ticks.close()
        self._runs, self._episodes = [None] * len(self._runs), [None] * len(self._runs)

    def __getstate__(self) -> dict[str, Any]:
        """Return settings and episodes, from which `__setstate__` builds the robots again."""
        episodes: dict[int, Any] = {}
        for index, run in enumerate(self._runs):
            if run is not None:
                self._take(index)
                episodes[index] = self.episode(index), self.state(index), run.recorder
        made = self.task, len(self._runs), self._threads, self._recorded
        return {"made": made, "episodes": episodes}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Build the robots again, each in its state."""
        task, count, threads, recorded = state["made"]
        self.__init__(task, count, threads=threads, recorded=recorded)  # type: ignore[misc]
        for index, (episode, whole, recorder) in state["episodes"].items():
            self._place(index, episode)
            self.set_state(whole, index)
            self._run(index).recorder = recorder
