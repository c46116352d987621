"""The adaptive controller as a whole: memory, planning, switches, refusals, and a hybrid simulation written here."""

import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mjbiped
from controllers import AdaptiveController, Memory
from mjbiped.controllers.room import COS, CURVES, REPLANNED, ROOM, SIN
from mjbiped.errors import InputError
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

ROBOT = Compass()
GAIT = find_passive_gait(ROBOT, math.radians(2))
PAPER = AdaptiveController(ROBOT, GAIT, position_gain=5, velocity_gain=12, adaptation_gain=0.3, replanning_delay=0.8)
CYCLE: list[float] = GAIT.start.tolist()
OFF = ([-0.25, 0.13], [0.8, 1.1])  # a first state far off the limit cycle

offsets = st.floats(-0.3, 0.3)
states = st.tuples(offsets, offsets, st.floats(-1, 1), st.floats(-1, 1)).map(lambda o: (GAIT.start + o).tolist())


class Guarded(list[float]):
    """A memory of fixed size that refuses every index but its own places, and writing where it is locked."""

    locked = False

    def __getitem__(self, index: Any) -> Any:
        assert isinstance(index, int)
        assert 0 <= index < len(self)
        return super().__getitem__(index)

    def __setitem__(self, index: Any, value: Any) -> None:
        assert not self.locked
        assert isinstance(index, int)
        assert 0 <= index < len(self)
        assert isinstance(value, float)
        super().__setitem__(index, value)


def started(controller: AdaptiveController, q: Sequence[float], dq: Sequence[float]) -> list[float]:
    """Memory after the start of a walk."""
    memory = [0.0] * controller.memory_size
    controller.start(memory, q, dq)
    return memory


# --- memory -----------------------------------------------------------------------------------------------------------


def test_integrated_states_stand_first_in_the_memory() -> None:
    assert PAPER.states == ("sin_slope_estimate", "cos_slope_estimate")
    controller = replace(PAPER, initial_slope_estimate=0.3)
    memory = started(controller, *OFF)
    assert memory[:2] == [math.sin(0.3), math.cos(0.3)]
    assert controller.slope_estimate(memory) == pytest.approx(0.3, abs=1e-15)  # rounding of sine and arcsine
    assert len(controller.torque(memory, 0.1, *OFF)) == 2 + len(PAPER.states)


def test_memory_is_used_within_its_size_and_never_written_by_the_law() -> None:
    memory = Guarded([0.0] * PAPER.memory_size)
    PAPER.start(memory, *OFF)
    before = list(memory)
    for t in (0.0, 0.3, 0.7, 2.0, 1e3):
        memory.locked = True
        PAPER.torque(memory, t, *OFF)
        PAPER.reference(memory, t)
        PAPER.slope_estimate(memory)
        memory.locked = False
    assert list(memory) == before
    PAPER.on_touchdown(memory, [0.2, -0.2], *OFF)
    PAPER.on_touchdown(memory, [0.2, -0.2], CYCLE[:2], CYCLE[2:])
    assert len(memory) == PAPER.memory_size


def test_the_memory_is_used_and_its_room_is_not() -> None:
    """The law of a re-planned step reads estimates and curves; what stands in the room changes nothing."""
    memory = started(PAPER, *OFF)
    torque = PAPER.torque(memory, 0.3, *OFF)
    for place in range(PAPER.memory_size):
        changed = list(memory)
        changed[place] = 0.0 if place == REPLANNED else changed[place] + 0.1
        used = place in (SIN, COS, REPLANNED) or place >= CURVES
        if used or place >= ROOM:
            assert (PAPER.torque(changed, 0.3, *OFF) != torque) == used


def test_list_and_array_give_the_same_numbers_bit_by_bit() -> None:
    outputs = []
    for memory in ([0.0] * PAPER.memory_size, np.zeros(PAPER.memory_size)):
        room: Any = memory
        PAPER.start(room, *OFF)
        numbers = [PAPER.torque(room, t, *OFF) for t in (0.0, 0.3, 0.7)]
        PAPER.on_touchdown(room, [0.25, -0.2], [-0.2, 0.2], [1.0, 0.9])
        numbers += [PAPER.torque(room, t, *OFF) for t in (0.0, 0.3, 0.7)]
        outputs.append(np.array([*np.ravel(numbers), *room, PAPER.slope_estimate(room)]).tobytes())
    assert outputs[0] == outputs[1]


