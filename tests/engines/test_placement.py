"""Feet that are placed to the side by hips that abduct: what only they survive, their work, and mirrored steps."""

import math
from typing import Any

import numpy as np
import pytest

import mjbiped
from mjbiped.control.registry import make_controller

SOLE: dict[str, Any] = {"sole": (0.12, 0.12), "sole_width": 0.08}
ROBOT = mjbiped.Abducting3D(**SOLE)


def walked(robot: mjbiped.Compass3D, engine: str = "mujoco", gains: Any = None, **given: Any) -> mjbiped.Walk:
    """A walk on level ground under the law for a narrow sole."""
    law = make_controller("bounded-ankle", robot, gains or {})
    return mjbiped.walk(law, mjbiped.Terrain.level(), engine=engine, **{"sample_period": None, **given})


def test_a_push_that_only_placed_feet_survive_and_the_work_of_placing_them() -> None:
    push = mjbiped.Disturbances(pushes=[(0.9, 1.2)], push_direction=math.pi / 2)
    assert walked(mjbiped.Compass3D(**SOLE), steps=3, disturbances=push).outcome == "fell"
    walk = walked(ROBOT, steps=4, disturbances=push, sample_period=1e-3)
    assert walk.outcome == "finished"
    apart = np.abs(np.diff(walk.touchdowns["y"]))
    assert apart.max() > 0.15
    assert apart.min() > 0.03
    opened = walk.samples["qpos"][:, [ROBOT.places.index(name) for name in ROBOT.hips]]
    np.testing.assert_allclose(opened, 0.5 * walk.samples["q"][:, [2, 2]], rtol=0, atol=1e-3)  # the gear
    works = 1e-3 * np.abs(walk.samples["torque"] * ROBOT.joint_rates(walk.samples["dq"])).sum(axis=0)
    assert walk.touchdowns["work_absolute"][-1] == pytest.approx(works.sum(), rel=0.03)
    assert works[ROBOT.joints.index("abduction")] > 0.1 * works.sum()


@pytest.mark.parametrize("engine", [pytest.param("hybrid", marks=pytest.mark.slow), "mujoco"])
def test_a_step_on_the_right_foot_is_one_on_the_left_mirrored(engine: str) -> None:
    held = {"lateral_gain": 0.0, "adaptation_gain": 1e-9, "estimate_update": False}  # a law that remembers nothing
    both = walked(ROBOT, engine, held, steps=2).touchdowns
    again = walked(ROBOT, engine, held, steps=1, initial=(*both["q"][0], *both["dq"][0])).touchdowns
    assert abs(both["dq"][0, 2]) > 0.05  # the legs are being opened
    np.testing.assert_allclose(again["q"][0], both["q"][1], rtol=0, atol=1e-6 if engine == "hybrid" else 1e-3)
    np.testing.assert_allclose(again["dq"][0], both["dq"][1], rtol=0, atol=1e-5 if engine == "hybrid" else 5e-3)
