"""`walk_many()`: each walk as by itself, whatever walks beside it, and nothing lost when one of them is broken off."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.records import measures

Terrain = mjbiped.Terrain
FALLS = Terrain.from_segments([(0.30, 2.0), (10.0, 2.0, 0.05)])  # a riser is struck in the first step
MOVING = Terrain.random(seed=2, length=400.0, segment_length=(0.1, 0.2), slope_deg=(-1.0, 1.0), rise=(0.0, 0.0))
ENGINES = ("hybrid", "mujoco")


@pytest.fixture(autouse=True)
def nothing_stays_installed() -> Any:
    before = mujoco.get_mju_user_warning()  # dm_control has one of its own
    yield
    assert mujoco.get_mjcb_control() is None
    assert mujoco.get_mju_user_warning() is before


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_as_each_by_itself(engine: str, controller: AdaptiveController) -> None:
    """To the last bit, for any number of workers, falls and a different law among them."""
    cases: list[tuple[Controller, Terrain]] = [
        (controller, Terrain.mixed()),
        (controller, FALLS),
        (replace(controller, replanning_delay=None), Terrain.random(seed=3)),
        (PassiveController(), Terrain.incline(2.0)),
        (controller, Terrain.random(seed=1)),
        (controller, MOVING),  # a thread builds new ground about its robot while the others step
    ]
    given: dict[str, Any] = {"engine": engine, "steps": 20}
    expected = [mjbiped.walk(*case, **given) for case in cases]
    assert {walk.outcome for walk in expected} == {"finished", "fell"}
    controllers, terrains = zip(*cases, strict=True)
    for workers in (1, 2, 5):
        assert mjbiped.walk_many(controllers, terrains, workers=workers, **given) == expected
    summaries = mjbiped.walk_many(controllers, terrains, summaries=True, **given)
    assert summaries == [measures.summary(walk) for walk in expected]


@pytest.mark.slow
def test_a_clock_in_python_is_put_aside_meanwhile(controller: AdaptiveController) -> None:
    """dm_control's profiling leaves one behind, and now and then a walk failed by it."""
    mujoco.set_mjcb_time(time.time)
    try:
        walks = mjbiped.walk_many(controller, [Terrain.random(seed=seed) for seed in range(40)], steps=2, workers=4)
        assert [walk.steps for walk in walks] == [2] * 40
        assert mujoco.get_mjcb_time() is time.time
    finally:
        mujoco.set_mjcb_time(None)


def test_one_of_a_kind_serves_all(controller: AdaptiveController) -> None:
    given: dict[str, Any] = {"engine": "hybrid", "steps": 2}
    state, softer = (-0.19, 0.19, 1.1, 0.8), replace(controller, position_gain=4.0)
    grounds = [Terrain.random(seed=4), Terrain.mixed()]
    laws = [controller, softer]
    starts: list[Any] = ["rest", state, "gait", np.array(state)]  # four of them, and no state
    expected = [mjbiped.walk(controller, Terrain.mixed(), initial=start, **given) for start in starts]
    assert mjbiped.walk_many(controller, Terrain.mixed(), initial=starts, **given) == expected
    assert mjbiped.walk_many(laws, Terrain.mixed(), initial=state, **given)[0] == expected[1]
    assert mjbiped.walk_many(controller, Terrain.mixed(), **given) == [expected[2]]
    assert mjbiped.walk_many(controller, iter(grounds), **given)[1] == expected[2]
    assert mjbiped.walk_many(laws, Terrain.mixed(), **given)[1] == mjbiped.walk(softer, Terrain.mixed(), **given)


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"terrains": [Terrain.level()] * 3}, "2 of controllers, 3 of terrains"),
        ({"controllers": [PassiveController(), None]}, "walk 1 of 2 .*controllers.Controller"),
        ({"terrains": [Terrain.incline(2.0), Terrain.level()]}, "walk 1 of 2 .*no passive gait"),
        ({"initial": ["rest", "sleeping"]}, "walk 1 of 2 .*sleeping"),
    ],
)
@pytest.mark.usefixtures("nothing_walks")
def test_bad_arguments_are_refused_before_anything_runs(bad: dict[str, Any], names: str) -> None:
    grounds = [Terrain.incline(2.0), Terrain.incline(3.0)]
    arguments: dict[str, Any] = {"controllers": [PassiveController()] * 2, "terrains": grounds, **bad}
    with pytest.raises(mjbiped.GaitError if "gait" in names else mjbiped.InputError, match=names):
        mjbiped.walk_many(**arguments)


