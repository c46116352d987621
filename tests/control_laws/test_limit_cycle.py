"""Limit cycle tracking: the errors obey the linear equation promised."""

import math

import numpy as np
import pytest
from closed_loop import memory_on, motion, slopes, states
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import LimitCycleController
from mjbiped.errors import InputError
from mjbiped.robots.compass import Array

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))


@given(states, slopes, slopes, st.floats(0.5, 40.0), st.floats(0.5, 400.0), st.floats(0.0, 0.8))
def test_accelerations_are_those_promised(
    state: Array, slope: float, tilt: float, rate_gain: float, position_gain: float, t: float
) -> None:
    controller = LimitCycleController(
        ROBOT,
        GAIT,
        rate_gain=rate_gain,
        position_gain=position_gain,
        initial_slope_estimate=slope,
        slope_source="two_point",
    )
    q, dq = state[:2], state[2:]
    torque = np.array(controller.torque(memory_on(controller, tilt), t, q.tolist(), dq.tolist()))
    coriolis = ROBOT.coriolis_matrix(q, dq) @ dq
    gravity = ROBOT.gravity_vector(q, slope)
    got = np.linalg.solve(ROBOT.mass_matrix(q), ROBOT.input_matrix @ torque - coriolis - gravity)
    q_r, dq_r, ddq_r = GAIT.reference(t)
    promised = ddq_r + rate_gain * (dq_r - dq) + position_gain * (q_r - (q - tilt))
    scale = 1.0 + np.abs(ddq_r).max() + 6.0 * rate_gain + 2.0 * position_gain + np.abs(gravity).max()
    assert got == pytest.approx(promised, abs=1e-10 * scale)


@pytest.mark.parametrize("tilt", [0.0, 0.03])
def test_errors_are_critically_damped(tilt: float) -> None:
    slope = 0.04
    controller = LimitCycleController(ROBOT, GAIT, initial_slope_estimate=slope, slope_source="two_point")
    times = np.linspace(0.0, 0.7, 29)
    off = np.array([0.03, -0.05, -0.2, 0.3])
    path = motion(
        controller, memory_on(controller, tilt), slope, GAIT.start + np.array([tilt, tilt, 0, 0]) + off, times
    )
    reference = np.array([np.concatenate(GAIT.reference(t)[:2]) for t in times])
    errors = path - reference - [tilt, tilt, 0.0, 0.0]
    e, de = off[:2], off[2:]
    # s^2 + 10 s + 25 = (s + 5)^2
    expected = np.exp(-5.0 * times)[:, None] * (e + (de + 5.0 * e) * times[:, None])
    # the reference's position, rate and acceleration agree to 1e-9
    assert errors[:, :2] == pytest.approx(expected, abs=1e-8)


def test_next_break_is_the_trajectorys_end() -> None:
    controller = LimitCycleController(ROBOT, GAIT)
    horizon = GAIT.horizon
    memory = memory_on(controller)
    assert horizon > GAIT.period
    assert controller.next_discontinuity(memory, 0.0) == horizon
    assert controller.next_discontinuity(memory, horizon) == math.inf
    assert controller.law().next_discontinuity(controller.law().parameters, memory, 0.0) == horizon


@pytest.mark.parametrize("name", ["rate_gain", "position_gain"])
def test_bad_gains_are_refused(name: str) -> None:
    for value in (0.0, -1.0, math.nan, "3", True):
        with pytest.raises(InputError, match=f"{name} = .*: must be "):
            LimitCycleController(ROBOT, GAIT, **{name: value})  # type: ignore[arg-type]
