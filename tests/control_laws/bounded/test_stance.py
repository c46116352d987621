"""Laws on a sole: accelerations and momentum are those of (1), the sole bears the torques, a recovery step is led."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from controllers import BoundedAnkleController, BoundedKneedController, KneedController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers import layout
from mjbiped.controllers.bounded.bounded_ankle import move
from mjbiped.controllers.bounded.identifier import MOMENTUM, SLOPE, identifier_rates, moments_about_foot
from mjbiped.controllers.bounded.recovery import Step, begin, constraint, planned, recover
from mjbiped.controllers.bounded.stance import footing_of, stand
from mjbiped.controllers.dynamics import move_end, observe
from mjbiped.controllers.layout import ADAPTATION_GAIN, ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS, BEHIND
from mjbiped.controllers.room import (
    ALONG,
    BENT,
    FORCE,
    MOTION,
    NORMAL,
    ROOM,
    STRAIGHT_LEGS_SIZE,
    TORQUE,
)
from mjbiped.controllers.slope_estimator import stand_bent
from mjbiped.controllers.tracking import track
from mjbiped.gaits.optimised import OptimisedGait
from mjbiped.robots.compass import Array
from mjbiped.robots.footed import FootedCompass

ANGLE, RATE = st.floats(-0.5, 0.5), st.floats(-3.0, 3.0)
STATES = st.tuples(ANGLE, ANGLE, RATE, RATE)
KNEED_STATES = st.tuples(ANGLE, ANGLE, ANGLE, RATE, RATE, RATE)
SLOPES = st.floats(-0.3, 0.3)
SOLES = st.tuples(st.floats(0.02, 0.2), st.floats(0.02, 0.2))
BENDS = st.sampled_from([0.0, 0.2])
ASKED = st.tuples(st.floats(-60.0, 60.0), st.floats(-50.0, 50.0), st.floats(0.0, 2.5))
"""Ankle torque that is asked for (N m), acceleration of the swing leg (rad/s²), and share of the stance leg's."""


@pytest.fixture(scope="module")
def robot() -> mjbiped.KneedBiped:
    return mjbiped.KneedBiped(sole=(0.12, 0.12))


@pytest.fixture(scope="module")
def gait(robot: mjbiped.KneedBiped) -> OptimisedGait:
    return mjbiped.find_reference(robot, clearance=0.08)


@pytest.fixture(scope="module")
def law(robot: mjbiped.KneedBiped, gait: OptimisedGait) -> BoundedKneedController:
    return BoundedKneedController(robot, gait)


def parameters_of(robot: mjbiped.Compass, more: Mapping[int, Any]) -> list[float]:
    """Parameters of the law of a compass biped without a gait."""
    gains = {layout.POSITION_GAIN: 5.0, layout.ON_ANGLE: 61.0, layout.ON_RATE: 17.0}
    return layout.flat({layout.SEGMENTS: 2, **gains, **more}, {layout.FREE: layout.chain_block(*robot.chains[2][:3])})


def room_at(q: Sequence[float] | Array, dq: Sequence[float] | Array) -> list[float]:
    """A room with a state."""
    room = [0.0] * (ROOM + 48)
    observe(len(q), [float(each) for each in q], [float(each) for each in dq], room)
    return room


class Driven(NamedTuple):
    """Torques (N m), accelerations (rad/s²), and the force of the ground along it and normal to it (N)."""

    ankle: float
    hip: float
    ddq1: float
    ddq2: float
    along: float
    normal: float


def made(robot: mjbiped.Compass, state: tuple[float, ...], slope: float, demand: tuple[float, float, float]) -> Driven:
    """What a robot does on its sole under an ankle torque that is asked for."""
    room, memory, (asked, offset, share) = room_at(state[:2], state[2:]), [0.0] * STRAIGHT_LEGS_SIZE, demand
    room[MOTION + 1] = offset
    move_end(1, offset, room)
    parameters = parameters_of(robot, footing_of(robot, 1.0))
    stand(parameters, memory, asked, share, 1.0, (math.sin(slope), math.cos(slope)), room)
    return Driven(*(room[at] for at in (TORQUE, TORQUE + 1, MOTION, MOTION + 1, ALONG, NORMAL)))


