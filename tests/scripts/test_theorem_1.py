"""Theorem 1 on the limit cycle: the return map against walks, and the numbers that docs/stability.md quotes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.error_dynamics import evolve, impact_gain, lyapunov_weights
from mjbiped.analysis.stability import stability
from scripts.paper.theorem_1 import cycle_stability, lyapunov_gain

gains = st.floats(0.05, 60.0)


@given(gains, gains, gains)
@settings(deadline=None, derandomize=True, max_examples=20)
def test_no_gain_lets_the_lyapunov_function_grow_within_a_step(k1: float, k2: float, gamma: float) -> None:
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2))
    controller = AdaptiveController(robot, gait, position_gain=k1, velocity_gain=k2, adaptation_gain=gamma)
    time = np.linspace(0.0, gait.period, 61)
    q, dq, _ = gait.reference(time)
    transitions = evolve(controller, time, q, dq).transitions
    gains_over_time = [lyapunov_gain(controller, phi) for phi in transitions[::10]]
    # each factor is the exponential of a matrix of the form of (22), up to Magnus' commutator, of third order
    assert np.diff(gains_over_time).max() < 1e-6
    assert gains_over_time[-1] < 1.0


def test_return_map_is_the_derivative_of_a_walk(controller: AdaptiveController) -> None:
    """A walk with a wrong estimate, not re-planned: what the return map leaves out is of second order."""
    controller = replace(controller, replanning_delay=None)
    cycle = cycle_stability(controller)
    left = []
    for error in (4e-3, 1e-3):
        wrong = replace(controller, initial_slope_estimate=error)
        walk = mjbiped.walk(wrong, mjbiped.Terrain.level(), engine="hybrid", steps=6, sample_period=2e-3)
        start = stability(walk).start
        predicted = start[:-1] @ cycle.return_map.T
        left.append(np.linalg.norm(start[1:] - predicted, axis=1).max() / np.linalg.norm(start[0]))
    assert left[1] < 0.05
    assert 3.5 < left[0] / left[1] < 4.5  # 4 for a remainder that is quadratic
    # the part of the slowest mode; eta is some 1e-6 there, with an error of integration of some 1e-11
    values, vectors = np.linalg.eig(cycle.return_map.T)
    slowest = start[4:] @ vectors[:, np.argmax(np.abs(values))].real
    assert slowest[1] / slowest[0] == pytest.approx(cycle.multipliers[0].real, rel=1e-3)


def test_numbers_of_the_papers_gains(controller: AdaptiveController) -> None:
    """(24) fails for them, whatever its constants, while the loop converges; docs/stability.md quotes these."""
    cycle = cycle_stability(controller)
    assert abs(cycle.multipliers[0]) == pytest.approx(0.2048, abs=1e-4)
    assert impact_gain(5.0, 0.0, 0.0) * cycle.contraction == pytest.approx(3.413, abs=1e-3)
    assert impact_gain(5.0, cycle.alpha, cycle.beta) * cycle.contraction == pytest.approx(11.13, abs=1e-2)
    assert lyapunov_weights(controller).tolist() == [1.0, 1.0, 1.0, 1.0, 1 / 0.3, 1 / 0.3]
