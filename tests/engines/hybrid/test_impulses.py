"""What a face that is struck asks of the ground under the stance foot, against the momenta of free rigid bodies."""

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
    after = [*w.y[3:6]] if knees else [*w.y[2:4]]
    change = bodies.rates(qpos, 0, after, SLOPE) - bodies.rates(qpos, 0, before, SLOPE)
    N = bodies.motions(qpos, 0, KNEE_LOCKED if knees else np.eye(2), SLOPE)
    along = bodies.ends[1].jacobian(qpos).real @ N
    assert along @ after[:2] == pytest.approx(0.0, abs=ROUNDING)
    if abs(along).max() > 1e-3:
        assert missed(bodies, qpos, change, N @ [[-along[1]], [along[0]]]) < ROUNDING
    pushed = N.T @ bodies.mass_matrix(qpos) @ change @ along / (along @ along)  # by the face, N s
    impulse = complex(w.impulse_along, w.impulse_normal) * np.exp(-1j * SLOPE)  # forward and upward
    assert impulse == pytest.approx(bodies.momentum(qpos, change) - pushed, abs=ROUNDING)
