"""The equations of motion with knees in the hybrid engine: what motors and pushes put in is what the energy gains."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL, hybrid_simulation

from mjbiped.engines.hybrid import kneed, kneed_posture
from mjbiped.engines.hybrid import state as at
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

ROBOTS = [KneedBiped(), UNEQUAL]
constants_of = cache(kneed_posture.constants_of)

near, rate = st.floats(-0.6, 0.6), st.floats(-4.0, 4.0)
flexions = st.one_of(st.just(0.0), st.floats(0.05, 1.0))
torques = st.tuples(*[st.floats(-40.0, 40.0)] * 3)


def given_torque(parameters: Any, memory: Any, t: float, *state: float) -> Any:
    return parameters


def scalars(**given: float) -> list[float]:
    w = [0.0] * at.SCALARS
    w[at.BEFORE] = math.inf
    for name, value in given.items():
        w[getattr(at, name)] = value
    return w


@given(
    st.sampled_from(ROBOTS),
    st.tuples(near, near, flexions, rate, rate, rate),
    st.booleans(),
    flexions,
    st.floats(-0.3, 0.3),
    torques,
    st.floats(-80.0, 80.0),
)
@settings(deadline=None, derandomize=True)
def test_motors_and_pushes_do_the_work_that_the_energy_gains(
    robot: KneedBiped,
    state: tuple[float, ...],
    locked: bool,
    bent: float,
    slope: float,
    torque: tuple[float, float, float],
    push: float,
) -> None:
    """The energy of the chain of four segments, along the motion; a push acts forwards at the hip."""
    q1, q2, flexion, dq1, dq2, dq3 = state
    if locked:
        flexion, dq3, torque = 0.0, dq2, (*torque[:2], 0.0)
    w = scalars(LOCKED=at.KNEE_LOCKED if locked else at.KNEE_FREE, STANCE_FLEXION=bent, SLOPE=slope, PUSH=push)
    y = (q1, q2, q2 + flexion, dq1, dq2, dq3, 0.0, 0.0, 0.0)
    changes = kneed.rates(given_torque, torque, constants_of(robot), robot.leg_length, [], w, 0.1, y)
    assert changes[:3] == (dq1, dq2, dq3)
    powers = changes[6:]
    assert powers == pytest.approx([torque[0] * dq1, torque[1] * (dq2 - dq1), torque[2] * (dq3 - dq2)], abs=1e-12)
    assert [w[at.ANKLE + joint] for joint in range(3)] == list(torque)
    assert [w[at.STAGE_ANKLE + joint] for joint in range(3)] == [abs(each) for each in torque]
    length, lean = bent_leg(robot.thigh_length, robot.shank_length, bent)

    def energy(h: float) -> float:
        moved = np.add(y[:6], h * np.array(changes[:6]))
        line, rates = moved[0], moved[3:]
        q = [line + lean, line + lean - bent, moved[1], moved[2]]
        return robot.energy(q, rates[[0, 0, 1, 2]], slope)

    h = 1e-5
    gained = (energy(h) - energy(-h)) / (2.0 * h)
    hip_rate = length * math.cos(q1 + slope) * dq1
    # rounding of 1e3 J over h, and h squared times the third derivative of some 1e5 W/s^2 where accelerations are 1e3
    assert gained == pytest.approx(sum(powers) + push * hip_rate, abs=1e-4, rel=1e-6)


@pytest.mark.parametrize("bent", [0.0, 0.5])
def test_the_force_of_the_ground_is_the_robots(bent: float) -> None:
    """In a state, and within a step from its dense output."""
    simulation = hybrid_simulation(Terrain.incline(3.0), (-0.2, 0.1, 0.5, 1.1, 0.4, -0.3), robot=UNEQUAL)
    constants, b, laws = simulation.constants, simulation.buffers, simulation.advance.args[0]
    kneed_posture.stand(constants.robot, bent)
    b.w[at.STANCE_FLEXION], b.w[at.BEFORE] = bent, math.inf
    state = [-0.2, 0.1, 0.5, 1.1, 0.4, -0.3]
    changes = kneed.rates(given_torque, (3.0, -2.0, 1.0), constants.robot, 1.0, [], b.w, 0.1, (*state, 0.0, 0.0, 0.0))
    place = 2 * len(b.y)
    b.k[place : place + 6] = changes[:6]
    expected = UNEQUAL.ground_force(
        state[:3], state[3:], [3.0, -2.0, 1.0], math.radians(3.0), locked=False, stance_flexion=bent
    )
    found = kneed.force_at(constants, b, laws.pose(b, state), state, place)
    assert found == pytest.approx(expected, rel=1e-12)
