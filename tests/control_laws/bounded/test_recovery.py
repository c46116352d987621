"""A recovery step: the swing leg gets onto its constraint in time, and stays on it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from law_rooms import parameters_of, room_at
from scipy.integrate import solve_ivp

import mjbiped
from mjbiped.controllers.bounded import recovery
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.bounded.stance import footing_of
from mjbiped.controllers.layout import ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS
from mjbiped.controllers.room import MOTION, STRAIGHT_LEGS_SIZE
from mjbiped.robots.compass import Array

STEP = Step(0.4, 0.22, -0.5)
ANKLE = {ANKLE_GAIN: 8.0, ANKLE_RATE: 1.1, ANKLE_STIFFNESS: 2.0}
LEVEL = (0.0, 1.0)


@given(half=st.floats(0.1, 0.5), retraction=st.floats(-2.0, 1.0))
def test_on_the_constraint_the_feet_come_down_together(half: float, retraction: float) -> None:
    assert recovery.constraint(Step(0.5, half, retraction), half) == pytest.approx(-half, abs=1e-15)


@pytest.mark.parametrize("sole", [None, (0.03, 0.05)])
def test_the_swing_leg_gets_onto_its_constraint_in_time_whatever_the_sole_bears(
    sole: tuple[float, float] | None,
) -> None:
    robot = mjbiped.Compass(sole=sole)
    parameters = parameters_of(robot, more={**footing_of(robot, 1.0), **ANKLE})
    memory = [0.0] * STRAIGHT_LEGS_SIZE
    start = (-0.2, 0.2, 1.0, 0.6)
    recovery.begin(memory, STEP, start[:2], start[2:])
    assert recovery.planned(memory) == STEP

    def rate(t: float, state: Array) -> Array:
        room = room_at(state[:2], state[2:])
        recovery.recover(parameters, memory, t, 1.0, LEVEL, room)
        return np.array([state[2], state[3], room[MOTION], room[MOTION + 1]])

    done = solve_ivp(rate, (0.0, 0.55), start, method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.005)
    late = done.t >= STEP.time
    q1, q2, dq1, dq2 = done.y[:, late]
    away = q2 - np.array([recovery.constraint(STEP, q) for q in q1])
    assert np.abs(away).max() < 1e-9  # the integration's
    assert np.abs(dq2 - (1.0 - STEP.retraction) * dq1).max() < 1e-7
    assert np.ptp(done.y[0]) > 0.1  # the stance leg has moved meanwhile


def test_the_ankle_drives_toward_its_rate() -> None:
    robot = mjbiped.Compass()
    parameters = parameters_of(robot, more={**footing_of(robot, 1.0), **ANKLE})
    memory = [0.0] * STRAIGHT_LEGS_SIZE
    recovery.begin(memory, STEP, (-0.2, 0.2), (1.0, 0.6))
    for q1 in (-0.3, 0.0, 0.3):
        wanted = math.hypot(1.1, 2.0 * q1)
        for lack in (-0.4, 0.0, 0.7):
            room = room_at((q1, 0.1), (wanted - lack, 0.5))
            ankle = recovery.recover(parameters, memory, 0.1, 1.0, LEVEL, room)
            assert ankle == pytest.approx(8.0 * lack, abs=1e-13)
