"""Slope identifier: the momentum that it predicts is the true one, and a wrong slope is found out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from law_rooms import parameters_of, room_at

import mjbiped
from controllers import BoundedAnkleController
from mjbiped.controllers.bounded.identifier import MOMENTUM, SLOPE, identifier_rates, moments_about_foot
from mjbiped.controllers.layout import ADAPTATION_GAIN
from mjbiped.controllers.room import STRAIGHT_LEGS_SIZE
from mjbiped.robots import compass

STATES = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@given(state=STATES, slope=st.floats(-0.3, 0.3), ankle=st.floats(-20.0, 20.0), hip=st.floats(-50.0, 50.0))
def test_with_the_true_slope_the_prediction_is_the_motion(
    state: tuple[float, ...], slope: float, ankle: float, hip: float
) -> None:
    """The derivative of the momentum along the motion, by central differences of the fourth order."""
    robot = mjbiped.Compass(hip_mass=3.0)
    constants = robot.constants
    q1, q2, dq1, dq2 = state
    angle = math.sin(slope), math.cos(slope)
    force = robot.input_matrix @ [ankle, hip]
    ddq1, ddq2 = compass.acceleration(constants, q1, q2, dq1, dq2, *angle, *force)

    parameters, memory = parameters_of(robot, more={ADAPTATION_GAIN: 0.3}), [0.0] * STRAIGHT_LEGS_SIZE

    def momentum(t: float) -> float:
        angles = q1 + dq1 * t + 0.5 * ddq1 * t * t, q2 + dq2 * t + 0.5 * ddq2 * t * t
        room = room_at(angles, (dq1 + ddq1 * t, dq2 + ddq2 * t))
        return moments_about_foot(parameters, memory, *angle, room)[0]

    memory[SLOPE], memory[MOMENTUM] = slope, momentum(0.0)
    rates = identifier_rates(parameters, memory, ankle, *angle, room_at((q1, q2), (dq1, dq2)))
    assert rates[0] == 0.0
    h = 1e-4
    change = (8.0 * (momentum(h) - momentum(-h)) - (momentum(2 * h) - momentum(-2 * h))) / (12.0 * h)
    # the differences' rounding, 1e-16 of some 100 kg m²/s over 1e-4 s, and the hip torque's share, which is zero
    assert rates[1] == pytest.approx(change, abs=1e-8 * max(1.0, abs(ddq1), abs(ddq2)))


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
