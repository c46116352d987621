"""Laws on a sole: their torques against the robot's equations of motion, and recovery steps."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, BoundedKneedController, KneedController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.bounded.bounded_ankle import OnSole, torque
from mjbiped.controllers.bounded.identifier import MOMENTUM
from mjbiped.controllers.bounded.recovery import Step, begin, constraint, planned
from mjbiped.controllers.layout import ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS
from mjbiped.controllers.room import BENT, ROOM
from mjbiped.controllers.slope_estimator import stand_bent
from mjbiped.robots.compass import Array

KNEED = mjbiped.KneedBiped(sole=(0.12, 0.12))
COMPASS = mjbiped.Compass(hip_mass=3.0)
GAIT = mjbiped.find_passive_gait(COMPASS, 0.03)
FOOTED = mjbiped.FootedCompass(hip_mass=3.0, sole=(0.1, 0.15), ankle_height=0.04)
ANGLES, RATES = st.tuples(*[st.floats(-0.5, 0.5)] * 3), st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@cache
def kneed() -> BoundedKneedController:
    return BoundedKneedController(KNEED, mjbiped.find_reference(KNEED, clearance=0.08))


def laws(name: str) -> tuple[OnSole, OnSole | AdaptiveController]:
    """A law on a sole, and one without a sole that asks for the same."""
    if name == "knees":
        return kneed(), replace(kneed(), robot=KNEED.mechanism)
    robot = FOOTED if name == "feet" else replace(COMPASS, sole=(0.05, 0.08))
    return BoundedAnkleController(robot, GAIT), AdaptiveController(COMPASS, GAIT)


def memory_on(law: OnSole | AdaptiveController, slope: float, bent: float) -> list[float]:
    """The memory of the gait's first step, on a slope and on a leg that is bent by so much, rad."""
    memory = [0.0] * law.memory_size
    assert law.gait is not None
    half = len(law.gait.start) // 2
    law.start(memory, law.gait.start[:half].tolist(), law.gait.start[half:].tolist())
    memory[:2] = [slope, 0.7] if isinstance(law, OnSole) else [math.sin(slope), math.cos(slope)]
    if bent:
        memory[BENT] = bent
        stand_bent(law.parameters, memory)
    return memory


@pytest.mark.parametrize("name", ["sole", "feet", "knees"])
@given(ANGLES, RATES, st.floats(-0.3, 0.3), st.sampled_from([0.0, 0.2]))
def test_torques_are_borne_by_the_sole_and_move_the_swing_leg_as_wanted(
    name: str, angles: Sequence[float], rates: Sequence[float], slope: float, bend: float
) -> None:
    """And the identifier follows its equations; all by the robot's own."""
    law, asking = laws(name)
    robot, n, bent, t = law.robot, len(law.robot.angles), bend if name == "knees" else 0.0, 0.3 * law.gait.period
    q, dq = np.array(angles[:n]), np.array(rates[:n])
    chain, memory = robot.chains_on(bent)[n], memory_on(law, slope, bent)
    found, rate, momentum_rate = np.split(np.array(law.torque(memory, t, q.tolist(), dq.tolist())), [n, n + 1])
    asked = np.array(asking.torque(memory_on(asking, slope, bent), t, q.tolist(), dq.tolist())[:n])
    ddq, wanted = (chain.accelerations(robot.input_matrix @ each, q, dq, slope) for each in (found, asked))
    size = max(1.0, *np.abs(ddq), *np.abs(wanted))  # rounding, of numbers of this size
    np.testing.assert_allclose(ddq[1:], wanted[1:], rtol=0, atol=1e-10 * size)
    force = complex(*chain.ground_force(q, dq, ddq, slope)) * np.exp(1j * slope)
    along, normal = force.real, force.imag
    foot = robot.bodies.foot
    moment = found[0] + (foot.height * along if foot else 0.0)
    behind, ahead = np.multiply(law.sole_share, robot.sole or ())
    slack = 1e-9 * max(1.0, abs(normal), abs(moment), *np.abs(asked))
    if not foot:
        assert abs(found[0]) <= abs(asked[0]) + slack
        assert found[0] * asked[0] >= -slack
        assert normal <= 0.0 or -ahead * normal - slack <= moment <= behind * normal + slack
    if normal > 0.0 and abs(found[0] - asked[0]) > slack and abs(moment) > slack:
        assert min(abs(moment - behind * normal), abs(moment + ahead * normal)) <= slack  # no more would be borne
    inertia, error = chain.mass_matrix(q), float(np.sum(chain.mass_matrix(q) @ dq)) - memory[MOMENTUM]
    gravity, by_slope = (-np.sum(chain.gravity_vector(q, angle)) for angle in (slope, slope + 0.5 * math.pi))
    expected = law.adaptation_gain * by_slope * error / np.sum(inertia) ** 2, found[0] + gravity + 20.0 * error
    np.testing.assert_allclose([*rate, *momentum_rate], expected, rtol=1e-10, atol=1e-10)