class Counting(Controller):
    """In plain Python; fails in its third step if it is told to."""

    states = ("work",)
    memory_size = 2

    def __init__(self, error: BaseException | None = None) -> None:
        self.error = error

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        memory[1] += 1.0
        if memory[1] == 2.0 and self.error is not None:
            raise self.error

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, -0.5 * (q[1] - q[0]), 1.0


@pytest.mark.parametrize(
    ("engine", "workers", "failure"),
    [
        ("hybrid", 1, mjbiped.InputError("gain")),
        pytest.param("hybrid", 2, ZeroDivisionError("gain"), marks=pytest.mark.slow),
        ("mujoco", 1, ZeroDivisionError("gain")),
    ],
)
def test_one_that_fails_costs_no_other(engine: str, workers: int, failure: Exception, controller: Controller) -> None:
    """In plain Python: with two workers in processes; beside a compiled one."""
    given: dict[str, Any] = {"engine": engine, "steps": 3, "sample_period": 0.05}
    ground = Terrain.incline(2.0)
    controllers = [Counting(), controller, Counting(failure)]
    told = r"1 of 3 .*walk 2 .*Counting failed at .*after 1 steps: .*gain"
    with pytest.raises(mjbiped.WalksStopped, match=told) as caught:
        mjbiped.walk_many(controllers, ground, workers=workers, **given)
    error = caught.value
    assert list(error.errors) == [2]
    assert error.walks[:2] == [mjbiped.walk(each, ground, **given) for each in controllers[:2]]
    assert isinstance(error.walks[2], mjbiped.Walk)
    assert (error.walks[2].outcome, error.walks[2].steps) == ("interrupted", 1)
    assert "raise self.error" in error.__notes__[0]


@pytest.mark.usefixtures("nothing_walks")
def test_what_cannot_be_sent_to_a_process_is_refused() -> None:
    class Local(Counting):
        """Of a function, which no other process finds."""

    with pytest.raises(mjbiped.InputError, match=r"Local .*pickled.*workers=1"):
        mjbiped.walk_many(Local(), [Terrain.incline(2.0)] * 2, engine="hybrid", workers=2)


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_ctrl_c_keeps_what_was_walked(workers: int) -> None:
    """One fell before it, one is under way, one had not begun."""
    controllers = [PassiveController(), Counting(KeyboardInterrupt()), Counting()]
    terrains = [FALLS, Terrain.incline(2.0), Terrain.incline(2.0)]
    given: dict[str, Any] = {"engine": "hybrid", "steps": 3, "workers": workers, "summaries": True}
    with pytest.raises(mjbiped.WalksInterrupted) as caught:
        mjbiped.walk_many(controllers, terrains, **given)
    told = [isinstance(walk, dict) and walk["outcome"] for walk in caught.value.walks]
    assert told[:2] == ["fell", "interrupted"]
    assert workers == 2 or not told[2]


def test_warnings_go_to_the_walk_that_they_are_of(controller: AdaptiveController) -> None:
    """MuJoCo has one handler of warnings for all threads."""
    wild = replace(controller, position_gain=1e6, velocity_gain=1e6)  # torques beyond MuJoCo's greatest number
    walks = mjbiped.walk_many([controller, wild, controller], Terrain.level(), steps=1, workers=3)
    assert walks[0] == walks[2] == mjbiped.walk(controller, Terrain.level(), steps=1)
    assert (bool(walks[0].settings["warnings"]), bool(walks[1].settings["warnings"])) == (False, True)
    assert walks[1] == mjbiped.walk(wild, Terrain.level(), steps=1)


def test_walks_inside_a_controller_are_refused() -> None:
    class Nesting(PassiveController):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            mjbiped.walk_many(PassiveController(), Terrain.incline(2.0), steps=1)
            return 0.0, 0.0

    with pytest.raises(mjbiped.WalkStopped, match="inside another"):
        mjbiped.walk(Nesting(), Terrain.incline(2.0), steps=1)
    with pytest.raises(mjbiped.WalksStopped, match="inside another"):
        mjbiped.walk_many(Nesting(), Terrain.incline(2.0), steps=1)
