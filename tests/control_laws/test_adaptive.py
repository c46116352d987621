"""The paper's controller: equations (5) to (17) and (27), transitions, memory, switches, refusals."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from controllers import AdaptiveController
from mjbiped.controllers.replanning import transition_at
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

ROBOT = Compass()
GAIT = find_passive_gait(ROBOT, math.radians(2))
PAPER = AdaptiveController(ROBOT, GAIT, position_gain=5, velocity_gain=12, adaptation_gain=0.3, replanning_delay=0.8)
ROBOTS = [
    ROBOT,
    Compass(hip_mass=10.0, leg_inertia=0.0),
    Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
]
CYCLE: list[float] = GAIT.start.tolist()
OFF = ([-0.25, 0.13], [0.8, 1.1])  # a first state far off the limit cycle

offsets = st.floats(-0.3, 0.3)
states = st.tuples(offsets, offsets, st.floats(-1, 1), st.floats(-1, 1)).map(lambda o: (GAIT.start + o).tolist())
wide = st.tuples(*[st.floats(-1.5, 1.5)] * 2, *[st.floats(-8, 8)] * 2).map(np.array)
gains = st.floats(0.1, 50)
slopes = st.floats(-0.5, 0.5)


def started(controller: AdaptiveController, q: Sequence[float], dq: Sequence[float]) -> list[float]:
    """Memory after the start of a walk."""
    memory = [0.0] * controller.memory_size
    controller.start(memory, q, dq)
    return memory


def acceleration(robot: Compass, q: Array, dq: Array, slope: float, tau: Array) -> Array:
    """Eq. (1) solved for the accelerations, with matrices."""
    force = robot.input_matrix @ tau - robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
    return np.asarray(np.linalg.solve(robot.mass_matrix(q), force))


@given(st.sampled_from(ROBOTS), wide, st.floats(0, 1), slopes, slopes, st.tuples(gains, gains, gains))
@settings(derandomize=True)
def test_the_laws_are_equations_14_and_17_and_theorem_1_holds(
    robot: Compass, state: Array, t: float, slope: float, estimate: float, given_gains: tuple[float, float, float]
) -> None:
    k1, k2, gamma = given_gains
    controller = replace(PAPER, robot=robot, position_gain=k1, velocity_gain=k2, adaptation_gain=gamma)
    memory, q, dq = started(controller, *OFF), state[:2], state[2:]
    memory[:2] = [1.1 * math.sin(estimate), 0.9 * math.cos(estimate)]  # off the unit circle, as (17) leaves them
    q_r, dq_r, ddq_r = np.array(controller.reference(memory, t)).reshape(3, 2)
    z1, dz1 = q_r - q, dq_r - dq
    z2, M = dz1 + k1 * z1, robot.mass_matrix(q)
    gc, gs = robot.gravity_vector(q, math.pi / 2), robot.gravity_vector(q, 0.0)
    wanted = ddq_r + (k1 * k2 + 1) * z1 + (k1 + k2) * dz1
    force = M @ wanted + robot.coriolis_matrix(q, dq) @ dq + gc * memory[0] + gs * memory[1]
    tau, inverse = np.linalg.solve(robot.input_matrix, force), np.linalg.inv(M)
    rates = gamma * z2 @ inverse @ np.transpose([gc, gs])
    found = np.array(controller.torque(memory, t, q.tolist(), dq.tolist()))
    # rounding of a few dozen operations, relative to the terms added up
    size = np.abs(M).sum() * (np.abs(wanted).max() + dq @ dq) + np.abs(gc).sum() + np.abs(gs).sum() + 1.0
    np.testing.assert_allclose(found[:2], tau, rtol=0, atol=1e-13 * size)
    norm = np.linalg.norm(inverse, 2)
    of_rates = 1e-13 * gamma * np.abs(z2).max() * norm * (np.abs(gc).sum() + np.abs(gs).sum())
    np.testing.assert_allclose(found[2:], rates, rtol=0, atol=of_rates + 1e-300)
    errors = np.array(controller.tracking_errors(memory, t, q.tolist(), dq.tolist()))
    np.testing.assert_allclose(errors, [*z1, *dz1, *z2], rtol=1e-14, atol=1e-14)
    # the derivative of Va along the motion: the slope's errors cancel (15), (16)
    ddq = acceleration(robot, q, dq, slope, found[:2])
    error = np.array([math.sin(slope), math.cos(slope)]) - memory[:2]
    derivative = z1 @ dz1 + z2 @ (ddq_r - ddq + k1 * dz1) - error @ found[2:] / gamma
    tolerance = 1e-13 * (np.abs(z2).sum() * norm * size + k1 * z1 @ z1 + k2 * z2 @ z2)
    assert derivative == pytest.approx(-k1 * z1 @ z1 - k2 * z2 @ z2, rel=0, abs=tolerance)


six = st.tuples(*[st.floats(-3, 3)] * 6)


@given(st.floats(0.02, 3.0), six, st.floats(0, 1))
@settings(derandomize=True)
def test_transitions_are_scipys_bernstein_polynomials(duration: float, numbers: tuple[float, ...], part: float) -> None:
    t, powers = part * duration, duration ** -np.arange(3.0)
    curve = BPoly(np.array(numbers)[:, None], [0.0, duration])
    found = transition_at([7.0, *numbers], 1, duration, t)
    # rounding of a few dozen operations: the second difference of control points is divided by t_c^2 / 20
    tolerance = 1e-14 * (max(map(abs, numbers)) + 1e-300) * np.array([1.0, 10.0, 80.0]) * powers
    assert (np.abs(found - np.array([float(curve.derivative(k)(t)) for k in range(3)])) <= tolerance).all()


@given(states, st.floats(0.1, 1.0))
@settings(derandomize=True)
def test_a_transition_leads_from_the_measured_state_to_the_gait(state: list[float], zeta: float) -> None:
    """It begins with the passive acceleration."""
    assume(state != CYCLE)
    controller = replace(PAPER, replanning_delay=zeta, replanning_threshold=1e-300)
    q, dq, end = np.array(state[:2]), np.array(state[2:]), zeta * GAIT.period
    memory = started(controller, state[:2], state[2:])
    first, before = controller.reference(memory, 0.0), controller.reference(memory, math.nextafter(end, 0.0))
    passive = acceleration(ROBOT, q, dq, GAIT.slope, np.zeros(2))
    # rounding of control points of the order of 1, divided by (zeta T)^2 / 20 >= 3e-4 for the acceleration
    for found, expected in ((first, [*state, *passive]), (before, motion_at(GAIT.tables[0], end))):
        np.testing.assert_allclose(found[:4], expected[:4], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found[4:], expected[4:], rtol=0, atol=1e-10)
    assert controller.transition_end(memory) == end
    assert controller.next_discontinuity(memory, 0.0) == end
    assert controller.reference(memory, end) == motion_at(GAIT.tables[0], end)


@given(states, st.floats(0.1, 1.0))
@settings(derandomize=True)
def test_additive_replanning_adds_the_error_to_the_gait_until_it_is_closed(state: list[float], zeta: float) -> None:
    controller = replace(PAPER, replanning="additive", replanning_delay=zeta)
    memory = started(controller, state[:2], state[2:])
    end = controller.transition_end(memory)
    if end == 0.0:  # the state is as good as on the limit cycle
        return
    away = np.array(state) - CYCLE
    for share in np.linspace(0.0, 1.0, 7).tolist():
        # the quintic that leads from an error and its rate to zero, its second derivatives zero at both ends
        of_error = (1 - share) ** 3 * (1 + 3 * share + 6 * share**2)
        of_rate = end * share * (1 - share) ** 3 * (1 + 3 * share)
        expected = motion_at(GAIT.tables[0], share * end)[:2] + of_error * away[:2] + of_rate * away[2:]
        np.testing.assert_allclose(controller.reference(memory, share * end)[:2], expected, rtol=0, atol=1e-13)
    first, gait = controller.reference(memory, 0.0), motion_at(GAIT.tables[0], 0.0)
    np.testing.assert_allclose(first[:4], state, rtol=0, atol=1e-13)
    np.testing.assert_allclose(first[4:], gait[4:], rtol=0, atol=1e-12 / end**2)
    assert controller.reference(memory, end) == motion_at(GAIT.tables[0], end)


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_only_a_step_off_the_limit_cycle_is_planned_anew(place: int, sign: float) -> None:
    for part, planned in ((0.9, False), (1.1, True)):
        state = list(CYCLE)
        state[place] += sign * part * PAPER.replanning_threshold
        memory = started(PAPER, *OFF)
        PAPER.on_touchdown(memory, [CYCLE[1], CYCLE[0]], state[:2], state[2:])  # nothing remains of the first step
        # on the curve the step starts at the measured state, otherwise at the cycle's; rounding, both lie 1e-2 apart
        expected = state if planned else CYCLE
        np.testing.assert_allclose(PAPER.reference(memory, 0.0)[:4], expected, rtol=0, atol=1e-12)
        if not planned:
            assert PAPER.reference(memory, 0.3) == motion_at(GAIT.tables[0], 0.3)


@given(slopes, st.floats(-0.1, 0.1), slopes, st.floats(-1.0, 1.0))
@settings(derandomize=True)
def test_the_update_27_finds_every_change_of_slope_and_keeps_the_estimates_error(
    before: float, error: float, after: float, leg: float
) -> None:
    """The leg that leaves the ground has one angle from the vertical; both normals are told from it."""
    controller = replace(PAPER, initial_slope_estimate=before + error, update_threshold=0.0)
    memory = started(controller, CYCLE[:2], CYCLE[2:])
    controller.on_touchdown(memory, [leg - before, 0.2], [0.2, leg - after], [1.0, 0.9])
    assert controller.slope_estimate(memory) == pytest.approx(after + error, abs=5e-15)  # arcsin's rounding
    assert math.hypot(*memory[:2]) == pytest.approx(1.0, abs=3e-16)  # two ulp of 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_changes_up_to_the_threshold_leave_the_estimate_untouched_and_a_switch_all(sign: float) -> None:
    swing, change = 0.25, 0.125  # powers of two: differences are exact
    below = math.nextafter(change, 0.0)
    for threshold, update, changed in ((change, True, False), (below, True, True), (0.0, False, False)):
        controller = replace(PAPER, update_threshold=threshold, estimate_update=update)
        for sine, angle in ((0.3, math.asin(0.3)), (1.7, math.pi / 2), (-1e9, -math.pi / 2)):
            memory = started(controller, CYCLE[:2], CYCLE[2:])
            memory[:2] = [sine, 0.8]  # off the unit circle, as the adaptive law may have left them
            assert controller.slope_estimate(memory) == pytest.approx(angle, abs=2e-16)
            controller.on_touchdown(memory, [swing + sign * change, 0.2], [0.2, swing], [1.0, 0.9])
            assert memory[:2] == ([math.sin(angle + sign * change), memory[1]] if changed else [sine, 0.8])
