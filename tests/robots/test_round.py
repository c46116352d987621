"""Robots that roll: where round feet touch the ground, what knees do on them, and the wheel's closed form."""

import math

import golden_numbers
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from simulations import Plain

import mjbiped
from mjbiped.controllers import PassiveController
from mjbiped.errors import InputError
from mjbiped.gaits.passive import find_rolling
from mjbiped.robots.round import RoundCompass, RoundKneed

SLOPE, KNEED_SLOPE = math.radians(1.6), 0.0456


def test_it_walks_on_planes_alone() -> None:
    for ground in (mjbiped.Terrain.stairs(tread=1.0, rise=0.01), mjbiped.Terrain.slopes(length=1.5, change_deg=0.3)):
        with pytest.raises(InputError, match="a RoundCompass walks on planes"):
            mjbiped.walk(PassiveController(), ground, robot=RoundCompass(), steps=1)


def test_on_feet_that_are_too_large_the_robot_stands() -> None:
    """The stance leg topples as long as the mass on it is higher than the arc's centre: m (a - R) + m (l - R) > 0."""
    assert mjbiped.find_passive_gait(RoundCompass(foot_radius=0.7), 0.1 * SLOPE).period > 0.0
    with pytest.raises(mjbiped.GaitError, match="on feet as large as these the robot stands"):
        mjbiped.find_passive_gait(RoundCompass(foot_radius=0.75), SLOPE)


def test_arcs_touch_the_ground_where_they_stand() -> None:
    """The lowest point of the drawn arc of an upright leg is the leg's end, and the arc is no longer than twice ARC."""
    robot = RoundCompass(foot_radius=0.3)
    lines = robot.outline([0.0, 1.0, 0.0, 0.4])
    assert lines.shape == (2, 18, 2)
    golden_numbers.check("outline of arcs", {"all": lines})
    np.testing.assert_allclose(lines[0, 1], [0.0, 0.0], atol=1e-15)
    assert lines[0, :, 1].min() == pytest.approx(0.0, abs=1e-15)
    centres = robot.limbs([0.0, 1.0, 0.0, 0.4])[:, 0] - 0.7 * np.array([[0.0, 1.0], [math.sin(0.4), math.cos(0.4)]])
    np.testing.assert_allclose(np.linalg.norm(lines[:, 2:] - centres[:, None], axis=-1), 0.3, rtol=1e-12)
    np.testing.assert_array_equal(mjbiped.Compass().outline([0.0, 1.0, 0.0, 0.4]), robot.limbs([0.0, 1.0, 0.0, 0.4]))


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_hip_over_large_feet_has_not_fallen(engine: str) -> None:
    """It is 0.5 leg lengths above the arcs' centres, and those are 0.5 above the ground."""
    robot = RoundCompass(foot_radius=0.5)
    gait = mjbiped.find_passive_gait(robot, SLOPE)
    golden_numbers.check("gait of round legs", golden_numbers.gait(gait))
    ground = mjbiped.Terrain.incline(math.degrees(SLOPE))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine=engine, steps=2, initial=gait.start)
    assert (walk.outcome, walk.steps) == ("finished", 2)


def test_states_after_a_touchdown_are_those_that_a_heel_strike_leaves() -> None:
    """With a knee that opens, and with one that the stop holds."""
    robot, opened = RoundKneed(), []
    for stance, swing in ((1.2, 0.4), (1.0, 2.5), (-1.0, 2.0)):
        q, dq = robot.heel_impact([0.3, -0.3], [stance, swing])
        state = np.concatenate([q, dq])
        np.testing.assert_allclose(robot.after_touchdown(state[[0, 3, 4]]), state, rtol=0, atol=1e-13)
        opened.append(bool(dq[2] > dq[1]))
    assert set(opened) == {False, True}


def test_a_foot_that_comes_down_on_a_bent_knee_trips_the_robot() -> None:
    gait = mjbiped.find_kneed_gait(RoundKneed(), KNEED_SLOPE)
    late = gait.start * [1.0, 1.0, 1.0, 1.6, 1.0, 1.0]
    ground = mjbiped.Terrain.incline(math.degrees(KNEED_SLOPE))
    walk = mjbiped.walk(Plain(), ground, robot=RoundKneed(), engine="hybrid", steps=3, initial=late)
    assert (walk.outcome, walk.steps) == ("fell", 0)


WHEEL_SLOPE = math.radians(5)
HUB = mjbiped.RimlessWheel()
HEAVY = mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.8, gravity=3.7)
ODD = mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.8, spokes=11, gravity=3.7)


def rate_after(robot: mjbiped.RimlessWheel, rate: float) -> float:
    """Rate just after the next impact, by energy and angular momentum."""
    hub, half = robot.mass * robot.length**2, math.pi / robot.spokes
    inertia = hub + robot.inertia
    fall = 4 * robot.mass * robot.gravity * robot.length * math.sin(half) * math.sin(WHEEL_SLOPE)
    return (hub * math.cos(2 * half) + robot.inertia) / inertia * math.sqrt(rate**2 + fall / inertia)


def test_the_steady_rate_is_the_textbooks() -> None:
    """Without inertia: cot 2a sqrt(4 (g/l) sin a sin slope)."""
    half = math.pi / 8
    told = math.sqrt(4 * 9.81 * math.sin(half) * math.sin(WHEEL_SLOPE)) / math.tan(2 * half)
    assert HUB.rolling_rate(WHEEL_SLOPE) == pytest.approx(told, rel=1e-14)
    for robot in (HUB, HEAVY, ODD):
        steady = robot.rolling_rate(WHEEL_SLOPE)
        assert rate_after(robot, steady) == pytest.approx(steady, rel=1e-14)


def test_a_wheel_turns_round_and_its_spokes_stand_again() -> None:
    wheel = mjbiped.RimlessWheel()
    ground, law = mjbiped.Terrain.incline(5.0), PassiveController()
    for engine in ("hybrid", "mujoco"):
        walk = mjbiped.walk(law, ground, robot=wheel, engine=engine, steps=wheel.spokes + 2)
        assert (walk.outcome, walk.steps) == ("finished", wheel.spokes + 2)
        assert np.abs(walk.samples["q"]).max() == pytest.approx(math.pi / wheel.spokes, abs=1e-4), engine


def test_steady_rolling_is_a_gait() -> None:
    """Its period is that of the pendulum between two impacts, its multiplier that of the rate."""
    gait = find_rolling(ODD, WHEEL_SLOPE)
    half, inertia, moment = math.pi / 11, 3.0 * 0.8**2 + 0.7, 3.0 * 3.7 * 0.8

    def fall(_: float, state: NDArray[np.float64]) -> list[float]:
        return [state[1], moment * math.sin(state[0] + WHEEL_SLOPE) / inertia]

    def lands(_: float, state: NDArray[np.float64]) -> float:
        return float(state[0]) - half

    lands.terminal = True  # type: ignore[attr-defined]
    step = solve_ivp(fall, (0.0, 5.0), gait.start, events=lands, rtol=1e-11, atol=1e-12)
    assert gait.period == pytest.approx(step.t[-1], rel=1e-9)
    near, far = (rate_after(ODD, gait.start[1] * (1 + change)) for change in (-1e-6, 1e-6))
    assert gait.multipliers.real == pytest.approx([(far - near) / (2e-6 * gait.start[1])], rel=1e-8)
    assert gait.step_length == pytest.approx(2 * 0.8 * math.sin(half))
    assert gait.stable
    assert np.concatenate(gait.reference(gait.period)[:2]) == pytest.approx(gait.end, abs=1e-9)
