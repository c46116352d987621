"""What impacts ask of the ground under the stance foot, against the momenta of bodies with free feet."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robots.test_coulomb_impact import Array, floating_mass_matrix, lever_jacobian
from simulations import hybrid_simulation

import mjbiped
from controllers import AdaptiveController
from mjbiped.dynamics.modes import LOCKED
from mjbiped.engines.hybrid.forces import note_impact
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import hit_face, transfer_support
from mjbiped.engines.hybrid.run import HybridRun
from mjbiped.engines.hybrid.state import State
from mjbiped.terrain.terrain import Terrain

SLOPE = 0.05
LEGS = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
RATES = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
ROBOTS = {False: mjbiped.Compass(), True: mjbiped.KneedBiped()}
ROUNDING = 1e-11
"""Of momenta of some 50 kg m/s, from sums of that size, and from a system of equations."""


def standing(knees: bool, legs: tuple[float, float], rates: tuple[float, float]) -> HybridRun:
    """An unpowered robot with straight legs on a slope; the angles are from the vertical."""
    q, dq = [angle - SLOPE for angle in legs], [*rates]
    start = [*q, q[1], *dq, dq[1]] if knees else [*q, *dq]
    simulation = hybrid_simulation(Terrain.incline(math.degrees(SLOPE)), start)
    simulation.state.y[: len(start)] = start
    simulation.state.locked = LOCKED
    enter_mode(simulation.constants, simulation.state)
    return simulation


def impulse_of(w: State) -> tuple[float, float]:
    """The ground's impulse on the stance foot, forward and upward, N s."""
    along, normal = w.impulse_along, w.impulse_normal
    return along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine


def rates_of(w: State, knees: bool) -> Array:
    y = w.y
    return np.array([y[3], y[4]] if knees else [y[2], y[3]])


@pytest.mark.parametrize("knees", [False, True])
@given(legs=LEGS, rates=RATES)
@settings(deadline=None, derandomize=True, max_examples=50)
def test_a_face_asks_for_the_impulse_that_holds_the_stance_foot(
    knees: bool, legs: tuple[float, float], rates: tuple[float, float]
) -> None:
    """Three impulses, of stance foot and face, stop three speeds: solved with the feet free, apart from the engine."""
    simulation = standing(knees, legs, rates)
    robot, w = ROBOTS[knees], simulation.state
    w.face_x, w.landing = 0.3, 0
    hit_face(simulation.constants, w)
    angles, length = np.array(legs), robot.leg_length
    J = np.vstack([np.eye(2, 4), lever_jacobian(angles, (length, -length))[:1]])
    pushed = np.linalg.solve(floating_mass_matrix(robot, angles), J.T)
    impulses = np.linalg.solve(J @ pushed, -J @ [0.0, 0.0, *rates])
    assert impulse_of(w) == pytest.approx(impulses[:2], abs=ROUNDING)
    assert rates_of(w, knees) == pytest.approx(np.array(rates) + (pushed @ impulses)[2:], abs=ROUNDING)


@pytest.mark.parametrize("knees", [False, True])
@pytest.mark.parametrize("half", [0.1, 0.3])
def test_a_heel_strike_asks_for_the_whole_change_of_momentum(knees: bool, half: float) -> None:
    """The departing foot leaves freely."""
    legs, rates = (SLOPE + half, SLOPE - half), (1.1, 0.6)
    simulation = standing(knees, legs, rates)
    robot, w = ROBOTS[knees], simulation.state
    M = floating_mass_matrix(robot, np.array(legs))
    transfer_support(simulation.constants, w)
    assert w.count == 1
    landed, departing = rates_of(w, knees)
    length = robot.leg_length
    foot = -lever_jacobian(np.array(legs), (length, -length))[:, 2:] @ [departing, landed]
    after = np.array([*foot, departing, landed])
    impulse = (M @ (after - [0.0, 0.0, *rates]))[:2]
    assert impulse_of(w) == pytest.approx(impulse, abs=ROUNDING)


def test_an_impulse_is_spread_over_the_time_that_forces_are_averaged_over() -> None:
    """On level ground: 0.016 pendulum times, 4.86 ms for a leg of 0.9 m; and it is taken in once."""
    simulation = hybrid_simulation(Terrain.level(), (-0.2, 0.2, 1.0, 0.5))
    constants, w = simulation.constants, simulation.state
    time = 0.016 * math.sqrt(constants.length / constants.linkages[0].gravity)
    w.along_now, w.normal_now, w.normal_force, w.friction = 20.0, 100.0, 90.0, 0.3
    w.impulse_along, w.impulse_normal = 25.0 * time, -50.0 * time
    for _ in range(2):
        note_impact(constants, w)
        assert (w.normal_force, w.friction) == pytest.approx((50.0, 0.9), rel=1e-14)
    w.impulse_normal = -150.0 * time
    note_impact(constants, w)
    assert w.normal_force == pytest.approx(-50.0, rel=1e-14)


@pytest.mark.parametrize(("share", "violated"), [(0.5, False), (0.6, True), (0.7, True), (0.8, False)])
def test_a_riser_that_is_struck_costs_both_engines_their_contact(
    share: float, violated: bool, controller: AdaptiveController
) -> None:
    """The impulse lifts the stance foot: MuJoCo's hops and slides by 4 mm, the hybrid engine's ground has to pull."""
    place = (4.0 + share) * controller.gait.step_length
    ground = mjbiped.Terrain.from_segments([(place, 0.0, 0.0), (1.0, 0.0, 0.04)])
    for engine in ("hybrid", "mujoco"):
        walk = mjbiped.walk(controller, ground, engine=engine, steps=7)
        assert walk.touchdowns["strikes"].any() == violated
        assert walk.contact_violations.any() == violated, engine
