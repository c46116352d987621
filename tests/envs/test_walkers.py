"""Robots that walk episodes: bitwise the walks of `mjbiped.walk`, alone and side by side, copied and resumed."""

import copy
import itertools
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from episodes import assert_begins_like, begun, random_actions, repeated, walked
from numpy.typing import NDArray

import mjbiped
from controllers import AdaptiveController
from mjbiped.engines.compiling import VARIABLE
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.envs import TASKS, observation
from mjbiped.envs.tasks import WalkTask
from mjbiped.envs.walkers import Walkers
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.rules.termination import Outcome


@pytest.mark.parametrize("name", TASKS)
def test_zero_residual_is_bitwise_the_walk(name: str) -> None:
    task = WalkTask(name, residual=True, time_limit=4.0)
    walkers = begun(task, seed=3)
    walked(walkers, np.zeros((200, 2)))
    record = walkers.walk()
    assert record.outcome == "time limit"
    # more samples than a simulation has room for at once; the last one is a period before the end at most
    assert record.end[0] == pytest.approx(4.0, abs=1.001 * DEFAULT_SAMPLE_PERIOD)
    assert record.steps >= 4
    assert_begins_like(record, repeated(walkers))


@pytest.mark.slow
def test_the_walk_of_another_control_period_likewise_and_on_moving_ground() -> None:
    """A ground of more than 40 segments is built again meanwhile; 8 ms are two physics steps."""
    ground = mjbiped.Terrain.random(seed=5, segment_length=(0.15, 0.25), slope_deg=(-1.0, 1.0), rise=(0.0, 0.0))
    task = WalkTask("walk_random", residual=True, terrain=ground, control_period=0.008)
    walkers = begun(task)
    models = set()
    for _ in range(1500):
        walkers.step()
        models.add(id(walkers.walker().run.simulation.model))
    record = walkers.walk()
    assert len(models) > 1
    assert_begins_like(record, repeated(walkers))


def test_an_ended_episode_has_the_end_of_the_walk() -> None:
    """A passive walk on level ground falls or stalls; the record has its outcome and its last sample."""
    task = WalkTask("walk_level")
    walkers = begun(task)
    rows = walked(walkers, np.zeros((400, 2)))
    record, other = walkers.walk(), repeated(walkers)
    assert record.outcome == other.outcome
    assert record.outcome != "interrupted"
    assert record.end == other.end
    assert_begins_like(record, other)
    assert rows[-1, -1] == walkers.outcome(0) != Outcome.WALKING
    ended = int(np.flatnonzero(rows[:, -1])[0])
    np.testing.assert_array_equal(rows[ended + 1 :, :4], np.tile(rows[ended + 1, :4], (len(rows) - ended - 1, 1)))


def test_what_is_felt_is_what_the_controller_is_told() -> None:
    """The law's arguments at each tick, noted by a controller in plain Python, are the observation before it."""
    task = WalkTask("walk_slopes", residual=True)
    told: list[tuple[float, ...]] = []

    class Noting(AdaptiveController):
        def torque(self, memory, t, q, dq):  # type: ignore[no-untyped-def]
            told.append((*q, *dq, t))
            return super().torque(memory, t, q, dq)

    base = task.controller.inner
    assert isinstance(base, AdaptiveController)
    noting = Noting(base.robot, base.gait)
    walkers = begun(task)
    felt = [walkers.felt[0, [0, 1, 2, 3, 5]], *walked(walkers, np.zeros((100, 2)))[:, [0, 1, 2, 3, 5]]]
    record = walkers.walk()
    mjbiped.walk(
        noting, record.terrain, engine=task.engine, initial=record.settings["initial"], steps=3, sample_period=None
    )
    told = told[max(k for k in range(10) if told[k][-1] == 0.0) :]  # before that the law was tried
    # 4e-16 s: the time since a touchdown is the difference of the same two numbers, the order of roles is the same
    np.testing.assert_array_equal(np.array(told[:100]), np.array(felt[:100]))


def test_two_interleaved_are_bitwise_two_alone() -> None:
    first, second = WalkTask("walk_random"), WalkTask("walk_stairs", residual=True, control_period=0.012)
    actions = random_actions(first, 120), random_actions(second, 120, seed=2)
    alone = walked(begun(first, 4), actions[0]), walked(begun(second, 5), actions[1])
    one, two = begun(first, 4), begun(second, 5)
    rows: tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]] = ([], [])
    for step, (mine, others) in enumerate(zip(*actions, strict=True)):
        rows[0].append(walked(one, mine[None]))
        if step % 15 == 0:
            mjbiped.walk(second.controller.inner, mjbiped.Terrain.level(), steps=1, initial="gait", sample_period=None)
        rows[1].append(walked(two, others[None]))
    assert np.concatenate(rows[0]).tobytes() == alone[0].tobytes()
    assert np.concatenate(rows[1]).tobytes() == alone[1].tobytes()


