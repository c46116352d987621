"""Kinetic energy tracking: its error falls exponentially in time."""

import math

import numpy as np
import pytest
from closed_loop import memory_on, motion, power, slopes, states
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import KineticEnergyController, PassivityController
from mjbiped.compass import Array
from mjbiped.errors import InputError

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))


def error(state: Array, tilt: float = 0.0) -> float:
    """T - T_ref(q)."""
    wanted = GAIT.energy - ROBOT.potential_energy(state[:2] - tilt, GAIT.slope)
    return ROBOT.kinetic_energy(state[:2], state[2:]) - wanted


@given(states, slopes, slopes, st.floats(0.1, 300.0))
def test_power_of_the_torques(state: Array, slope: float, tilt: float, gain: float) -> None:
    controller = KineticEnergyController(ROBOT, GAIT, gain=gain, initial_slope=slope, slope_source="two_point")
    q, dq = state[:2], state[2:]
    ground, imitated = ROBOT.gravity_vector(q, slope), ROBOT.gravity_vector(q - tilt, GAIT.slope)
    # d/dt (T - T_ref), since dT/dt is the power of torques and gravity, and dT_ref/dt = -g(q, phi_r) dq
    rate = power(controller, memory_on(controller, tilt), 0.0, state) - (ground - imitated) @ dq
    held = min(1.0, float(dq @ dq) / controller.slowest**2)  # the law weakens for rates below
    promised = -gain * error(state, tilt) * held
    scale = 1.0 + abs(promised) + np.abs(ground) @ np.abs(dq) + np.abs(imitated) @ np.abs(dq)
    assert rate == pytest.approx(promised, abs=1e-10 * scale)


@pytest.mark.parametrize(("tilt", "gain"), [(0.0, 3.0), (0.0, 12.0), (-0.04, 5.0)])
def test_error_falls_exponentially_along_a_step(tilt: float, gain: float) -> None:
    slope = -0.05
    controller = KineticEnergyController(ROBOT, GAIT, gain=gain, initial_slope=slope, slope_source="two_point")
    start = GAIT.start + np.array([tilt, tilt, 0.25, 0.4])
    times = np.linspace(0.0, 0.5, 26)
    path = motion(controller, memory_on(controller, tilt), slope, start, times)
    errors = np.array([error(state, tilt) for state in path])
    assert abs(errors[0]) > 0.5
    assert errors == pytest.approx(errors[0] * np.exp(-gain * times), abs=1e-9)  # integrator, of energies of 50 J


def test_forces_are_of_least_norm() -> None:
    """Beside the other slope's gravity they lie along the rates, as passivity-based control's do."""
    controller = KineticEnergyController(ROBOT, GAIT, gain=7.0, initial_slope=0.1)
    q, dq = [-0.1, 0.25], [1.3, -0.6]
    same = PassivityController(ROBOT, GAIT, gain=7.0 / (1.3**2 + 0.6**2), initial_slope=0.1)
    expected = same.torque(memory_on(same), 0.0, q, dq)
    assert controller.torque(memory_on(controller), 0.0, q, dq) == pytest.approx(expected, rel=1e-13)


def test_torques_stay_bounded_at_rest() -> None:
    controller = KineticEnergyController(ROBOT, GAIT, gain=100.0, slowest=0.1)
    memory = memory_on(controller)
    still = controller.torque(memory, 0.0, (0.0, 0.0), (0.0, 0.0))
    gravity = ROBOT.gravity_vector([0.0, 0.0], 0.0) - ROBOT.gravity_vector([0.0, 0.0], GAIT.slope)
    assert still == pytest.approx(tuple(np.linalg.solve(ROBOT.input_matrix, gravity)), abs=1e-13)
    greatest = 100.0 * abs(error(np.zeros(4))) / controller.slowest  # of u
    for speed in (1e-9, 1e-3, 0.05, 0.0999, 0.1001):
        ankle, hip = controller.torque(memory, 0.0, (0.0, 0.0), (speed, 0.0))
        assert abs(ankle - still[0]) <= 1.01 * greatest
        assert hip == pytest.approx(still[1], abs=1e-12)


@pytest.mark.parametrize("name", ["gain", "slowest"])
def test_bad_gains_are_refused(name: str) -> None:
    for value in (0.0, -1.0, math.nan, "3", True):
        with pytest.raises(InputError, match=f"{name} = .*: must be "):
            KineticEnergyController(ROBOT, GAIT, **{name: value})  # type: ignore[arg-type]