def test_states_may_come_as_arrays() -> None:
    plain = started(PAPER, *OFF)
    memory = [0.0] * PAPER.memory_size
    arrays: Any = [np.array(part) for part in OFF]  # no Sequence to mypy
    q, dq = arrays
    PAPER.start(memory, q, dq)
    assert memory == plain
    assert tuple(PAPER.torque(memory, 0.3, q, dq)) == tuple(PAPER.torque(plain, 0.3, *OFF))


def test_nothing_remains_of_an_earlier_step() -> None:
    """A step that starts on the cycle is led by the gait, though the one before it was re-planned."""
    memory = started(PAPER, *OFF)
    PAPER.on_touchdown(memory, [CYCLE[1], CYCLE[0]], CYCLE[:2], CYCLE[2:])
    for t in (0.0, 0.3, 0.7):
        assert PAPER.reference(memory, t) == motion_at(GAIT.tables[0], t)


@given(states, states, st.floats(0, 1), st.floats(-0.5, 0.5))
@settings(deadline=None, derandomize=True)
def test_law_is_equations_14_and_17_with_the_estimates_in_memory(
    first: list[float], state: list[float], t: float, estimate: float
) -> None:
    controller = replace(PAPER, position_gain=4.0, velocity_gain=9.0, adaptation_gain=0.7)
    memory = started(controller, first[:2], first[2:])
    memory[:2] = [1.1 * math.sin(estimate), 0.9 * math.cos(estimate)]  # off the unit circle, as (17) leaves them
    q, dq = np.array(state[:2]), np.array(state[2:])
    q_r, dq_r, ddq_r = np.array(controller.reference(memory, t)).reshape(3, 2)
    z1, dz1 = q_r - q, dq_r - dq
    K1, K2 = 4.0 * np.eye(2), 9.0 * np.eye(2)
    M, C, B = ROBOT.mass_matrix(q), ROBOT.coriolis_matrix(q, dq), ROBOT.input_matrix
    gc, gs = ROBOT.gravity_vector(q, math.pi / 2), ROBOT.gravity_vector(q, 0.0)
    wanted = ddq_r + (K1 @ K2 + np.eye(2)) @ z1 + (K1 + K2) @ dz1
    tau = np.linalg.inv(B) @ (M @ wanted + C @ dq + gc * memory[0] + gs * memory[1])
    rates = 0.7 * np.linalg.inv(M) @ (dz1 + K1 @ z1)
    # rounding of a few dozen operations on terms of up to some 1e3 N m and 1e2 1/s
    found = controller.torque(memory, t, state[:2], state[2:])
    np.testing.assert_allclose(found, [*tau, rates @ gc, rates @ gs], rtol=0, atol=1e-10)


# --- planning ---------------------------------------------------------------------------------------------------------


@given(states, st.floats(0.1, 1.0))
@settings(deadline=None, derandomize=True)
def test_transition_starts_at_the_measured_state_with_the_passive_acceleration(state: list[float], zeta: float) -> None:
    controller = replace(PAPER, replanning_delay=zeta, replanning_threshold=1e-300)
    q, dq = np.array(state[:2]), np.array(state[2:])
    reference = controller.reference(started(controller, state[:2], state[2:]), 0.0)
    # rounding of control points of the order of 1, divided by (zeta T)^2 / 20 >= 3e-4 for the acceleration
    np.testing.assert_allclose(reference[:4], state, rtol=0, atol=1e-12)
    passive = -(ROBOT.coriolis_matrix(q, dq) @ dq + ROBOT.gravity_vector(q, GAIT.slope))
    np.testing.assert_allclose(reference[4:], np.linalg.solve(ROBOT.mass_matrix(q), passive), rtol=0, atol=1e-10)