def test_a_row_of_robots_is_bitwise_robots_alone_with_any_number_of_threads() -> None:
    task = WalkTask("walk_random", residual=True)
    actions = np.random.default_rng(0).uniform(-3.0, 3.0, (80, 5, 2))
    alone = np.array([walked(begun(task, seed), actions[:, seed]) for seed in range(5)])
    for threads in (1, 2, 3):
        row = Walkers(task, 5, threads=threads, recorded=False)
        for index in range(5):
            row.begin(index, np.random.default_rng(index))
        together = []
        for each in actions:
            row.actions[:] = each
            row.step()
            columns = row.felt, row.columns["reward"], row.columns["outcome"]
            together.append(np.column_stack(columns))
        assert np.array(together).swapaxes(0, 1).tobytes() == alone.tobytes()
        row.close()


@pytest.mark.parametrize("recorded", [True, False])
def test_touchdowns_are_taken_when_the_room_for_samples_is_used_up_and_only_if_recorded(recorded: bool) -> None:
    """The memory of robots that are not recorded does not grow, however long they walk."""
    row = Walkers(WalkTask("walk_level", residual=True), recorded=recorded)
    row.begin(0, np.random.default_rng(0))
    for _ in range(60):  # 240 samples
        row.step()
    count = row.walker().run.simulation.state.count
    assert count > 0  # touchdowns so far
    assert row.walker().run.recorder.steps == 0
    for _ in range(10):
        row.step()
    assert (row.walker().run.recorder.steps >= count) == recorded


@pytest.mark.compiled
def test_plain_python_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    task = WalkTask("walk_stairs", residual=True)
    actions = random_actions(task, 60)
    compiled = walked(begun(task), actions)
    monkeypatch.setattr("mjbiped.control.compiled.compilable_law", lambda _: None)  # methods, called by it
    assert walked(begun(task), actions).tobytes() == compiled.tobytes()
    monkeypatch.setenv(VARIABLE, "never")
    assert walked(begun(task), actions).tobytes() == compiled.tobytes()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
def test_a_copy_goes_on_by_itself(copied) -> None:  # type: ignore[no-untyped-def]
    task = WalkTask("walk_random", residual=True)
    actions = random_actions(task, 150)
    walkers = begun(task)
    walked(walkers, actions[:70])
    other = copied(walkers)
    assert other.felt.tobytes() == walkers.felt.tobytes()
    assert walked(other, actions[70:]).tobytes() == walked(walkers, actions[70:]).tobytes()
    assert_begins_like(walkers.walk(), other.walk())


def test_a_state_can_be_set_back() -> None:
    task = WalkTask("walk_slopes")
    actions = random_actions(task, 60)
    walkers = begun(task)
    walked(walkers, actions[:30])
    state = walkers.state()
    after = walked(walkers, actions[30:])
    walkers.set_state(state)
    np.testing.assert_array_equal(walked(walkers, actions[30:]), after)
    with pytest.raises(InputError, match="expected shape"):
        walkers.set_state(state[:-1])
    draw = np.random.default_rng(1)
    for odd in (state * np.nan, draw.normal(size=state.shape), np.where(np.arange(len(state)) == 7, 1e300, state)):
        with pytest.raises(InputError, match="none that was got from an episode"):
            walkers.set_state(odd)
    np.testing.assert_array_equal(walkers.state(), walkers.state())


def test_actions_of_other_shapes_are_refused() -> None:
    """NumPy would repeat them for the other joint, or the other robots."""
    one, two = begun(WalkTask("walk_level")), Walkers(WalkTask("walk_level"), 2)
    for walkers, odd in ((one, 1.0), (one, [1.0]), (one, [[1.0], [2.0]]), (two, [1.0, 2.0]), (two, [[1.0], [2.0]])):
        with pytest.raises(InputError, match=r"action = .*expected"):
            walkers.act(odd)
    one.act([[1.0, 2.0]])
    assert one.actions.tolist() == [[1.0, 2.0]]


def test_a_walk_for_all_of_its_time_ended_by_the_time_limit(tmp_path: Path) -> None:
    walkers = begun(WalkTask("walk_level", residual=True, time_limit=0.2))
    for _ in range(9):
        walkers.act([0.0, 0.0])
        walkers.step()
    assert walkers.walk().outcome == "interrupted"
    walkers.act([0.0, 0.0])
    walkers.step()
    walk = walkers.walk()
    assert (walk.outcome, walk.fell) == ("time limit", False)
    walk.save(tmp_path / "walk.npz")
    assert Walk.load(tmp_path / "walk.npz") == walk


