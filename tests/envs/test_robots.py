"""Environments of robots with knees, soles and disturbances: bitwise the walks of `mjbiped.walk`, and what is felt."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from episodes import assert_begins_like, begun, random_actions, repeated, walked
from gymnasium.vector import SyncVectorEnv

import mjbiped
from controllers import AdaptiveController, KneedController
from mjbiped.envs import observation
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.vector import WalkVectorEnv

NOISE = {"angle_noise": 0.002, "rate_noise": 0.02, "angle_bias": 0.001, "angle_resolution": 1e-4}
"""Of all sensors."""

ROBOTS: dict[str, Any] = {
    "knees": "kneed",
    "sole": {"sole": 0.12},
    "drawn": {"kind": "kneed", "thigh_mass": {"uniform": [4.3, 4.7]}, "sole": 0.2},
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "disturbances", [None, {**NOISE, "torque_limit": 30.0, "push_impulse": 1.0, "push_interval": 0.5}]
)
@pytest.mark.parametrize("robot", ["knees", "sole", pytest.param("drawn", marks=pytest.mark.slow)])  # a search
def test_zero_residual_is_bitwise_the_walk(robot: str, disturbances: Any) -> None:
    task = WalkTask("walk_random", residual=True, robot=ROBOTS[robot], disturbances=disturbances, time_limit=2.0)
    walkers = begun(task, seed=3)
    walked(walkers, np.zeros((100, len(task.limits))))
    record = walkers.walk()
    assert record.outcome == "time limit"
    assert record.steps >= 1
    assert_begins_like(record, repeated(walkers))


@pytest.mark.parametrize("robot", ["compass", "kneed"])
def test_what_is_felt_is_what_the_sensors_show_the_controller(robot: str) -> None:
    """The arguments of a law in plain Python, at ticks and at touchdowns, are the observations before them."""
    task = WalkTask("walk_stairs", residual=True, robot=robot, disturbances=NOISE)
    told: list[tuple[float, ...]] = []
    base = task.controller.inner
    assert isinstance(base, AdaptiveController | KneedController)
    last = [0.0] * (2 * len(task.limits))

    class Noting(type(base)):  # type: ignore[misc]  # of either class
        def start(self, memory, q, dq):  # type: ignore[no-untyped-def]
            told.clear()  # the law has been tried
            last[:] = [0.0] * len(last)
            super().start(memory, q, dq)

        def on_touchdown(self, memory, q_before, q, dq):  # type: ignore[no-untyped-def]
            last[:] = *q_before, *q
            super().on_touchdown(memory, q_before, q, dq)

        def torque(self, memory, t, q, dq):  # type: ignore[no-untyped-def]
            told.append((*q, *dq, t, *last))
            return super().torque(memory, t, q, dq)

    noting = Noting(base.robot, base.gait)
    walkers = begun(task)
    parts = observation.observed(len(task.limits))
    names = ("joint_angles", "joint_rates", "time_since_touchdown", "last_touchdown")
    felt = [np.concatenate([walkers.felt[0, parts[name]] for name in names])]
    for _ in range(80):
        walkers.step()
        felt.append(np.concatenate([walkers.felt[0, parts[name]] for name in names]))
    episode = walkers.walker().episode
    mjbiped.walk(
        noting,
        episode.terrain,
        engine=task.engine,
        initial=episode.start,
        robot=episode.robot,
        disturbances=episode.disturbances,
        steps=4,
        sample_period=None,
    )
    ticks = np.array(told[:: task.ticks])
    count = min(len(ticks), len(felt))
    assert count > 60
    np.testing.assert_array_equal(ticks[:count], np.array(felt[:count]))
    assert np.array(felt)[-1, -1] != 0.0  # there was a touchdown
    quiet = begun(WalkTask("walk_stairs", residual=True, robot=robot))
    assert (quiet.felt[0, parts["joint_angles"]] != felt[0][: len(task.limits)]).all()


@pytest.mark.slow
def test_python_callbacks_give_the_same_with_knees(monkeypatch: pytest.MonkeyPatch) -> None:
    task = WalkTask("walk_random", robot="kneed", disturbances={"rate_noise": 0.05})
    actions = random_actions(task, 30)
    compiled = walked(begun(task), actions)
    monkeypatch.setattr("mjbiped.control.compiled.compilable_law", lambda _: None)
    assert walked(begun(task), actions).tobytes() == compiled.tobytes()


def test_a_locked_knee_is_felt() -> None:
    task = WalkTask("walk_level", residual=True, robot="kneed")
    walkers = begun(task)
    locked, flexion = [], []
    for _ in range(120):
        walkers.step()
        locked.append(walkers.felt[0, -1])
        flexion.append(walkers.felt[0, 2] - walkers.felt[0, 1])
    assert set(locked) == {0.0, 1.0}
    assert np.array(flexion)[np.array(locked) == 1.0] == pytest.approx(0.0, abs=1e-3)  # the lock is soft
    assert np.max(flexion) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_many_robots_draw_as_alone(threads: int) -> None:
    options: dict[str, Any] = {
        "robot": ROBOTS["drawn"],
        "disturbances": {**NOISE, "friction": {"uniform": [0.5, 1.0]}},
        "time_limit": 0.3,
    }
    many = gymnasium.make_vec("mjbiped/KneedWalkRandom-v0", num_envs=3, threads=threads, **options)
    row = SyncVectorEnv([lambda: gymnasium.make("mjbiped/KneedWalkRandom-v0", **options) for _ in range(3)])
    assert isinstance(many.unwrapped, WalkVectorEnv)
    mine: Any = many.reset(seed=1)
    others: Any = row.reset(seed=1)
    random, masses = np.random.default_rng(0), set()
    for _ in range(35):
        np.testing.assert_array_equal(mine[0], others[0])
        for name in ("robot.thigh_mass", "disturbances.friction", "terrain.seed", "outcome"):
            np.testing.assert_array_equal(mine[-1][name], others[-1][name])
        masses.update(mine[-1]["robot.thigh_mass"].tolist())
        actions = random.uniform(-1.0, 1.0, (3, 3)).astype(np.float32)
        mine, others = many.step(actions), row.step(actions)
    assert len(masses) == 9  # three episodes of three robots
    many.close()
