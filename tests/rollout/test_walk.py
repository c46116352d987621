"""`walk()`: what it refuses, what it keeps when it is broken off, and that it repeats itself."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, Law, LawController, Memory, PassiveController
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures

Terrain = mjbiped.Terrain
each_engine = pytest.mark.parametrize("engine", ["mujoco", "hybrid"])


def test_same_arguments_same_record_until_steps_or_distance_are_made(controller: AdaptiveController) -> None:
    walks = [mjbiped.walk(controller, Terrain.level(), distance=1.0) for _ in range(2)]
    assert walks[0] == walks[1]
    assert walks[0].outcome == "finished"
    assert walks[0].touchdowns["x"][-2] < 1.0 <= walks[0].distance
    assert mjbiped.walk(controller, Terrain.level(), distance=1.0, steps=2).steps == 2


@pytest.mark.usefixtures("nothing_walks")
@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"engine": "bullet"}, "mujoco"),
        ({"engine": mjbiped.Hybrid}, r"Hybrid\(\)"),
        ({"initial": "sleeping"}, "gait, rest"),
        ({"controller": PassiveController}, "class"),
        # ahead: it would have touched down, sin(0.3) along the slope and 1 - cos(0.3) under it; inside a riser
        (
            {"terrain": Terrain.incline(5.0), "initial": (0.3, 0.0, 1.0, 1.0)},
            "swing foot would start 0.0448 m under the ground, at x = 0.2905 m",
        ),
        ({"terrain": Terrain.stairs(rise=0.1, first=0.2), "initial": (0.15, -0.15, 1.0, 1.0)}, "swing foot would"),
        ({"terrain": Terrain.level(), "initial": (2.0, 0.0, 0.0, 0.0)}, "hip would start"),
        ({"terrain": Terrain.level()}, 'no passive gait .*give initial="rest"'),
    ],
)
def test_bad_arguments_are_refused_before_anything_runs(bad: dict[str, Any], names: str) -> None:
    arguments = {"controller": PassiveController(), "terrain": Terrain.incline(2.0), **bad}
    controller, terrain = arguments.pop("controller"), arguments.pop("terrain")
    kind = mjbiped.GaitError if "no passive gait" in names else mjbiped.InputError
    with pytest.raises(kind, match=names):
        mjbiped.walk(controller, terrain, **arguments)


class Wordless(Exception):  # noqa: N818
    """An exception that has no words for itself."""

    def __str__(self) -> str:
        raise ValueError("no words")


def wrapped_interrupt() -> SystemError:
    """As CPython reports an interrupt that came while C code ran."""
    error = SystemError("returned a result with an exception set")
    error.__cause__ = KeyboardInterrupt()
    return error


class Failing(Controller):
    """Works for half a second, then raises what it was given."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if t > 0.5:
            raise self.error
        return 0.0, -0.5 * (q[1] - q[0])


@each_engine
@pytest.mark.parametrize(
    ("error", "expected", "words"),
    [
        (ZeroDivisionError("gain"), mjbiped.WalkStopped, "Failing failed at 0.* ZeroDivisionError: gain"),
        (SystemExit(5), mjbiped.WalkStopped, "SystemExit: 5"),
        (Wordless(), mjbiped.WalkStopped, "Wordless, whose words cannot be told"),
        (KeyboardInterrupt(), mjbiped.WalkInterrupted, "interrupted"),
        (wrapped_interrupt(), mjbiped.WalkInterrupted, "interrupted"),
    ],
)
def test_broken_off(engine: str, error: BaseException, expected: type[BaseException], words: str) -> None:
    """What was walked before a controller failed, or Ctrl-C, is not lost."""
    with pytest.raises(expected, match=words) as caught:
        mjbiped.walk(Failing(error), Terrain.level(), initial=(-0.19, 0.19, 1.1, 0.8), engine=engine)
    walk: mjbiped.Walk = caught.value.walk  # type: ignore[attr-defined]
    assert walk.outcome == "interrupted"
    assert 0.4 < walk.end[0] < 0.51  # the hybrid engine keeps whole integration steps alone
    assert len(walk.samples["time"]) > 80


