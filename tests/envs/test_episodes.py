"""Robots that walk episodes: bitwise the walks of `mjbiped.walk`, alone and side by side, copied and resumed."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from episodes import assert_begins_like, begun, random_actions, repeated, walked

import mjbiped
from mjbiped.engines.compiling import VARIABLE
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.envs import TASKS, observation
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.rules.termination import Outcome

NOISE = {"angle_noise": 0.002, "rate_noise": 0.02, "angle_bias": 0.001, "angle_resolution": 1e-4}
"""Of all sensors."""

ROUGH: dict[str, Any] = {"disturbances": {**NOISE, "torque_limit": 30.0, "push_impulse": 1.0, "push_interval": 0.5}}
DRAWN = {"kind": "kneed", "thigh_mass": {"uniform": [4.3, 4.7]}, "sole": 0.2}
MOVING = mjbiped.Terrain.random(seed=5, segment_length=(0.15, 0.25), slope_deg=(-1.0, 1.0), rise=(0.0, 0.0))
"""More than 40 segments: MuJoCo's model is built again within the walk."""


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        *((name, {}) for name in TASKS),
        pytest.param("walk_random", {"robot": {"sole": 0.12}, **ROUGH}, marks=pytest.mark.slow),
        pytest.param("walk_random", {"robot": "kneed"}, marks=pytest.mark.slow),
        pytest.param("walk_random", {"robot": DRAWN, **ROUGH}, marks=pytest.mark.slow),
        pytest.param("walk_random", {"terrain": MOVING, "control_period": 0.008}, marks=pytest.mark.slow),
    ],
)
def test_zero_residual_is_bitwise_the_walk(name: str, settings: dict[str, Any]) -> None:
    task = WalkTask(name, residual=True, time_limit=4.0, **settings)
    walkers = begun(task, seed=3)
    walked(walkers, np.zeros((task.max_steps, len(task.limits))))
    record = walkers.walk()
    assert record.outcome == "time limit"
    # more samples than a simulation has room for at once; the last one is a period before the end at most
    assert record.end[0] == pytest.approx(4.0, abs=1.001 * DEFAULT_SAMPLE_PERIOD)
    assert record.steps >= 3
    assert_begins_like(record, repeated(walkers))


def test_an_ended_episode_has_the_end_of_the_walk() -> None:
    """A passive walk on level ground falls or stalls; the record has its outcome and its last sample."""
    walkers = begun(WalkTask("walk_level"))
    rows = walked(walkers, np.zeros((400, 2)))
    record, other = walkers.walk(), repeated(walkers)
    assert (record.outcome, record.end) == (other.outcome, other.end)
    assert record.outcome != "interrupted"
    assert_begins_like(record, other)
    assert rows[-1, -1] == walkers.outcome(0) != Outcome.WALKING
    ended = int(np.flatnonzero(rows[:, -1])[0])
    np.testing.assert_array_equal(rows[ended + 1 :, :4], np.tile(rows[ended + 1, :4], (len(rows) - ended - 1, 1)))


def test_a_row_of_robots_is_bitwise_robots_alone_with_any_number_of_threads() -> None:
    """Another task's robot and another walk come between."""
    task, other = WalkTask("walk_random", residual=True), WalkTask("walk_stairs", residual=True, control_period=0.012)
    actions = np.random.default_rng(0).uniform(-3.0, 3.0, (80, 5, 2))
    alone = np.array([walked(begun(task, seed), actions[:, seed]) for seed in range(5)])
    beside = walked(begun(other, 5), actions[:, 0])
    for threads in (1, 2, 3):
        row, second = Walkers(task, 5, threads=threads, recorded=False), begun(other, 5)
        for index in range(5):
            row.begin(index, np.random.default_rng(index))
        together, between = [], []
        for each in actions:
            row.act(each)
            row.step()
            together.append(np.column_stack((row.felt, row.columns["reward"], row.columns["outcome"])))
            between.append(walked(second, each[:1]))
        assert np.array(together).swapaxes(0, 1).tobytes() == alone.tobytes()
        assert np.concatenate(between).tobytes() == beside.tobytes()
        row.close()


