"""The supervised law: tracking where that goes well, recovery steps where it does not, and what it foresees."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import mjbiped
from controllers import BoundedAnkleController, SupervisedController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.bounded import recovery, supervisor
from mjbiped.controllers.bounded.identifier import SLOPE
from mjbiped.controllers.bounded.prediction import (
    FRICTION,
    GRID,
    STEP,
    State,
    nominal_steps,
    plan_nominal,
    step_ahead,
)
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.layout import SUPERVISION
from mjbiped.controllers.room import CLIMBING, RECOVERING, SUPPORT, SUPPORT_AHEAD
from mjbiped.gaits.optimised import OptimisedGait


@pytest.fixture(scope="module")
def robot() -> mjbiped.Compass:
    return mjbiped.Compass(sole=(0.08, 0.08))


@pytest.fixture(scope="module")
def gait(robot: mjbiped.Compass) -> OptimisedGait:
    return mjbiped.find_reference(robot, clearance=0.077, retraction=False)


STAIRS = mjbiped.Terrain.from_segments([(1.3, 0.0, 0.0), *[(1.8, 0.0, 0.04)] * 6])


@pytest.mark.slow
def test_on_level_ground_it_is_the_tracking_law(robot: mjbiped.Compass, gait: OptimisedGait) -> None:
    laws = (SupervisedController(robot, gait), BoundedAnkleController(robot, gait))
    walks = [mjbiped.walk(each, mjbiped.Terrain.level(), engine="hybrid", steps=5) for each in laws]
    for name in ("time", "q", "torque"):
        assert (walks[0].samples[name] == walks[1].samples[name]).all()  # the same operations


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_it_climbs_stairs_on_which_the_tracking_law_falls(
    robot: mjbiped.Compass, gait: OptimisedGait, engine: str
) -> None:
    supervised, tracking = (
        mjbiped.walk(each, STAIRS, engine=engine, steps=14)
        for each in (SupervisedController(robot, gait), BoundedAnkleController(robot, gait))
    )
    assert tracking.outcome == "fell"
    assert supervised.verdict == "finished"
    made = [memory[RECOVERING] for _, memory in replayed(supervised, SupervisedController(robot, gait))]
    assert 0 < sum(made) < 10


@pytest.mark.parametrize(("support", "recovers"), [((0.0, 0.0), False), ((0.08, 0.08), False), ((0.005, 0.08), True)])
def test_it_foresees_with_what_bears_the_foot(
    robot: mjbiped.Compass, gait: OptimisedGait, support: tuple[float, float], recovers: bool
) -> None:
    """A slow step is tracked on the whole sole, not where the ground ends half a centimetre behind the ankle."""
    law = SupervisedController(robot, gait)
    start = gait.start - [0.0, 0.0, 0.1, 0.0]
    memory = [0.0] * law.memory_size
    law.start(memory, start[:2].tolist(), start[2:].tolist())
    memory[SUPPORT], memory[SUPPORT_AHEAD] = support
    supervisor.choose(law.parameters, memory, State(*start.tolist()))
    assert bool(memory[RECOVERING]) == recovers
    assert (memory[SUPPORT], memory[SUPPORT + 1]) == support  # it lasts for all of the step


def test_the_best_of_the_grid_is_chosen(robot: mjbiped.Compass, gait: OptimisedGait) -> None:
    """Early ends of the search change nothing: against all costs, each computed to its end."""
    law = SupervisedController(robot, gait)
    state = State(*(gait.start * [1.0, 1.0, 0.72, 0.8]).tolist())
    memory = [0.0] * law.memory_size
    few, grid = list(law.parameters), int(law.parameters[SUPERVISION]) + GRID
    few[grid + 2], few[grid + 5] = 2.0, 3.0
    times, halves, retractions = (supervisor.Range(*few[at : at + 3]) for at in range(grid, grid + 9, 3))
    found, step = supervisor.cheapest(few, memory, state)
    costs = {
        (i, j, k): supervisor.cost(
            few,
            memory,
            state,
            Step(
                times.first + i * times.step,
                halves.first + j * halves.step,
                retractions.first + k * retractions.step,
            ),
            math.inf,
        )
        for i in range(2)
        for j in range(3)
        for k in range(int(retractions.number))
    }
    best = min(costs, key=lambda index: costs[index])
    assert found == costs[best]
    assert step.half == halves.first + best[1] * halves.step
    assert sum(cost < math.inf for cost in costs.values()) > 1


@pytest.mark.slow  # it searches for references of another robot
def test_it_scales_with_the_robot(gait: OptimisedGait) -> None:
    """Legs of half the length and a third of the mass: times shrink by the root, and the same stairs are climbed."""
    small = mjbiped.Compass(leg_mass=5 / 3, lower_length=0.25, upper_length=0.25, sole=(0.06, 0.06))
    law = SupervisedController(
        small, mjbiped.find_reference(small, speed=0.494 / math.sqrt(2), clearance=0.0385, retraction=False)
    )
    stairs = mjbiped.Terrain.from_segments([(0.65, 0.0, 0.0), *[(0.9, 0.0, 0.02)] * 6])
    assert mjbiped.walk(law, stairs, engine="hybrid", steps=14).verdict == "finished"


@pytest.mark.slow
def test_figures_show_what_it_tracks(robot: mjbiped.Compass, gait: OptimisedGait) -> None:
    law = SupervisedController(robot, gait)
    walk = mjbiped.walk(law, STAIRS, engine="hybrid", steps=6)
    recovering = [memory for _, memory in replayed(walk, law) if memory[RECOVERING]]
    assert recovering
    for _, memory in replayed(walk, law):
        tracked = law.climbing_gait if memory[CLIMBING] else gait
        assert tracked is not None
        after = 0.9 * tracked.period  # past the transition
        q, dq = law.tracked(memory, after)
        assert all(map(math.isnan, (*q, *dq))) if memory[RECOVERING] else q == tuple(tracked.reference(after)[0])
        assert law.transition_end(memory) in (0.0, 0.8 * tracked.period)


@pytest.mark.slow
def test_after_a_step_it_lifts_its_feet_for_some_steps(robot: mjbiped.Compass, gait: OptimisedGait) -> None:
    law = SupervisedController(robot, gait, climbing_steps=2)
    assert isinstance(law.climbing_gait, OptimisedGait)
    assert (law.climbing_gait.goal.clearance, law.climbing_gait.goal.retraction) == (0.14, False)
    for rise, expected in ((0.03, [2.0, 1.0, 0.0, 0.0]), (0.02, [0.0] * 4)):
        ground = mjbiped.Terrain.from_segments([(0.5 * gait.step_length, 0.0, 0.0), (50.0, 0.0, rise)])
        walk = mjbiped.walk(law, ground, engine="hybrid", steps=4)
        assert [memory[CLIMBING] for _, memory in replayed(walk, law)][1:] == expected


@pytest.fixture(scope="module")
def tracking() -> SupervisedController:
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    return SupervisedController(robot, mjbiped.find_reference(robot, clearance=0.06))


def prepared(law: SupervisedController, state: State, slope: float = 0.0) -> list[float]:
    memory = [0.0] * law.memory_size
    memory[SLOPE] = slope
    plan_nominal(law.parameters, memory, state)
    return memory


def changed(given: list[float], limit: int, value: float) -> list[float]:
    """Parameters with another number among the limits of simulations."""
    other = list(given)
    other[int(given[SUPERVISION]) + limit] = value
    return other


@pytest.mark.slow
@pytest.mark.parametrize(("slope_deg", "off"), [(0.0, 0.0), (0.0, 0.15), (2.0, -0.1), (-3.0, 0.1)])
def test_a_step_is_foreseen_as_the_hybrid_engine_walks_it(
    tracking: SupervisedController, slope_deg: float, off: float
) -> None:
    slope = math.radians(slope_deg)
    start = tracking.gait.start + np.array([0.0, 0.0, off, 0.0])
    state = State(*start.tolist())
    knowing = replace(tracking, initial_slope_estimate=slope)
    ground = mjbiped.Terrain.incline(slope_deg)
    walk = mjbiped.walk(knowing, ground, engine=mjbiped.Hybrid(tolerance=1e-10), steps=1, initial=tuple(start))
    after = np.concatenate([walk.touchdowns["q"][0], walk.touchdowns["dq"][0]])
    errors = []
    for times in (1.0, 2.0, 4.0):
        given = changed(
            tracking.parameters, STEP, tracking.parameters[int(tracking.parameters[SUPERVISION]) + STEP] / times
        )
        work, found = step_ahead(given, prepared(tracking, state, slope), state, 0.0)
        assert 0.0 < work < 20.0
        errors.append(np.abs(np.array(found) - after).max())
    # the midpoint rule is of the second order; kinks where the sole begins to bound, and the touchdown between two
    # steps, leave it between the first and the second
    assert errors[0] < 4e-3
    assert errors[2] < 0.5 * errors[0]


def test_on_the_limit_cycle_steps_go_on(tracking: SupervisedController) -> None:
    state = State(*tracking.gait.start.tolist())
    count, work = nominal_steps(tracking.parameters, prepared(tracking, state), state, 5)
    assert count == 5
    weight = tracking.robot.total_mass * tracking.robot.gravity
    cost = work / (weight * 5 * tracking.gait.step_length)
    assert isinstance(tracking.gait, OptimisedGait)
    assert cost == pytest.approx(tracking.gait.cost_of_transport, rel=5e-3)  # of sums over 130 steps of 6 ms


def test_steps_that_fall_are_foreseen_to_fall(tracking: SupervisedController) -> None:
    slow = State(*(tracking.gait.start * [1.0, 1.0, 0.2, 0.2]).tolist())
    count, _ = nominal_steps(tracking.parameters, prepared(tracking, slow), slow, 3)
    assert count < 3
    lazy = Step(0.35, 0.3, 0.0)
    memory = prepared(tracking, slow)
    recovery.begin(memory, lazy, slow[:2], slow[2:])
    assert step_ahead(changed(tracking.parameters, FRICTION, 0.05), memory, slow, 0.0)[0] == math.inf