def test_an_error_before_the_first_sample_is_told() -> None:
    class Broken(PassiveController):
        def slope_estimate(self, memory: Memory) -> float:
            raise ZeroDivisionError("slope")

    with pytest.raises(mjbiped.WalkStopped, match="slope") as caught:
        mjbiped.walk(Broken(), Terrain.level(), initial="rest")
    assert len(caught.value.walk.samples["time"]) == 0


def nested(levels: int) -> list[Any]:
    return [nested(levels - 1)] if levels else []


VALUES: tuple[Any, ...] = (10**5000, nested(60), {1, 2}, [0] * 2_000_000)
UNTELLABLE: tuple[Any, ...] = (None, {"name": 5}, {"name": "\ud800"}, *({"name": "x", "n": each} for each in VALUES))
"""What no record could tell of a controller."""


@pytest.mark.usefixtures("nothing_walks")
@pytest.mark.parametrize(
    ("parts", "names"),
    [
        ({"states": "work"}, "tuple of names"),
        ({"states": ("a", "b"), "memory_size": 1}, "memory_size"),
        *[({"memory_size": 4, "support": place}, "index of the first of two") for place in (3, 1.0)],
        ({"states": ("a", "b"), "memory_size": 4, "support": 1}, "behind its 2 states, 2 at most"),
        ({"describe": lambda self: {"self": self}}, "JSON"),
        *[({"describe": lambda *_, told=told: told}, "what a record can hold") for told in UNTELLABLE],
        ({"describe": lambda *_: 1 / 0}, "does not tell what it is: ZeroDivisionError"),
        ({"law": lambda *_: 5}, r"Made\.law\(\) gives 5; expected a Law, or None"),
        ({"start": lambda *_: sys.exit(5)}, r"Made\.start fails: SystemExit: 5"),
    ],
)
def test_ill_made_controllers_are_refused(parts: dict[str, Any], names: str) -> None:
    made = type("Made", (PassiveController,), parts)
    with pytest.raises(mjbiped.InputError, match=names):
        mjbiped.walk(made(), Terrain.incline(2.0), steps=1)


def by_table(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[0], out[1] = 0.0, -parameters[0][1] * (q[1] - q[0])


class ByTable(LawController):
    """A law whose first parameter is a table, which only Python can read."""

    @property
    def plain_law(self) -> Law:
        parameters: Any = ((0.3, 0.1), 0.5)
        return Law(parameters, by_table)


@each_engine
def test_a_law_may_begin_with_a_table(engine: str) -> None:
    walk = mjbiped.walk(ByTable(), Terrain.incline(2.0), engine=engine, steps=1)
    np.testing.assert_array_equal(walk.samples["torque"][0], [0.0, -0.1 * (walk.samples["q"][0] @ [-1.0, 1.0])])


@each_engine
def test_without_samples_all_else_is_the_same(engine: str, controller: AdaptiveController, tmp_path: Path) -> None:
    asked: list[dict[str, Any]] = [{}, {"sample_period": None}]
    sampled, bare = (mjbiped.walk(controller, Terrain.random(seed=2), engine=engine, steps=3, **each) for each in asked)
    assert replace(bare, samples=sampled.samples, settings=sampled.settings) == sampled
    assert bare.settings == {**sampled.settings, "sample_period": None}
    assert not any(map(len, bare.samples.values()))
    assert measures.summary(bare) == measures.summary(sampled)
    bare.save(tmp_path / "bare.npz")
    assert mjbiped.Walk.load(tmp_path / "bare.npz") == bare
    with pytest.raises(mjbiped.RenderError, match="no samples"):
        plot_walk(bare)
