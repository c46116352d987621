"""A compass on its sole: the accelerations are those of (1), and the centre of pressure lies on the sole."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from law_rooms import parameters_of, room_at

import mjbiped
from mjbiped.controllers.bounded.stance import footing_of, stand
from mjbiped.controllers.dynamics import move_end
from mjbiped.controllers.layout import bounds
from mjbiped.controllers.room import ALONG, MOTION, NORMAL, STRAIGHT_LEGS_SIZE, SUPPORT, SUPPORT_AHEAD, TORQUE
from mjbiped.robots import compass
from mjbiped.robots.footed import FootedCompass

STATES = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
SLOPES = st.floats(-0.3, 0.3)
TORQUES = st.floats(-60.0, 60.0)
OFFSETS = st.floats(-50.0, 50.0)
SHARES = st.floats(0.0, 2.5)
SOLES = st.tuples(st.floats(0.02, 0.2), st.floats(0.02, 0.2))
CASES = st.tuples(SOLES, STATES, SLOPES, TORQUES, OFFSETS, SHARES)

Case: TypeAlias = tuple[tuple[float, float], tuple[float, ...], float, float, float, float]


class Driven(NamedTuple):
    """Torques (N m), accelerations (rad/s²), and the force of the ground along it and normal to it (N)."""

    ankle: float
    hip: float
    ddq1: float
    ddq2: float
    along: float
    normal: float


def made(
    robot: mjbiped.Compass, state: tuple[float, ...], slope: float, asked: float, offset: float, share: float
) -> Driven:
    """What a robot does on its sole under an ankle torque that is asked for."""
    room, memory = room_at(state[:2], state[2:]), [0.0] * STRAIGHT_LEGS_SIZE
    room[MOTION + 1] = offset
    move_end(1, offset, room)
    parameters = parameters_of(robot, more=footing_of(robot, 1.0))
    stand(parameters, memory, asked, share, 1.0, (math.sin(slope), math.cos(slope)), room)
    return Driven(*(room[at] for at in (TORQUE, TORQUE + 1, MOTION, MOTION + 1, ALONG, NORMAL)))


@given(case=CASES)
def test_its_torques_make_its_accelerations(case: Case) -> None:
    sole, state, slope, asked, offset, share = case
    robot = mjbiped.Compass(sole=sole)
    found = made(robot, state, slope, asked, offset, share)
    q1, q2, dq1, dq2 = state
    force = robot.input_matrix @ [found.ankle, found.hip]
    ddq = compass.acceleration(robot.constants, q1, q2, dq1, dq2, math.sin(slope), math.cos(slope), *force)
    scale = max(1.0, abs(found.ddq1), abs(found.ddq2))  # rounding, of numbers of this size
    np.testing.assert_allclose(ddq, (found.ddq1, found.ddq2), rtol=0, atol=1e-12 * 20 * scale)
    assert found.ddq2 == pytest.approx(offset + share * found.ddq1, rel=1e-12, abs=1e-12)


@given(case=CASES)
def test_the_centre_of_pressure_lies_on_the_sole(case: Case) -> None:
    sole, state, slope, asked, offset, share = case
    found = made(mjbiped.Compass(sole=sole), state, slope, asked, offset, share)
    behind, ahead = sole
    slack = 1e-12 * max(1.0, abs(found.normal), abs(asked))  # rounding
    if found.normal > 0.0:
        assert -ahead * found.normal - slack <= found.ankle <= behind * found.normal + slack
    else:
        assert abs(found.ankle) <= slack or found.normal >= -slack
    assert abs(found.ankle) <= abs(asked) + slack
    assert found.ankle * asked >= 0.0
    whole = made(mjbiped.Compass(), state, slope, asked, offset, share)
    assert whole.ankle == asked
    if -ahead * whole.normal < asked < behind * whole.normal:
        assert found == whole


@pytest.mark.slow
@given(case=CASES, height=st.floats(0.0, 0.05))
def test_over_an_ankle_the_force_along_the_sole_moves_the_centre_of_pressure(case: Case, height: float) -> None:
    """x = -(torque + height F_t) / F_n, by the force that acts under the torque given."""
    sole, state, slope, asked, offset, share = case
    assume(asked == 0.0 or abs(asked) > 1e-3)  # the law divides differences of forces by it, which cancel below
    robot = FootedCompass(sole=sole, ankle_height=max(height, 1e-3))
    found = made(robot, state, slope, asked, offset, share)
    moment = found.ankle + robot.ankle_height * found.along
    slack = 1e-10 * max(1.0, abs(found.normal), abs(asked), abs(moment))  # rounding, of differences of forces
    if found.normal > 0.0 and found.ankle != asked and moment != 0.0:
        ends = (sole[0] * found.normal, -sole[1] * found.normal)
        assert min(abs(moment - end) for end in ends) <= slack  # what is not given is what an end does not bear


@given(behind=st.floats(1e-3, 0.3), ahead=st.floats(0.0, 0.3), share=st.floats(0.1, 1.0))
def test_a_foot_across_an_edge_stands_on_what_the_ground_bears(behind: float, ahead: float, share: float) -> None:
    robot, memory = mjbiped.Compass(sole=(0.1, 0.15)), [0.0] * STRAIGHT_LEGS_SIZE
    parameters = parameters_of(robot, more=footing_of(robot, share))
    assert bounds(parameters, memory, share) == (share * 0.1, share * 0.15)
    memory[SUPPORT], memory[SUPPORT_AHEAD] = behind, ahead
    assert bounds(parameters, memory, share) == (min(share * 0.1, share * behind), min(share * 0.15, share * ahead))


@given(state=STATES, slope=SLOPES, asked=TORQUES, offset=OFFSETS)
def test_the_ground_bears_the_weight_and_the_change_of_momentum(
    state: tuple[float, ...], slope: float, asked: float, offset: float
) -> None:
    """By the force in the vertical frame, turned."""
    robot = mjbiped.Compass()
    found = made(robot, state, slope, asked, offset, 0.5)
    q1, q2, dq1, dq2 = state
    ddq = np.array([found.ddq1, found.ddq2])
    forward, upward = robot.chains[2].ground_force(np.array([q1, q2]), np.array([dq1, dq2]), ddq, slope)
    sine, cosine = math.sin(slope), math.cos(slope)
    scale = max(1.0, abs(forward), abs(upward))
    assert found.along == pytest.approx(forward * cosine - upward * sine, abs=1e-13 * 10 * scale)
    assert found.normal == pytest.approx(forward * sine + upward * cosine, abs=1e-13 * 10 * scale)
