"""Environment steps per second, beside Gymnasium's Walker2d-v5 and dm_control's walker-walk at the same control period.

Actions are random over the whole of each action space. Episodes restart when they end; restarts are not timed, but in
the rows of an untrained policy, whose robots fall every second or two.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

import mjbiped.envs
from mjbiped.envs.tasks import CONTROL_PERIOD
from mjbiped.envs.vector import WalkVectorEnv
from scripts.benchmarks.timing import Case, Rows, interleaved, side_by_side

STEPS = 1500  # of one environment in a repetition
ROBOTS = 64
VECTOR_STEPS = 60  # of all robots
UNTRAINED_STEPS = 200  # the same, in which each robot falls a few times


def of_gymnasium(name: str, **options: Any) -> Case:
    """Steps of an environment of Gymnasium."""
    env = gymnasium.make(name, disable_env_checker=True, **options)
    assert abs(CONTROL_PERIOD - getattr(env.unwrapped, "dt", CONTROL_PERIOD)) < 1e-12
    space = env.action_space
    assert isinstance(space, gymnasium.spaces.Box)
    actions = np.random.default_rng(0).uniform(space.low, space.high, (STEPS, *space.shape)).astype(np.float32)

    def step(action: Any) -> bool:
        _, _, terminated, truncated, _ = env.step(action)
        return bool(terminated or truncated)

    return stepping(lambda: env.reset(seed=0), step, actions)


def of_dm_control(env: Any) -> Case:
    """Steps of an environment of dm_control."""
    assert abs(CONTROL_PERIOD - env.control_timestep()) < 1e-12
    spec = env.action_spec()
    actions = np.random.default_rng(0).uniform(spec.minimum, spec.maximum, (STEPS, *spec.shape))
    return stepping(env.reset, lambda action: bool(env.step(action).last()), actions)


def stepping(reset: Callable[[], object], step: Callable[[Any], bool], actions: Any) -> Case:
    """Time steps, without the resets."""

    def run() -> float:
        reset()
        taken, started = 0.0, time.thread_time()
        for action in actions:
            if step(action):
                taken += time.thread_time() - started
                reset()
                started = time.thread_time()
        return taken + time.thread_time() - started

    return run


def many(threads: int) -> Case:
    """Steps of many robots, each on ground of its own."""
    env = WalkVectorEnv(ROBOTS, "walk_random", residual=True, threads=threads)
    random = np.random.default_rng(0)
    actions = random.uniform(-1.0, 1.0, (VECTOR_STEPS, ROBOTS, 2)).astype(np.float32)

    def run() -> float:
        env.reset(seed=0)
        started = time.perf_counter()
        for action in actions:
            env.step(action)
        return time.perf_counter() - started

    return run


def untrained(residual: bool) -> Case:
    """Steps of many robots with restarts: standard normal actions, as PPO of stable-baselines3 begins."""
    env = WalkVectorEnv(ROBOTS, "walk_random", residual=residual, threads=1)
    actions = np.random.default_rng(0).normal(size=(UNTRAINED_STEPS, ROBOTS, 2)).clip(-1.0, 1.0).astype(np.float32)

    def run() -> float:
        env.reset(seed=0)
        started = time.process_time()
        for action in actions:
            env.step(action)
        return time.process_time() - started

    return run


def hashing(threads: int) -> Case:
    """Two pieces of work that share nothing: what threads can gain on this machine at the moment."""
    block = bytes(20_000_000)

    def run() -> float:
        return side_by_side(lambda: hashlib.sha256(block).digest(), threads) * (2 // threads)

    return run


def walker_of_dm_control() -> Any:
    """The suite's walker-walk, at our control period instead of 25 ms."""
    from dm_control.rl import control
    from dm_control.suite import walker

    physics = walker.Physics.from_xml_string(*walker.get_model_and_assets())
    task = walker.PlanarWalker(move_speed=1.0, random=0)
    return control.Environment(physics, task, time_limit=25.0, control_timestep=CONTROL_PERIOD)


def over_environments(repeats: int) -> Rows:
    """Time environments one by one, and many robots in threads."""
    tasks = {"residual": True, "random": 0}
    cases: dict[str, tuple[Case, int]] = {
        "Gymnasium: Walker2d-v5": (of_gymnasium("Walker2d-v5", frame_skip=10), STEPS),
        "Gymnasium: mjbiped/CompassWalk-v0": (of_gymnasium("mjbiped/CompassWalk-v0"), STEPS),
        "Gymnasium: mjbiped/CompassWalkRandom-v0, residual": (
            of_gymnasium("mjbiped/CompassWalkRandom-v0", residual=True),
            STEPS,
        ),
        "Gymnasium: mjbiped/KneedWalkRandom-v0, residual": (
            of_gymnasium("mjbiped/KneedWalkRandom-v0", residual=True),
            STEPS,
        ),
        "dm_control: walker-walk": (of_dm_control(walker_of_dm_control()), STEPS),
        "dm_control: walk_level": (of_dm_control(mjbiped.envs.load("walk_level", {"random": 0})), STEPS),
        "dm_control: walk_random, residual": (of_dm_control(mjbiped.envs.load("walk_random", tasks)), STEPS),
        f"{ROBOTS} robots on random ground, 1 thread": (many(1), ROBOTS * VECTOR_STEPS),
        f"{ROBOTS} robots on random ground, 2 threads": (many(2), ROBOTS * VECTOR_STEPS),
        f"{ROBOTS} robots, untrained policy, restarts timed": (untrained(False), ROBOTS * UNTRAINED_STEPS),
        f"{ROBOTS} robots, untrained residual policy, restarts timed": (untrained(True), ROBOTS * UNTRAINED_STEPS),
        "hashing, for comparison: 1 thread": (hashing(1), 2),
        "hashing, for comparison: 2 threads": (hashing(2), 2),
    }
    timings = interleaved(cases, repeats, "environments")
    names = list(cases)
    first = {name: next(other for other in names if other.split()[0] == name.split()[0]) for name in names}
    return [[name, timings[name].rate, timings[name].ratio(timings[first[name]])] for name in names]
