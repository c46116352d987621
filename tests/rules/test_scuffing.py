"""The scuffing rule: which gaits it lets walk, and how those that it does not are refused."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from command_line import run
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.limit_cycles.basin import basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.bifurcation import bifurcation_diagram
from mjbiped.rules.scuffing import ScuffingRule, check_landing, swing_foot_collides

TABLE_ONE = mjbiped.Compass()
GENTLE = (0.1, 0.2, 0.28)
"""Slopes (deg) within the paper's range (0, 2.72) on which a step is shorter than the default reach."""


def gait_on(slope_deg: float) -> mjbiped.Gait:
    return mjbiped.find_passive_gait(TABLE_ONE, math.radians(slope_deg))


LAW = AdaptiveController(TABLE_ONE, gait_on(0.2))


def at_touchdown(gait: mjbiped.Gait, slope: float) -> float:
    """How far ahead of the stance foot the swing foot comes down, horizontally, leg lengths; by vectors."""
    along, above = TABLE_ONE.swing_foot(gait.reference(gait.period)[0])
    return float(along * math.cos(slope) + above * math.sin(slope))


@pytest.mark.parametrize("slope_deg", GENTLE)
def test_any_reach_up_to_the_step_walks_and_none_beyond_it(slope_deg: float) -> None:
    """In the hybrid engine; the greatest reach is the step's horizontal length."""
    gait, terrain = gait_on(slope_deg), mjbiped.Terrain.incline(slope_deg)
    most = gait.step_length * math.cos(gait.slope)

    def walked(rule: ScuffingRule, **terms: Any) -> mjbiped.Walk:
        given = {"steps": 20, "sample_period": None, "scuffing": rule, **terms}
        return mjbiped.walk(PassiveController(), terrain, engine="hybrid", **given)

    assert at_touchdown(gait, gait.slope) == pytest.approx(most, rel=1e-9)  # the gait finder's 1e-12, over 0.1 m
    for reach in (0.0, 0.5 * most, most - 1e-5):
        walk = walked(ScuffingRule(reach))
        # the rule says when the foot may land, not how it moves; the engine keeps states to 1e-10
        states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
        np.testing.assert_allclose(states, np.tile(gait.start, (20, 1)), rtol=0, atol=1e-9)
    beyond = ScuffingRule(reach=most + 1e-5)
    with pytest.raises(mjbiped.InputError, match="shorter reach"):
        walked(beyond)
    # and it is not refused for nothing: the same first state as numbers, of which no gait is known
    fallen = walked(beyond, initial=gait.start.tolist(), steps=3)
    assert (fallen.outcome, fallen.steps) == ("fell", 0)


@pytest.mark.parametrize("initial", ["gait", "rest", (-0.07, 0.07, 0.4, 0.3)])
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_an_imitated_gait_is_refused_wherever_it_begins(engine: str, initial: Any) -> None:
    controller = AdaptiveController(TABLE_ONE, gait_on(0.28))
    with pytest.raises(mjbiped.InputError, match=r"0\.192 leg lengths .*reach=0\.09.*--scuffing-reach 0\.09"):
        mjbiped.walk(controller, mjbiped.Terrain.level(), engine=engine, initial=initial)


def test_rule_holds_on_the_ground_that_is_walked_on() -> None:
    """Horizontally: 6 degrees uphill the same posture reaches less far than on the level."""
    gait = gait_on(0.32)
    controller: Controller = AdaptiveController(TABLE_ONE, gait)
    uphill = mjbiped.Terrain.incline(-6.0)
    assert at_touchdown(gait, uphill.slope_at(0.0)) < 0.2 < at_touchdown(gait, 0.0)
    assert mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=3).outcome == "finished"
    with pytest.raises(mjbiped.InputError, match="scuffing rule"):
        mjbiped.walk(controller, uphill, engine="hybrid", steps=3)


def test_delay_longer_than_the_step_is_told() -> None:
    gait = gait_on(2.0)
    check_landing(gait, gait.slope, ScuffingRule(delay=gait.period - 1e-6))
    with pytest.raises(mjbiped.InputError, match=r"0\.765 s.*delay=0\.3"):
        check_landing(gait, gait.slope, ScuffingRule(delay=gait.period))


@pytest.mark.parametrize(
    "call",
    [
        lambda: mjbiped.walk(PassiveController(), mjbiped.Terrain.incline(0.31), engine="hybrid"),
        lambda: mjbiped.walk_many(LAW, [mjbiped.Terrain.level()], engine="hybrid", steps=1),
        lambda: basin_of_attraction(TABLE_ONE, math.radians(0.2)),
        lambda: basin_of_control(LAW),
        lambda: bifurcation_diagram(TABLE_ONE, np.radians([0.2, 0.4])),
    ],
)
def test_walks_and_maps_are_refused(call: Callable[[], object]) -> None:
    with pytest.raises(mjbiped.InputError, match="scuffing rule"):
        call()


PASSIVE = "walk incline:slope_deg=0.2 --controller passive --engine mujoco --steps 3"


def test_the_command_line_names_the_cure_and_takes_it() -> None:
    words = PASSIVE.split()
    refused = run(*words)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "--scuffing-reach 0.08" in refused.stderr
    walked = run(*words, "--scuffing-reach", 0.08, "--json")
    assert walked.exit_code == 0
    assert '"outcome": "finished"' in walked.stdout
    assert '"reach": 0.08' in walked.stdout
    assert run(*words, "--scuffing-reach", -1).exit_code == 2


def test_all_three_conditions_must_hold() -> None:
    assert swing_foot_collides(0.2, 0.1, 0.2, 0.2, 1e-9)
    for time, ahead, clearance in ((0.1, 0.3, 0.1), (0.2, 0.19, 0.1), (0.2, 0.3, 0.0)):
        assert not swing_foot_collides(0.2, 0.1, time, ahead, clearance)


SWINGS_BACK = (-0.15, 0.15, 0.8, -0.5)
"""From here the second step's swing foot comes ahead of the reach, swings back, and is level with the stance foot."""


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_foot_that_comes_back_to_the_stance_foot_makes_no_step(engine: str) -> None:
    walk = mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), engine=engine, steps=2, initial=SWINGS_BACK)
    assert (walk.outcome, walk.steps) == ("fell", 1)


@given(
    st.tuples(st.floats(-0.3, -0.1), st.floats(0.2, 1.4), st.floats(-1.5, 1.5)),
    st.floats(0.0, 3.0),
    st.floats(0.0, 0.3),
)
def test_no_step_is_shorter_than_the_reach(start: tuple[float, float, float], slope_deg: float, reach: float) -> None:
    q1, dq1, dq2 = start
    walked = mjbiped.ReturnMap(TABLE_ONE, math.radians(slope_deg), ScuffingRule(reach)).walk((q1, -q1, dq1, dq2), 5)
    legs = np.sin(walked.states[:, :2] + math.radians(slope_deg))
    assert (legs[:, 1] - legs[:, 0] >= reach - 1e-8).all()  # where a touchdown is found to 1e-8 s
