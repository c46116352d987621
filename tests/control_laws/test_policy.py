"""The learned policy that is walked by name: the one that was trained, as it walked in training, in both engines."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import mjbiped
import mjbiped.envs
from controllers import PolicyController
from mjbiped.controllers.policy import STORED, TORQUE, action
from mjbiped.envs.tasks import WalkTask
from mjbiped.errors import InputError
from scripts.learning import export
from scripts.learning.checkpoint import Checkpoint
from scripts.learning.evaluate import STORED as TRAINED


@pytest.fixture(scope="module")
def policy() -> PolicyController:
    robot = mjbiped.Compass()
    return PolicyController(robot, mjbiped.find_passive_gait(robot, slope=np.radians(2.0)))


def test_it_is_the_best_free_one_that_was_trained(policy: PolicyController) -> None:
    free = [Checkpoint.load(TRAINED / f"free-{seed}.npz") for seed in range(1, 6)]
    best = max(free, key=lambda training: training.last_return)
    np.testing.assert_array_equal(policy.weights, best.weights.ravel())
    assert export.written(best) == STORED.read_text(encoding="utf-8")
    with pytest.raises(InputError, match="give a free one"):
        export.written(Checkpoint.load(TRAINED / "residual-1.npz"))


@pytest.mark.slow  # environments compile the law that an action drives
def test_it_walks_bitwise_as_in_training(policy: PolicyController) -> None:
    task = WalkTask("walk_random")
    assert task.limits == TORQUE
    env: Any = gymnasium.make("mjbiped/CompassWalkRandom-v0", time_limit=6.0).unwrapped
    felt, _ = env.reset(seed=4)
    turned, over = 0.0, False
    while not over:
        if felt[4]:
            turned += felt[6] - felt[9]
        q1, q2, dq1, dq2 = felt[:4]
        shares = action(policy.weights, min(felt[5], 1.5 * 0.765), q1, q2, dq1, dq2, felt[8], turned)
        felt, _, fell, late, _ = env.step(np.array(shares))
        over = fell or late
    there = env.walk()
    here = mjbiped.walk(
        policy,
        there.terrain,
        engine=task.engine,
        initial=there.settings["initial"],
        steps=there.settings["steps"],
        distance=2.0,
    )
    assert there.outcome == "time limit"
    assert 4 <= here.steps <= there.steps
    for name, column in here.touchdowns.items():
        if not name.startswith("slope_estimate"):  # the environment's controller has none
            np.testing.assert_array_equal(column, there.touchdowns[name][: here.steps], err_msg=name)


@pytest.mark.parametrize("t", [0.0, 0.3, 1.2])
def test_its_torques_are_a_feedback_whose_gains_are_linear_in_time(policy: PolicyController, t: float) -> None:
    """Until one and a half periods of the gait, where time stands still; and within the greatest of the training."""
    q, dq, memory, latest = (0.1, -0.15), (0.9, 0.3), [-0.18, 0.02], 1.5 * 0.765
    phase = 2.0 * min(t, latest) / 0.765 - 1.0
    constant, slope = policy.weights.reshape(2, 2, 8).swapaxes(0, 1)
    features = [q[0] / 0.2, q[1] / 0.2, *dq, phase, memory[0] / 0.2 + 1.0, memory[1] / 0.035, 1.0]
    expected = np.clip((constant + slope * phase) @ features, -1.0, 1.0) * TORQUE
    np.testing.assert_allclose(policy.torque(memory, t, q, dq), expected, rtol=1e-12)
    assert policy.next_discontinuity(memory, t) == (latest if t < latest else np.inf)


def test_its_slope_is_the_turn_of_the_ground(policy: PolicyController) -> None:
    ground = mjbiped.Terrain.from_segments([(0.3, 2.0, 0.0), (5.0, 3.0, 0.0)])
    walk = mjbiped.walk(policy, ground, engine="hybrid", steps=3)
    np.testing.assert_allclose(np.degrees(walk.touchdowns["slope_estimate"][1:]), 1.0, rtol=0, atol=1e-9)
