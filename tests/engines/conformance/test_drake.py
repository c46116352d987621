"""The model against Drake's `CompassGait`, written by others; skipped where Drake is not installed."""

import math
from importlib import import_module
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import PassiveController

pytest.importorskip("pydrake.examples")
drake_walk: Any = import_module("scripts.benchmarks.drake_walk")


def test_accelerations_are_drakes() -> None:
    robot, slope = drake_walk.robot_and_slope()
    for state in np.random.default_rng(1).uniform(-2.0, 2.0, (20, 4)):
        q, dq = state[:2] - slope, state[2:]
        force = -robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
        ours = np.linalg.solve(robot.mass_matrix(q), force)
        # rounding; M's condition number is at most some 100
        assert np.allclose(drake_walk.derivatives(state), [*dq, *ours], rtol=1e-12, atol=1e-11)


def test_walks_are_drakes() -> None:
    robot, slope = drake_walk.robot_and_slope()
    start = mjbiped.find_passive_gait(robot, slope).start * np.array([1.0, 1.0, 1.0, 0.98])
    ground = mjbiped.Terrain.incline(math.degrees(slope))
    ours = mjbiped.walk(PassiveController(), ground, engine="hybrid", robot=robot, steps=20, initial=start).touchdowns
    theirs = drake_walk.DrakeWalk("runge_kutta5", 1e-10).touchdowns(start, float(ours["time"][-1]) + 0.01)
    both = np.column_stack([ours["q_before"], ours["dq_before"], ours["time"]])
    # measured 3e-10: what Drake's isolation of a touchdown leaves, at tighter accuracies up to 8e-10
    assert np.abs(theirs - both).max() < 1e-9
