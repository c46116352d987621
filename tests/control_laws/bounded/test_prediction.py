"""Predictions: what is foreseen is what the hybrid engine then walks."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import mjbiped
from controllers import SupervisedController
from mjbiped.controllers.bounded import identifier, recovery
from mjbiped.controllers.bounded.prediction import FRICTION, STEP, State, nominal_steps, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import Step
from mjbiped.controllers.layout import SUPERVISION
from mjbiped.gaits.optimised import OptimisedGait


@pytest.fixture(scope="module")
def law() -> SupervisedController:
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    return SupervisedController(robot, mjbiped.find_reference(robot, clearance=0.06))


def prepared(law: SupervisedController, state: State, slope: float = 0.0) -> list[float]:
    memory = [0.0] * law.memory_size
    memory[identifier.SLOPE] = slope
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
    law: SupervisedController, slope_deg: float, off: float
) -> None:
    slope = math.radians(slope_deg)
    start = law.gait.start + np.array([0.0, 0.0, off, 0.0])
    state = State(*start.tolist())
    knowing = replace(law, initial_slope_estimate=slope)
    ground = mjbiped.Terrain.incline(slope_deg)
    walk = mjbiped.walk(knowing, ground, engine=mjbiped.Hybrid(tolerance=1e-10), steps=1, initial=tuple(start))
    after = np.concatenate([walk.touchdowns["q"][0], walk.touchdowns["dq"][0]])
    errors = []
    for times in (1.0, 2.0, 4.0):
        given = changed(law.parameters, STEP, law.parameters[int(law.parameters[SUPERVISION]) + STEP] / times)
        work, found = step_ahead(given, prepared(law, state, slope), state, 0.0)
        assert 0.0 < work < 20.0
        errors.append(np.abs(np.array(found) - after).max())
    # the midpoint rule is of the second order; kinks where the sole begins to bound, and the touchdown between two
    # steps, leave it between the first and the second
    assert errors[0] < 4e-3
    assert errors[2] < 0.5 * errors[0]


def test_on_the_limit_cycle_steps_go_on(law: SupervisedController) -> None:
    state = State(*law.gait.start.tolist())
    count, work = nominal_steps(law.parameters, prepared(law, state), state, 5)
    assert count == 5
    weight = law.robot.total_mass * law.robot.gravity
    cost = work / (weight * 5 * law.gait.step_length)
    assert isinstance(law.gait, OptimisedGait)
    assert cost == pytest.approx(law.gait.cost_of_transport, rel=5e-3)  # of sums over 130 steps of 6 ms


def test_steps_that_fall_are_foreseen_to_fall(law: SupervisedController) -> None:
    slow = State(*(law.gait.start * [1.0, 1.0, 0.2, 0.2]).tolist())
    count, _ = nominal_steps(law.parameters, prepared(law, slow), slow, 3)
    assert count < 3
    lazy = Step(0.35, 0.3, 0.0)
    memory = prepared(law, slow)
    recovery.begin(memory, lazy, slow[:2], slow[2:])
    assert step_ahead(changed(law.parameters, FRICTION, 0.05), memory, slow, 0.0)[0] == math.inf


def test_a_higher_foothold_is_met_earlier(law: SupervisedController) -> None:
    state = State(*law.gait.start.tolist())
    found = [step_ahead(law.parameters, prepared(law, state), state, rise)[1] for rise in (-0.01, 0.0, 0.01)]
    assert found[0].q2 > found[1].q2 > found[2].q2  # q2 after the transfer is the stance angle before it