@given(states, st.floats(0.1, 1.0))
@settings(deadline=None, derandomize=True)
def test_additive_replanning_adds_the_error_to_the_gait_until_it_is_closed(state: list[float], zeta: float) -> None:
    controller = replace(PAPER, replanning="additive", replanning_delay=zeta)
    memory = started(controller, state[:2], state[2:])
    end = controller.transition_end(memory)
    if end == 0.0:  # the state is as good as on the limit cycle
        return
    first = controller.reference(memory, 0.0)
    gait = motion_at(GAIT.tables[0], 0.0)
    # the measured state, with the gait's own acceleration; rounding of numbers near 1, times 20 / t_c²
    np.testing.assert_allclose(first[:4], state, rtol=0, atol=1e-13)
    np.testing.assert_allclose(first[4:], gait[4:], rtol=0, atol=1e-12 / end**2)
    for t in np.linspace(0.0, end, 7).tolist():
        share = t / end
        # the quintic that leads from an error and its rate to zero, its second derivatives zero at both ends
        of_error = (1 - share) ** 3 * (1 + 3 * share + 6 * share**2)
        of_rate = end * share * (1 - share) ** 3 * (1 + 3 * share)
        gait = motion_at(GAIT.tables[0], t)
        for leg in (0, 1):
            expected = gait[leg] + of_error * (state[leg] - CYCLE[leg]) + of_rate * (state[2 + leg] - CYCLE[2 + leg])
            assert controller.reference(memory, t)[leg] == pytest.approx(expected, abs=1e-13)
    assert controller.reference(memory, end) == motion_at(GAIT.tables[0], end)


def test_additive_replanning_tracks_what_it_plans() -> None:
    """From a state off the limit cycle the robot stays on the reference: no error arises, with the slope known."""
    controller = replace(PAPER, replanning="additive")
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1, initial=[-0.2, 0.2, 1.0, 0.7])
    memory = started(controller, [-0.2, 0.2], [1.0, 0.7])
    for t, q in zip(walk.samples["time"].tolist(), walk.samples["q"], strict=True):
        if t < walk.touchdowns["time"][0]:
            # the integration's tolerance of 1e-8 a step
            np.testing.assert_allclose(q, controller.reference(memory, t)[:2], rtol=0, atol=1e-6)


@given(states, st.floats(0.1, 1.0))
@settings(deadline=None, derandomize=True)
def test_transition_joins_the_gait_with_position_rate_and_acceleration(state: list[float], zeta: float) -> None:
    controller = replace(PAPER, replanning_delay=zeta, replanning_threshold=1e-300)
    memory = started(controller, state[:2], state[2:])
    end = zeta * GAIT.period
    before, after = controller.reference(memory, math.nextafter(end, 0.0)), controller.reference(memory, end)
    assert after == motion_at(GAIT.tables[0], end)
    # as above; within an ulp of the time nothing moves by more
    np.testing.assert_allclose(before[:4], after[:4], rtol=0, atol=1e-12)
    np.testing.assert_allclose(before[4:], after[4:], rtol=0, atol=1e-10)


@pytest.mark.parametrize("zeta", [0.2, 0.8, 1.0])
def test_reference_is_one_smooth_motion(zeta: float) -> None:
    """Rates and accelerations are the derivatives of the angles, on the curve, after it and across the joint."""
    controller = replace(PAPER, replanning_delay=zeta)
    memory = started(controller, *OFF)
    step = 1e-4
    joint = zeta * GAIT.period
    for t in (0.03, 0.5 * joint, joint, joint + 0.05):
        early, now, late = (np.array(controller.reference(memory, time)) for time in (t - step, t, t + step))
        # central differences over 1e-4 s: h^2 / 6 times the third derivative (some 1e3 for zeta = 0.2), and at the
        # joint h / 4 times the jump of the third derivative for the acceleration
        np.testing.assert_allclose((late - early)[:2] / (2 * step), now[2:4], rtol=0, atol=1e-5)
        np.testing.assert_allclose((late - early)[2:4] / (2 * step), now[4:], rtol=0, atol=0.1)


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_only_a_step_off_the_limit_cycle_is_planned_anew(place: int, sign: float) -> None:
    threshold = PAPER.replanning_threshold
    for part, planned in ((0.9, False), (1.1, True)):
        state = list(CYCLE)
        state[place] += sign * part * threshold
        memory = started(PAPER, state[:2], state[2:])
        # on the curve the step starts at the measured state, otherwise at the cycle's
        expected = state if planned else CYCLE
        # rounding as above; both lie 1e-2 apart
        np.testing.assert_allclose(PAPER.reference(memory, 0.0)[:4], expected, rtol=0, atol=1e-12)


def test_replanning_can_be_switched_off() -> None:
    controller = replace(PAPER, replanning_delay=None)
    memory = started(controller, *OFF)
    controller.on_touchdown(memory, [0.25, -0.2], *OFF)
    for t in (0.0, 0.3, 0.7, 0.9):
        assert controller.reference(memory, t) == motion_at(GAIT.tables[0], t)