@pytest.mark.compiled
@pytest.mark.parametrize("robot", ["compass", pytest.param("kneed", marks=pytest.mark.slow)])
def test_plain_python_gives_the_same(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    task = WalkTask("walk_stairs", residual=True, robot=robot, disturbances={"rate_noise": 0.05})
    actions = random_actions(task, 60)
    compiled = walked(begun(task), actions)
    monkeypatch.setattr("mjbiped.control.compiled.compilable_law", lambda _: None)  # methods, called by it
    assert walked(begun(task), actions).tobytes() == compiled.tobytes()
    monkeypatch.setenv(VARIABLE, "never")
    assert walked(begun(task), actions).tobytes() == compiled.tobytes()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
def test_a_copy_goes_on_by_itself_and_a_state_can_be_set_back(copied: Callable[[Walkers], Walkers]) -> None:
    task = WalkTask("walk_random", residual=True)
    actions = random_actions(task, 150)
    walkers = begun(task)
    walked(walkers, actions[:70])
    other, state = copied(walkers), walkers.state()
    assert other.felt.tobytes() == walkers.felt.tobytes()
    after = walked(walkers, actions[70:]).tobytes()
    assert walked(other, actions[70:]).tobytes() == after
    assert_begins_like(walkers.walk(), other.walk())
    walkers.set_state(state)
    assert walked(walkers, actions[70:]).tobytes() == after
    draw = np.random.default_rng(1)
    for odd in (state[:-1], state * np.nan, draw.normal(size=state.shape)):
        with pytest.raises(mjbiped.InputError, match="state: "):
            walkers.set_state(odd)


@pytest.mark.parametrize(
    "drawn", [{}, {"robot": {"leg_mass": {"uniform": [4.0, 6.0]}}}, {"disturbances": {"rate_noise": 0.1}}]
)
def test_another_episode_on_the_same_ground_is_that_of_a_new_robot(drawn: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo's model is made use of again where robot, ground and disturbances are the same."""
    monkeypatch.setenv(VARIABLE, "never")  # no other model for machine code
    task = WalkTask("walk_level", **drawn)
    walkers, fresh, random = Walkers(task), Walkers(task), np.random.default_rng(0)
    walkers.begin(0, random)
    walked(walkers, random_actions(task, 40))
    walkers.begin(0, random)
    fresh.place(0, walkers.walker().episode)
    actions = random_actions(task, 60, seed=8)
    assert walked(walkers, actions).tobytes() == walked(fresh, actions).tobytes()


@pytest.mark.parametrize("residual", [False, True])
def test_actions_and_torques_are_cut_off_at_their_limits(residual: bool) -> None:
    task = WalkTask("walk_level", residual=residual)
    wide, narrow = begun(task), begun(task)
    assert walked(wide, np.full((3, 2), 1e3)).tobytes() == walked(narrow, np.tile(task.limits, (3, 1))).tobytes()
    if not residual:
        np.testing.assert_array_equal(wide.felt[0, observation.observed(2)["torque"]], task.limits)


def test_the_reward_is_what_the_page_says() -> None:
    task = WalkTask("walk_random", residual=True)
    walkers = begun(task)
    x0, work0, target = walkers.columns["x_position"][0], 0.0, task.target_speed * 0.02
    average = target
    for _ in range(50):
        walkers.step()
        x, work = walkers.columns["x_position"][0], walkers.walker().row.ahead[0].state[0].work_absolute
        hip = walkers.walker().run.simulation.data.qpos[0]
        assert x == pytest.approx(hip, abs=1e-4)  # the foot slips and rolls by some µm
        average += 0.02 / task.gait.period * (x - x0 - average)
        progress = min(max(average / target, 0.0), 1.0)
        economy = 1.0 / (1.0 + (work - work0) / (0.1 * 98.1 * target))
        # 1e-12: a few roundings
        assert walkers.columns["reward"][0] == pytest.approx(0.75 * progress + 0.25 * economy, rel=1e-12)
        x0, work0 = x, work


def test_what_is_no_number_ends_the_episode() -> None:
    """MuJoCo warns of it and resets; nothing that is no number comes out."""
    walkers = begun(WalkTask("walk_level"))
    rows = walked(walkers, np.array([[0.0, 0.0], [np.nan, 0.0], [0.0, 0.0]]))
    assert walkers.outcome(0) is Outcome.DIVERGED
    assert np.isfinite(rows).all()
    walkers.begin(0, np.random.default_rng(0))
    assert np.isfinite(walked(walkers, np.zeros((5, 2)))).all()
    assert walkers.outcome(0) is Outcome.WALKING


def test_the_ground_is_seen_where_it_is() -> None:
    walkers = begun(WalkTask("walk_stairs", residual=True, privileged=True))
    walked(walkers, np.zeros((220, 2)))
    seen, terrain = walkers.ground_seen(0), walkers.walker().run.plan.terrain
    foot = walkers.columns["foot_x"][0]
    assert terrain.height(foot) == pytest.approx(-0.02)  # it stands on the first tread down already
    assert seen[0] == terrain.slope(foot)
    heights = terrain.height(foot + np.arange(1, 11) / 10.0) - terrain.height(foot)
    np.testing.assert_allclose(seen[1:], heights, rtol=0, atol=2e-6)  # the foot stands 1 µm deep
    assert np.ptp(seen[1:]) == pytest.approx(0.02)
