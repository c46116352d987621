"""The equations of motion with knees in the hybrid engine: what motors and pushes put in is what the energy gains."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL, hybrid_simulation

from mjbiped.dynamics.modes import FREE, LOCKED, bend_stance_knee
from mjbiped.engines.hybrid.motion import enter_mode, rates, stance_force
from mjbiped.engines.hybrid.state import Constants, State
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

ROBOTS = [KneedBiped(), UNEQUAL]
near, rate = st.floats(-0.6, 0.6), st.floats(-4.0, 4.0)
flexions = st.one_of(st.just(0.0), st.floats(0.05, 1.0))
torques = st.tuples(*[st.floats(-40.0, 40.0)] * 3)


def given_torque(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    out[:3] = parameters


def under(torque: tuple[float, float, float], robot: KneedBiped, **state: Any) -> tuple[Constants, State]:
    """A robot with knees under constant torques, in a state that the given names change."""
    run = hybrid_simulation(Terrain.level(), (-0.2, 0.1, 0.5, 1.1, 0.4, -0.3), robot=robot)
    c, w = run.constants, run.state
    for name, value in {"before": math.inf, **state}.items():
        setattr(w, name, value)
    w.sine, w.cosine = math.sin(w.slope), math.cos(w.slope)
    bend_stance_knee(w, c.upper, c.lower, w.stance_flexion)
    enter_mode(c, w)
    c.torque, c.parameters = given_torque, torque
    return c, w


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
    c, w = under(torque, robot, locked=LOCKED if locked else FREE, stance_flexion=bent, slope=slope, push=push)
    y, changes = [q1, q2, q2 + flexion, dq1, dq2, dq3, 0.0, 0.0, 0.0], [0.0] * 9
    rates(c, w, 0.1, y, changes)
    assert changes[:3] == [dq1, dq2, dq3]
    powers = changes[6:]
    assert powers == pytest.approx([torque[0] * dq1, torque[1] * (dq2 - dq1), torque[2] * (dq3 - dq2)], abs=1e-12)
    assert w.given[0][:3] == list(torque)
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
    torque, state = (3.0, -2.0, 1.0), [-0.2, 0.1, 0.5, 1.1, 0.4, -0.3]
    c, w = under(torque, UNEQUAL, locked=FREE, stance_flexion=bent, slope=math.radians(3.0))
    changes = [0.0] * 9
    rates(c, w, 0.1, [*state, 0.0, 0.0, 0.0], changes)
    along, normal = stance_force(c, w, state[:3], state[3:], changes[3:6])
    found = along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine
    expected = UNEQUAL.ground_force(state[:3], state[3:], torque, math.radians(3.0), locked=False, stance_flexion=bent)
    assert found == pytest.approx(expected, rel=1e-12)
