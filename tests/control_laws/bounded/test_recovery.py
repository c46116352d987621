"""A recovery step: the swing leg gets onto its constraint in time, and stays on it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from mjbiped.controllers.bounded import recovery
from mjbiped.controllers.bounded.recovery import Ankle, Step
from mjbiped.controllers.bounded.stance import model_of
from mjbiped.robots.compass import Array

STEP = Step(0.4, 0.22, -0.5)


@given(half=st.floats(0.1, 0.5), retraction=st.floats(-2.0, 1.0))
def test_on_the_constraint_the_feet_come_down_together(half: float, retraction: float) -> None:
    assert recovery.constraint(Step(0.5, half, retraction), half) == pytest.approx(-half, abs=1e-15)


@pytest.mark.parametrize("sole", [None, (0.03, 0.05)])
def test_the_swing_leg_gets_onto_its_constraint_in_time_whatever_the_sole_bears(
    sole: tuple[float, float] | None,
) -> None:
    robot = mjbiped.Compass(sole=sole)
    model, ankle = model_of(robot, 1.0), Ankle(8.0, 1.1, 2.0)
    memory = [0.0] * recovery.SIZE
    start = (-0.2, 0.2, 1.0, 0.6)
    recovery.begin(memory, STEP, *start)
    assert recovery.planned(memory) == STEP

    def rate(t: float, state: Array) -> Array:
        made = recovery.motion(model, ankle, memory, t, *state.tolist())
        return np.array([state[2], state[3], made.ddq1, made.ddq2])

    done = solve_ivp(rate, (0.0, 0.55), start, method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.005)
    late = done.t >= STEP.time
    q1, q2, dq1, dq2 = done.y[:, late]
    away = q2 - np.array([recovery.constraint(STEP, q) for q in q1])
    assert np.abs(away).max() < 1e-9  # the integration's
    assert np.abs(dq2 - (1.0 - STEP.retraction) * dq1).max() < 1e-7
    assert np.ptp(done.y[0]) > 0.1  # the stance leg has moved meanwhile


def test_the_ankle_drives_toward_its_rate() -> None:
    model, ankle = model_of(mjbiped.Compass(), 1.0), Ankle(8.0, 1.1, 2.0)
    memory = [0.0] * recovery.SIZE
    recovery.begin(memory, STEP, -0.2, 0.2, 1.0, 0.6)
    for q1 in (-0.3, 0.0, 0.3):
        wanted = math.hypot(1.1, 2.0 * q1)
        for lack in (-0.4, 0.0, 0.7):
            made = recovery.motion(model, ankle, memory, 0.1, q1, 0.1, wanted - lack, 0.5)
            assert made.ankle == pytest.approx(8.0 * lack, abs=1e-13)