@given(SOLES, STATES, SLOPES, ASKED)
def test_a_compass_moves_by_its_torques_and_its_pressure_lies_on_the_sole(
    sole: tuple[float, float], state: tuple[float, ...], slope: float, demand: tuple[float, float, float]
) -> None:
    robot, (asked, offset, share) = mjbiped.Compass(sole=sole), demand
    found, whole = made(robot, state, slope, demand), made(mjbiped.Compass(), state, slope, demand)
    q, dq, ddq = np.array(state[:2]), np.array(state[2:]), np.array([found.ddq1, found.ddq2])
    pull = robot.input_matrix @ [found.ankle, found.hip] - robot.coriolis_matrix(q, dq) @ dq
    expected = np.linalg.solve(robot.mass_matrix(q), pull - robot.gravity_vector(q, slope))
    scale = max(1.0, *np.abs(ddq))  # rounding, of numbers of this size
    np.testing.assert_allclose(ddq, expected, rtol=0, atol=2e-11 * scale)
    assert found.ddq2 == pytest.approx(offset + share * found.ddq1, rel=1e-12, abs=1e-12)
    forward, upward = robot.chains[2].ground_force(q, dq, ddq, slope)  # in the vertical frame
    sine, cosine = math.sin(slope), math.cos(slope)
    scale = max(1.0, abs(forward), abs(upward))
    assert found.along == pytest.approx(forward * cosine - upward * sine, abs=1e-12 * scale)
    assert found.normal == pytest.approx(forward * sine + upward * cosine, abs=1e-12 * scale)
    behind, ahead = sole
    slack = 1e-12 * max(1.0, abs(found.normal), abs(asked))
    if found.normal > 0.0:
        assert -ahead * found.normal - slack <= found.ankle <= behind * found.normal + slack
    else:
        assert abs(found.ankle) <= slack or found.normal >= -slack
    assert abs(found.ankle) <= abs(asked) + slack
    assert found.ankle * asked >= 0.0
    assert whole.ankle == asked
    if -ahead * whole.normal < asked < behind * whole.normal:
        assert found == whole


@given(SOLES, STATES, SLOPES, ASKED, st.floats(1e-3, 0.05))
def test_over_an_ankle_the_force_along_the_sole_moves_the_centre_of_pressure(
    sole: tuple[float, float], state: tuple[float, ...], slope: float, demand: tuple[float, float, float], height: float
) -> None:
    """x = -(torque + height F_t) / F_n, by the force that acts under the torque given."""
    asked = demand[0]
    assume(asked == 0.0 or abs(asked) > 1e-3)  # the law divides differences of forces by it, which cancel below
    found = made(FootedCompass(sole=sole, ankle_height=height), state, slope, demand)
    moment = found.ankle + height * found.along
    slack = 1e-10 * max(1.0, abs(found.normal), abs(asked), abs(moment))  # rounding, of differences of forces
    if found.normal > 0.0 and found.ankle != asked and moment != 0.0:
        ends = (sole[0] * found.normal, -sole[1] * found.normal)
        assert min(abs(moment - end) for end in ends) <= slack  # what is not given is what an end does not bear


def standing(law: BoundedKneedController, bent: float) -> list[float]:
    """A memory with a stance leg bent by so much, rad."""
    memory = [0.0] * law.memory_size
    memory[BENT] = bent
    if bent:
        stand_bent(law.parameters, memory)
    return memory


def derivative(function: object, at: float) -> float:
    """Central difference of the fourth order."""
    f, h = function, 1e-4
    assert callable(f)
    return float((8.0 * (f(at + h) - f(at - h)) - (f(at + 2 * h) - f(at - 2 * h))) / (12.0 * h))