STEP = Step(0.4, 0.22, -0.5)


@pytest.mark.parametrize("sole", [None, (0.03, 0.05)])
def test_a_recovery_step_gets_onto_its_constraint_in_time_whatever_the_sole_bears(sole: Any) -> None:
    robot, start = mjbiped.Compass(sole=sole), (-0.2, 0.2, 1.0, 0.6)
    law = BoundedAnkleController(robot, GAIT)
    parameters, memory = list(law.parameters), [0.0] * law.memory_size
    for place, value in ((ANKLE_GAIN, 8.0), (ANKLE_RATE, 1.1), (ANKLE_STIFFNESS, 2.0)):
        parameters[place] = value
    begin(memory, STEP, start[:2], start[2:])
    assert planned(memory) == STEP
    assert constraint(STEP, STEP.half) == pytest.approx(-STEP.half, abs=1e-15)  # the feet come down together

    def torques(t: float, state: Sequence[float] | Array) -> Array:
        out = [0.0] * (ROOM + 48)
        torque(parameters, memory, t, state[:2], state[2:], out)  # type: ignore[arg-type]
        return np.array(out[:2])

    def rate(t: float, state: Array) -> Array:
        forces = robot.input_matrix @ torques(t, state)
        return np.concatenate([state[2:], robot.chains[2].accelerations(forces, state[:2], state[2:], 0.0)])

    done = solve_ivp(rate, (0.0, 0.55), start, method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.005)
    q1, q2, dq1, dq2 = done.y[:, done.t >= STEP.time]
    assert np.abs(q2 - [constraint(STEP, q) for q in q1]).max() < 1e-9  # the integration's
    assert np.abs(dq2 - (1.0 - STEP.retraction) * dq1).max() < 1e-7
    assert np.ptp(done.y[0]) > 0.1  # the stance leg has moved meanwhile
    for angle, lack in ((-0.3, -0.4), (0.0, 0.0), (0.3, 0.7)):
        ankle, _ = torques(0.1, (angle, 0.1, math.hypot(1.1, 2.0 * angle) - lack, 0.5))
        assert sole or ankle == pytest.approx(8.0 * lack, abs=1e-13)  # the ankle drives toward its rate


STAIRS = mjbiped.Terrain.from_segments([(1.3, 0.0, 0.0), *[(1.8, 0.0, 0.03)] * 4])


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_it_climbs_stairs_on_which_the_paper_s_law_falls(engine: str) -> None:
    law, plain = kneed(), KneedController(KNEED, kneed().gait)
    walk, clipped = (mjbiped.walk(each, STAIRS, engine=engine, steps=16) for each in (law, plain))
    assert clipped.outcome in ("fell", "slipped")
    assert walk.verdict == "finished"
    if engine == "mujoco":
        return
    # the law leans on its share of the sole
    assert walk.summary()["share_of_time_at_sole_bound"] == 0.0
    # a rad of error of the slope's estimate changes the normal force by some ten times itself
    error = 10.0 * 0.12 * np.abs(walk.samples["slope_estimate"]).max()
    assert walk.touchdowns["pressure_behind"].max() == pytest.approx(0.95 * 0.12, abs=error)
    assert error < 1e-3
    for k, (_, memory) in enumerate(replayed(walk, law)):
        if k > 0:  # the prediction begins with the momentum of each step
            q, dq = walk.touchdowns["q"][k - 1], walk.touchdowns["dq"][k - 1]
            mass = KNEED.chains_on(memory[BENT])[3].mass_matrix(q)
            assert memory[MOMENTUM] == pytest.approx(np.sum(mass @ dq), rel=1e-12)