def test_estimate_update_can_be_switched_off() -> None:
    q_before, q = [0.25, -0.15], [-0.2, 0.2]  # the slope changes by 0.05
    for update, change in ((True, 0.05), (False, 0.0)):
        controller = replace(PAPER, estimate_update=update, initial_slope_estimate=0.1)
        memory = started(controller, CYCLE[:2], CYCLE[2:])
        controller.on_touchdown(memory, q_before, q, [1.0, 0.9])
        assert controller.slope_estimate(memory) == pytest.approx(0.1 + change, abs=1e-15)  # rounding of arcsin


def test_estimate_is_updated_only_above_the_threshold() -> None:
    controller = replace(PAPER, update_threshold=0.01)
    for change, expected in ((0.009, 0.0), (-0.009, 0.0), (0.011, 0.011), (-0.011, -0.011)):
        memory = started(controller, CYCLE[:2], CYCLE[2:])
        controller.on_touchdown(memory, [0.2 + change, -0.2], [-0.2 - change, 0.2], [1.0, 0.9])
        assert controller.slope_estimate(memory) == pytest.approx(expected, abs=1e-15)  # rounding of 0.2 + change


# --- parameters -------------------------------------------------------------------------------------------------------

POSITIVE = ("position_gain", "velocity_gain", "adaptation_gain", "update_threshold", "replanning_threshold")


@pytest.mark.parametrize("name", POSITIVE)
@pytest.mark.parametrize("value", [-1e-9, -1.0, math.nan, math.inf, "5", None])
def test_gains_and_thresholds_outside_their_domain_are_refused_by_name(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"^{name} "):
        replace(PAPER, **{name: value})


@pytest.mark.parametrize("zeta", [0.0, -0.1, 1.2, math.nextafter(1.0, 2.0), math.nan, math.inf])
def test_delays_outside_the_paper_s_interval_are_refused(zeta: float) -> None:
    with pytest.raises(InputError, match="replanning_delay"):
        replace(PAPER, replanning_delay=zeta)


@pytest.mark.parametrize("zeta", [1, 1.0, 1e-3, None])
def test_delays_within_it_pass(zeta: float | None) -> None:
    assert replace(PAPER, replanning_delay=zeta).replanning_delay == zeta


@pytest.mark.parametrize("slope", [math.pi / 2, -2.0, math.nan, math.inf])
def test_an_initial_estimate_that_is_no_slope_is_refused(slope: float) -> None:
    with pytest.raises(InputError, match="initial_slope_estimate"):
        replace(PAPER, initial_slope_estimate=slope)


def test_description_is_json_and_complete() -> None:
    for controller in (PAPER, replace(PAPER, replanning_delay=None, estimate_update=False)):
        description = controller.describe()
        assert json.loads(json.dumps(description, allow_nan=False)) == description
        assert set(description) == {"name", *(field.name for field in fields(controller))}
        assert description["gait"]["slope"] == GAIT.slope
        assert description["replanning_delay"] == controller.replanning_delay
        assert Compass(**description["robot"]) == ROBOT


# --- a hybrid simulation of its own -----------------------------------------------------------------------------------


@dataclass
class Step:
    """One step of the hybrid system: times, errors of what was tracked, slope and estimates around the touchdown."""

    period: float
    first_error: float  # max |q_r - q|, rad, at the step's start
    last_error: float  # and at its end
    last_states: Array
    slope: float  # of the next step
    estimate_before: float
    estimate_after: float
    replanned: bool


class Ground:
    """A profile of straight pieces through the origin: corners at `corners` (m), slopes in degrees."""

    def __init__(self, corners: Sequence[float], degrees: Sequence[float]) -> None:
        self.corners, self.slopes = np.array(corners), np.radians(degrees)
        assert self.corners.min() > 0
        self.heights = np.zeros(len(corners))
        before = 0.0
        for k, corner in enumerate(corners):
            start = self.heights[k - 1] if k else 0.0
            self.heights[k] = start - math.tan(self.slopes[k]) * (corner - before)
            before = corner

    def slope(self, x: float) -> float:
        return float(self.slopes[np.searchsorted(self.corners, x, side="right")])

    def height(self, x: float) -> float:
        k = max(int(np.searchsorted(self.corners, x, side="right")) - 1, 0)
        return float(self.heights[k]) - math.tan(self.slope(x)) * (x - float(self.corners[k]))


