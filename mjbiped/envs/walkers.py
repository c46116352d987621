"""Robots that walk episodes of a task, for the environments of dm_control and of Gymnasium.

Compiled robots run without Python between two actions, and are stepped in threads.
"""

from __future__ import annotations

import math
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjbiped.engines.compiling import compiles
from mjbiped.engines.mujoco import callback
from mjbiped.engines.mujoco.engine import MujocoRun
from mjbiped.engines.mujoco.simulation import BLOCK, WHOLE_STATE
from mjbiped.envs.observation import AHEAD, HIGHEST, Felt, Row, advance_rows, bounds, machine_code
from mjbiped.envs.recipes import Curriculum
from mjbiped.envs.tasks import Episode, WalkTask
from mjbiped.errors import InputError, MjbipedError, shown
from mjbiped.numerics.blocks import dtype_of, packed
from mjbiped.records.record import Walk
from mjbiped.rules.termination import Outcome
from mjbiped.utils.mujoco import mujoco

_AHEAD = np.array(AHEAD)
AFFORDED = 0.1
"""Work over weight and distance (the gait's, at full speed) at which the reward's second term is a half: three times
the adaptive controller's on level ground."""


class Walker(NamedTuple):
    """A robot in its episode.

    Attributes:
        run: Its walk.
        episode: What the episode began with.
        row: What steps it.
        living: What a packed row points to.
    """

    run: MujocoRun
    episode: Episode
    row: Row
    living: object


