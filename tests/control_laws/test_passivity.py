"""Passivity-based control: its storage falls as promised."""

import math

import numpy as np
import pytest
from closed_loop import memory_on, motion, power, slopes, states
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import PassivityController
from mjbiped.errors import InputError
from mjbiped.robots.compass import Array, Compass

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
ROBOTS = [
    ROBOT,
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=5.0),
]


def surplus(robot: Compass, state: Array, tilt: float = 0.0) -> float:
    """E - E_ref on the imitated slope, against the law's normal."""
    return robot.energy(state[:2] - tilt, state[2:], GAIT.slope) - GAIT.energy


@given(st.sampled_from(ROBOTS), states, slopes, slopes, st.floats(0.1, 300.0))
def test_power_of_the_torques(robot: Compass, state: Array, slope: float, tilt: float, gain: float) -> None:
    controller = PassivityController(robot, GAIT, gain=gain, initial_slope_estimate=slope)
    memory = memory_on(controller, tilt)
    q, dq = state[:2], state[2:]
    ground, imitated = robot.gravity_vector(q, slope), robot.gravity_vector(q - tilt, GAIT.slope)
    rate = power(controller, memory, 0.0, state) - (ground - imitated) @ dq  # of the energy on the imitated slope
    promised = -gain * surplus(robot, state, tilt) * (dq @ dq)
    scale = 1.0 + abs(promised) + np.abs(ground) @ np.abs(dq) + np.abs(imitated) @ np.abs(dq)
    assert rate == pytest.approx(promised, abs=1e-10 * scale)


@pytest.mark.parametrize("tilt", [0.0, 0.05])
def test_storage_falls_along_a_step(tilt: float) -> None:
    slope = 0.03
    controller = PassivityController(ROBOT, GAIT, gain=3.0, initial_slope_estimate=slope)
    start = GAIT.start + np.array([tilt, tilt, 0.3, -0.2])
    times = np.linspace(0.0, 0.4, 801)
    path = motion(controller, memory_on(controller, tilt), slope, start, times)
    surpluses = np.array([surplus(ROBOT, state, tilt) for state in path])
    speed = (path[:, 2:] ** 2).sum(axis=1)
    from scipy.integrate import simpson

    # S = S0 exp(-2 k times the integral of |dq|^2); Simpson's rule over 0.5 ms leaves 1e-10
    left = math.exp(-2 * controller.gain * float(simpson(speed, x=times)))
    assert left < 0.2
    assert surpluses[-1] ** 2 == pytest.approx(surpluses[0] ** 2 * left, rel=1e-8)
    assert (np.diff(surpluses**2) < 0.0).all()


def test_the_imitated_gait_needs_no_damping() -> None:
    """On the gait the torques are the difference of the slopes' gravity, and on its own slope none."""
    controller = PassivityController(ROBOT, GAIT, gain=50.0, initial_slope_estimate=GAIT.slope)
    for t in np.linspace(0.0, GAIT.period, 9):
        q, dq, _ = GAIT.reference(t)
        assert controller.torque(memory_on(controller), t, q.tolist(), dq.tolist()) == pytest.approx(
            (0.0, 0.0), abs=1e-8
        )


def test_bad_gains_are_refused() -> None:
    for gain in (0.0, -1.0, math.nan, math.inf, "3", True):
        with pytest.raises(InputError, match=r"gain = .*: must be "):
            PassivityController(ROBOT, GAIT, gain=gain)  # type: ignore[arg-type]
