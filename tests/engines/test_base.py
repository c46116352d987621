from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

import mjbiped
from controllers import PassiveController
from mjbiped import Terrain
from mjbiped.engines.base import Run, Show
from mjbiped.engines.plan import Plan
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, Cancellation, never_cancelled, width
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

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> Run:
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


PASSIVE = PassiveController()


def test_an_engine_of_ones_own(capsys: pytest.CaptureFixture[str]) -> None:
    walk = mjbiped.walk(PASSIVE, Terrain.level(), engine=Sliding(speed=2.0), steps=3, initial="rest", progress=True)
    assert (walk.outcome, walk.steps, walk.settings["engine"]) == ("finished", 3, "sliding")
    assert walk.settings["speed"] == 2.0
    assert walk.end[0] == 3 * PERIOD / 2.0
    many = mjbiped.walk_many(PASSIVE, [Terrain.level()] * 2, engine=Sliding(2.0), steps=3, initial="rest", workers=1)
    assert many == [walk] * 2
    with pytest.raises(mjbiped.InputError, match="planes only"):
        mjbiped.walk(PASSIVE, Terrain.mixed(), engine=Sliding(), initial="rest")
    capsys.readouterr()


BAD: list[tuple[Any, dict[str, Any], str]] = [
    (mjbiped.Mujoco, {"timestep": 0.01}, "timestep"),
    (mjbiped.Mujoco, {"contact_timestep": 0.0}, "contact_timestep"),
    (mjbiped.Mujoco, {"control_period": 3e-4}, "control_period .*multiple"),
    (mjbiped.Mujoco, {"ground": "sand"}, "heightfield"),
    (mjbiped.Mujoco, {"lands": 1}, "lands"),
    (mjbiped.Mujoco, {"stance_knee": "free"}, "unknown stance_knee 'free': valid are locked, motor"),
    (mjbiped.Hybrid, {"tolerance": 0.0}, "tolerance"),
    (mjbiped.Hybrid, {"tolerance": "a"}, "tolerance"),
]


@pytest.mark.parametrize(("engine", "bad", "names"), BAD)
def test_bad_settings_are_refused(engine: Any, bad: dict[str, Any], names: str) -> None:
    with pytest.raises(mjbiped.InputError, match=names):
        engine(**bad)
    with pytest.raises(mjbiped.InputError, match="did you mean 'mujoco'"):
        mjbiped.walk(PASSIVE, Terrain.incline(2.0), engine="mujuco")
