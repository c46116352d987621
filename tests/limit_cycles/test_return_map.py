"""The return map against an integration of its own by SciPy, against the hybrid engine, and against physics."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from controllers import PassiveController
from mjbiped.errors import InputError
from mjbiped.gaits.described import passive_gait_of
from mjbiped.limit_cycles.map_slices import PUSH, MapSlices, map_slices
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.compass import Array, Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

TABLE_ONE, KNEED, WHEEL = Compass(), mjbiped.KneedBiped(), mjbiped.RimlessWheel()
MOON = Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62)
SLENDER = Compass(leg_mass=2.0, hip_mass=20.0, lower_length=0.8, upper_length=0.2, leg_inertia=0.01)
slow = pytest.mark.slow


def scipy_step(robot: Compass, slope: float, start: Array, rule: ScuffingRule) -> tuple[float, Array] | str:
    """One step by DOP853 from the matrices; touchdown ends the first stretch above ground in which the rule is met."""

    def rates(_: float, state: Array) -> Array:
        q, dq = state[:2], state[2:]
        force = -robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
        return np.concatenate([dq, np.linalg.solve(robot.mass_matrix(q), force)])

    def height(_: float, state: Array) -> float:
        return float(robot.swing_foot(state[:2])[1])

    def fallen(_: float, state: Array) -> float:
        return math.cos(state[0]) - 0.5

    fallen.terminal = True  # type: ignore[attr-defined]
    limit = 10 * math.sqrt(robot.leg_length / robot.gravity)
    accuracy: Any = {"rtol": 1e-13, "atol": 1e-14, "dense_output": True, "max_step": limit / 150}
    solution: Any = solve_ivp(rates, (0, limit), start, "DOP853", events=(height, fallen), **accuracy)
    turn = np.array([[math.cos(slope), math.sin(slope)], [-math.sin(slope), math.cos(slope)]])
    crossings = [0.0, *solution.t_events[0]]
    for begin, end in pairwise(crossings):
        times = np.linspace(begin, end, 501)[1:-1]
        feet = np.array([robot.swing_foot(state[:2]) for state in solution.sol(times).T])
        ahead, reach = (feet @ turn.T)[:, 0], rule.reach * robot.leg_length
        collides = ((times > rule.delay) & (ahead >= reach)).any() and ahead[-1] >= reach  # and is not drawn in again
        if (feet[:, 1] > -1e-6).all() and collides:
            before = solution.y_events[0][crossings.index(end) - 1]
            return float(end), np.concatenate(robot.impact(before[:2], before[2:]))
    return "fell" if len(solution.t_events[1]) else "stalled"


@slow
@pytest.mark.parametrize("robot", [TABLE_ONE, MOON, SLENDER])
def test_one_step_against_scipy(robot: Compass) -> None:
    """From states around the gait, and from wild ones."""
    slope, rule = math.radians(2.5), ScuffingRule()
    gait = mjbiped.find_passive_gait(robot, slope)
    random = np.random.default_rng(3)
    landed = 0
    for spread in (0.0, *[0.05] * 4, *[0.6] * 8):
        q1, _, dq1, dq2 = gait.start * (1 + spread * random.uniform(-1, 1, 4))
        start = np.array([q1, -q1, dq1, dq2])
        expected, found = scipy_step(robot, slope, start, rule), ReturnMap(robot, slope, rule).walk(start, 1)
        if isinstance(expected, str):
            assert (found.outcome, len(found.states)) == (expected, 0)
            continue
        landed += 1
        scale = np.abs(expected[1]).max()
        # wild states need shorter integration steps, of which each is good to 1e-9
        tolerance = 1e-10 if spread < 0.1 else 5e-9
        np.testing.assert_allclose(found.states[0], expected[1], rtol=0, atol=tolerance * scale)
        assert found.periods[0] == pytest.approx(expected[0], rel=tolerance)
    assert landed > 4


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
        PassiveController(),
        terrain,
        engine="hybrid",
        robot=robot,
        initial=start.tolist(),
        steps=steps,
        sample_period=None,
    )
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    found = ReturnMap(robot, terrain.slope_at(0.0)).walk(start, steps)
    assert len(found.states) == walk.steps > 5
    np.testing.assert_allclose(found.states, states, rtol=0, atol=tolerance)
    np.testing.assert_allclose(np.cumsum(found.periods), walk.touchdowns["time"], rtol=0, atol=late)


@given(st.floats(0.15, 0.3), st.floats(0.9, 2.0), st.floats(-1, 2), st.floats(0.2, 5))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_energy_is_kept_between_impacts_and_lost_at_them(q: float, dq1: float, dq2: float, degrees: float) -> None:
    """Undo the impact: the state before it must have the energy of the step's start, in the potential of one plane."""
    slope = math.radians(degrees)
    steps = ReturnMap(TABLE_ONE, slope).walk([-q, q, dq1, dq2], 3)
    state = np.array([-q, q, dq1, dq2])
    for after in steps.states:
        # the impact map is linear in the rates: what was before it
        q_before = after[[1, 0]]
        columns = [TABLE_ONE.impact(q_before, rate)[1] for rate in np.eye(2)]
        before = np.linalg.solve(np.column_stack(columns), after[2:])
        energy = TABLE_ONE.energy(state[:2], state[2:], slope)
        # the integration's error, magnified by the inverse impact map
        assert TABLE_ONE.energy(q_before, before, slope) == pytest.approx(energy, rel=1e-8)
        assert TABLE_ONE.kinetic_energy(after[:2], after[2:]) <= TABLE_ONE.kinetic_energy(q_before, before)
        assert TABLE_ONE.swing_foot(after[:2])[1] == pytest.approx(0, abs=1e-12)  # on the plane: Newton's last change
        state = after


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


