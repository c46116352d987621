"""The return map against the hybrid engine, which steps are steps, and slices through it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mjbiped
from controllers import PassiveController
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles.map_slices import PUSH, MapSlices, map_slices
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

TABLE_ONE, KNEED, WHEEL = Compass(), mjbiped.KneedBiped(), mjbiped.RimlessWheel()
slow = pytest.mark.slow


@pytest.mark.parametrize(
    ("robot", "degrees", "off", "tolerance", "late"),
    [
        (TABLE_ONE, 0.5, [1.02, 1.02, 1.0, 1.03], 1e-9, 1e-9),
        (TABLE_ONE, 2.0, [1.02, 1.02, 1.0, 1.03], 1e-9, 1e-9),
        (TABLE_ONE, 3.35, [1.02, 1.02, 1.0, 1.03], 5e-9, 5e-9),
        pytest.param(KNEED, 2.5, [1.0, 1.0, 1.0, 1.01, 0.95, 0.95], 1e-8, 1e-7, marks=slow),
    ],
)
def test_many_steps_are_those_of_the_hybrid_engine(
    robot: Robot, degrees: float, off: list[float], tolerance: float, late: float
) -> None:
    """Whose integration steps are adaptive, of 1e-10 each: at 1e-13 the difference on 3.35 degrees is 1e-10."""
    terrain = Terrain.incline(degrees)
    start, steps = passive_gait_of(robot, math.radians(degrees)).start * off, 40 if len(off) == 4 else 12
    walk = mjbiped.walk(
        PassiveController(), terrain, engine="hybrid", robot=robot, initial=start, steps=steps, sample_period=None
    )
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    found = ReturnMap(robot, terrain.slope_at(0.0)).walk(start, steps)
    assert len(found.states) == walk.steps > 5
    np.testing.assert_allclose(found.states, states, rtol=0, atol=tolerance)
    np.testing.assert_allclose(np.cumsum(found.periods), walk.touchdowns["time"], rtol=0, atol=late)


@pytest.mark.parametrize(
    ("state", "degrees", "outcome"),
    [
        ((-0.19, 0.19, 0.0, 0.0), 2.0, "fell"),  # backwards
        ((-0.19, 0.19, 6.0, 0.0), 2.0, "fell"),  # too fast for the swing leg
        ((0.0, 0.0, 1e9, -1e9), 2.0, "fell"),  # within a nanosecond, which the engine's steps resolve
        ((0.0, 0.0, 0.0, 0.0), 0.0, "stalled"),  # feet together at rest: nothing ever moves
    ],
)
def test_failures_have_names(state: tuple[float, ...], degrees: float, outcome: str) -> None:
    steps = ReturnMap(TABLE_ONE, math.radians(degrees)).walk(state, 5)
    assert steps.outcome == outcome
    assert len(steps.states) == len(steps.periods) < 5


def test_a_rule_says_which_steps_are_steps(robot: Compass) -> None:
    """Shorter ones than its reach are none, measured horizontally: on 5 degrees that differs from along the slope."""
    gentle, steep = (mjbiped.find_passive_gait(robot, math.radians(degrees)) for degrees in (0.25, 5.0))
    step = steep.step_length * math.cos(steep.slope)
    assert steep.step_length - step > 1e-3
    for gait, rule, outcome in (
        (gentle, ScuffingRule(), "fell"),
        (gentle, ScuffingRule(reach=0.0, delay=0.0), "walking"),
        (steep, ScuffingRule(step - 1e-5, 0.1), "walking"),
        (steep, ScuffingRule(step + 1e-5, 0.1), "fell"),
    ):
        assert ReturnMap(robot, gait.slope, rule).walk(gait.start, 1).outcome == outcome


# ---- slices through it -----------------------------------------------------------------------------------------------


def found(robot: Robot, degrees: float) -> MapSlices:
    return map_slices(robot, math.radians(degrees), points=41, steps=20)


@pytest.mark.parametrize(
    ("robot", "degrees"),
    [(TABLE_ONE, 2.0), pytest.param(KNEED, 2.5, marks=slow), pytest.param(WHEEL, 5.0, marks=slow)],
    ids=["compass", "kneed", "wheel"],
)
def test_slices_meet_in_the_gait_and_walks_reach_it(robot: Robot, degrees: float) -> None:
    slices = found(robot, degrees)
    fixed = slices.fixed_point
    np.testing.assert_allclose(slices.before[:, 20], fixed, rtol=1e-15)
    np.testing.assert_allclose(slices.after[:, 20], fixed, rtol=0, atol=1e-10)  # it repeats itself
    assert len(slices.components) == len(slices.before) == len(slices.after)
    np.testing.assert_allclose(slices.walk[0], (1.0 + PUSH) * fixed)
    # by the greatest multiplier a step, 0.71 with knees: 0.02 * 0.71^20 = 2e-5, and some room for the first steps
    assert np.abs(slices.walk[-1] - fixed).max() < 1e-4
    assert (slices.outcome, slices.settled) == ("walking", None)
    if robot is TABLE_ONE:
        step = ReturnMap(robot, math.radians(degrees)).walk([fixed[0], -fixed[0], slices.before[1, 15], fixed[2]], 1)
        assert step.states[0, 2] == slices.after[1, 15]
        assert np.isnan(slices.after[0, 0])  # 15 % longer a step does not land


@pytest.mark.parametrize(("degrees", "count"), [(3.0, 2), (3.35, 4), (3.41, 8), (3.5, None)])
def test_beyond_doublings_walks_settle_on_more_steps(degrees: float, count: int | None) -> None:
    """On 3.5 degrees they are aperiodic."""
    settled = found(TABLE_ONE, degrees).settled
    assert (None if settled is None else len(settled.states)) == count
    assert settled is None or settled.stable
