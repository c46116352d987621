"""The supervised law: tracking where that goes well, recovery steps where it does not, and what it foresees."""

import math
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from golden_numbers import check

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, Controller, LibraryController, SupervisedController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.bounded import recovery, supervisor
from mjbiped.controllers.bounded.identifier import SLOPE
from mjbiped.controllers.bounded.prediction import FRICTION, GRID, STEP, State, nominal_steps, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.layout import SUPERVISION
from mjbiped.controllers.room import RECOVERING, SUPPORT, SUPPORT_AHEAD
from mjbiped.gaits.optimised import OptimisedGait

STAIRS = mjbiped.Terrain.from_segments([(1.3, 0.0, 0.0), *[(1.8, 0.0, 0.04)] * 6])


@cache
def short() -> SupervisedController:
    """On a sole that bears little."""
    robot = mjbiped.Compass(sole=(0.08, 0.08))
    return SupervisedController(robot, mjbiped.find_reference(robot, clearance=0.077, retraction=False))


@cache
def long() -> SupervisedController:
    """On a sole on which most steps are tracked."""
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    return SupervisedController(robot, mjbiped.find_reference(robot, clearance=0.06))


def memory_of(law: SupervisedController, *, slope: float = 0.0) -> list[float]:
    memory = [0.0] * law.memory_size
    memory[SLOPE] = slope
    return memory


def state_of(law: SupervisedController, *factors: float) -> State:
    """The gait's first state, with its angles and rates times these."""
    return State(*(law.gait.start * (factors or (1.0,))).tolist())


@pytest.mark.slow
@pytest.mark.parametrize("supervised", [False, True])
def test_on_level_ground_it_is_the_law_that_it_extends(supervised: bool) -> None:
    """So is the law with two references."""
    laws: tuple[Controller, Controller] = short(), BoundedAnkleController(short().robot, short().gait)
    if not supervised:
        robot = mjbiped.Compass()
        gait = mjbiped.find_reference(robot, clearance=0.04)
        laws = LibraryController(robot, gait), AdaptiveController(robot, gait, replanning="additive")
    walks = [mjbiped.walk(each, mjbiped.Terrain.level(), engine="hybrid", steps=5) for each in laws]
    for name in ("time", "q", "torque"):
        assert (walks[0].samples[name] == walks[1].samples[name]).all()  # the same operations


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_it_climbs_stairs_on_which_the_tracking_law_falls(engine: str) -> None:
    law, tracking = short(), BoundedAnkleController(short().robot, short().gait)
    supervised, tracked = (mjbiped.walk(each, STAIRS, engine=engine, steps=14) for each in (law, tracking))
    assert tracked.outcome == "fell"
    assert supervised.verdict == "finished"
    assert 0 < sum(memory[RECOVERING] for _, memory in replayed(supervised, law)) < 10


@pytest.mark.parametrize(("support", "recovers"), [((0.0, 0.0), False), ((0.08, 0.08), False), ((0.005, 0.08), True)])
def test_it_foresees_with_what_bears_the_foot(support: tuple[float, float], recovers: bool) -> None:
    """A slow step is tracked on the whole sole, not where the ground ends half a centimetre behind the ankle."""
    law, memory = short(), memory_of(short())
    start = law.gait.start - [0.0, 0.0, 0.1, 0.0]
    law.start(memory, start[:2].tolist(), start[2:].tolist())
    memory[SUPPORT], memory[SUPPORT_AHEAD] = support
    supervisor.choose(law.parameters, memory, State(*start.tolist()))
    assert bool(memory[RECOVERING]) == recovers
    assert (memory[SUPPORT], memory[SUPPORT + 1]) == support  # it lasts for all of the step


@pytest.mark.parametrize("rates", [(0.72, 0.8), (1.5, 1.0)])
def test_the_best_of_the_grid_is_chosen(rates: tuple[float, float]) -> None:
    """Early ends of the search change nothing: against all costs, each computed to its end."""
    law, memory, state = short(), memory_of(short()), state_of(short(), 1.0, 1.0, *rates)
    few, grid = list(law.parameters), int(law.parameters[SUPERVISION]) + GRID
    few[grid + 2], few[grid + 5] = 2.0, 3.0
    ranges = (supervisor.Range(*few[at : at + 3]) for at in range(grid, grid + 9, 3))
    steps = product(*([each.first + k * each.step for k in range(int(each.number))] for each in ranges))
    found, step = supervisor.cheapest(few, memory, state)
    costs = {step: supervisor.cost(few, memory, state, Step(*step), math.inf) for step in steps}
    best = min(costs, key=lambda each: costs[each])
    assert (found, step.half, len(costs) % 6) == (costs[best], best[1], 0)
    assert sum(cost < math.inf for cost in costs.values()) > 1
    check(f"costs of recovery steps {rates}", {"costs": list(costs.values())})


def foreseen(law: SupervisedController, state: State, slope: float, limit: int, times: float) -> tuple[float, State]:
    """The step ahead that is tracked, with one of the limits of simulations times a number."""
    given, memory = list(law.parameters), memory_of(law, slope=slope)
    given[int(given[SUPERVISION]) + limit] *= times
    plan_nominal(law.parameters, memory, state)
    return step_ahead(given, memory, state, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(("slope_deg", "off"), [(0.0, 0.0), (0.0, 0.15), (2.0, -0.1), (-3.0, 0.1)])
def test_a_step_is_foreseen_as_the_hybrid_engine_walks_it(slope_deg: float, off: float) -> None:
    slope, start = math.radians(slope_deg), long().gait.start + np.array([0.0, 0.0, off, 0.0])
    knowing, engine = replace(long(), initial_slope_estimate=slope), mjbiped.Hybrid(tolerance=1e-10)
    walk = mjbiped.walk(knowing, mjbiped.Terrain.incline(slope_deg), engine=engine, steps=1, initial=tuple(start))
    after = np.concatenate([walk.touchdowns["q"][0], walk.touchdowns["dq"][0]])
    errors = []
    for times in (1.0, 0.5, 0.25):
        work, found = foreseen(long(), State(*start.tolist()), slope, STEP, times)
        assert 0.0 < work < 20.0
        errors.append(np.abs(np.array(found) - after).max())
    # the midpoint rule is of the second order; kinks where the sole begins to bound, and the touchdown between two
    # steps, leave it between the first and the second
    assert errors[0] < 4e-3
    assert errors[2] < 0.5 * errors[0]


def test_on_the_limit_cycle_steps_go_on_and_steps_that_fall_are_foreseen_to_fall() -> None:
    law, memory, state = long(), memory_of(long()), state_of(long())
    plan_nominal(law.parameters, memory, state)
    count, work = nominal_steps(law.parameters, memory, state, 5)
    assert count == 5
    assert isinstance(law.gait, OptimisedGait)
    cost = work / (law.robot.weight * 5 * law.gait.step_length)
    assert cost == pytest.approx(law.gait.cost_of_transport, rel=5e-3)  # of sums over 130 steps of 6 ms
    slow, memory = state_of(law, 1.0, 1.0, 0.2, 0.2), memory_of(law)
    plan_nominal(law.parameters, memory, slow)
    assert nominal_steps(law.parameters, memory, slow, 3)[0] < 3
    recovery.begin(memory, Step(0.35, 0.3, 0.0), slow[:2], slow[2:])
    icy = list(law.parameters)
    icy[int(icy[SUPERVISION]) + FRICTION] = 0.05
    assert step_ahead(icy, memory, slow, 0.0)[0] == math.inf