@given(KNEED_STATES, SLOPES, SOLES, BENDS)
def test_with_knees_torques_make_the_accelerations_and_the_momentum_changes_as_predicted(
    law: BoundedKneedController, state: tuple[float, ...], slope: float, sole: tuple[float, float], bent: float
) -> None:
    """By the robot's own equations of motion and ground force, which share the chain's only."""
    parameters, memory, t, robot = list(law.parameters), standing(law, bent), 0.3 * law.gait.period, law.robot
    parameters[BEHIND], parameters[BEHIND + 1] = sole
    angle, q, dq = (math.sin(slope), math.cos(slope)), np.array(state[:3]), np.array(state[3:])
    asked, room, chain = room_at(q, dq), room_at(q, dq), robot.chains_on(bent)[3]
    track(parameters, memory, t, angle, asked)
    wanted = sum(asked[FORCE : FORCE + 3])
    move(parameters, memory, t, 1.0, angle, room)
    torque, motion = np.array(room[TORQUE : TORQUE + 3]), np.array(room[MOTION : MOTION + 3])
    pull = robot.input_matrix @ torque - chain.coriolis_matrix(q, dq) @ dq - chain.gravity_vector(q, slope)
    scale = max(1.0, *np.abs(motion), *np.abs(asked[MOTION : MOTION + 3]))  # rounding, of numbers of this size
    np.testing.assert_allclose(np.linalg.solve(chain.mass_matrix(q), pull), motion, rtol=0, atol=1e-11 * scale)
    np.testing.assert_array_equal(motion[1:], asked[MOTION + 1 : MOTION + 3])  # the swing leg follows its reference
    forward, upward = robot.ground_force(q, dq, torque, slope, locked=False, stance_flexion=bent)
    normal, force = forward * angle[0] + upward * angle[1], max(1.0, abs(forward), abs(upward))
    assert room[NORMAL] == pytest.approx(normal, abs=1e-11 * force)
    assert room[ALONG] == pytest.approx(forward * angle[1] - upward * angle[0], abs=1e-11 * force)
    if normal > 0.0:
        slack = 1e-11 * max(force, abs(wanted))
        assert -sole[1] * normal - slack <= torque[0] <= sole[0] * normal + slack
    assert torque[0] * wanted >= -1e-11 * force * abs(wanted)  # of one sign, but for rounding
    assert abs(torque[0]) <= abs(wanted) * (1.0 + 1e-12)

    def momentum(time: float) -> float:
        there = room_at(q + dq * time + 0.5 * motion * time * time, dq + motion * time)
        return moments_about_foot(parameters, memory, 0.0, 1.0, there)[0]

    def moment(of: float) -> float:
        return moments_about_foot(parameters, memory, math.sin(of), math.cos(of), room)[1]

    _, gravity, by_slope, inertia = moments_about_foot(parameters, memory, *angle, room)
    # rounding, 1e-16 of some 100 kg m²/s over 1e-4 s, and h⁴ of its derivatives
    assert torque[0] + gravity == pytest.approx(derivative(momentum, 0.0), abs=1e-8 * scale)
    assert by_slope == pytest.approx(derivative(moment, slope), abs=1e-8)
    assert inertia == pytest.approx(np.sum(chain.mass_matrix(q)), rel=1e-14)


@given(STATES, SLOPES, st.floats(-20.0, 20.0), st.floats(-5.0, 5.0))
def test_the_identifier_follows_its_equations(
    state: tuple[float, ...], slope: float, ankle: float, error: float
) -> None:
    robot = mjbiped.Compass(hip_mass=3.0)
    parameters, memory = parameters_of(robot, {ADAPTATION_GAIN: 0.3}), [0.0] * STRAIGHT_LEGS_SIZE
    angle, room = (math.sin(slope), math.cos(slope)), room_at(state[:2], state[2:])
    momentum, gravity, by_slope, inertia = moments_about_foot(parameters, memory, *angle, room)
    memory[SLOPE], memory[MOMENTUM] = slope, momentum - error
    found = identifier_rates(parameters, memory, ankle, *angle, room)
    expected = 0.3 * by_slope / inertia * error / inertia, ankle + gravity + 20.0 * error
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