def test_a_restarted_simulation_is_a_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """On ground that stays the same the model is made use of again."""
    monkeypatch.setenv(VARIABLE, "never")  # no other model for machine code
    task = WalkTask("walk_level")
    random = np.random.default_rng(0)
    walkers = Walkers(task)
    walkers.begin(0, random)
    model = walkers.walker().run.simulation.model
    walked(walkers, random_actions(task, 90))
    walkers.begin(0, np.random.default_rng(9))
    assert walkers.walker().run.simulation.model is model
    actions = random_actions(task, 90, seed=8)
    assert walked(walkers, actions).tobytes() == walked(begun(task, 9), actions).tobytes()


def test_another_robot_or_disturbance_on_the_same_ground_is_a_new_simulation() -> None:
    drawn: Any
    for drawn in ({"robot": {"leg_mass": {"uniform": [4.0, 6.0]}}}, {"disturbances": {"rate_noise": 0.1}}):
        task = WalkTask("walk_level", **drawn)
        random = np.random.default_rng(0)
        walkers = Walkers(task)
        walkers.begin(0, random)
        walkers.begin(0, random)
        episode = walkers.walker().episode
        fresh = Walkers(task)
        fresh.place(0, episode)
        actions = random_actions(task, 30)
        assert walked(walkers, actions).tobytes() == walked(fresh, actions).tobytes()


@pytest.mark.parametrize(("name", "residual"), [*itertools.product(TASKS, (False, True))])
def test_random_actions_give_numbers_within_their_ranges(name: str, residual: bool) -> None:
    task = WalkTask(name, residual=residual)
    walkers, random = Walkers(task), np.random.default_rng(0)
    walkers.begin(0, random)
    seen, ends = [], 0
    for _ in range(700):
        walkers.actions[0] = random.uniform(-2.0, 2.0, 2) * task.limits
        walkers.step()
        assert 0.0 <= walkers.columns["reward"][0] <= 1.0
        seen.append(walkers.felt[0].copy())
        if walkers.outcome(0) is not Outcome.WALKING:
            ends += 1
            walkers.begin(0, random)
    rows = np.array(seen)
    assert np.isfinite(rows).all()
    low, high = observation.bounds(2)
    assert (rows >= low).all()
    assert (rows <= high).all()
    assert (np.ptp(rows, axis=0) > 0.0).all()  # none is constant
    assert residual or ends >= 2  # the adaptive controller bears these disturbances


def test_actions_and_torques_are_cut_off_at_their_limits() -> None:
    for residual in (False, True):
        task = WalkTask("walk_level", residual=residual)
        most = task.limits
        wide, narrow = begun(task), begun(task)
        assert walked(wide, np.full((3, 2), 1e3)).tobytes() == walked(narrow, np.tile(most, (3, 1))).tobytes()
        if not residual:
            np.testing.assert_array_equal(wide.felt[0, observation.observed(2)["torque"]], most)


def test_the_reward_is_what_the_page_says() -> None:
    task = WalkTask("walk_random", residual=True)
    walkers = begun(task)
    x0, work0, target = walkers.columns["x_position"][0], 0.0, task.target_speed * 0.02
    average = target
    for _ in range(50):
        walkers.step()
        u, x = walkers.walker().row.ahead[0].state[0], walkers.columns["x_position"][0]
        assert x == pytest.approx(
            walkers.walker().run.simulation.data.qpos[0], abs=1e-4
        )  # the foot slips and rolls by some µm
        average += 0.02 / task.gait.period * (x - x0 - average)
        progress = min(max(average / target, 0.0), 1.0)
        work = u.work_absolute
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
    assert walkers.outcome(0) is Outcome.WALKING
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


def test_before_an_episode_it_is_said_what_to_do() -> None:
    robots = Walkers(WalkTask("walk_level"))
    for early in (robots.walk, robots.step):
        with pytest.raises(MjbipedError, match=r"call reset\(\) first"):
            early()
    two = Walkers(WalkTask("walk_level"), 2)
    two.begin(1, np.random.default_rng(0))
    with pytest.raises(MjbipedError, match=r"call reset\(\) first"):
        two.step()
    two.begin(0, np.random.default_rng(0))
    two.step()
    two.close()
    with pytest.raises(MjbipedError, match=r"call reset\(\) first"):
        two.step()


@pytest.mark.parametrize("action", [[1.0, 2.0, 3.0], [[1.0], [2.0]], "a", [None, 1.0]])
def test_actions_of_another_shape_are_named(action: Any) -> None:
    with pytest.raises(InputError, match=r"expected shape \(1, 2\) or \(2,\): ankle, hip of each robot"):
        Walkers(WalkTask("walk_level")).act(action)
    with pytest.raises(InputError, match=r"expected shape \(4, 2\): ankle, hip of each robot"):
        Walkers(WalkTask("walk_level"), 4).act(action)