def walk(controller: AdaptiveController, ground: Ground, count: int, start: Sequence[float]) -> list[Step]:
    """Equations (1)-(4) with SciPy: motion with the controller's states, guard on the ground, impact map."""
    l, memory = ROBOT.leg_length, [0.0] * controller.memory_size  # noqa: E741 - the paper's symbol
    many = len(controller.states)
    q, dq = np.array(start[:2]), np.array(start[2:])
    controller.start(memory, q.tolist(), dq.tolist())
    foot, steps = 0.0, []

    for _ in range(count):
        slope = ground.slope(foot)

        def rates(t: float, y: Array, slope: float = slope) -> Array:
            now: Memory = [*y[4:].tolist(), *memory[many:]]
            ankle, hip, *states = controller.torque(now, t, y[:2].tolist(), y[2:4].tolist())
            force = ROBOT.input_matrix @ [ankle, hip] - ROBOT.coriolis_matrix(y[:2], y[2:4]) @ y[2:4]
            ddq = np.linalg.solve(ROBOT.mass_matrix(y[:2]), force - ROBOT.gravity_vector(y[:2], slope))
            return np.array([*y[2:4], *ddq, *states])

        def clearance(_: float, y: Array, slope: float = slope, foot: float = foot) -> float:
            theta1, theta2 = y[0] + slope, y[1] + slope
            ahead = l * (math.sin(theta1) - math.sin(theta2))
            up = l * (math.cos(theta1) - math.cos(theta2))
            # straight legs scuff while they pass each other
            return up + ground.height(foot) - ground.height(foot + ahead) if ahead > 0.2 * l else 1.0

        clearance.terminal, clearance.direction = True, -1.0  # type: ignore[attr-defined]  # SciPy's way
        begin = [*q, *dq, *memory[:many]]
        solution = solve_ivp(rates, (0.0, 1.5), begin, "DOP853", rtol=1e-9, atol=1e-11, events=clearance)
        assert solution.status == 1, "no touchdown"
        time, end = float(solution.t[-1]), solution.y[:, -1]
        first, last = (np.array(controller.reference(memory, t))[:2] for t in (0.0, time))
        errors = float(np.abs(first - q).max()), float(np.abs(last - end[:2]).max())
        middle = 0.5 * time
        replanned = controller.reference(memory, middle) != motion_at(GAIT.tables[0], middle)

        memory[:many] = end[4:].tolist()
        foot += l * (math.sin(end[0] + slope) - math.sin(end[1] + slope))
        q, dq = ROBOT.impact(end[:2], end[2:4])
        q = q - (ground.slope(foot) - slope)  # eq. (2)
        before = controller.slope_estimate(memory)
        controller.on_touchdown(memory, end[:2].tolist(), q.tolist(), dq.tolist())
        after = controller.slope_estimate(memory)
        steps.append(Step(time, *errors, end[:4], ground.slope(foot), before, after, replanned))
    return steps


UNEVEN = Ground([0.5, 1.2], [0, 3, -2])


def test_ground_of_this_test_is_continuous_and_has_its_slopes() -> None:
    # a nanometre of corner times a slope of 0.05; differences of 1e-6 m lose ten digits of sixteen
    for corner in UNEVEN.corners:
        assert UNEVEN.height(corner - 1e-9) == pytest.approx(UNEVEN.height(corner), abs=1e-10)
    for x in (0.1, 0.7, 2.0):
        fall = UNEVEN.height(x - 5e-7) - UNEVEN.height(x + 5e-7)
        assert math.atan(fall / 1e-6) == pytest.approx(UNEVEN.slope(x), abs=1e-9)


def test_on_uneven_ground_the_estimate_follows_every_change_of_slope_at_once() -> None:
    steps = walk(PAPER, UNEVEN, 6, CYCLE)
    assert sorted({round(math.degrees(step.slope), 9) for step in steps}) == [-2.0, 0.0, 3.0]
    for step in steps:
        # with a true estimate (27) gives the true slope; what is left is the integration's error, 1e-9 per step
        assert step.estimate_after == pytest.approx(step.slope, abs=1e-7)
        # transitions begin in the measured state, so that nothing is ever off the reference
        assert step.last_error < 1e-7
    assert [step.replanned for step in steps].count(True) == 2  # the step after each change of slope, no other
    # back on the limit cycle: (28)'s own touchdown, to the table's and the integration's accuracy
    np.testing.assert_allclose(steps[-1].last_states, GAIT.end, rtol=0, atol=1e-6)
    assert steps[-1].period == pytest.approx(GAIT.period, abs=1e-6)