@pytest.mark.parametrize(("swing", "swing_rate", "steps"), [(-1.02, 3.0, 1), (-1.06, 0.0, 0)])
def test_touchdown_and_fall_within_one_integration_step(swing: float, swing_rate: float, steps: int) -> None:
    """The stance leg, at 57 degrees, passes 60 some 23 ms later; the foot lands before (after 4 ms) or would after."""
    found = ReturnMap(TABLE_ONE, math.radians(2), ScuffingRule(delay=0.0)).walk([1.0, swing, 2.0, swing_rate], 1)
    assert (len(found.states), found.outcome) == (steps, "walking" if steps else "fell")


def test_a_step_depends_on_its_first_state_alone(robot: Compass) -> None:
    """Nothing is left of the steps before: neither place nor time, nor the length of an integration step."""
    walked = ReturnMap(robot, math.radians(3.5)).walk([-0.24, 0.24, 1.4, 0.9], 20)
    for before, after, period in zip(walked.states, walked.states[1:], walked.periods[1:], strict=False):
        alone = ReturnMap(robot, math.radians(3.5)).walk(before, 1)
        assert (alone.states[0].tolist(), alone.periods[0]) == (after.tolist(), period)


@pytest.mark.parametrize(
    ("robot", "state"),
    [
        (TABLE_ONE, [1, 2, 3, math.nan]),
        (TABLE_ONE, "abcd"),
        (KNEED, [-0.2, 0.2, 1.0, 0.5]),
        (KNEED, [-0.2, 0.2, 0.3, 1.0, 0.5, 0.5]),  # bent
        (KNEED, [-0.3, 0.3, 0.3, 1.0, 0.5, 0.6]),  # which bends at once
        (mjbiped.RoundKneed(), [-0.3, 0.3, 0.3, 1.0, 0.5, 0.4]),  # forwards
    ],
)
def test_states_are_checked(robot: Robot, state: Any) -> None:
    with pytest.raises(InputError, match=r"^state"):
        ReturnMap(robot, 0.03).walk(state, 1)


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
    if robot is WHEEL:
        # the square of the rate after an impact is the one before it, and what falling adds, times the square kept
        hub, fallen = WHEEL.mass * WHEEL.length**2 + WHEEL.inertia, 2 * WHEEL.length * math.sin(WHEEL.between / 2)
        gained = 2 * WHEEL.weight * fallen * math.sin(math.radians(degrees)) / hub
        rolls = ~np.isnan(slices.after)
        expected = WHEEL.kept * np.sqrt(slices.before**2 + gained)
        np.testing.assert_allclose(slices.after[rolls], expected[rolls], rtol=1e-9)  # the integration's tolerance


@pytest.mark.parametrize(("degrees", "count"), [(3.0, 2), (3.35, 4), (3.41, 8), (3.5, None)])
def test_beyond_doublings_walks_settle_on_more_steps(degrees: float, count: int | None) -> None:
    """On 3.5 degrees they are aperiodic."""
    settled = found(TABLE_ONE, degrees).settled
    assert (None if settled is None else len(settled.states)) == count
    assert settled is None or settled.stable
