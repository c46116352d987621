"""The return map against an integration of its own by SciPy, against the hybrid engine, and against physics."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from controllers import PassiveController
from mjbiped.errors import InputError
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.robots.compass import Array, Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

TABLE_ONE = Compass()
MOON = Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62)
SLENDER = Compass(leg_mass=2.0, hip_mass=20.0, lower_length=0.8, upper_length=0.2, leg_inertia=0.01)


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
    solution = solve_ivp(
        rates,
        (0, limit),
        start,
        "DOP853",
        events=(height, fallen),
        rtol=1e-13,
        atol=1e-14,
        dense_output=True,
        max_step=limit / 150,
    )
    assert solution.sol is not None
    assert solution.t_events is not None
    assert solution.y_events is not None
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


@pytest.mark.slow
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


@pytest.mark.parametrize("degrees", [0.5, 2.0, 3.35])
def test_many_steps_against_the_gait_and_the_hybrid_engine(degrees: float) -> None:
    """The same states as `walk(..., engine="hybrid")`, whose integration steps are adaptive."""
    terrain = Terrain.incline(degrees)
    gait = mjbiped.find_passive_gait(TABLE_ONE, math.radians(degrees))
    start = gait.start * [1.02, 1.02, 1.0, 1.03]
    walk = mjbiped.walk(
        PassiveController(),
        terrain,
        engine="hybrid",
        robot=TABLE_ONE,
        initial=start.tolist(),
        steps=40,
        sample_period=1.0,
    )
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    found = ReturnMap(TABLE_ONE, terrain.slope_at(0.0)).walk(start, 40)
    assert len(found.states) == walk.steps > 5
    # the engine's error at its tolerance of 1e-10 a step: at 1e-13 the difference on 3.35 degrees is 1e-10
    tolerance = 1e-9 if degrees < 3 else 5e-9
    np.testing.assert_allclose(found.states, states, rtol=0, atol=tolerance)
    np.testing.assert_allclose(np.cumsum(found.periods), walk.touchdowns["time"], rtol=0, atol=tolerance)


def test_gait_is_a_fixed_point(robot: Compass, gait: mjbiped.Gait) -> None:
    steps = ReturnMap(robot, gait.slope).walk(gait.start, 200)
    # the root finder's 1e-12 and the integration's error, both damped by the gait's stability
    np.testing.assert_allclose(steps.states, np.tile(gait.start, (200, 1)), rtol=0, atol=5e-11)
    np.testing.assert_allclose(steps.periods, gait.period, rtol=0, atol=5e-11)


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


def test_motion_scales_with_mass_length_and_gravity(gait: mjbiped.Gait) -> None:
    giant = Compass(leg_mass=50.0, lower_length=2.0, upper_length=2.0, gravity=9.81 / 4)
    units = np.array([1, 1, 4, 4])
    start = gait.start * [1.02, 1.02, 1.0, 1.03]
    small = ReturnMap(TABLE_ONE, gait.slope).walk(start, 10)
    great = ReturnMap(giant, gait.slope, ScuffingRule(delay=0.4)).walk(start / units, 10)
    np.testing.assert_allclose(great.states * units, small.states, rtol=0, atol=1e-12)  # rounding


@pytest.mark.parametrize(
    ("state", "outcome"),
    [
        ((-0.19, 0.19, 0.0, 0.0), "fell"),  # backwards
        ((-0.19, 0.19, 6.0, 0.0), "fell"),  # too fast for the swing leg
        ((0.0, 0.0, 1e9, -1e9), "fell"),  # within a nanosecond, which the engine's steps resolve
    ],
)
def test_failures_have_names(state: tuple[float, ...], outcome: str, robot: Compass) -> None:
    steps = ReturnMap(robot, math.radians(2)).walk(state, 5)
    assert steps.outcome == outcome
    assert len(steps.states) == len(steps.periods) < 5


def test_stalled(robot: Compass) -> None:
    """Feet together at rest on level ground: nothing ever moves."""
    assert ReturnMap(robot, 0.0).walk([0, 0, 0, 0], 1).outcome == "stalled"


def test_rule_makes_gentle_gaits_fall(robot: Compass) -> None:
    """Steps shorter than the rule's reach are none: with it nothing walks below some 0.3 degrees."""
    slope = math.radians(0.25)
    start = mjbiped.find_passive_gait(robot, slope).start
    assert ReturnMap(robot, slope).walk(start, 20).outcome == "fell"
    assert ReturnMap(robot, slope, ScuffingRule(reach=0.0, delay=0.0)).walk(start, 20).outcome == "walking"


def test_rule_measures_horizontally(robot: Compass) -> None:
    """As the engines do, not along the slope: on 5 degrees the two differ."""
    slope = math.radians(5)
    gait = mjbiped.find_passive_gait(robot, slope)
    step = gait.step_length * math.cos(slope)
    assert gait.step_length - step > 1e-3
    for reach, outcome in ((step - 1e-5, "walking"), (step + 1e-5, "fell")):
        assert ReturnMap(robot, slope, ScuffingRule(reach, 0.1)).walk(gait.start, 1).outcome == outcome


@pytest.mark.parametrize(("swing", "swing_rate", "steps"), [(-1.02, 3.0, 1), (-1.06, 0.0, 0)])
def test_touchdown_and_fall_within_one_integration_step(
    swing: float, swing_rate: float, steps: int, robot: Compass
) -> None:
    """The stance leg, at 57 degrees, passes 60 some 23 ms later; the foot lands before (after 4 ms) or would after."""
    rule, slope = ScuffingRule(delay=0.0), math.radians(2)
    found = ReturnMap(robot, slope, rule).walk([1.0, swing, 2.0, swing_rate], 1)
    assert len(found.states) == steps
    assert found.outcome == ("walking" if steps else "fell")


def test_a_step_depends_on_its_first_state_alone(robot: Compass) -> None:
    """Nothing is left of the steps before: neither place nor time, nor the length of an integration step."""
    walked = ReturnMap(robot, math.radians(3.5)).walk([-0.24, 0.24, 1.4, 0.9], 20)
    for before, after, period in zip(walked.states, walked.states[1:], walked.periods[1:], strict=False):
        alone = ReturnMap(robot, math.radians(3.5)).walk(before, 1)
        assert alone.states[0].tolist() == after.tolist()
        assert alone.periods[0] == period


def test_bitwise_deterministic(robot: Compass) -> None:
    one, two = (ReturnMap(robot, math.radians(3.5)).walk([-0.24, 0.24, 1.4, 0.9], 200) for _ in range(2))
    assert one.states.tobytes() == two.states.tobytes()
    assert one.periods.tobytes() == two.periods.tobytes()


@pytest.mark.parametrize("state", [[1, 2, 3], [1, 2, 3, math.nan], "abcd", None])
def test_states_are_checked(state: object, robot: Compass) -> None:
    with pytest.raises(InputError, match=r"^state"):
        ReturnMap(robot, 0.03).walk(state, 1)  # type: ignore[arg-type]


def test_other_arguments_are_checked(robot: Compass) -> None:
    with pytest.raises(InputError, match="slope"):
        ReturnMap(robot, 2.0)
    with pytest.raises(InputError, match="slope"):
        ReturnMap(robot, math.nan)
    with pytest.raises(InputError, match="steps"):
        ReturnMap(robot, 0.03).walk([0, 0, 0, 0], 0)