def test_a_wrong_estimate_is_found_out_by_walking() -> None:
    """Starting with "level" on 3 degrees: the estimate converges by (17), and by (27) keeps its error over a change."""
    ground = Ground([0.9], [3, 1])
    steps = walk(PAPER, ground, 4, CYCLE)
    # the slope under the step that an estimate belongs to
    true = [math.radians(3), *(step.slope for step in steps)]
    errors = [abs(PAPER.initial_slope_estimate - true[0])]
    for step, old, new in zip(steps, true, true[1:], strict=False):
        before, after = step.estimate_before - old, step.estimate_after - new
        # (27) neither adds nor takes: exact angles, arcsin's rounding and the integration's 1e-9
        assert after == pytest.approx(before, abs=1e-7)
        errors.append(abs(after))
    # the paper's gains: each step leaves a fraction of the error (observed 0.04 to 0.22)
    assert all(later < 0.5 * earlier for earlier, later in itertools.pairwise(errors))
    assert errors[-1] < 1e-3
    assert steps[-1].last_error < 0.1 * steps[0].last_error  # tracking heals with the estimate (Theorem 1)
    assert true[-1] == math.radians(1)  # the change was walked over


def test_without_the_update_only_the_adaptive_law_finds_the_new_slope() -> None:
    """Fig. 5 of the paper: both arrive, (27) at once."""
    ground = Ground([0.5], [0, 3])
    jumped, plain = (
        walk(controller, ground, 5, CYCLE) for controller in (PAPER, replace(PAPER, estimate_update=False))
    )
    change = next(k for k, step in enumerate(jumped) if step.slope > 0)
    assert abs(jumped[change].estimate_after - jumped[change].slope) < 1e-7  # as above
    assert abs(plain[change].estimate_after - plain[change].slope) > 0.04  # the whole 3 degrees are missing
    assert abs(plain[-1].estimate_after - plain[-1].slope) < 1e-3  # and gone after three steps
    assert max(step.last_error for step in plain) > 100 * max(step.last_error for step in jumped)


def test_without_replanning_the_error_decays_within_the_step() -> None:
    controller = replace(PAPER, replanning_delay=None)
    steps = walk(controller, UNEVEN, 6, CYCLE)
    changed = [step for step in steps if step.first_error > 0.01]
    assert len(changed) == 2
    for step in changed:
        # z1 obeys z'' + 17 z' + 61 z = 0 while the estimate is true: the slow root is 5.1 / s, and exp(-5.1 T) = 0.02;
        # five times that for the initial rate and the adaptation that the error sets off
        assert step.last_error < 0.1 * step.first_error
    assert abs(steps[-1].estimate_after - steps[-1].slope) < 5e-3  # disturbed by the errors (Fig. 6), not lost


def test_from_rest_the_robot_walks_into_the_gait() -> None:
    """Section V-B: both legs together, at rest, level ground."""
    steps = walk(PAPER, Ground([99.0], [0, 0]), 2, [0.0, 0.0, 0.0, 0.0])
    assert [step.replanned for step in steps] == [True, False]
    # the first step already ends as the gait's do; integration errors as above
    np.testing.assert_allclose(steps[0].last_states, GAIT.end, rtol=0, atol=1e-6)
    assert steps[0].period == pytest.approx(GAIT.period, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("replanning_delay", "0.8"),
        ("replanning_delay", True),
        ("initial_slope_estimate", "0"),
        ("estimate_update", "no"),
        ("robot", None),
        ("gait", None),
        ("position_gain", "5"),
    ],
)
def test_values_of_another_type_are_refused(name: str, value: Any) -> None:
    with pytest.raises(InputError):
        replace(PAPER, **{name: value})


@pytest.mark.parametrize("value", [np.float32(5.0), np.int64(5), 5])
def test_numpy_numbers_are_numbers(value: Any) -> None:
    assert replace(PAPER, position_gain=value).position_gain == 5
