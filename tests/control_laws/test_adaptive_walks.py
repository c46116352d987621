"""Walks of the adaptive controller in a hybrid simulation written here, with SciPy and the robot's matrices."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from controllers import AdaptiveController, Memory
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

ROBOT = Compass()
GAIT = find_passive_gait(ROBOT, math.radians(2))
PAPER = AdaptiveController(ROBOT, GAIT)
CYCLE: list[float] = GAIT.start.tolist()


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
        self.heights = -np.cumsum(np.diff(corners, prepend=0.0) * np.tan(self.slopes[:-1]))

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
        replanned = controller.reference(memory, 0.5 * time) != motion_at(GAIT.tables[0], 0.5 * time)

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
    steps = walk(PAPER, Ground([0.9], [3, 1]), 4, CYCLE)
    # the slope under the step that an estimate belongs to
    true = [math.radians(3), *(step.slope for step in steps)]
    errors = [abs(true[0])]
    for step, old, new in zip(steps, true, true[1:], strict=False):
        # (27) neither adds nor takes: exact angles, arcsin's rounding and the integration's 1e-9
        assert step.estimate_after - new == pytest.approx(step.estimate_before - old, abs=1e-7)
        errors.append(abs(step.estimate_after - new))
    # the paper's gains: each step leaves a fraction of the error (observed 0.04 to 0.22)
    assert all(later < 0.5 * earlier for earlier, later in itertools.pairwise(errors))
    assert errors[-1] < 1e-3
    assert steps[-1].last_error < 0.1 * steps[0].last_error  # tracking heals with the estimate (Theorem 1)
    assert true[-1] == math.radians(1)  # the change was walked over


def test_without_the_update_only_the_adaptive_law_finds_the_new_slope() -> None:
    """Fig. 5 of the paper: both arrive, (27) at once."""
    plain = walk(replace(PAPER, estimate_update=False), Ground([0.5], [0, 3]), 5, CYCLE)
    change = next(k for k, step in enumerate(plain) if step.slope > 0)
    assert abs(plain[change].estimate_after - plain[change].slope) > 0.04  # the whole 3 degrees are missing
    assert abs(plain[-1].estimate_after - plain[-1].slope) < 1e-3  # and gone after three steps
    assert max(step.last_error for step in plain) > 1e-5  # with (27) below 1e-7, see above


def test_without_replanning_the_error_decays_within_the_step() -> None:
    steps = walk(replace(PAPER, replanning_delay=None), UNEVEN, 6, CYCLE)
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
