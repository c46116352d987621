"""What the engine keeps from one physics step to the next, against the geometry and mechanics that it stands for."""

import math
from typing import Any

import pytest
from hypothesis import strategies as st
from standing import GROUND, LENGTH, SLOPE, Posture, begun, constants, standing_at

from mjbiped.disturbances.chance import Pushes
from mjbiped.engines.mujoco import motors, observation
from mjbiped.engines.mujoco.state import State
from mjbiped.rules.termination import Outcome

angles, rates = st.floats(-0.5, 0.5), st.floats(-3.0, 3.0)


def observe(u: State, time: float, state: Posture, **changed: Any) -> Any:
    """Take a state in; returns the touchdown's row."""
    c = constants(state, **changed)
    observation.observe(c, u, time)
    return c.row


def fallen(low: float) -> tuple[float, float]:
    """The hip at so many leg lengths over the ground, along its normal."""
    return 0.05, GROUND.height_at(0.05) + low * LENGTH / math.cos(SLOPE)


STILL = (0.0, GROUND.height_at(0.0))


@pytest.mark.parametrize(
    ("hip", "foot", "time", "outcome"),
    [
        (fallen(0.501), STILL, 1.0, Outcome.WALKING),
        (fallen(0.499), STILL, 1.0, Outcome.FELL),
        (fallen(1.0), STILL, 10.01 * math.sqrt(LENGTH / 9.81), Outcome.STALLED),
        (fallen(1.0), STILL, 9.99 * math.sqrt(LENGTH / 9.81), Outcome.WALKING),
        (fallen(1.0), (0.101 * LENGTH, STILL[1] - 0.101 * LENGTH * math.tan(SLOPE)), 1.0, Outcome.SLIPPED),
        (fallen(1.0), (0.0, STILL[1] + 0.101 * LENGTH), 1.0, Outcome.SLIPPED),
        (fallen(1.0), (0.0, STILL[1] + 0.099 * LENGTH), 1.0, Outcome.WALKING),
        (fallen(1.0), (0.0, STILL[1] - 0.03 * LENGTH), 1.0, Outcome.DIVERGED),
        (fallen(1.0), (0.0, STILL[1] - 0.019 * LENGTH), 1.0, Outcome.WALKING),
        ((3.01, 1.2), STILL, 1.0, Outcome.LEFT_TERRAIN),
        ((-3.01, 1.4), STILL, 1.0, Outcome.LEFT_TERRAIN),
    ],
)
def test_how_a_walk_ends(hip: tuple[float, float], foot: tuple[float, float], time: float, outcome: Outcome) -> None:
    u = begun(standing_at(0.0, 0.1, -0.2))
    u.time, u.q[:3] = time, (*hip, 0.1)
    observation.judge(constants(), u, *foot)
    assert Outcome(int(u.outcome)) is outcome


@pytest.mark.parametrize(
    ("count", "x", "outcome"),
    [
        (8, 0.5, Outcome.WALKING),
        (9, 0.5, Outcome.FINISHED),
        (3, 2.0 + 1e-9, Outcome.FINISHED),
        (3, 2.0 - 1e-9, Outcome.WALKING),
        (3, 3.0 + 1e-9, Outcome.LEFT_TERRAIN),  # the foot has, the hip not yet
    ],
)
def test_a_walk_is_finished_by_steps_or_by_distance(count: int, x: float, outcome: Outcome) -> None:
    u = begun(standing_at(0.0, 0.1, -0.2))
    u.noted, u.count = 1.0, count - 1.0
    observe(u, 0.7, standing_at(x, -0.2, 0.1, left=False), distance=2.0 if x < 2.5 else math.inf)
    assert (u.count, Outcome(int(u.outcome))) == (count, outcome)


def ahead(distance: float) -> Posture:
    """The swing foot so far ahead of the stance foot and clear of the ground, m."""
    state = standing_at(0.0, 0.05, math.asin(0.05 - distance / LENGTH))
    state[0][1] += 0.1  # as if the stance leg were longer
    return state


@pytest.mark.parametrize(
    ("enabled", "reach", "time", "expected"),
    [(0, 0.2, 0.2, 1), (0, 0.15, 0.2, 0), (0, 0.2, 0.09, 0), (1, 0.2, 0.2, 1), (1, 0.1, 0.2, 0), (1, 0.2, 0.0, 1)],
)
def test_the_scuffing_rule_lets_the_swing_foot_collide(enabled: int, reach: float, time: float, expected: int) -> None:
    """0.18 m ahead at least, 0.1 s after the transfer, in the air; drawn in, it ceases to."""
    u = begun(ahead(reach))
    u.enabled = float(enabled)
    observe(u, time, ahead(reach))
    assert u.enabled == expected


@pytest.mark.parametrize("late", [-1e-12, 0.0, 1e-12])
def test_a_push_begins_in_the_physics_step_at_its_time(late: float) -> None:
    """Half of it acts after that time, by the middle of the step; times are the same within rounding."""
    pushes, u = Pushes([0.3], [2.0], 1, 0.1, 0.0, 0.0, 0, 0), State()
    u.next_push, u.push_impulse, u.time = 0.3, 2.0, 0.3 + late
    u.planned = u.last_step = 1e-3
    motors.push(constants(pushes=[pushes]), u)
    assert u.pushing == 1.0
    assert u.push == pytest.approx(0.5 * 2.0 / 0.1, rel=1e-8)


def test_a_push_ends_when_nothing_but_rounding_is_left_of_its_impulse() -> None:
    pushes, u = Pushes([0.3, 0.9], [2.0, -2.0], 2, 0.1, 0.0, 0.0, 0, 0), State()
    u.next_push, u.push_impulse, u.time = 0.3, 2.0, 0.4
    u.planned = u.last_step = 1e-3
    u.pushing, u.push_left = 1.0, 1.5e-12  # of 2 N s
    motors.push(constants(pushes=[pushes]), u)
    assert (u.pushing, u.push, u.pushes, u.next_push, u.push_impulse) == (0.0, 0.0, 1.0, 0.9, -2.0)
