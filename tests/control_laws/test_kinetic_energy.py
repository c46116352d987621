"""Kinetic energy tracking: its error falls exponentially in time."""

import math

import numpy as np
import pytest
from closed_loop import memory_on, motion, power, slopes, states
from hypothesis import given
from hypothesis import strategies as st

import mjbiped
from controllers import KineticEnergyController, PassivityController
from mjbiped.errors import InputError
from mjbiped.robots.compass import Array

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))


def error(state: Array, tilt: float = 0.0) -> float:
    """T - T_ref(q)."""
    wanted = GAIT.energy - ROBOT.potential_energy(state[:2] - tilt, GAIT.slope)
    return ROBOT.kinetic_energy(state[:2], state[2:]) - wanted


weights = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 10.0))


@given(states, slopes, slopes, st.floats(0.1, 300.0), weights)
def test_power_of_the_torques(state: Array, slope: float, tilt: float, gain: float, weight: float) -> None:
    controller = KineticEnergyController(
        ROBOT, GAIT, gain=gain, hip_weight=weight, initial_slope_estimate=slope, slope_source="two_point"
    )
    q, dq = state[:2], state[2:]
    ground, imitated = ROBOT.gravity_vector(q, slope), ROBOT.gravity_vector(q - tilt, GAIT.slope)
    # d/dt (T - T_ref), since dT/dt is the power of torques and gravity, and dT_ref/dt = -g(q, phi_r) dq
    rate = power(controller, memory_on(controller, tilt), 0.0, state) - (ground - imitated) @ dq
    held = min(1.0, float(dq[0] ** 2 + weight * dq[1] ** 2) / controller.slowest**2)  # the law weakens for rates below
    promised = -gain * error(state, tilt) * held
    scale = 1.0 + abs(promised) + np.abs(ground) @ np.abs(dq) + np.abs(imitated) @ np.abs(dq)
    assert rate == pytest.approx(promised, abs=1e-10 * scale)


@pytest.mark.parametrize(("tilt", "gain"), [(0.0, 3.0), (0.0, 12.0), (-0.04, 5.0)])
@pytest.mark.parametrize("weight", [0.0, 0.3, 1.0])
def test_error_falls_exponentially_along_a_step(tilt: float, gain: float, weight: float) -> None:
    slope = -0.05
    controller = KineticEnergyController(
        ROBOT, GAIT, gain=gain, hip_weight=weight, initial_slope_estimate=slope, slope_source="two_point"
    )
    start = GAIT.start + np.array([tilt, tilt, 0.25, 0.4])
    # with the ankle alone as long as the stance leg is faster than `slowest`
    times = np.linspace(0.0, 0.5 if weight else 0.2, 26)
    path = motion(controller, memory_on(controller, tilt), slope, start, times)
    errors = np.array([error(state, tilt) for state in path])
    assert abs(errors[0]) > 0.5
    assert errors == pytest.approx(errors[0] * np.exp(-gain * times), abs=1e-9)  # integrator, of energies of 50 J


def test_ankle_acts_alone_unless_told_otherwise() -> None:
    """Beside the other slope's gravity, whose torques are those of no error."""
    controller = KineticEnergyController(ROBOT, GAIT, initial_slope_estimate=0.1)
    q, dq = [-0.1, 0.25], [1.3, -0.6]
    gravity = ROBOT.gravity_vector(q, 0.1) - ROBOT.gravity_vector(q, GAIT.slope)
    shaped = np.linalg.solve(ROBOT.input_matrix, gravity)
    ankle, hip = controller.torque(memory_on(controller), 0.0, q, dq)
    assert hip == pytest.approx(shaped[1], rel=1e-13)
    assert ankle - shaped[0] == pytest.approx(-controller.gain * error(np.array([*q, *dq])) / dq[0], rel=1e-12)


@given(states, st.floats(0.01, 10.0))
def test_forces_are_those_of_least_weighted_norm(state: Array, weight: float) -> None:
    """No other forces of the same power have a smaller u1² + u2²/w."""
    controller = KineticEnergyController(ROBOT, GAIT, hip_weight=weight, slope_source="none")
    bare = ROBOT.gravity_vector(state[:2], 0.0) - ROBOT.gravity_vector(state[:2], GAIT.slope)
    torque = controller.torque(memory_on(controller), 0.0, state[:2].tolist(), state[2:].tolist())
    forces = ROBOT.input_matrix @ torque - bare
    along = np.array([-state[3], state[2]])  # of no power
    slope = forces @ (along * [1.0, 1.0 / weight])  # of half the weighted norm along it
    scale = 1.0 + float(np.linalg.norm(bare) + np.linalg.norm(torque))
    scale *= (1.0 + float(np.linalg.norm(along))) * (1.0 + 1.0 / weight)
    assert slope == pytest.approx(0.0, abs=1e-12 * scale)


def test_with_both_joints_alike_the_forces_lie_along_the_rates() -> None:
    """Beside the other slope's gravity, as passivity-based control's do."""
    controller = KineticEnergyController(ROBOT, GAIT, gain=7.0, hip_weight=1.0, initial_slope_estimate=0.1)
    q, dq = [-0.1, 0.25], [1.3, -0.6]
    same = PassivityController(ROBOT, GAIT, gain=7.0 / (1.3**2 + 0.6**2), initial_slope_estimate=0.1)
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


def falls(engine: str, changes: list[tuple[float, float, float]], places: int = 5) -> list[str]:
    """Of walks of the defaults from the imitated gait over single changes of level ground, those that end early."""
    grounds = [
        mjbiped.Terrain.from_segments([((2.0 + 2.0 * (place + 0.5) / places) * GAIT.step_length, 0.0, 0.0), change])
        for change in changes
        for place in range(places)
    ]
    walks = mjbiped.walk_many(
        KineticEnergyController(ROBOT, GAIT), grounds, engine=engine, steps=25, sample_period=None
    )
    return [str(walk.terrain.parameters) for walk in walks if walk.outcome != "finished"]


CLAIMED = [(99.0, 0.0, -0.05), (99.0, -3.0, 0.0), (99.0, 3.0, 0.0)]
"""What the paper's introduction says that the method withstands: 5 % of the leg's length, and 3 degrees."""


@pytest.mark.slow
def test_defaults_bear_what_the_paper_says() -> None:
    smaller = [(99.0, 0.0, rise) for rise in (-0.04, -0.03, -0.02, -0.01, 0.01)]
    assert not falls("hybrid", [*CLAIMED, *smaller])
    assert len(falls("hybrid", [(99.0, 0.0, 0.02)])) == 5, "a step up of 20 mm is too much, as docs/comparison.md says"


@pytest.mark.slow
def test_defaults_bear_it_in_mujoco_too() -> None:
    assert not falls("mujoco", CLAIMED)


@pytest.mark.parametrize("weight", [-1.0, math.nan, math.inf, "1", None, True])
def test_bad_weights_are_refused(weight: object) -> None:
    with pytest.raises(InputError, match=r"hip_weight = .*: must be "):
        KineticEnergyController(ROBOT, GAIT, hip_weight=weight)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["gain", "slowest"])
def test_bad_gains_are_refused(name: str) -> None:
    for value in (0.0, -1.0, math.nan, "3", True):
        with pytest.raises(InputError, match=f"{name} = .*: must be "):
            KineticEnergyController(ROBOT, GAIT, **{name: value})  # type: ignore[arg-type]
