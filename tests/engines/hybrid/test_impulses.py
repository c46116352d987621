"""What impacts ask of the ground under the stance foot, against the momenta of free rigid bodies."""

import math

import numpy as np
import pytest
from engines.conformance.free_bodies import FreeRobot
from engines.conformance.test_impacts import LOCKED as KNEE_LOCKED
from engines.conformance.test_impacts import missed
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import hybrid_simulation

import mjbiped
from mjbiped.dynamics.modes import LOCKED
from mjbiped.engines.hybrid.engine import HybridRun
from mjbiped.engines.hybrid.impacts import hit_face
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import transfer_support
from mjbiped.engines.hybrid.state import State
from mjbiped.terrain.terrain import Terrain

SLOPE = 0.05
BODIES = {False: FreeRobot(mjbiped.Compass()), True: FreeRobot(mjbiped.KneedBiped())}
PAIRS = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
ROUNDING = 1e-11
"""Of momenta of some 50 kg m/s, from sums of that size, and from a system of equations."""


def standing(knees: bool, legs: tuple[float, float], rates: tuple[float, float]) -> tuple[HybridRun, np.ndarray]:
    """An unpowered robot with straight legs on a slope, the angles being from the vertical, and its posture."""
    q, dq = [angle - SLOPE for angle in legs], [*rates]
    start = [*q, q[1], *dq, dq[1]] if knees else [*q, *dq]
    simulation = hybrid_simulation(Terrain.incline(math.degrees(SLOPE)), start)
    simulation.state.y[: len(start)] = start
    simulation.state.locked = LOCKED
    enter_mode(simulation.constants, simulation.state)
    angles = [*legs, legs[1]] if knees else legs
    return simulation, np.array(BODIES[knees].robot.posture((0.0, 0.0), 0, angles))


def impulse_of(w: State) -> complex:
    """The ground's impulse on the stance foot, forward and upward, N s."""
    return complex(w.impulse_along, w.impulse_normal) * complex(np.exp(-1j * SLOPE))


def rates_of(w: State, knees: bool) -> list[float]:
    return [*w.y[3:6]] if knees else [*w.y[2:4]]


@pytest.mark.parametrize("knees", [False, True])
@given(legs=PAIRS, rates=PAIRS)
@settings(deadline=None, derandomize=True, max_examples=50)
def test_a_face(knees: bool, legs: tuple[float, float], rates: tuple[float, float]) -> None:
    """The face stops the swing foot's way along x, without friction, on a stance foot that the ground holds."""
    (simulation, qpos), bodies = standing(knees, legs, rates), BODIES[knees]
    w = simulation.state
    w.face_x, w.landing = 0.3, 0
    hit_face(simulation.constants, w)
    before = [*rates, rates[1]] if knees else [*rates]
    change = bodies.rates(qpos, 0, rates_of(w, knees), SLOPE) - bodies.rates(qpos, 0, before, SLOPE)
    N = bodies.motions(qpos, 0, KNEE_LOCKED if knees else np.eye(2), SLOPE)
    along = bodies.ends[1].jacobian(qpos).real @ N
    assert along @ rates_of(w, knees)[:2] == pytest.approx(0.0, abs=ROUNDING)
    if abs(along).max() > 1e-3:
        assert missed(bodies, qpos, change, N @ [[-along[1]], [along[0]]]) < ROUNDING
    pushed = N.T @ bodies.mass_matrix(qpos) @ change @ along / (along @ along)  # by the face, N s
    assert impulse_of(w) == pytest.approx(bodies.momentum(qpos, change) - pushed, abs=ROUNDING)


@pytest.mark.parametrize("knees", [False, True])
@pytest.mark.parametrize("half", [0.1, 0.3])
def test_a_heel_strike_asks_for_the_whole_change_of_momentum(knees: bool, half: float) -> None:
    """The departing foot leaves freely."""
    rates = (1.1, 0.6)
    (simulation, qpos), bodies = standing(knees, (SLOPE + half, SLOPE - half), rates), BODIES[knees]
    w = simulation.state
    transfer_support(simulation.constants, w)
    assert w.count == 1
    before = bodies.rates(qpos, 0, [*rates, rates[1]] if knees else rates, SLOPE)
    after = bodies.rates(qpos, 1, rates_of(w, knees), SLOPE)
    assert impulse_of(w) == pytest.approx(bodies.momentum(qpos, after - before), abs=ROUNDING)
