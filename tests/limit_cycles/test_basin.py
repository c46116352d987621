"""Basins of attraction against single walks, with and without knees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import as_completed
from typing import Any, NamedTuple

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, KneedController
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles import basin as basins
from mjbiped.limit_cycles.basin import Basin, BasinInterrupted, Fate, basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.robot import Array, Robot
from mjbiped.terrain.terrain import Terrain

SLOPE = math.radians(2)
STANCE, SWING = np.linspace(0.95, 1.25, 16), np.linspace(-0.5, 1.5, 21)
slow = pytest.mark.slow


class Slice(NamedTuple):
    """A robot, a plane, and the rates of a map."""

    robot: Robot
    slope: float
    stance: Array
    swing: Array


COMPASS = Slice(mjbiped.Compass(), SLOPE, STANCE, SWING)
KNEED = Slice(mjbiped.KneedBiped(), math.radians(2.5), np.linspace(1.0, 1.2, 5), np.linspace(-0.2, 0.8, 6))


def basin_of(case: Slice, threads: int = 2) -> Basin:
    return basin_of_attraction(
        case.robot, case.slope, stance_rates=case.stance, swing_rates=case.swing, threads=threads
    )


def start_of(goal: Array, rates: Sequence[float]) -> list[float]:
    """The state of the slice through a gait that has these rates."""
    half = len(goal) // 2
    return [*goal[:half], rates[0], *[rates[1]] * (half - 1)]


def assert_fate(fate: Fate, steps: int, goal: Array, walked: Array, outcome: str, first: int) -> None:
    """A single walk, judged anew, ends alike: of its states the first one stands after so many steps."""
    near = basins.SETTLED * np.repeat([1.0, math.sqrt(9.81)], len(goal) // 2)
    inside = (np.abs(walked - goal) < near).all(axis=1)
    settled = bool(inside.any())
    expected = ("settled", first + inside.argmax()) if settled else (outcome, len(walked) - 1 + first)
    assert (fate.name.lower(), steps) == expected


@pytest.mark.parametrize("case", [COMPASS, pytest.param(KNEED, marks=slow)], ids=["compass", "kneed"])
def test_each_start_is_a_walk_whatever_the_number_of_threads(case: Slice) -> None:
    found, goal = basin_of(case), passive_gait_of(case.robot, case.slope).start
    assert found.fates.shape == found.steps.shape == (len(case.swing), len(case.stance))
    walk = ReturnMap(case.robot, case.slope).walk
    for row, column in [*np.ndindex(found.fates.shape)][::7]:
        start = start_of(goal, (case.stance[column], case.swing[row]))
        walked, fate = walk(start, 100), Fate(found.fates[row, column])
        states = np.vstack([start, walked.states])
        assert_fate(fate, found.steps[row, column], goal, states, walked.outcome, 0)
        if fate is Fate.SETTLED and len(goal) == 4:  # and stays: it does converge, to the gait's own digits
            np.testing.assert_allclose(walk(start, 300).states[-1], goal, rtol=0, atol=1e-10)
    assert found.share(Fate.SETTLED) > 0.1
    assert found.share(Fate.FELL) > 0.1
    alone = basin_of(case, threads=1)
    assert (alone.fates.tobytes(), alone.steps.tobytes()) == (found.fates.tobytes(), found.steps.tobytes())


def test_attractor_may_have_any_period(robot: mjbiped.Compass) -> None:
    """On 3 degrees the gait of period one is unstable, and walks settle on that of period two; on 4 on none."""
    found = basin_of_attraction(robot, math.radians(3), stance_rates=[1.1, 1.2, 1.3], swing_rates=[0.4, 0.7, 1.0])
    assert found.share(Fate.SETTLED) > 0
    nothing = basin_of_attraction(robot, math.radians(4), stance_rates=[1.3, 1.4], swing_rates=[0.4, 0.7])
    assert (nothing.fates == Fate.FELL).all()


@pytest.mark.parametrize(
    ("kneed", "rates"),
    [(False, (1.1, 0.8)), (False, (2.5, -3.0)), (False, (9.5, 0.0))]
    + [pytest.param(True, rates, marks=slow) for rates in ((1.1, 0.8), (2.5, -2.0), (12.0, -6.0))],
)
def test_a_controlled_start_is_a_walk(controller: AdaptiveController, kneed: bool, rates: tuple[float, float]) -> None:
    law: Controller = controller
    if kneed:
        law = KneedController(mjbiped.KneedBiped(), mjbiped.find_kneed_gait(mjbiped.KneedBiped(), KNEED.slope))
    assert law.gait is not None
    found = basin_of_control(law, stance_rates=rates[:1], swing_rates=rates[1:], limit=6)
    start: Any = start_of(law.gait.start, rates)
    walk = mjbiped.walk(law, Terrain.level(), engine="hybrid", initial=start, steps=6)
    states, fate = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]]), Fate(found.fates[0, 0])
    assert_fate(fate, found.steps[0, 0], law.gait.start, states, walk.outcome, 1)
    assert found.peak_torque[0, 0] == pytest.approx(walk.peak_torque.max(), rel=1e-6)
    assert (fate is Fate.SETTLED) == (rates[0] < 9.0)


def test_interrupt_keeps_the_rows(robot: mjbiped.Compass, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C reaches the main thread, which waits for rows."""

    def interrupted(futures: list[object]) -> object:
        for count, future in enumerate(as_completed(futures)):  # type: ignore[arg-type,var-annotated]
            yield future
            if count == 4:
                raise KeyboardInterrupt

    monkeypatch.setattr(basins, "as_completed", interrupted)
    with pytest.raises(BasinInterrupted) as caught:
        basin_of_attraction(robot, SLOPE, stance_rates=STANCE, swing_rates=np.linspace(-0.5, 1.5, 400), threads=1)
    assert 4 <= (caught.value.basin.fates != Fate.UNDECIDED).any(axis=1).sum() < 400
