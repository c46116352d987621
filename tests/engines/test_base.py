from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from controllers import Controller, PassiveController
from mjbiped import Terrain
from mjbiped.engines.base import Run, Show
from mjbiped.engines.plan import Plan
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, width
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.rules.termination import Outcome

PERIOD, LENGTH = 0.5, 0.4


@dataclass(frozen=True)
class Sliding(mjbiped.Engine):
    """An engine of a user's own: feet are set down at equal distances, whatever the law."""

    name: ClassVar[str] = "sliding"

    speed: float = 1.0

    def check(self, plan: Plan) -> None:
        if len(plan.terrain.x) > 2:
            raise mjbiped.InputError("the engine sliding knows planes only")

    def start(
        self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled
    ) -> SlidingRun:
        return SlidingRun(plan, self.speed, summarised=summarised, cancellation=cancellation)


class SlidingRun(Run):
    def __init__(self, plan: Plan, speed: float, *, summarised: bool, cancellation: Cancellation) -> None:
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        self.speed = speed

    def walk(self, show: Show) -> Outcome:
        steps = self.plan.terms.steps or 0
        for step in range(1, steps + 1):
            self.recorder.cancellation()
            row = np.zeros((1, width(TOUCHDOWNS)))
            row[0, 0], row[0, 5] = step * PERIOD / self.speed, step * LENGTH
            sample = np.zeros((1, width(SAMPLES)))
            sample[0, 0] = row[0, 0]
            self.recorder.add(row, sample)
            show(1, step * LENGTH)
        return Outcome.FINISHED

    def peak_torque(self) -> NDArray[np.float64]:
        return np.zeros(2)

    def settings(self) -> dict[str, Any]:
        return {"speed": self.speed}


@pytest.fixture
def passive() -> Controller:
    return PassiveController()


def test_an_engine_of_ones_own(passive: Controller, capsys: pytest.CaptureFixture[str]) -> None:
    walk = mjbiped.walk(passive, Terrain.level(), engine=Sliding(speed=2.0), steps=3, initial="rest", progress=True)
    assert (walk.outcome, walk.steps, walk.settings["engine"], walk.settings["speed"]) == (
        "finished",
        3,
        "sliding",
        2.0,
    )
    assert walk.end[0] == 3 * PERIOD / 2.0
    with pytest.raises(mjbiped.InputError, match="planes only"):
        mjbiped.walk(passive, Terrain.mixed(), engine=Sliding(), initial="rest")
    capsys.readouterr()


@pytest.mark.parametrize(("word", "engine"), [("mujoco", mjbiped.Mujoco()), ("hybrid", mjbiped.Hybrid())])
def test_the_short_words_mean_the_defaults(word: str, engine: mjbiped.Engine, passive: Controller) -> None:
    short, long = (mjbiped.walk(passive, Terrain.incline(2.0), engine=each, steps=3) for each in (word, engine))
    assert short == long
    assert short.settings["engine"] == word


def test_settings_stand_in_the_record(passive: Controller) -> None:
    settings = {
        "timestep": 4e-4,
        "contact_timestep": 4e-5,
        "control_period": 8e-4,
        "ground": "heightfield",
        "lands": False,
    }
    walk = mjbiped.walk(passive, Terrain.incline(2.0), engine=mjbiped.Mujoco(**settings), steps=1)  # type: ignore[arg-type]
    assert {name: walk.settings[name] for name in settings} == settings
    walk = mjbiped.walk(passive, Terrain.incline(2.0), engine=mjbiped.Hybrid(tolerance=1e-10), steps=1)
    assert walk.settings["tolerance"] == 1e-10


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"timestep": "a"}, "timestep"),
        ({"timestep": 1.0}, "timestep"),
        ({"contact_timestep": 0.0}, "contact_timestep"),
        ({"control_period": 3e-4}, "control_period .*multiple"),
        ({"ground": "sand"}, "heightfield"),
        ({"lands": 1}, "lands"),
    ],
)
def test_bad_settings_are_refused(bad: dict[str, Any], names: str) -> None:
    with pytest.raises(mjbiped.InputError, match=names):
        mjbiped.Mujoco(**bad)


def test_an_unknown_engine_is_told_with_the_nearest() -> None:
    with pytest.raises(mjbiped.InputError, match="did you mean 'mujoco'"):
        mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine="mujuco")