STEP = Step(0.4, 0.22, -0.5)
ANKLE = {ANKLE_GAIN: 8.0, ANKLE_RATE: 1.1, ANKLE_STIFFNESS: 2.0}


@pytest.mark.parametrize("sole", [None, (0.03, 0.05)])
def test_a_recovery_step_gets_onto_its_constraint_in_time_whatever_the_sole_bears(
    sole: tuple[float, float] | None,
) -> None:
    robot, memory, start = mjbiped.Compass(sole=sole), [0.0] * STRAIGHT_LEGS_SIZE, (-0.2, 0.2, 1.0, 0.6)
    parameters = parameters_of(robot, {**footing_of(robot, 1.0), **ANKLE})
    begin(memory, STEP, start[:2], start[2:])
    assert planned(memory) == STEP
    assert constraint(STEP, STEP.half) == pytest.approx(-STEP.half, abs=1e-15)  # the feet come down together

    def rate(t: float, state: Array) -> Array:
        room = room_at(state[:2], state[2:])
        recover(parameters, memory, t, 1.0, (0.0, 1.0), room)
        return np.array([state[2], state[3], room[MOTION], room[MOTION + 1]])

    done = solve_ivp(rate, (0.0, 0.55), start, method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.005)
    q1, q2, dq1, dq2 = done.y[:, done.t >= STEP.time]
    assert np.abs(q2 - [constraint(STEP, q) for q in q1]).max() < 1e-9  # the integration's
    assert np.abs(dq2 - (1.0 - STEP.retraction) * dq1).max() < 1e-7
    assert np.ptp(done.y[0]) > 0.1  # the stance leg has moved meanwhile
    for angle, lack in ((-0.3, -0.4), (0.0, 0.0), (0.3, 0.7)):
        room = room_at((angle, 0.1), (math.hypot(1.1, 2.0 * angle) - lack, 0.5))
        ankle = recover(parameters, memory, 0.1, 1.0, (0.0, 1.0), room)
        assert sole or ankle == pytest.approx(8.0 * lack, abs=1e-13)  # the ankle drives toward its rate


STAIRS = mjbiped.Terrain.from_segments([(1.3, 0.0, 0.0), *[(1.8, 0.0, 0.03)] * 4])


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_it_climbs_stairs_on_which_the_paper_s_law_falls(law: BoundedKneedController, engine: str) -> None:
    plain = KneedController(law.robot, law.gait)
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
            mass = law.robot.chains_on(memory[BENT])[3].mass_matrix(q)
            assert memory[MOMENTUM] == pytest.approx(np.sum(mass @ dq), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize("error", [4.0, -4.0])
def test_a_wrong_start_is_found_out_within_two_steps(error: float, engine: str) -> None:
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    gait = mjbiped.find_reference(robot, clearance=0.06)
    law = BoundedAnkleController(robot, gait, initial_slope_estimate=math.radians(error), estimate_update=False)
    walk = mjbiped.walk(law, mjbiped.Terrain.level(), engine=engine, steps=4)
    assert walk.outcome == "finished"
    left = np.abs(walk.samples["slope_estimate"])
    late = walk.samples["time"] > walk.touchdowns["time"][1]
    assert left[0] == pytest.approx(math.radians(abs(error)))
    # 6.4 rad/s overdamped: its slower root, -2.4/s, leaves 2 % of 4° after 1.6 s; MuJoCo's impacts add 1e-4 rad
    assert left[late].max() < 0.03 * math.radians(abs(error)) + 3e-4
