"""Basins of attraction against single walks."""

import math
from concurrent.futures import as_completed

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.errors import GaitError, InputError
from mjbiped.limit_cycles import basin as basins
from mjbiped.limit_cycles.basin import Basin, BasinInterrupted, Fate, basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.terrain.terrain import Terrain

SLOPE = math.radians(2)
STANCE, SWING = np.linspace(0.95, 1.25, 16), np.linspace(-0.5, 1.5, 21)


@pytest.fixture(scope="module")
def passive(robot: mjbiped.Compass) -> Basin:
    return basin_of_attraction(robot, SLOPE, stance_rates=STANCE, swing_rates=SWING, threads=2)


def test_each_start_is_a_walk(passive: Basin, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """Walked again, one by one, and judged with NumPy."""
    assert passive.fates.shape == passive.steps.shape == (len(SWING), len(STANCE))
    near = basins.SETTLED * np.array([1, 1, math.sqrt(9.81), math.sqrt(9.81)])
    for row in range(0, len(SWING), 4):
        for column in range(0, len(STANCE), 3):
            start = [*gait.start[:2], STANCE[column], SWING[row]]
            walked = ReturnMap(robot, SLOPE).walk(start, 100)
            inside = (np.abs(np.vstack([start, walked.states]) - gait.start) < near).all(axis=1)
            fate, steps = Fate(passive.fates[row, column]), passive.steps[row, column]
            if inside.any():
                assert (fate, steps) == (Fate.SETTLED, inside.argmax())
            else:
                assert (fate.name.lower(), steps) == (walked.outcome, len(walked.states))


def test_basin_holds_the_gait_and_has_an_end(passive: Basin, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    alone = basin_of_attraction(robot, SLOPE, stance_rates=gait.start[2:3], swing_rates=gait.start[3:])
    assert (alone.fates[0, 0], alone.steps[0, 0]) == (Fate.SETTLED, 0)
    assert 0.1 < passive.share(Fate.SETTLED) < 0.6
    assert 0.3 < passive.share(Fate.FELL) < 0.9


def test_settled_walks_stay(passive: Basin, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    """What counts as settled does converge: to the gait's own digits."""
    for row, column in np.argwhere(passive.fates == Fate.SETTLED)[::5]:
        walked = ReturnMap(robot, SLOPE).walk([*gait.start[:2], STANCE[column], SWING[row]], 300)
        np.testing.assert_allclose(walked.states[-1], gait.start, rtol=0, atol=1e-10)


def test_map_does_not_depend_on_the_number_of_threads(robot: mjbiped.Compass, passive: Basin) -> None:
    other = basin_of_attraction(robot, SLOPE, stance_rates=STANCE, swing_rates=SWING, threads=1)
    assert other.fates.tobytes() == passive.fates.tobytes()
    assert other.steps.tobytes() == passive.steps.tobytes()


def test_attractor_may_have_any_period(robot: mjbiped.Compass) -> None:
    """On 3 degrees the gait of period one is unstable, and walks settle on that of period two."""
    found = basin_of_attraction(robot, math.radians(3), stance_rates=[1.1, 1.2, 1.3], swing_rates=[0.4, 0.7, 1.0])
    assert found.share(Fate.SETTLED) > 0
    nothing = basin_of_attraction(robot, math.radians(4), stance_rates=[1.3, 1.4], swing_rates=[0.4, 0.7])
    assert nothing.share(Fate.SETTLED) == 0  # there is no attractor
    assert nothing.share(Fate.FELL) == 1


@pytest.mark.parametrize("rates", [(1.1, 0.8), (2.5, -3.0), (9.5, 0.0)])
def test_controlled_start_is_a_walk(rates: tuple[float, float], controller: AdaptiveController) -> None:
    found = basin_of_control(controller, stance_rates=rates[:1], swing_rates=rates[1:], limit=6)
    start = (*controller.gait.start[:2], *rates)
    walk = mjbiped.walk(controller, Terrain.level(), engine="hybrid", initial=start, steps=6)
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    near = basins.SETTLED * np.array([1, 1, math.sqrt(9.81), math.sqrt(9.81)])
    inside = (np.abs(states - controller.gait.start) < near).all(axis=1)
    fate, steps = Fate(found.fates[0, 0]), found.steps[0, 0]
    if inside.any():
        assert (fate, steps) == (Fate.SETTLED, 1 + inside.argmax())
    else:
        assert (fate.name.lower(), steps) == (walk.outcome, walk.steps)
    assert found.peak_torque[0, 0] == pytest.approx(walk.peak_torque.max(), rel=1e-6)
    assert (fate is Fate.FELL) == (rates[0] == 9.5)


def test_control_widens_the_basin(controller: AdaptiveController) -> None:
    wide = basin_of_control(controller, stance_rates=[0.0, 1.0, 2.0, 3.0], swing_rates=[-4.0, 0.0, 4.0], threads=2)
    assert wide.share(Fate.SETTLED) == 1
    assert (wide.peak_torque > 5).any()


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
    done = (caught.value.basin.fates != Fate.UNDECIDED).any(axis=1)
    assert 4 <= done.sum() < 400


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"stance_rates": [1.0, 0.5]}, "stance_rates"),
        ({"swing_rates": [math.nan]}, "swing_rates"),
        ({"swing_rates": []}, "swing_rates"),
        ({"limit": 0}, "limit"),
        ({"threads": 0}, "threads"),
    ],
)
def test_bad_input_is_refused(options: dict[str, object], message: str, robot: mjbiped.Compass) -> None:
    with pytest.raises(InputError, match=message):
        basin_of_attraction(robot, SLOPE, **options)  # type: ignore[arg-type]


def test_what_has_no_gait_has_no_basin(robot: mjbiped.Compass) -> None:
    with pytest.raises(GaitError):
        basin_of_attraction(robot, -0.1)
    with pytest.raises(InputError, match="imitates no gait"):
        basin_of_control(PassiveController())