class Walkers:
    """A row of robots, each on ground of its own.

    Attributes:
        task: Their task.
        each: Their numbers, which `step` overwrites.
        columns: The same as an array with the fields of `Felt`.
        actions: Torques for the next control period, N m, shape (robots, joints); `act` writes them.
        felt: Observations of the robots, shape (robots, numbers), which `step` overwrites; see `observation.observed`.
    """

    def __init__(
        self, task: WalkTask, count: int = 1, threads: int = 1, recorded: bool = True, scenery: bool = False
    ) -> None:
        """Prepare a row without episodes; `begin` sets a robot on the ground.

        Args:
            task: Their task.
            count: Number of robots.
            threads: Number of threads that step robots at the same time.
            recorded: Whether the samples of walks are kept.
            scenery: Whether the ground is drawn in pictures; the walks are the same.
        """
        self.task = task
        self._made = task, count, threads, recorded, scenery
        self._recorded, self._scenery, self._joints = recorded, scenery, len(task.model.joints)
        self.each = (Felt * count)()
        self.columns = np.ctypeslib.as_array(self.each)
        self.actions = self.columns["action"][:, : self._joints]
        self.felt: NDArray[np.float64] = self.columns["observation"][:, : len(bounds(self._joints)[0])]
        self._shapes = (self.actions.shape, *([(self._joints,)] if count == 1 else []))  # of actions
        self._walkers: list[Walker | None] = [None] * count
        self._difficulty = [0.0] * count  # of the ground, where the task has a curriculum
        self._table = np.zeros(count, dtype_of(Row))
        self._address = self._table.ctypes.data
        self._native: Any = None
        parts = max(1, min(threads, count))
        self._parts = list(pairwise(count * part // parts for part in range(parts + 1)))
        self._pool = ThreadPoolExecutor(parts, thread_name_prefix="robots")
        self._compiled, self._stepping = False, 0.0  # time spent on steps, s

    def begin(self, index: int, random: np.random.Generator, *, anew: bool = False) -> None:
        """Begin an episode of a robot.

        Args:
            index: Number of the robot.
            random: Generator that draws the episode.
            anew: Whether a curriculum begins anew.
        """
        ground = self.task.terrain
        if anew:
            self._difficulty[index] = 0.0
        elif isinstance(ground, Curriculum) and self.each[index].tick > self.task.ticks:  # it has walked before
            self._difficulty[index] = ground.after(self._difficulty[index], self.outcome(index))
        self.place(index, self.task.episode(random, self._difficulty[index]))

    def place(self, index: int, episode: Episode) -> None:
        """Set a robot on the ground at the beginning of an episode, which may be the one that it is in."""
        task, before = self.task, self._walkers[index]
        plan = task.plan(episode, recorded=self._recorded)
        if before is None or episode is not before.episode:  # one that begins again: others hold its model and data
            spent = math.inf if len(self.each) > 1 else self._stepping
            self._compiled = self._compiled or compiles(plan, spent)
        same = None
        if before is not None and all(a is b for a, b in zip(before.episode[:3], episode[:3], strict=True)):
            same = before.run.simulation if self._compiled == (before.run.simulation.block is not None) else None
        run = MujocoRun(plan, task.engine, before=same, scenery=self._scenery, compile=self._compiled)
        self._connect(index, run, episode)
        target = task.target_speed * task.control_period
        self.each[index] = Felt(
            ticks=task.ticks,
            last=task.ticks * task.max_steps,
            senses=any(episode.disturbances.sensors[:5]),
            target=target,
            share=min(1.0, task.control_period / task.gait.period),
            afforded=AFFORDED * plan.robot.weight * target,
        )
        self._go(index, index + 1, 0)
        self.each[index].average = target

    def _connect(self, index: int, run: MujocoRun, episode: Episode) -> None:
        """Let the simulation of a run be stepped as that of a robot."""
        simulation, living = run.simulation, None
        model, data, ahead = simulation.model, simulation.data, simulation.ahead()
        felt, sensors = [self.each[index]], [episode.disturbances.sensors]
        row = Row([simulation.constants], [ahead], model, data, felt, sensors, self.task.controller.place)
        if self._compiled:
            block, below = simulation.packed(ahead)
            where = {"model": model._address, "data": data._address, "felt": self.columns[index : index + 1]}
            made, more = packed(row._replace(constants=simulation.block, ahead=block, **where))
            self._table[index], living, self._native = made[0], (block, below, more), simulation.native
        self._walkers[index] = Walker(run, episode, row, living)

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
            shapes, joints = " or ".join(map(str, self._shapes)), ", ".join(self.task.model.joints)
            raise InputError(f"action = {shown(actions)}: expected shape {shapes}: {joints} of each robot") from error

    def step(self) -> None:
        """Simulate a control period of all robots with their actions.

        Raises:
            MjbipedError: A robot has not begun an episode.
        """
        walkers, ticks, began = [self.walker(k) for k in range(len(self.each))], self.task.ticks, time.perf_counter()
        parts = self._parts if self._compiled else [(0, len(walkers))]
        others = [self._pool.submit(self._go, *part, ticks) for part in parts[1:]]
        self._go(*parts[0], ticks)
        for other in others:
            other.result()
        self._stepping += time.perf_counter() - began
        for index, ((run, episode, *_), x) in enumerate(zip(walkers, self.columns["x_position"].tolist(), strict=True)):
            simulation, (low, high) = run.simulation, run.simulation.inside
            if self._recorded and simulation.state.samples > BLOCK // 2:  # room for those of the longest period
                simulation.take(run.recorder)
            if not low < x < high and simulation.move_on():
                self._connect(index, run, episode)

    def _go(self, first: int, last: int, ticks: int) -> None:
        """Step some robots, or only look, in this thread."""
        walkers = [] if self._compiled else [self.walker(index) for index in range(first, last)]
        callback.enter(self._native)
        try:
            if self._compiled:
                machine_code()(self._address, first, last, ticks)
            else:
                advance_rows([walker.row for walker in walkers], 0, last - first, ticks)
        finally:
            callback.leave(self._native)
        for walker in walkers:
            walker.run.simulation.check()

    def walker(self, index: int = 0) -> Walker:
        """A robot in its episode.

        Raises:
            MjbipedError: It has not begun one.
        """
        walker = self._walkers[index]
        if walker is None:
            raise MjbipedError("there is no episode yet; call reset() first")
        return walker

    def outcome(self, index: int = 0) -> Outcome:
        """Outcome of a robot's episode; `Outcome.WALKING` while it lasts."""
        return Outcome(int(self.each[index].outcome))

    def observations(self) -> NDArray[np.float64]:
        """Observations of all robots, in a privileged task with those of the ground."""
        seen = [self.ground_seen(index) for index in range(len(self.each))] if self.task.privileged else []
        return np.column_stack([self.felt, seen]) if seen else self.felt.copy()

    def ground_seen(self, index: int = 0) -> NDArray[np.float64]:
        """Privileged part of an observation.

        The slope under the stance foot (rad, positive downhill), then the ground's heights over that of the stance foot
        (m) at the places `AHEAD`.
        """
        plan, felt = self.walker(index).run.plan, self.each[index]
        heights = plan.terrain.height(felt.foot_x + _AHEAD * plan.robot.leg_length) - felt.foot_z
        return np.append(felt.slope, heights).clip(-HIGHEST, HIGHEST)

    def walk(self, index: int = 0) -> Walk:
        """Return the record of a robot's episode so far.

        Its outcome is "interrupted" while it walks, and "time limit" once it has walked for the longest time.
        """
        run, outcome = self.walker(index).run, self.outcome(index)
        run.outcome = Outcome.INTERRUPTED if outcome is Outcome.WALKING else outcome
        run.simulation.finish(run.recorder)
        return run.record()

    def state(self, index: int = 0) -> NDArray[np.float64]:
        """Return everything that a robot's future depends on, with its controller's memory, for `set_state`."""
        simulation = self.walker(index).run.simulation
        whole = np.empty(mujoco.mj_stateSize(simulation.model, WHOLE_STATE))
        mujoco.mj_getState(simulation.model, simulation.data, whole, WHOLE_STATE)
        state = np.concatenate([whole, self.columns[index : index + 1].view(np.float64)])
        return np.append(state, zlib.crc32(state.tobytes()))

    def set_state(self, state: NDArray[np.float64], index: int = 0) -> None:
        """Set a robot back to a state of the same episode; what is recorded goes on from there.

        Raises:
            InputError: `state` did not return it: it holds the controller's memory and the quantities that end a
                walk, which other numbers would contradict.
        """
        run, episode, *_ = self.walker(index)
        simulation, felt = run.simulation, self.columns[index : index + 1].view(np.float64)
        state, size = np.asarray(state, dtype=np.float64), mujoco.mj_stateSize(simulation.model, WHOLE_STATE)
        if state.shape != (size + len(felt) + 1,):
            raise InputError(f"state: expected shape {(size + len(felt) + 1,)}, got {state.shape}")
        if state[-1] != zlib.crc32(state[:-1].tobytes()):
            raise InputError("state: it is none that was got from an episode; give one as it was got, unchanged")
        simulation.data.warning.number[:] = 0
        mujoco.mj_setState(simulation.model, simulation.data, state[:size], WHOLE_STATE)
        if simulation.move_on():
            self._connect(index, run, episode)
        felt[:] = state[size:-1]

    def close(self) -> None:
        """End the threads, and release the simulations."""
        self._pool.shutdown()
        self._walkers = [None] * len(self._walkers)

    def __reduce__(self) -> tuple[object, ...]:
        """Return what builds the robots again, each in its state."""
        episodes = {}
        for index, walker in enumerate(self._walkers):
            if walker is not None:
                walker.run.simulation.take(walker.run.recorder)
                episodes[index] = walker.episode, self.state(index), walker.run.recorder
        return type(self), self._made, (self._difficulty, episodes)

    def __setstate__(self, kept: tuple[list[float], dict[int, Any]]) -> None:
        """Set the robots into their states."""
        self._difficulty, episodes = kept
        for index, (episode, state, recorder) in episodes.items():
            self.place(index, episode)
            self.set_state(state, index)
            self.walker(index).run.recorder = recorder
